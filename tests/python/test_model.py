"""Systems, forcing, stops, scenes, modes and recovery matrices against the formulas they stand for."""

import copy
import os
import pickle

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

import vibroimpact as vi

CASES = int(os.environ.get("VIBROIMPACT_CASES", "50"))
law = settings(max_examples=CASES, deadline=5000)

M = np.array([[2.0, 0.5], [0.5, 1.0]])
C = np.array([[0.2, -0.1], [-0.1, 0.1]])
K = np.array([[5.0, -1.0], [-1.0, 3.0]])


def close(value, expected, *, rtol=0.0, atol=0.0):
    """Every entry within the tolerances named, and no others."""
    return np.allclose(value, expected, rtol=rtol, atol=atol)


def two_stops(**options):
    return [vi.Stop(0, 0.3, 0.9, **options), vi.Stop([1.0, -2.0], 0.4, 0.5, **options)]


def double_pendulum_matrices(m, mu):
    """Theory 2, symmetric form: mass, stiffness and the force of a unit base acceleration."""
    xi = m / (1 + m)
    alpha = xi / mu
    return np.array([[1, alpha], [alpha, alpha / mu]]), np.diag([1, alpha]) / (1 + m), np.array([1, alpha])


def every_object():
    scene = vi.paper_scene(kind=3)
    return {
        "LinearSystem": vi.LinearSystem(M, C, K, load=[1, 2], influence=[1, 0]),
        "diagonal": vi.LinearSystem([1, 2], [0.1, 0.2], [3, 4]),
        "DoublePendulum": vi.DoublePendulum(3, 3.24, (0.1, 0.2)),
        "PendulumChain": vi.PendulumChain([1, 2, 3], [1, 1, 2], 0.1),
        "Harmonic": vi.Harmonic([1, 2], 1.5, 0.3),
        "complex Harmonic": vi.Harmonic([1 + 1j, 2], 1.5, 0.3),
        "BaseMotion": vi.BaseMotion(0.1, 1.5, 0.3),
        "Stop": vi.Stop(1, 0.15, 0.9, side="lower", reaction="coordinate"),
        "vector Stop": vi.Stop([1, 2], -0.15, 0.9, reaction=[1, 0.5]),
        "Wall": vi.Wall(1, 0.5, 0.8, side="left"),
        "Scene": scene,
        "nonlinear Scene": vi.Scene(vi.DoublePendulum(1, 2), vi.BaseMotion(0.1, 2), vi.Wall(0, 0.5, 0.9)),
        "Modes": vi.modes(scene.system),
    }


def public_values(value):
    """What an object says of itself, as plain data."""
    found = {}
    for name in dir(type(value)):
        if not name.startswith("_") and not callable(getattr(value, name)):
            entry = getattr(value, name)
            is_own = type(entry).__module__.startswith("vibroimpact") or isinstance(entry, tuple)
            found[name] = repr(entry) if is_own else np.asarray(entry).tolist()
    return found


