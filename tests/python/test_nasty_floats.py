"""Whatever floats are given: an answer in time, or a refusal in order."""

import multiprocessing
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import vibroimpact as vi

CASES = int(os.environ.get("VIBROIMPACT_CASES", "50"))
nasty = settings(max_examples=CASES, deadline=5000, suppress_health_check=[HealthCheck.too_slow])
ANSWER = 5.0  # [s] within which a search for orbits must answer
START = 60.0  # [s] within which the process that searches must start

NAN, INF = float("nan"), float("inf")
PAIR = vi.paper_scene(kind=3)
FORCED = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic(1, 2.8), vi.Stop(0, 0.5, 0.8))
ORBIT = vi.periodic_orbits(PAIR, [1], 2)[0]

NASTY = [NAN, INF, -INF, 1e308, -1e308, 1e154, -1e154, 1e-154, 5e-324, -5e-324, 2.3e-308, -0.0, 0.0, 1.0, 0.5, -1.0]
any_float = st.one_of(st.sampled_from(NASTY), st.floats())
size = st.integers(1, 3)


def vector(n):
    return st.lists(any_float, min_size=n, max_size=n)


def matrix(n):
    return st.one_of(st.lists(vector(n), min_size=n, max_size=n), vector(n))


def attempt(call, *arguments, **options):
    """The value of a call, or None where it is refused in order; anything else that is raised is a failure."""
    try:
        return call(*arguments, **options)
    except (ValueError, vi.ConvergenceError):
        return None
    except BaseException as error:
        if type(error).__name__ == "PanicException":
            raise AssertionError(f"panic: {error}") from None
        raise


def search(scene, pattern, n_periods, options):
    """Look for orbits and say in a word what came of it."""
    try:
        orbits = vi.periodic_orbits(scene, pattern, n_periods, **options)
        return "found" if repr(orbits) else "no text"
    except (ValueError, vi.ConvergenceError):
        return "refused"
    except BaseException as error:
        return f"{type(error).__name__}: {error}"


def serve(connection):
    connection.send("ready")
    while True:
        connection.send(search(*connection.recv()))


class Searcher:
    """Searches in a process of its own: one that hangs, deaf to signals, is ended, and the next call starts another."""

    def __init__(self):
        self.process = None

    def __call__(self, scene, pattern, n_periods=1, **options):
        if self.process is None:
            context = multiprocessing.get_context("spawn")
            self.connection, other = context.Pipe()
            self.process = context.Process(target=serve, args=(other,), daemon=True)
            self.process.start()
            assert self.connection.poll(START)
            self.connection.recv()
        self.connection.send((scene, pattern, n_periods, options))
        if not self.connection.poll(ANSWER):
            self.close()
            pytest.fail(f"no answer within {ANSWER} s")
        answer = self.connection.recv()
        assert answer in ("found", "refused")
        return answer

    def close(self):
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.connection.close()
            self.process = None


@pytest.fixture(scope="module")
def searcher():
    searcher = Searcher()
    yield searcher
    searcher.close()


# A search that does not answer costs seconds: take the first that is found.
searching = settings(nasty, deadline=None, phases=[Phase.explicit, Phase.generate], report_multiple_bugs=False)


class TestSearches:
    @searching
    @given(
        any_float,
        any_float,
        st.sampled_from([[0], [1], [(0, 1)], []]),
        st.sampled_from([None, 0.0, NAN, 1e308, 5e-324]),
    )
    def test_orbits_of_the_papers_scene(self, searcher, frequency, clearance, pattern, phase):
        scene = attempt(PAIR.replace, clearance=clearance)
        if scene is not None and (0.01 < abs(frequency) < 100 or not 1e-100 < abs(frequency) < 1e100):
            scene = attempt(scene.replace, frequency=frequency)
        if scene is not None:
            searcher(scene, pattern, phase=phase)

    @searching
    @given(st.data(), st.integers(1, 2))
    def test_orbits_in_nasty_units(self, searcher, data, n):
        """Ratios of times stay small, so that few oscillations fall in a period; everything else is extreme."""
        unit = st.sampled_from([1e300, 1e154, 1e100, 1.0, 1e-100, 1e-154, 1e-300, 5e-324])
        number = st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, 2.0, 1e-3, 100.0])
        mass, time, length = (data.draw(unit) for _ in range(3))
        numbers = [np.array(data.draw(st.lists(number, min_size=n, max_size=n))) for _ in range(4)]
        with np.errstate(all="ignore"):
            rate = np.float64(1.0) / time
            system = attempt(
                vi.LinearSystem,
                mass * np.ones(n),
                mass * rate * np.abs(numbers[0]),
                mass * rate**2 * numbers[1],
                mass * rate**2 * length * numbers[2],
            )
            forcing = attempt(vi.Harmonic, mass * rate**2 * length * numbers[3], rate)
        stop = attempt(vi.Stop, 0, length * data.draw(number), data.draw(st.sampled_from([0.0, 1.0, 0.5, 1e-12])))
        if None not in (system, forcing, stop):
            scene = vi.Scene(system, forcing, stop)
            for phase in (None, data.draw(number), data.draw(any_float)):
                searcher(scene, [0], phase=phase)

    @searching
    @given(any_float, any_float, any_float, any_float)
    def test_free_and_between(self, searcher, low, high, phase, scale):
        searcher(PAIR, [(0, 1)], 3, free="damping_scale", between=(low, high))
        searcher(PAIR, [(0, 1)], 3, phase=phase)
        scene = attempt(PAIR.replace, forcing_scale=scale)
        if scene is not None:
            searcher(scene, [(0, 1)], 3, free="clearance")
            searcher(scene, [(0, 1)], 3, free="forcing_scale")

    def test_no_impact_at_all(self, searcher):
        searcher(PAIR, [], 2)

    @pytest.mark.parametrize("phase", [None, 0.0])
    @pytest.mark.parametrize("amplitude", [0.0, 1e-15, 1e-300])
    def test_a_forcing_too_weak_to_leave_the_stop(self, searcher, amplitude, phase):
        """The load holds the mass at the stop: the gap is zero, or rounding, for the whole period."""
        system = vi.LinearSystem(1, 0.1, 1, load=0.1)
        searcher(vi.Scene(system, vi.Harmonic(amplitude, 1), vi.Stop(0, 0.1, 0.5)), [0], phase=phase)

    def test_a_free_parameter_up_to_the_largest_number(self, searcher):
        for between in [(0.0, 1e308), (1.0, 1e308), (5e-324, 1.0), (-1e308, 1e308)]:
            searcher(PAIR, [(0, 1)], 3, free="damping_scale", between=between)


