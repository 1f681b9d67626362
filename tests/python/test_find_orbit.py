"""`find_orbit` from Python: the same answers, the guesses it takes and those it refuses."""

import numpy as np
import pytest

import vibroimpact as vi


@pytest.fixture(scope="module")
def stable():
    return vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]


def test_a_settled_trajectory_and_a_neighbour_give_the_orbit(stable):
    scene = stable.scene
    run = vi.simulate(scene, stable.q0 * 0.999, stable.v0, (0, 5.3 * stable.period))
    for guess in (run, stable):
        orbit = vi.find_orbit(scene, guess)
        assert orbit.n_periods == 2
        assert orbit.pattern == stable.pattern
        np.testing.assert_allclose(orbit.q0, stable.q0, atol=1e-12)
        np.testing.assert_allclose(orbit.v0, stable.v0, atol=1e-12)
        np.testing.assert_allclose(orbit.floquet_multipliers, stable.floquet_multipliers, atol=1e-9)
    assert len(vi.find_orbit(scene, run, n_periods=4).impacts) == 2


def test_following_an_orbit_through_a_parameter_ends_on_the_closed_form(stable):
    orbit = stable
    for zeta in np.linspace(0.05, 0.06, 6):
        scene = vi.paper_scene(kind=3, damping=zeta)
        orbit = vi.find_orbit(scene, orbit)
    known = vi.periodic_orbits(scene, pattern=[1], n_periods=2)
    distance = [max(abs(orbit.q0 - o.q0).max(), abs(orbit.v0 - o.v0).max()) for o in known]
    assert min(distance) < 1e-12


def test_what_does_not_close_says_how_far_it_got(stable):
    hopeless = vi.paper_scene(kind=3).replace(clearance=5.0)
    with pytest.raises(vi.ConvergenceError, match=r"shooting .* residual"):
        vi.find_orbit(hopeless, stable)


@pytest.mark.parametrize("n_periods", [3, 0, -1])
def test_period_counts_that_do_not_fit_are_refused(stable, n_periods):
    with pytest.raises(ValueError, match="n_periods"):
        vi.find_orbit(stable.scene, stable, n_periods=n_periods)


@pytest.mark.parametrize("guess", [None, 3.0, "orbit"])
def test_other_guesses_are_refused(stable, guess):
    with pytest.raises(TypeError, match="guess is of type"):
        vi.find_orbit(stable.scene, guess)


def test_a_found_orbit_can_be_saved(stable):
    import pickle

    orbit = vi.find_orbit(stable.scene, stable)
    again = pickle.loads(pickle.dumps(orbit))
    np.testing.assert_array_equal(again.v0, orbit.v0)


def ball(restitution, shake):
    """Make the scene of a ball of unit mass and weight on a table that shakes: q'' = -1 + a cos(t)."""
    system = vi.LinearSystem([1.0], [0.0], [0.0], load=[-1.0])
    return vi.Scene(system, vi.Harmonic([shake], 1.0), [vi.Stop(0, 0.0, restitution, side="lower")])


@pytest.mark.parametrize("restitution", [0.5, 0.0])
def test_a_ball_that_rests_on_its_table_each_period_is_let_go_at_minus_g(restitution):
    scene = ball(restitution, 1.3)
    run = vi.simulate(scene, 0.3, 0.0, (0, 12 * scene.period))
    orbit = vi.find_orbit(scene, run)
    (stick,) = orbit.segments[orbit.segments["kind"] == "stick"]
    # The table's acceleration reaches -g where a cos = 1, on its way up.
    release = (orbit.phase + stick["end"]) % (2 * np.pi)
    assert release == pytest.approx(2 * np.pi - np.arccos(1 / 1.3), abs=1e-11)
    assert stick["stop"] == 0
    assert orbit.is_admissible
    assert orbit.is_stable
    assert abs(orbit.floquet_multipliers).max() < 1e-12
    assert set(orbit.pattern) == {0}
    assert ("chatter" in orbit.segments["kind"]) == (restitution > 0)
    assert "in contact with stop 0 from t = " in repr(orbit)
    again = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 3 * orbit.period))
    t = np.linspace(0, 3 * orbit.period, 500)
    np.testing.assert_allclose(again.position(t), orbit.position(t), atol=1e-9)


def test_an_orbit_with_lasting_contact_can_be_saved_and_drawn():
    import pickle

    scene = ball(0.5, 1.3)
    orbit = vi.find_orbit(scene, vi.simulate(scene, 0.3, 0.0, (0, 12 * scene.period)))
    again = pickle.loads(pickle.dumps(orbit))
    t = np.linspace(0, orbit.period, 200)
    np.testing.assert_array_equal(again.position(t), orbit.position(t))
    np.testing.assert_array_equal(again.segments, orbit.segments)
    assert repr(again) == repr(orbit)
    assert "0 x " in repr(orbit)
    arrays = orbit.to_arrays()
    assert len(arrays["segments"]) == len(orbit.segments)
    pytest.importorskip("matplotlib").use("Agg")
    for draw in (vi.plot.time_history, vi.plot.phase_portrait, vi.plot.poincare_section, vi.plot.multipliers):
        assert draw(orbit).figure is not None