class TestInput:
    @pytest.mark.parametrize(
        "convert",
        [
            np.ndarray.tolist,
            lambda a: (4 * a).astype(np.float32) / np.float32(4),
            lambda a: np.repeat(np.repeat(a, 2, axis=0), 2, axis=-1)[::2, ::2] if a.ndim == 2 else np.repeat(a, 2)[::2],
            np.asfortranarray,
            lambda a: a[::-1][::-1],
        ],
        ids=["lists", "float32", "strided", "column order", "reversed twice"],
    )
    def test_array_likes_are_equal(self, convert):
        mass, damping, stiffness = M, np.array([[0.25, -0.125], [-0.125, 0.25]]), K
        load, influence, amplitude = np.array([0.5, 1.5]), np.array([1.0, 0.25]), np.array([2.0, 0.5])
        normal, q0, v0 = np.array([1.0, -0.5]), np.array([0.125, 0.0]), np.array([0.5, 0.25])
        plain = vi.LinearSystem(mass, damping, stiffness, load, influence)
        given_system = vi.LinearSystem(*map(convert, (mass, damping, stiffness, load, influence)))
        assert given_system == plain
        scene = vi.Scene(plain, vi.Harmonic(amplitude, 2), vi.Stop(normal, 0.5, 1))
        converted = vi.Scene(given_system, vi.Harmonic(convert(amplitude), 2), vi.Stop(convert(normal), 0.5, 1))
        assert converted == scene
        assert np.array_equal(converted.gaps(convert(q0)), scene.gaps(q0))
        one = vi.simulate(scene, q0, v0, (0, 5), t_eval=np.linspace(0, 5, 9))
        other = vi.simulate(scene, convert(q0), convert(v0), (0, 5), t_eval=convert(np.linspace(0, 5, 9)))
        assert np.array_equal(other.q, one.q)
        assert np.array_equal(other.v, one.v)

    def test_integers(self):
        assert vi.LinearSystem([[2, 0], [0, 1]], [0, 0], [[5, -1], [-1, 3]]) == vi.LinearSystem(
            [[2.0, 0.0], [0.0, 1.0]], [0.0, 0.0], [[5.0, -1.0], [-1.0, 3.0]]
        )
        assert vi.Harmonic([1, 2], 3) == vi.Harmonic([1.0, 2.0], 3.0)
        assert vi.Stop(np.int32(1), 1, 1) == vi.Stop(1, 1.0, 1.0)

    def test_plain_numbers_for_one_coordinate(self):
        plain = vi.Scene(vi.LinearSystem(2, 0.1, 3, 0.5, 1), vi.Harmonic(1, 2), vi.Stop(0, 0.5, 0.8))
        arrays = vi.Scene(vi.LinearSystem([2], [0.1], [3], [0.5], [1]), vi.Harmonic([1], 2), [vi.Stop(0, 0.5, 0.8)])
        assert plain == arrays
        assert plain.n_dof == 1
        assert plain.gaps(0.2) == pytest.approx([0.3])
        run = vi.simulate(plain, 0.1, 0, (0, 10))
        assert np.array_equal(run.q, vi.simulate(arrays, [0.1], [0], (0, 10)).q)

    def test_a_diagonal_is_the_matrix(self):
        diagonal = vi.LinearSystem([1, 2], [0.1, 0.2], [3, 4])
        dense = vi.LinearSystem(np.diag([1, 2]), np.diag([0.1, 0.2]), np.diag([3, 4]))
        one, other = vi.modes(diagonal), vi.modes(dense)
        assert close(one.natural_frequencies, np.sqrt([2, 3]), rtol=1e-14)
        assert close(other.natural_frequencies, np.sqrt([2, 3]), rtol=1e-14)

    def test_one_stop_or_several(self):
        system, stop = vi.LinearSystem(1, 0, 1), vi.Stop(0, 1, 1)
        assert vi.Scene(system, None, stop) == vi.Scene(system, stops=(stop,)) == vi.Scene(system, None, [stop])
        assert vi.Scene(system).stops == ()

    def test_data_are_copied(self):
        mass = np.eye(2)
        system = vi.LinearSystem(mass, C, K)
        mass[0, 0] = 7
        assert system.mass[0, 0] == 1
        system.mass[0, 0] = 7
        assert system.mass[0, 0] == 1