class TestNastyFloats:
    @nasty
    @given(st.data(), size)
    def test_linear_systems(self, data, n):
        system = attempt(
            vi.LinearSystem,
            data.draw(matrix(n)),
            data.draw(matrix(n)),
            data.draw(matrix(n)),
            data.draw(vector(n)),
            None,
        )
        if system is not None:
            for name in ("mass", "damping", "stiffness", "load"):
                assert np.all(np.isfinite(getattr(system, name)))
            modes = attempt(vi.modes, system)
            assert modes is None or repr(modes)

    @nasty
    @given(any_float, any_float, any_float, any_float)
    def test_pendulums(self, a, b, c, d):
        for call in (
            lambda: vi.DoublePendulum(a, b, (c, d)),
            lambda: vi.PendulumChain([a, b], [c, d]),
            lambda: vi.PendulumChain([1, a], [1, b], [c, 0], gravity=d),
        ):
            system = attempt(call)
            if system is not None:
                linear = attempt(system.linearise)
                assert linear is None or np.all(np.isfinite(linear.stiffness))
        attempt(vi.paper_system, a, b, c)
        for kind in (1, 2, 3):
            attempt(vi.paper_scene, kind, damping=a, clearance=b, linear=bool(d))

    @nasty
    @given(any_float, any_float, any_float)
    def test_forcing_and_stops(self, a, b, c):
        for call in (
            lambda: vi.Harmonic([a], b, c),
            lambda: vi.Harmonic(complex(a, b), c),
            lambda: vi.BaseMotion(a, b, c),
            lambda: vi.Stop([a], b, c),
            lambda: vi.Stop(0, a, b, reaction=[c]),
            lambda: vi.Wall(0, a, b, side="left"),
        ):
            value = attempt(call)
            assert value is None or repr(value)

    @nasty
    @given(
        st.sampled_from(
            [
                "frequency",
                "phase",
                "amplitude",
                "clearance",
                "restitution",
                "forcing_scale",
                "damping_scale",
                "clearance[1]",
                "restitution[0]",
            ]
        ),
        any_float,
    )
    def test_replace(self, name, value):
        scene = attempt(PAIR.replace, **{name: value})
        if scene is not None:
            assert repr(scene)
            assert np.all(np.isfinite([stop.clearance for stop in scene.stops]))

    @nasty
    @given(st.data(), size, st.sampled_from(["inertia", "coordinate"]))
    def test_recovery_and_audit(self, data, n, reaction):
        system = attempt(vi.LinearSystem, data.draw(matrix(n)), np.zeros(n), np.ones(n))
        stops = [attempt(vi.Stop, data.draw(vector(n)), 1, data.draw(any_float), reaction=reaction) for _ in range(2)]
        if system is not None and None not in stops:
            scene = attempt(vi.Scene, system, None, stops)
            if scene is not None:
                attempt(vi.recovery_matrix, scene, 0)
                attempt(vi.recovery_matrix, scene, [0, 1])
        attempt(vi.audit_recovery, data.draw(matrix(2 * n)), np.eye(n), [data.draw(vector(n))])

    @nasty
    @given(any_float, any_float, any_float, any_float)
    def test_simulate(self, q0, v0, start, end):
        run = attempt(vi.simulate, FORCED, q0, v0, (start, min(end, start + 10.0)), max_impacts=20, keep="final")
        assert run is None or repr(run)

    @nasty
    @given(any_float, any_float)
    def test_times_of_an_orbit(self, t, other):
        q = attempt(ORBIT.position, [t, other])
        assert q is None or q.shape == (2, 2)
        v = attempt(ORBIT.velocity, t, side="before")
        assert v is None or np.all(np.isfinite(v))