def test_a_pendulum_pressed_against_its_wall_each_period():
    wall = vi.Wall(1, -0.1, 0.5, side="right")
    scene = vi.Scene(vi.DoublePendulum(1.0, 1.0, damping=(0.2, 0.1)), vi.BaseMotion(0.4, 0.4), [wall])
    run = vi.simulate(scene, [-0.2, -0.2], [0.0, 0.0], (0, 12 * scene.period))
    orbit = vi.find_orbit(scene, run)
    assert orbit.is_admissible
    assert (abs(orbit.floquet_multipliers) < 1e-9).sum() == 2
    near = scene.replace(amplitude=0.405)
    followed = vi.find_orbit(near, orbit)
    settled = vi.find_orbit(near, vi.simulate(near, orbit.q0, orbit.v0, (0, 12 * scene.period)))
    np.testing.assert_allclose(followed.q0, settled.q0, atol=1e-10)
    np.testing.assert_allclose(followed.v0, settled.v0, atol=1e-10)


@pytest.mark.parametrize("linear", [True, False])
def test_a_run_that_holds_too_few_periods_is_refused_and_not_stretched(linear):
    """A settled run of exactly n periods has n impacts, the first and last n - 1 periods apart: of n there is no return."""
    chain = vi.PendulumChain([1.0, 0.5], [0.5, 0.3], damping=0.02)
    scene = vi.Scene(chain, vi.BaseMotion(0.03, 5.0), vi.Wall(1, 0.12, 0.7))
    scene = scene.linearise() if linear else scene
    settled = vi.simulate(scene, [0, 0], [0, 0], (0, 100 * scene.period))
    orbit = vi.find_orbit(scene, settled)

    def run(n):
        start, (q, v) = settled.t[-1], settled.final
        return vi.simulate(scene, q, v, (start, start + n * scene.period))

    assert orbit.pattern == [(0,)] or orbit.pattern == [0]
    for n in (1, 2, 3):
        assert len(run(n).impacts) == n
        with pytest.raises(ValueError, match=rf"guess is .* n_periods = {n} forcing periods earlier; simulate longer"):
            vi.find_orbit(scene, run(n), n_periods=n)
        longer = vi.find_orbit(scene, run(n + 1), n_periods=n)
        assert (longer.n_periods, len(longer.impacts)) == (n, n)
        np.testing.assert_allclose(longer.impacts["speed_before"], orbit.impacts["speed_before"][0], rtol=1e-10)


class TestFromAState:
    def test_the_state_behind_the_first_impact(self, stable):
        found = vi.find_orbit(stable.scene, (stable.q0, 1.001 * stable.v0), n_periods=2)
        assert found.pattern == [1]
        np.testing.assert_allclose(found.q0, stable.q0, atol=1e-12)
        np.testing.assert_allclose(found.floquet_multipliers, stable.floquet_multipliers, atol=1e-9)

    @pytest.mark.parametrize("part", [0.2, 0.55, 0.9])
    def test_any_other_of_its_states(self, stable, part):
        t = part * stable.period
        w = 2 * np.pi / stable.scene.period
        later = stable.scene.replace(phase=stable.phase + w * t)
        found = vi.find_orbit(later, [stable.position(t), stable.velocity(t)], n_periods=2)
        np.testing.assert_allclose(found.v0, stable.v0, atol=1e-12)
        assert abs(found.phase - stable.phase) < 1e-11

    def test_a_motion_that_hits_nothing(self):
        scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))
        found = vi.find_orbit(scene, (0.1, 0.0))
        assert found.pattern == []
        x = 1.0 / (1 - 2.4**2 + 0.24j)
        assert abs(found.position(0.0)[0] - abs(x) * np.cos(np.angle(x) + found.phase)) < 1e-12

    def test_without_forcing_the_period_is_guessed_too(self):
        scene = vi.Scene(vi.LinearSystem(1.0, -0.1, 1.0), None, vi.Stop(0, 0.3, 0.6))
        known = vi.find_orbit(scene, vi.simulate(scene, 0.0, 0.5, (0, 200)))
        found = vi.find_orbit(scene, (known.q0, known.v0, 1.02 * known.period))
        assert abs(found.period - known.period) < 1e-11

    def test_through_accumulating_impacts(self):
        ball = vi.LinearSystem([1.0], [0.0], [0.0], load=[-1.0])
        scene = vi.Scene(ball, vi.Harmonic([1.3], 1.0), [vi.Stop(0, 0.0, 0.5, side="lower")])
        known = vi.find_orbit(scene, vi.simulate(scene, 0.3, 0.0, (0, 12 * scene.period)))
        found = vi.find_orbit(known.scene, (known.q0, known.v0))
        assert found.pattern == known.pattern
        assert abs(found.phase - known.phase) < 1e-10

    def test_what_is_no_state(self, stable):
        scene = stable.scene
        with pytest.raises(ValueError, match=r"q0\[0\] is NaN"):
            vi.find_orbit(scene, ([np.nan, 0.0], [0.0, 0.0]))
        with pytest.raises(ValueError, match="q0"):
            vi.find_orbit(scene, ([0.0], [0.0, 0.0]))
        with pytest.raises(ValueError, match=r"guess\[2\] is 3, but the scene has a forcing"):
            vi.find_orbit(scene, (stable.q0, stable.v0, 3.0))
        free = vi.Scene(vi.LinearSystem(1.0, -0.1, 1.0), None, vi.Stop(0, 0.3, 0.6))
        with pytest.raises(ValueError, match=r"guess is a state without a period, .* \(q0, v0, period\)"):
            vi.find_orbit(free, (0.0, 0.5))
        with pytest.raises(ValueError, match=r"guess\[2\] is -1"):
            vi.find_orbit(free, (0.0, 0.5, -1.0))
        with pytest.raises(TypeError, match=r"it must be an Orbit, a Trajectory or \(q0, v0\)"):
            vi.find_orbit(scene, (stable.q0,))