class TestSystems:
    @pytest.mark.parametrize(("m", "mu"), [(3, 3.24), (1, 3.2), (0.2, 0.7), (1e-6, 1), (1e6, 1)])
    def test_double_pendulum_about_rest(self, m, mu):
        p1, p2 = 0.3, 0.7
        system = vi.DoublePendulum(m, mu, (p1, p2)).linearise()
        mass, stiffness, force = double_pendulum_matrices(m, mu)
        assert close(system.mass, mass, rtol=1e-14, atol=0)
        assert close(system.stiffness, stiffness, rtol=1e-14, atol=0)
        assert close(system.damping, [[p1 + p2, -p2], [-p2, p2]], rtol=1e-14)
        assert close(mass @ system.influence, force, rtol=1e-9)

    def test_paper_system_differs_in_damping_alone(self):
        paper, pendulum = vi.paper_system(3, 3.24, 0.05), vi.DoublePendulum(3, 3.24, (0.1, 0.2)).linearise()
        assert close(paper.mass, pendulum.mass, rtol=1e-14)
        assert close(paper.stiffness, pendulum.stiffness, rtol=1e-14)
        assert close(paper.influence, pendulum.influence, rtol=1e-14)
        assert close(paper.damping, 0.1 * paper.stiffness, rtol=1e-14)
        assert not close(paper.damping, pendulum.damping)

    def test_paper_form_7(self):
        m, mu = 3.0, 3.24
        system = vi.paper_system(m, mu, 0.05)
        assert close(np.linalg.solve(system.mass, system.stiffness), [[1, -m / (1 + m)], [-mu, mu]], rtol=1e-13)

    def test_any_damping_matrix(self):
        assert np.array_equal(vi.DoublePendulum(1, 2, C).damping, C)
        assert np.array_equal(vi.DoublePendulum(1, 2, C).linearise().damping, C)
        assert np.array_equal(vi.PendulumChain([1, 2], [1, 1], C).damping, C)

    def test_chain_of_two_is_the_double_pendulum(self):
        m, mu = 3.0, 3.24
        chain = vi.PendulumChain([1 / (1 + m), m / (1 + m)], [1, 1 / mu], [0.3, 0.7], gravity=1 / (1 + m))
        one, other = chain.linearise(), vi.DoublePendulum(m, mu, (0.3, 0.7)).linearise()
        for name in ("mass", "damping", "stiffness", "influence"):
            assert close(getattr(one, name), getattr(other, name), rtol=1e-14, atol=1e-15)

    def test_chain_from_its_energies(self):
        masses, lengths, dampers, gravity = np.array([1.0, 2.0, 0.5]), np.array([1.0, 0.5, 2.0]), [0.1, 0.2, 0.3], 9.0
        system = vi.PendulumChain(masses, lengths, dampers, gravity).linearise()
        places = np.tril(np.ones((3, 3))) * lengths  # bob k stands at sum of l_i q_i, i <= k
        mass = places.T @ np.diag(masses) @ places
        joints = np.eye(3) - np.eye(3, k=-1)  # rates of the joints
        heights = np.tril(np.ones((3, 3))) * lengths  # second derivative of the height of bob k, on the diagonal
        assert close(system.mass, mass, rtol=1e-14)
        assert close(system.damping, joints.T @ np.diag(dampers) @ joints, rtol=1e-14, atol=1e-16)
        assert close(system.stiffness, np.diag(gravity * masses @ heights), rtol=1e-14)
        force = places.T @ masses  # of a unit acceleration of the base
        assert close(mass @ system.influence, force, rtol=1e-12)

    def test_one_damper_for_all(self):
        assert vi.PendulumChain([1, 2], [1, 1], 0.1) == vi.PendulumChain([1, 2], [1, 1], [0.1, 0.1])

    def test_linearise_of_a_linear_system_is_itself(self):
        system = vi.LinearSystem(M, C, K)
        assert system.linearise() == system


class TestForcing:
    def test_base_motion_is_the_force_it_makes(self):
        """u = a cos(w t + phase) makes the force -M r u'' = M r a w^2 cos(w t + phase)."""
        influence, amplitude, frequency, phase = np.array([1.0, -0.5]), 0.1, 1.7, 0.4
        system = vi.LinearSystem(M, C, K, influence=influence)
        stops = two_stops()
        base = vi.Scene(system, vi.BaseMotion(amplitude, frequency, phase), stops)
        force = vi.Scene(system, vi.Harmonic(M @ influence * amplitude * frequency**2, frequency, phase), stops)
        one = vi.simulate(base, [0.1, 0], [0, 0.2], (0, 20), t_eval=np.linspace(0, 20, 50))
        other = vi.simulate(force, [0.1, 0], [0, 0.2], (0, 20), t_eval=np.linspace(0, 20, 50))
        assert len(one.impacts) == len(other.impacts) > 3
        assert close(one.q, other.q, atol=1e-10)
        orbits = [vi.periodic_orbits(scene, [0], phase=1.0)[0] for scene in (base, force)]
        assert close(orbits[0].q0, orbits[1].q0, rtol=1e-12)
        assert close(orbits[0].v0, orbits[1].v0, rtol=1e-12)

    def test_base_motion_of_the_pendulum(self):
        """Theory 2: F = a w^2 (1, alpha) on the angles."""
        m, mu, a, w = 3.0, 3.24, 0.05, 1.5
        system = vi.paper_system(m, mu, 0.05)
        force = a * w**2 * double_pendulum_matrices(m, mu)[2]
        start = ([0.1, 0.0], [0.0, 0.1], (0, 30))
        times = np.linspace(0, 30, 40)
        one = vi.simulate(vi.Scene(system, vi.BaseMotion(a, w)), *start, t_eval=times)
        other = vi.simulate(vi.Scene(system, vi.Harmonic(force, w)), *start, t_eval=times)
        assert close(one.q, other.q, atol=1e-12)

    def test_the_frequency_scales_the_base_force_alone(self):
        scene = vi.paper_scene(kind=3)
        frequency = 2.0
        faster = scene.replace(frequency=frequency)
        assert faster.forcing.amplitude == scene.forcing.amplitude
        assert faster.period == pytest.approx(np.pi, rel=1e-15)

    def test_a_complex_amplitude_is_a_phase(self):
        system = vi.LinearSystem(M, C, K)
        turned = vi.Harmonic(np.array([1.0, 2.0]) * np.exp(0.7j), 1.3)
        plain = vi.Harmonic([1.0, 2.0], 1.3, 0.7)
        start = ([0.1, 0.0], [0.0, 0.1], (0, 10))
        times = np.linspace(0, 10, 30)
        one = vi.simulate(vi.Scene(system, turned), *start, t_eval=times)
        other = vi.simulate(vi.Scene(system, plain), *start, t_eval=times)
        assert close(one.q, other.q, atol=1e-13)
        assert turned.amplitude.dtype == complex
        assert plain.amplitude.dtype == float

    def test_steady_response(self):
        """Started on the steady response, an unconstrained system stays on it."""
        force, w, phase = np.array([1.0, -0.3j]), 1.3, 0.2
        amplitude = np.linalg.solve(K - w**2 * M + 1j * w * C, force) * np.exp(1j * phase)
        scene = vi.Scene(vi.LinearSystem(M, C, K), vi.Harmonic(force, w, phase))
        times = np.linspace(0, 40, 60)
        run = vi.simulate(scene, amplitude.real, (1j * w * amplitude).real, (0, 40), t_eval=times)
        assert close(run.q, (np.exp(1j * w * times)[:, None] * amplitude).real, atol=1e-12)


