"""Whatever acts on whatever moves: each excitation on each system by each method, against one that SciPy integrates."""

import ctypes
import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibroimpact as vi

MASS = np.array([[2.0, 0.3], [0.3, 1.0]])
DAMPING = np.array([[0.2, 0.03], [0.05, 0.15]])
STIFFNESS = np.array([[9.0, -2.0], [-2.0, 5.0]])
INFLUENCE = np.array([1.0, -0.5])
MATRICES = np.hstack([-np.linalg.solve(MASS, STIFFNESS), -np.linalg.solve(MASS, DAMPING)])
SPAN = (0.5, 4.5)
Q0, V0 = np.array([0.2, -0.1]), np.array([-0.3, 0.5])
STEPS = ["rk45", "dop853", "radau"]

# Forces on the coordinates, each with what it is at a time -------------------------------------------------------------

A, B, MEAN = np.array([0.8 + 0.2j, -0.5j]), np.array([0.1j, 0.3]), np.array([0.4, -0.2])
TIMES, VALUES = [0.0, 1.0, 2.5, 6.0], [0.3, -0.5, 0.8, 0.1]
CUBICS = vi.Signal([1.0, 2.0, 4.0], [[0.2, -0.1], [0.0, 0.3], [-0.5, 0.2], [1.0, -0.4]])
D = np.array([0.7, -1.1])


def turning(amplitude, w, phase):
    return lambda t: (amplitude * np.exp(1j * (w * t + phase))).real


def cubics(t):
    pieces = [(1.0, 2.0, [0.2, 0.0, -0.5, 1.0]), (2.0, 4.0, [-0.1, 0.3, 0.2, -0.4])]
    return sum(np.polyval(c, t - a) for a, b, c in pieces if a <= t < b)


def total(*forces):
    return lambda t: sum(force(t) for force in forces)


HARMONIC = (vi.Harmonic(A, 1.3, 0.4), turning(A, 1.3, 0.4))
FOURIER = (vi.Fourier([A, 0 * A, B], 0.9, -0.3, mean=MEAN), total(turning(A, 0.9, -0.3), turning(B, 2.7, -0.9), lambda t: MEAN))
CONSTANT = (vi.Load(D, ([0.0, 10.0], [0.6, 0.6])), lambda t: 0.6 * D)
SAMPLES = (vi.Load(D, (TIMES, VALUES)), lambda t: D * np.interp(t, TIMES, VALUES))
ON_ONE = (vi.Load(1, CUBICS), lambda t: np.array([0.0, cubics(t)]))
FORCES = {
    "nothing": (None, lambda t: np.zeros(2)),
    "harmonic": HARMONIC,
    "fourier": FOURIER,
    "fourier of a mean alone": (vi.Fourier([0 * A], 1.0, mean=MEAN), lambda t: MEAN),
    "harmonics of one period": ([vi.Harmonic(B, 2.6, 0.1), HARMONIC[0]], total(turning(B, 2.6, 0.1), HARMONIC[1])),
    "without a period": ([HARMONIC[0], FOURIER[0]], total(HARMONIC[1], FOURIER[1])),
    "constant load": CONSTANT,
    "load of samples": SAMPLES,
    "load in pieces": ON_ONE,
    "loads": ([SAMPLES[0], ON_ONE[0]], total(SAMPLES[1], ON_ONE[1])),
    "load and harmonic": ([SAMPLES[0], HARMONIC[0]], total(SAMPLES[1], HARMONIC[1])),
    "load and a harmonic of nothing": ([SAMPLES[0], vi.Harmonic(0 * A, 1.0)], SAMPLES[1]),
}
# What drifts: for w from 1.3 at 0.2 a time, the angle is 1.3 s + 0.1 s^2 at a time s after the start.
SWEPT = 1.3 * SPAN[0] + 0.4


def swept(t):
    s = t - SPAN[0]
    return (A * np.exp(1j * (SWEPT + 1.3 * s + 0.1 * s**2))).real