class TestForAPattern:
    def scene(self, *more):
        stops = [vi.Stop(0, 0.5, 0.8), vi.Stop(0, 0.55, 0.7, side="lower"), *more]
        return vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 1.4), stops)

    def test_other_stops_are_passed_through(self):
        known = next(own for own in vi.periodic_orbits(self.scene(), [0, 1]) if own.is_admissible)
        other = self.scene(vi.Stop(0, 0.1, 0.5))
        run = vi.simulate(self.scene(), 0.0, 0.0, (0, 40 * known.period))
        t = known.period - 0.05
        state = (known.position(t), known.velocity(t))
        turned = other.replace(phase=known.phase + 1.4 * t)
        for where, guess in [(turned, state), (other, known), (other, run)]:
            found = vi.find_orbit(where, guess, pattern=[0, 1])
            assert found.pattern == [0, 1]
            assert found.is_admissible is False
            np.testing.assert_allclose(found.v0, known.v0, rtol=1e-10)

    def test_what_is_no_pattern(self):
        with pytest.raises(ValueError, match=r"pattern\[0\]"):
            vi.find_orbit(self.scene(), (0.0, 1.0), pattern=[7])
        with pytest.raises(ValueError, match="pattern must be a list"):
            vi.find_orbit(self.scene(), (0.0, 1.0), pattern=1)
        with pytest.raises(ValueError, match=r"stop 1 is to be reached from outside"):
            vi.find_orbit(self.scene(), (-1.0, 1.0), pattern=[1])
        free = vi.Scene(vi.LinearSystem(1, 0, 1), stops=vi.Stop(0, 0.5, 1.0))
        with pytest.raises(ValueError, match="a trajectory, but without forcing its period is not known"):
            vi.find_orbit(free, vi.simulate(free, -1.0, 0.0, (0, 20)), pattern=[0])
        with pytest.raises(ValueError, match="is not hit within a period"):
            vi.find_orbit(self.scene(vi.Stop(0, 50.0, 0.5)), (0.0, 1.0), pattern=[2])


@pytest.mark.parametrize("amplitude", [0.8, 2.5])
def test_the_orbit_itself_is_found_in_a_family_of_integrated_motions(amplitude):
    # q'' = -q - q^3 before a stop at 1/2: the quadrature of its period, without the root at its end.
    duffing = vi.NonlinearSystem(1, lambda t, q, v: -q - q**3, mass=1.0)
    scene = vi.Scene(duffing, stops=vi.Stop(0, 0.5, 1.0))
    x, weights = np.polynomial.legendre.leggauss(400)
    end = np.arcsin(0.5 / amplitude)
    angle = 0.5 * (end + np.pi / 2) * (x + 1) - np.pi / 2
    rate = 1 / np.sqrt(1 + 0.5 * amplitude**2 * (1 + np.sin(angle) ** 2))
    period = (end + np.pi / 2) * (weights * rate).sum()
    found = vi.find_orbit(scene, ([-amplitude], [0.0], period))
    assert found.period == pytest.approx(period, rel=1e-10)
    assert np.abs(found.position(np.linspace(0, period, 400))).max() == pytest.approx(amplitude, rel=1e-4)


def test_beyond_a_fold_the_error_says_that_there_is_one():
    scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 1.0), vi.Stop(0, 1.0, 0.8))
    orbit = vi.periodic_orbits(scene.replace(forcing_scale=0.1001), [0])[0]
    # The fold lies at 0.0999707.
    assert vi.find_orbit(scene.replace(forcing_scale=0.09999), orbit).is_admissible is not None
    for force in (0.09995, 0.0999):
        with pytest.raises(vi.ConvergenceError, match="there is a fold nearby"):
            vi.find_orbit(scene.replace(forcing_scale=force), orbit)