class TestScene:
    def test_gaps(self):
        stops = [*two_stops(), vi.Stop(1, -0.2, 0.9, side="lower")]
        scene = vi.Scene(vi.LinearSystem(M, C, K), None, stops)
        q = np.array([[[0.1, 0.2], [0.0, 0.0], [-1.0, 2.0]]])
        expected = np.stack([0.3 - q[..., 0], 0.4 - q[..., 0] + 2 * q[..., 1], -0.2 + q[..., 1]], axis=-1)
        assert close(scene.gaps(q), expected, rtol=1e-15)
        assert scene.gaps(q).shape == (1, 3, 3)
        assert scene.gaps([0.1, 0.2]).shape == (3,)

    def test_gaps_of_walls(self):
        lengths = np.array([1.0, 0.5, 2.0])
        walls = [vi.Wall(1, 0.4, 0.9), vi.Wall(2, -0.3, 0.9, side="left")]
        scene = vi.Scene(vi.PendulumChain([1, 1, 1], lengths), None, walls)
        q = np.array([0.2, -0.1, 0.7])
        places = np.cumsum(lengths * np.sin(q))
        gaps = scene.gaps(q)
        assert gaps[0] == pytest.approx(0.4 - places[1], rel=1e-14)
        assert gaps[1] == pytest.approx(places[2] + 0.3, rel=1e-14)

    def test_linearised_walls(self):
        lengths = np.array([1.0, 0.5])
        scene = vi.Scene(
            vi.PendulumChain([1, 1], lengths),
            vi.BaseMotion(0.1, 2),
            [vi.Wall(1, 0.4, 0.9), vi.Wall(0, -0.3, 0.8, side="left")],
        )
        linear = scene.linearise()
        assert isinstance(linear.system, vi.LinearSystem)
        assert linear.forcing == scene.forcing
        q = 1e-4 * np.array([1.0, -2.0])
        assert close(linear.gaps(q), scene.gaps(q), atol=1e-11)  # sin q = q to third order
        assert [stop.restitution for stop in linear.stops] == [0.9, 0.8]

    def test_period(self):
        assert vi.Scene(vi.LinearSystem(1, 0, 1), vi.Harmonic(1, 4)).period == pytest.approx(np.pi / 2, rel=1e-15)
        assert vi.Scene(vi.LinearSystem(1, 0, 1)).period is None

    def test_replace(self):
        scene = vi.paper_scene(kind=3)
        assert [s.clearance for s in scene.replace(clearance=0.3).stops] == [0.3, 0.3]
        assert [s.clearance for s in scene.replace(clearance=[0.3, 0.4]).stops] == [0.3, 0.4]
        assert [s.restitution for s in scene.replace(restitution=(0.3, 1)).stops] == [0.3, 1.0]
        assert [s.clearance for s in scene.replace(**{"clearance[1]": 0.4}).stops] == [scene.stops[0].clearance, 0.4]
        forced = scene.replace(frequency=2.0, phase=0.5, amplitude=0.2).forcing
        assert forced == vi.BaseMotion(0.2, 2.0, 0.5)
        assert scene.replace(forcing_scale=3).forcing.amplitude == pytest.approx(3 * scene.forcing.amplitude)
        assert close(scene.replace(damping_scale=3).system.damping, 3 * scene.system.damping)
        assert scene.replace(forcing=None).forcing is None
        assert scene.replace(stops=()).stops == ()
        assert scene.replace(system=vi.paper_system(1, 2, 0.1)).system == vi.paper_system(1, 2, 0.1)
        assert scene.replace() == scene
        assert scene == vi.paper_scene(kind=3)

    def test_kinds(self):
        assert vi.KINDS == {1: [(0, 1)], 2: [0], 3: [1], 4: []}

    @pytest.mark.parametrize("kind", [1, 2, 3])
    def test_paper_scenes(self, kind):
        m, mu, f10 = {1: (3, 3.24, 0.162), 2: (1, 3.24, 0.22), 3: (1, 3.2, 0.1)}[kind]
        scene = vi.paper_scene(kind, damping=0.03, clearance=0.2)
        mass, stiffness, force = double_pendulum_matrices(m, mu)
        assert close(scene.system.mass, mass, rtol=1e-14)
        assert close(scene.system.damping, 0.06 * stiffness, rtol=1e-14)
        assert scene.forcing.frequency == 1.5
        assert scene.forcing.amplitude * 1.5**2 == pytest.approx(f10, rel=1e-14)
        expected = [vi.Stop(i, 0.2, 0.9, reaction="coordinate") for i in range(2)]
        assert list(scene.stops) == expected
        full = vi.paper_scene(kind, damping=0.03, clearance=0.2, linear=False)
        assert isinstance(full.system, vi.DoublePendulum)
        assert close(full.system.damping, 0.06 * stiffness, rtol=1e-14)
        assert close(mass @ scene.system.influence, force, rtol=1e-12)

    def test_plan_names_what_runs(self):
        linear = vi.LinearSystem(M, C, K)
        assert "no forcing" in vi.Scene(linear).plan()
        assert "no stops" in vi.Scene(linear).plan()
        assert "real modes" in vi.paper_scene(kind=3).plan()
        assert "complex modes" in vi.Scene(linear).plan()
        assert "2 stops" in vi.paper_scene(kind=3).plan()


