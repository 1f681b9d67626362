"""Arguments by the names that others give them are answered with those that exist."""

import inspect
import pickle

import pytest

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([7.0], 2.4), vi.Stop(0, 1.0, 0.8))
MADE = [
    *(vi.LinearSystem, vi.DoublePendulum, vi.PendulumChain, vi.NonlinearSystem, vi.Scene, vi.Stop, vi.Wall, vi.NonlinearStop),
    *(vi.Harmonic, vi.BaseMotion, vi.Fourier, vi.Load, vi.BaseAcceleration, vi.Ramp),
]


@pytest.mark.parametrize("made", MADE)
def test_help_shows_the_arguments_that_are_taken(made):
    assert inspect.signature(made) == inspect.signature(made._made)


@pytest.mark.parametrize(
    ("given", "here", "call"),
    [
        ("M", "mass", lambda: vi.LinearSystem(M=1, C=0.1, K=1)),
        ("K", "stiffness", lambda: vi.LinearSystem(1, 0.1, K=1)),
        ("zeta", "damping", lambda: vi.LinearSystem(1, zeta=0.1, stiffness=1)),
        ("omega", "frequency", lambda: vi.Harmonic([1.0], omega=2.0)),
        ("freq", "frequency", lambda: vi.BaseMotion(1.0, freq=2.0)),
        ("amplitudes", "amplitude", lambda: vi.Harmonic(amplitudes=[1.0], frequency=2.0)),
        ("amplitude", "amplitudes", lambda: vi.Fourier(amplitude=[[1.0]], frequency=2.0)),
        ("phi", "phase", lambda: vi.Harmonic([1.0], 2.0, phi=2.0)),
        ("e", "restitution", lambda: vi.Stop(0, 1.0, e=0.5)),
        ("gap", "clearance", lambda: vi.Stop(0, gap=1.0, restitution=0.5)),
        ("clearance", "position", lambda: vi.Wall(1, clearance=1.0, restitution=0.5)),
        ("walls", "stops", lambda: vi.Scene(SCENE.system, walls=vi.Stop(0, 1.0, 0.8))),
        ("force", "forcing", lambda: vi.Scene(SCENE.system, force=SCENE.forcing)),
    ],
)
def test_a_name_from_elsewhere_is_answered_with_the_one_here(given, here, call):
    with pytest.raises(TypeError, match=rf"has no {given}: it is called {here} here \(of "):
        call()


def test_a_name_that_nothing_has_is_answered_with_all_names():
    with pytest.raises(
        TypeError, match="Stop has no colour: it has normal, clearance, restitution, contact, side, reaction, motion"
    ):
        vi.Stop(0, 1.0, 0.8, colour="red")


def test_what_is_missing_or_too_much_is_said_of_the_class():
    with pytest.raises(TypeError, match=r"^Stop\(\) missing 1 required positional argument: 'clearance'"):
        vi.Stop(0)
    with pytest.raises(TypeError, match="one of restitution and contact is needed"):
        vi.Stop(0, 1.0)
    with pytest.raises(TypeError, match="restitution and contact are both given"):
        vi.Stop(0, 1.0, 0.5, contact=vi.Newton(0.5))
    with pytest.raises(TypeError, match="contact is float, but a law of contact is needed"):
        vi.Stop(0, 1.0, contact=0.5)
    with pytest.raises(TypeError, match=r"^Harmonic\(\) takes .* positional arguments"):
        vi.Harmonic([1.0], 2.0, 0.0, 3.0)


@pytest.mark.parametrize(
    "call",
    [
        lambda: SCENE.replace(omega=2.0),
        lambda: vi.continuation(vi.periodic_orbits(SCENE, [0])[0], "omega", (1.0, 3.0)),
        lambda: vi.periodic_orbits(SCENE, [0])[0].derivatives("omega"),
    ],
)
def test_numbers_of_a_scene_too(call):
    with pytest.raises(ValueError, match=r"omega.*it is called frequency"):
        call()


def test_a_stop_on_both_sides_is_two():
    with pytest.raises(ValueError, match=r'side is "both".*on both sides stand two stops, one of each'):
        vi.Stop(0, 1.0, 0.8, side="both")


def test_a_run_that_was_not_kept_says_what_there_is():
    run = vi.simulate(SCENE, [0.0], [0.0], (0, 10), keep="final")
    with pytest.raises(ValueError, match="what there is of this run is its last state"):
        _ = run.t