def logarithmic(t):
    s = t - SPAN[0]
    return (A * np.exp(1j * (SWEPT + 1.3 * np.expm1(0.1 * s) / 0.1))).real


def grown(t):
    return (1 + 0.25 * (t - SPAN[0])) * HARMONIC[1](t)


RAMPS = {
    "frequency": (HARMONIC[0], vi.Ramp("frequency", 9.0, rate=0.2), swept),
    "frequency by its logarithm": (HARMONIC[0], vi.Ramp("frequency", 9.0, rate=0.1, law="log"), logarithmic),
    "scale": (HARMONIC[0], vi.Ramp("forcing_scale", 9.0, rate=0.25), grown),
    "frequency beside a load": ([SAMPLES[0], HARMONIC[0]], vi.Ramp("frequency", 9.0, rate=0.2), total(SAMPLES[1], swept)),
}


def shaken(amplitude, w, phase):
    """The acceleration of a base that moves by Re(amplitude e^{i (w t + phase)})."""
    return lambda t: (-amplitude * w**2 * np.exp(1j * (w * t + phase))).real


# A base pushes with -M r times its acceleration.
BASES = {
    "motion": (vi.BaseMotion([0.2, 0.05j], 1.1, 0.3), total(shaken(0.2, 1.1, 0.3), shaken(0.05j, 2.2, 0.6))),
    "acceleration": (vi.BaseAcceleration((TIMES, VALUES)), lambda t: np.interp(t, TIMES, VALUES)),
    "acceleration in pieces": (vi.BaseAcceleration(CUBICS), cubics),
    "both": (
        [vi.BaseMotion(0.2, 1.1, 0.3), vi.BaseAcceleration((TIMES, VALUES))],
        total(shaken(0.2, 1.1, 0.3), lambda t: np.interp(t, TIMES, VALUES)),
    ),
}

# Stops that are never met: the motion of a stop is no force. -----------------------------------------------------------

STOPS = {
    "no stop": (),
    "a stop": vi.Stop(0, 50.0, 0.5),
    "a moving stop": vi.Stop(0, 50.0, 0.5, motion=vi.Harmonic(0.3, 0.7)),
    "a stop after a signal": vi.Stop(1, 50.0, 0.5, motion=vi.Signal([-100.0, 100.0], [[0.01], [0.1]])),
}