class TestObjects:
    @pytest.mark.parametrize("name", every_object())
    @pytest.mark.parametrize(
        "copied",
        [lambda x: pickle.loads(pickle.dumps(x)), copy.copy, copy.deepcopy],
        ids=["pickle", "copy", "deepcopy"],
    )
    def test_copies_are_equal(self, name, copied):
        value = every_object()[name]
        other = copied(value)
        assert type(other) is type(value)
        assert repr(other) == repr(value)
        assert public_values(other) == public_values(value)
        if name != "Modes":
            assert other == value

    def test_the_audit_can_be_pickled(self):
        audit = vi.audit_recovery(np.eye(2), 1.0, [0])
        assert pickle.loads(pickle.dumps(audit)).energy_gain == audit.energy_gain

    @pytest.mark.parametrize("name", every_object())
    def test_nothing_can_be_set(self, name):
        value = every_object()[name]
        for attribute in [*public_values(value), "anything"]:
            with pytest.raises(AttributeError):
                setattr(value, attribute, 1)

    @pytest.mark.parametrize("name", every_object())
    def test_repr_fits_a_screen(self, name):
        text = repr(every_object()[name])
        assert type(every_object()[name]).__name__ in text
        assert len(text.splitlines()) <= 24
        assert max(map(len, text.splitlines())) <= 160

    def test_repr_of_a_large_scene_fits_a_screen(self):
        n = 200
        stops = [vi.Stop(i, 1, 1) for i in range(n)]
        scene = vi.Scene(vi.LinearSystem(np.ones(n), np.zeros(n), np.ones(n)), vi.Harmonic(np.ones(n), 2), stops)
        assert len(repr(scene).splitlines()) <= 24

    def test_equality_is_by_value(self):
        assert vi.Stop(0, 1, 1) == vi.Stop(0, 1.0, 1.0)
        assert vi.Stop(0, 1, 1) != vi.Stop(0, 1, 0.9)
        assert vi.Stop(0, 1, 1) != "a stop"
        assert vi.paper_scene(3) != vi.paper_scene(2)