def test_long_values_in_messages_are_cut():
    with pytest.raises(TypeError) as raised:
        vi.bifurcation_curve(vi.periodic_orbits(SCENE, [0])[0], list(range(500)), ((0, 1), (0, 1)))
    assert len(str(raised.value)) < 400
    with pytest.raises((TypeError, ValueError)) as raised:
        vi.periodic_orbits(SCENE, ["stop"] * 500)
    assert len(str(raised.value)) < 400


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: vi.simulate(SCENE, [0.0], [0.0], tspan=(0, 1)),
            r"^simulate\(\) has no tspan: it is called t_span here",
        ),
        (lambda: vi.simulate(SCENE, x0=[0.0], v0=[0.0], t_span=(0, 1)), "x0: it is called q0 here"),
        (lambda: vi.bifurcation_diagram(SCENE, parameter="phase", values=[1.0]), "parameter: it is called axis here"),
        (
            lambda: vi.bifurcation_diagram(SCENE, "phase", [1.0]),
            r"3 arguments by place, .* 2: .*; axis : \(str, array",
        ),
        (
            lambda: vi.basins(SCENE, (0, 1, 3), (0, 1, 3)),
            "3 arguments by place, .* 1: scene : .*; by name q, v",
        ),
        (lambda: vi.continuation(None, "phase", 0.0, 1.0), r"between : "),
        (lambda: vi.find_orbit(SCENE, colour="red"), r"find_orbit\(\) has no colour: it has scene, "),
    ],
)
def test_a_call_that_does_not_fit_is_answered_with_what_does(call, said):
    with pytest.raises(TypeError, match=said):
        call()


def test_other_errors_of_a_call_stay_as_they_are():
    with pytest.raises(TypeError, match="missing 2 required positional arguments"):
        vi.simulate(SCENE, [0.0])
    with pytest.raises(TypeError, match="scene is 'a', but a Scene is needed"):
        vi.simulate("a", [0.0], [0.0], (0.0, 1.0))


def test_functions_keep_their_signatures_and_can_be_sent():
    assert str(inspect.signature(vi.simulate)).startswith("(scene, q0, v0=None, t_span=None, *,")
    assert pickle.loads(pickle.dumps(vi.simulate)) is vi.simulate


@pytest.fixture(scope="module")
def things():
    orbit = vi.periodic_orbits(SCENE, [0])[0]
    run = vi.simulate(SCENE, [0.0], [0.0], (0, 5))
    return {"orbit": orbit, "run": run, "branch": vi.continuation(orbit, "frequency", (2.3, 2.5), max_points=2), "scene": SCENE}


@pytest.mark.parametrize(
    ("thing", "given", "said"),
    [
        ("orbit", "multipliers", "Orbit has no multipliers: it is called floquet_multipliers here"),
        ("orbit", "stable", "it is called is_stable here"),
        ("run", "time", r"Trajectory has no time: it is called t here \(of acceleration, along, "),
        ("run", "x", "it is called q here"),
        ("branch", "specials", "Branch has no specials: it is called special here"),
        ("branch", "values", "it is called parameter here"),
        ("scene", "colour", "Scene has no colour: it has .*forcing, .*stops, "),
    ],
)
def test_an_attribute_from_elsewhere_is_answered_with_the_one_here(things, thing, given, said):
    with pytest.raises(AttributeError, match=said):
        getattr(things[thing], given)
    assert not hasattr(things[thing], "__array__")


def test_names_of_the_modules_are_answered_with_those_that_are_near():
    with pytest.raises(AttributeError, match="has no attribute 'lyapunov'; is LyapunovExponents or lyapunov_exponents meant"):
        vi.lyapunov  # noqa: B018
    with pytest.raises(AttributeError, match=r"'phase_plane'; is .*phase_portrait.* meant"):
        vi.plot.phase_plane  # noqa: B018
    with pytest.raises(AttributeError, match=r"has no attribute 'xyzzy'$"):
        vi.xyzzy  # noqa: B018


@pytest.mark.parametrize(
    "call",
    [
        lambda orbit: vi.continuation(orbit, "force", (0.5, 2.0)),
        lambda orbit: vi.bifurcation_diagram(SCENE, ("force", [1.0, 2.0])),
        lambda orbit: vi.existence_map(SCENE, [0], ("force", [1.0]), ("clearance", [1.0])),
    ],
)
def test_a_force_is_a_factor_everywhere(things, call):
    with pytest.raises(ValueError, match="it is called forcing_scale here"):
        call(things["orbit"])


def test_a_factor_out_of_range_says_what_it_counts_from(things):
    with pytest.raises(ValueError, match=r"the orbit is at 1 \(a factor is 1 in the orbit's own scene\)"):
        vi.continuation(things["orbit"], "forcing_scale", (5.0, 12.0))


def test_what_has_many_lines_is_said_by_its_type(things):
    with pytest.raises(TypeError, match="orbit is of type Branch, but an Orbit is needed"):
        vi.continuation(things["branch"], "frequency", (2.3, 2.5))


def test_arguments_by_place_are_listed():
    with pytest.raises(TypeError, match=r"^Load\(\) takes 2 positional arguments.*: direction, signal"):
        vi.Load(0, [0.0, 1.0], [0.0, 1.0])
