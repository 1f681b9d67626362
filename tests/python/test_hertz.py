"""Stops of elastic bodies that touch: Hertz's law, with dissipation by Hunt and Crossley or by Tsuji."""

import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import gamma

import vibroimpact as vi

STEPS = ["auto", "rk45", "dop853", "radau"]
OSCILLATOR = vi.LinearSystem(1.0, 0.1, 1.0)
FORCE = vi.Harmonic([1.0], 0.8)
TIGHT = {"rtol": 1e-11, "atol": 1e-13}

#: x and v at t = 20 and the duration of the second of three contacts of x'' + 0.1 x' + x = cos 0.8 t, 40 p^1.5 beyond 0.5.
KNOWN = (-0.0667587668514655, -0.112650748323477, 0.665522726636188)


def before(law, system=OSCILLATOR, force=FORCE, clearance=0.5):
    """Return an oscillator before a stop."""
    return vi.Scene(system, force, [vi.Stop(0, clearance, contact=law)])


def meets(law, mass, speed, method="dop853"):
    """Return the run of a free body that meets a stop."""
    free = before(law, vi.LinearSystem(mass, 0.0, 0.0), None, 1.0)
    return vi.simulate(free, 0.0, speed, (0, 8.0 / speed), method=method, **TIGHT)


@pytest.mark.parametrize("method", STEPS)
def test_a_run_ends_where_the_reference_says(method):
    """The reference is known to 14 digits."""
    run = vi.simulate(before(vi.Hertz(40.0)), 0.0, 0.3, (0, 20), method=method, **TIGHT)
    x, v, duration = KNOWN
    known_to = 1e-8 if method == "radau" else 1e-9
    assert run.final[0][0] == pytest.approx(x, abs=known_to)
    assert run.final[1][0] == pytest.approx(v, abs=known_to)
    assert len(run.contacts) == run.stats.n_contacts == 3
    assert run.contacts["end"][1] - run.contacts["start"][1] == pytest.approx(duration, abs=1e-9)
    assert np.abs(run.energy.balance).max() < 1e-8
    assert np.abs(run.energy.contact_loss).max() < 1e-8


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 3.3])
@pytest.mark.parametrize("method", STEPS)
def test_an_elastic_contact_is_as_deep_and_as_long_as_its_formula(exponent, method):
    """Largest approach, force and duration of a free body; of m = 2, k = 5, v0 = 0.7 and spheres the references' numbers."""
    mass, stiffness, speed = 2.0, 5.0, 0.7
    contact = meets(vi.Hertz(stiffness, exponent), mass, speed, method).contacts[0]
    order = exponent + 1.0
    deepest = (order * mass * speed**2 / (2.0 * stiffness)) ** (1.0 / order)
    lasts = 2.0 * deepest / speed * np.sqrt(np.pi) * gamma(1.0 + 1.0 / order) / gamma(0.5 + 1.0 / order)
    if exponent == 1.5:
        assert deepest == pytest.approx(0.569726517372455, rel=1e-14)
        assert lasts == pytest.approx(2.39551702919155, rel=1e-14)
    assert contact["peak_approach"] == pytest.approx(deepest, rel=1e-8)
    assert contact["peak_force"] == pytest.approx(stiffness * deepest**exponent, rel=1e-8)
    assert contact["end"] - contact["start"] == pytest.approx(lasts, rel=1e-8)
    assert contact["speed_after"] == pytest.approx(speed, rel=1e-9)
    assert contact["impulse"] == pytest.approx(2.0 * mass * speed, rel=1e-7)
    assert contact["loss"] == pytest.approx(0.0, abs=1e-7)


LAWS = [
    vi.Hertz(30.0, damping=0.4),
    vi.Hertz(30.0, 2.2, damping=3.0),
    vi.Hertz(30.0, damping=2.0, dissipation="tsuji", release="gap"),
    vi.Hertz(30.0, 1.2, damping=2.0, dissipation="tsuji", release="clipped"),
    vi.Hertz(30.0, 1.0, damping=7.0, dissipation="tsuji", release="clipped"),
]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("speed", [0.2, 1.5])
def test_a_free_body_is_given_back_what_the_law_says(law, speed):
    """Speed, loss and impulse of a contact."""
    run = meets(law, 2.0, speed)
    contact = run.contacts[0]
    kept = law.equivalent_restitution(2.0, speed)
    assert contact["speed_after"] / contact["speed_before"] == pytest.approx(kept, rel=1e-8)
    lost = speed**2 * (1.0 - kept**2)
    assert contact["loss"] == pytest.approx(lost, rel=1e-6)
    assert run.energy.contact_loss[-1] == pytest.approx(lost, rel=1e-6)
    assert contact["impulse"] == pytest.approx(2.0 * speed * (1.0 + kept), rel=1e-6)


def force_of(law, p, rate):
    """Return the force of a law, written down anew."""
    if p <= 0.0:
        return 0.0
    k, m, c = law.stiffness, law.exponent, law.damping
    if law.dissipation == "tsuji":
        force = k * p**m + c * p ** ((m - 1.0) / 2.0) * rate
        return force if law.release == "gap" else max(0.0, force)
    return max(0.0, k * p**m * (1.0 + c * rate))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("moves", [False, True])