class TestModes:
    def test_paper_frequencies(self):
        """(10): w^4 - (1 + mu) w^2 + mu (1 - xi) = 0; the damping ratios are zeta w."""
        m, mu, zeta = 3.0, 3.24, 0.05
        squares = np.sort(np.roots([1, -(1 + mu), mu * (1 - m / (1 + m))]))
        modes = vi.modes(vi.paper_system(m, mu, zeta))
        assert close(modes.natural_frequencies, np.sqrt(squares), rtol=1e-13)
        assert close(modes.damping_ratios, zeta * np.sqrt(squares), rtol=1e-13)
        assert modes.is_proportional

    @law
    @given(st.integers(1, 6), st.integers(0, 2**32 - 1))
    def test_shapes_are_orthonormal(self, n, seed):
        random = np.random.default_rng(seed)
        a, b = random.normal(size=(2, n, n))
        mass, stiffness = a @ a.T + 0.1 * np.eye(n), b @ b.T + 0.1 * np.eye(n)
        modes = vi.modes(vi.LinearSystem(mass, 0.02 * stiffness + 0.1 * mass, stiffness))
        shapes, frequencies = modes.shapes, modes.natural_frequencies
        scale = np.linalg.cond(mass)
        assert close(shapes.T @ mass @ shapes, np.eye(n), atol=1e-13 * scale)
        assert close(shapes.T @ stiffness @ shapes, np.diag(frequencies**2), atol=1e-13 * scale * max(1, frequencies[-1] ** 2))
        assert np.all(np.diff(frequencies) >= 0)
        assert np.all(shapes[np.argmax(np.abs(shapes), axis=0), np.arange(n)] > 0)
        assert modes.is_proportional
        assert close(2 * modes.damping_ratios * frequencies, 0.02 * frequencies**2 + 0.1, rtol=1e-8)

    @law
    @given(st.integers(1, 5), st.integers(0, 2**32 - 1))
    def test_eigenvalues(self, n, seed):
        random = np.random.default_rng(seed)
        a, b, c = random.normal(size=(3, n, n))
        mass, stiffness, damping = a @ a.T + np.eye(n), b @ b.T, 0.3 * c @ c.T
        modes = vi.modes(vi.LinearSystem(mass, damping, stiffness))
        blocks = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
        expected = np.linalg.eigvals(blocks)
        assert modes.eigenvalues.shape == (2 * n,)
        distance = np.abs(modes.eigenvalues[:, None] - expected[None, :])
        assert distance.min(axis=0).max() < 1e-6 * np.abs(expected).max()
        assert distance.min(axis=1).max() < 1e-6 * np.abs(expected).max()

    def test_rigid_body(self):
        modes = vi.modes(vi.LinearSystem([1, 1], [0, 0], [[1, -1], [-1, 1]]))
        assert close(modes.natural_frequencies, [0, np.sqrt(2)], atol=1e-7)

    def test_joint_dampers_are_not_proportional_but_for_one_ratio(self):
        m = 3.0
        assert not vi.modes(vi.DoublePendulum(m, 3.24, (0.1, 0.2)).linearise()).is_proportional
        assert vi.modes(vi.DoublePendulum(m, 3.24, (0.1, 0.1 * m)).linearise()).is_proportional