def reference(force, breaks=(), mass=MASS, damping=DAMPING, stiffness=STIFFNESS, state=(Q0, V0)):
    """The state at the end, by SciPy from break to break."""
    x, places = np.concatenate(state), sorted({*SPAN, *(t for t in breaks if SPAN[0] < t < SPAN[1])})

    def rate(t, x):
        return np.concatenate([x[2:], np.linalg.solve(mass, force(t) - stiffness @ x[:2] - damping @ x[2:])])

    for start, end in itertools.pairwise(places):
        # A step ends before a jump at its end.
        inside = np.nextafter(end, start)
        x = solve_ivp(lambda t, x, last=inside: rate(min(t, last), x), (start, end), x, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return x


BREAKS = [*TIMES, 1.0, 2.0, 4.0]
POINTER = ctypes.POINTER(ctypes.c_double)


@ctypes.CFUNCTYPE(None, ctypes.c_double, POINTER, POINTER, POINTER, POINTER)
def in_c(t, q, v, a, parameters):
    for i in range(2):
        a[i] = sum(MATRICES[i, j] * q[j] + MATRICES[i, 2 + j] * v[j] for j in range(2))


def own(t, q, v):
    return MATRICES @ np.concatenate([q, v])


def jacobian(t, q, v):
    return MATRICES


def same_mass(q):
    return MASS


SYSTEMS = {
    "linear": lambda: vi.LinearSystem(MASS, DAMPING, STIFFNESS, influence=INFLUENCE),
    "constant mass": lambda: vi.NonlinearSystem(2, own, mass=MASS),
    "mass of the position": lambda: vi.NonlinearSystem(2, own, mass=same_mass),
    "jacobian": lambda: vi.NonlinearSystem(2, own, mass=MASS, jacobian=jacobian),
    "jacobian and mass of the position": lambda: vi.NonlinearSystem(2, own, mass=same_mass, jacobian=jacobian),
    "in C": lambda: vi.NonlinearSystem(2, in_c, mass=MASS),
    "in C, mass of the position": lambda: vi.NonlinearSystem(2, in_c, mass=same_mass),
}


def methods(system):
    return ["auto", *STEPS] if system != "linear" else ["auto", "exact", *STEPS]


def check(scene, method, expected, ramp=None, state=(Q0, V0), size=1.0):
    options = {"rtol": 1e-9, "atol": 1e-11 * size, "keep": "final"}
    run = vi.simulate(scene, *state, SPAN, method=method, ramp=ramp, **options)
    assert run.status == "finished"
    np.testing.assert_allclose(np.concatenate(run.final), expected, rtol=0, atol=2e-7 * size, err_msg=f"by {method}")


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("force", FORCES)
def test_forces_act_on_every_system(force, system):
    forcing, value = FORCES[force]
    expected = reference(value, BREAKS)
    for stop in STOPS.values():
        scene = vi.Scene(SYSTEMS[system](), forcing, stop)
        for method in methods(system):
            check(scene, method, expected)


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("name", RAMPS)
def test_ramps_act_on_every_system(name, system):
    forcing, ramp, value = RAMPS[name]
    expected = reference(value, BREAKS)
    for stop in ("no stop", "a stop"):
        scene = vi.Scene(SYSTEMS[system](), forcing, STOPS[stop])
        for method in ["auto", *STEPS]:
            check(scene, method, expected, ramp)


@pytest.mark.parametrize("name", BASES)
def test_bases_push_a_linear_system_and_no_equations(name):
    forcing, acceleration = BASES[name]
    expected = reference(lambda t: -MASS @ INFLUENCE * acceleration(t), BREAKS)
    for stop in STOPS.values():
        for method in methods("linear"):
            check(vi.Scene(SYSTEMS["linear"](), forcing, stop), method, expected)
    for system in list(SYSTEMS)[1:]:
        with pytest.raises(ValueError, match=r"write it into the acceleration"):
            vi.Scene(SYSTEMS[system](), forcing)


# Motions of a pendulum this small are linear to 1e-12 of themselves.
SMALL = 1e-6
PENDULUMS = {
    "double": vi.DoublePendulum(0.6, 1.4, damping=(0.05, 0.02)),
    "chain": vi.PendulumChain([1.0, 0.6], [1.0, 0.7], damping=[0.05, 0.02]),
}


@pytest.mark.parametrize("pendulum", PENDULUMS)
@pytest.mark.parametrize("name", [*FORCES, *BASES])
def test_what_acts_on_pendulums_acts_on_their_small_motions(name, pendulum):
    forcing, value = FORCES[name] if name in FORCES else BASES[name]
    system = PENDULUMS[pendulum]
    scene = vi.Scene(system, forcing).replace(forcing_scale=SMALL) if forcing else vi.Scene(system)
    linear = vi.Scene(system).linearise().system
    state = (SMALL * Q0, SMALL * V0)

    def force(t):
        return SMALL * value(t) if name in FORCES else -linear.mass @ linear.influence * SMALL * value(t)

    matrices = {"mass": linear.mass, "damping": linear.damping, "stiffness": linear.stiffness}
    # In the units of the small motion the absolute tolerances of SciPy mean something.
    expected = SMALL * reference(lambda t: force(t) / SMALL, BREAKS, state=(Q0, V0), **matrices)
    for method in ["auto", "taylor", *STEPS]:
        check(scene, method, expected, state=state, size=SMALL)
    for method in ["auto", *STEPS]:
        check(scene.linearise(), method, expected, state=state, size=SMALL)
