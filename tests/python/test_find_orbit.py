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