class TestRecovery:
    @law
    @given(st.integers(1, 5), st.integers(0, 2**32 - 1), st.floats(0, 1), st.sampled_from(["inertia", "coordinate"]))
    def test_one_stop(self, n, seed, restitution, reaction):
        random = np.random.default_rng(seed)
        a = random.normal(size=(n, n))
        mass = a @ a.T + 0.2 * np.eye(n)
        normal = random.normal(size=n)
        scene = vi.Scene(vi.LinearSystem(mass, np.zeros(n), np.ones(n)), None, vi.Stop(normal, 1, restitution, reaction=reaction))
        matrix = vi.recovery_matrix(scene, 0)
        b = np.linalg.solve(mass, normal) if reaction == "inertia" else normal
        jump = np.eye(n) - (1 + restitution) * np.outer(b, normal) / (normal @ b)
        tolerance = 1e-12 * np.linalg.cond(mass)
        assert close(matrix, scipy.linalg.block_diag(np.eye(n), jump), atol=tolerance)
        assert close(normal @ matrix[n:, n:], -restitution * normal, atol=tolerance)
        audit = vi.audit_recovery(matrix, mass, [normal])
        assert audit.restitution[0] == pytest.approx(restitution, abs=tolerance)
        root = scipy.linalg.sqrtm(mass).real
        gain = np.linalg.norm(root @ jump @ np.linalg.inv(root), 2) ** 2
        assert audit.energy_gain == pytest.approx(gain, rel=1e-7)
        if reaction == "inertia":
            assert audit.is_realisable
            assert audit.energy_gain <= 1 + 1e-9

    @law
    @given(st.integers(2, 5), st.integers(0, 2**32 - 1))
    def test_coupled_stops(self, n, seed):
        """N^T P = -E N^T and the jump lies in the span of the reactions."""
        random = np.random.default_rng(seed)
        a = random.normal(size=(n, n))
        mass = a @ a.T + 0.5 * np.eye(n)
        normals, restitution = random.normal(size=(n, 2)), random.uniform(size=2)
        stops = [vi.Stop(normals[:, i], 1, restitution[i]) for i in range(2)]
        scene = vi.Scene(vi.LinearSystem(mass, np.zeros(n), np.ones(n)), None, stops)
        jump = vi.recovery_matrix(scene, [0, 1])[n:, n:]
        b = np.linalg.solve(mass, normals)
        expected = np.eye(n) - b @ np.linalg.solve(normals.T @ b, np.diag(1 + restitution) @ normals.T)
        tolerance = 1e-12 * np.linalg.cond(mass) * np.linalg.cond(normals) ** 2
        assert close(jump, expected, atol=tolerance)
        assert close(vi.recovery_matrix(scene, (1, 0))[n:, n:], expected, atol=tolerance)

    def test_both_pendulums_together(self):
        """R1 = -e I on the velocities, which never gains energy."""
        scene = vi.paper_scene(kind=1)
        matrix = vi.recovery_matrix(scene, (0, 1))
        assert close(matrix, np.diag([1, 1, -0.9, -0.9]), atol=1e-15)
        audit = vi.audit_recovery(matrix, scene.system.mass, [0, 1])
        assert audit.energy_gain == pytest.approx(0.81, rel=1e-12)
        assert audit.is_realisable

    @pytest.mark.parametrize(("m", "gain"), [(1.0, 5.27), (3.0, 12.58)])
    @pytest.mark.parametrize("mu", [0.5, 3.24])
    @pytest.mark.parametrize("stop", [0, 1])
    def test_the_papers_law_gains_energy(self, m, gain, mu, stop):
        system = vi.paper_system(m, mu, 0.05)
        stops = [vi.Stop(i, 1, 0.9, reaction="coordinate") for i in range(2)]
        matrix = vi.recovery_matrix(vi.Scene(system, None, stops), stop)
        audit = vi.audit_recovery(matrix, system.mass, [stop])
        assert audit.energy_gain == pytest.approx(gain, abs=0.005)
        assert not audit.is_realisable
        assert audit.reasons

    def test_a_stop_from_either_side_is_the_same_mirror(self):
        system = vi.LinearSystem(M, C, K)
        matrices = [
            vi.recovery_matrix(vi.Scene(system, None, vi.Stop([1, 2], 1, 0.7, side=side)), 0) for side in ("upper", "lower")
        ]
        assert close(*matrices, atol=1e-15)

    def test_normals_as_rows_or_indices(self):
        matrix = np.diag([1, 1, 1, -0.5])
        by_index = vi.audit_recovery(matrix, [1, 2], [1])
        by_row = vi.audit_recovery(matrix, [1, 2], [[0, 1]])
        assert by_index.restitution == by_row.restitution == pytest.approx([0.5])


def test_numbers_that_round_to_zero_are_shown_without_a_sign():
    w, ratios = np.arange(1.0, 8.0), np.array([-7e-18, -1e-9, -6e-7, -0.5, 0, 0.25, 0.1])
    shown = repr(vi.modes(vi.LinearSystem(np.ones(7), 2 * ratios * w, w**2)))
    assert "damping_ratios=[0.000000, 0.000000, -0.000001, -0.500000, 0.000000, 0.250000, ...]" in shown