def test_a_forced_run_is_that_of_the_equations_written_down_anew(law, moves):
    """Beside a rigid stop; the stop may move."""

    def rates(t, x):
        place, speed = (0.1 * np.cos(0.8 * t + 0.3), -0.08 * np.sin(0.8 * t + 0.3)) if moves else (0.0, 0.0)
        force = force_of(law, x[0] - 0.5 - place, x[1] - speed)
        return [x[1], 2.0 * np.cos(0.8 * t) - 0.1 * x[1] - x[0] - force]

    motion = vi.Harmonic([0.1], 0.8, 0.3) if moves else None
    stops = [vi.Stop(0, 0.5, contact=law, motion=motion), vi.Stop(0, 9.0, 0.5)]
    scene = vi.Scene(OSCILLATOR, vi.Harmonic([2.0], 0.8), stops)
    run = vi.simulate(scene, 0.0, 0.3, (0, 15), **TIGHT)
    known = solve_ivp(rates, (0, 15), [0.0, 0.3], method="DOP853", rtol=1e-11, atol=1e-12, max_step=1e-3)
    assert len(run.contacts) >= 2
    assert np.concatenate(run.final) == pytest.approx(known.y[:, -1], abs=2e-6)
    assert np.abs(run.energy.balance).max() < 1e-6
    for contact in run.contacts:
        t = np.linspace(contact["start"], np.nan_to_num(contact["end"], nan=15.0), 9)[1:-1]
        p = run.position(t)[:, 0] - 0.5 - (0.1 * np.cos(0.8 * t + 0.3) if moves else 0.0)
        rate = run.velocity(t)[:, 0] + (0.08 * np.sin(0.8 * t + 0.3) if moves else 0.0)
        assert run.contact_force(0, t) == pytest.approx([force_of(law, *own) for own in zip(p, rate, strict=True)], abs=1e-9)


def test_a_body_that_is_drawn_away_fast_is_not_held_back():
    """By Hunt and Crossley the force is none where the body is drawn away faster than 1/d: the stop is idle."""
    law = vi.Hertz(30.0, damping=3.0)
    scene = before(law, vi.LinearSystem(1.0, 0.0, 0.0, load=[-4.0]), None, 0.0)
    run = vi.simulate(scene, 0.3, 0.0, (0, 0.6), **TIGHT)
    assert list(run.regimes["state"][:, 0]) == ["pressed", "idle", "free"]
    at = run.regimes["end"][0]
    assert run.velocity(at)[0] == pytest.approx(-1.0 / 3.0, rel=1e-9)
    assert run.contact_force(0, at + 0.01) == 0.0


def test_linear_scenes_say_that_they_are_integrated():
    """The plan has it; exact flights and what needs them refuse the law by its name."""
    scene = before(vi.Hertz(40.0))
    assert "stop 0 by Hertz integrated" in scene.plan()
    calls = [
        lambda: vi.simulate(scene, 0.0, 0.3, (0, 1), method="exact"),
        lambda: vi.periodic_orbits(scene, [0]),
        lambda: vi.find_orbit(scene, (0.0, 0.3), 1),
        lambda: vi.modes(scene, pressed=[0]),
        lambda: vi.recovery_matrix(scene, [0]),
        lambda: vi.lyapunov_exponents(scene, 0.0, 0.3, (0, 10)),
    ]
    for call in calls:
        with pytest.raises(ValueError, match=r"stops\[0\] is Hertz"):
            call()


def test_numbers_are_refused_by_their_names():
    """What is wrong, and what is missing."""
    for make, message in [
        (lambda: vi.Hertz(0.0), "stiffness is 0"),
        (lambda: vi.Hertz(1.0, 0.5), "exponent is 0.5"),
        (lambda: vi.Hertz(1.0, damping=-1.0), "damping is -1"),
        (lambda: vi.Hertz(1.0, damping=1.0, dissipation="tsuji"), "release is None"),
        (lambda: vi.Hertz(1.0, damping=1.0, dissipation="tsuji", release="force"), "release is .*force"),
        (lambda: vi.Hertz(1.0, dissipation="dashpot"), "dissipation is .*dashpot"),
        (lambda: vi.Hertz(1.0, release="gap"), "release is given"),
        (lambda: vi.Hertz(1.0, damping=1.0).equivalent_restitution(1.0), "speed is None"),
    ]:
        with pytest.raises(ValueError, match=message):
            make()


@pytest.mark.parametrize("law", LAWS)
def test_it_comes_back(law, tmp_path):
    """From pickle, from its text, from a file with its run; its numbers are numbers of a scene."""
    assert pickle.loads(pickle.dumps(law)) == law
    assert eval(repr(law), {"Hertz": vi.Hertz}) == law
    scene = before(law)
    run = vi.simulate(scene, 0.0, 0.3, (0, 10))
    run.save(tmp_path / "run.npz")
    again = vi.load(tmp_path / "run.npz")
    assert again.scene == scene
    assert np.array_equal(again.contacts, run.contacts)
    other = scene.replace(**{"contact_stiffness[0]": 7.0, "contact_exponent": 2.0, "contact_damping": 1.0}).stops[0].contact
    assert (other.stiffness, other.exponent, other.damping) == (7.0, 2.0, 1.0)
    assert (other.dissipation, other.release) == (law.dissipation, law.release)
    with pytest.raises(ValueError, match="Hertz"):
        scene.replace(preload=1.0)
