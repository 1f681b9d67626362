"""Branches through touches of stops that give way, beside closed forms, other ways to a number, and where the branch goes."""

import numpy as np
import pytest

import vibroimpact as vi

#: The releases, None without a dashpot.
RELEASES = (None, "gap", "force", "clipped")


def oscillator(release, forcing=1.0, preload=0.0, stops=1):
    """Return the scene of G12 of the references, and a stop on the other side too."""
    law = vi.Spring(20.0, 0.0 if release is None else 0.5, release=release, preload=preload)
    both = [vi.Stop(0, 0.5, contact=law), vi.Stop(0, 0.5, contact=law, side="lower")]
    return vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([forcing], 0.8), both[:stops])


def without_contact(scene):
    """Return the motion that meets no stop."""
    n = scene.n_dof
    return vi.find_orbit(scene, (np.zeros(n), np.zeros(n)), 1)


def touch_of(branch):
    """Return the one touch of a branch."""
    (found,) = [own for own in branch.special if own.kind in ("touch", "border_collision", "graze", "lost_impact")]
    return found


def met(scene):
    """Return the orbit with one contact."""
    (own,) = [own for own in vi.periodic_orbits(scene, [0]) if own.is_admissible]
    return own


#: The forcing at which the motion without contact touches the stop.
TOUCHING = 0.5 * np.hypot(0.36, 0.08)


@pytest.mark.parametrize("release", RELEASES)
def test_orbits_on_both_sides_are_those_of_the_branch(release):
    """At each value there is one orbit, with a contact behind the touch and none before, whose durations go to zero as a root."""
    branch = vi.continuation(met(oscillator(release)), "forcing_scale", (0.05, 2.0))
    touch = touch_of(branch)
    assert touch.parameter == pytest.approx(TOUCHING, abs=1e-14)
    assert touch.stop == 0
    assert [len(own.contacts) for own in branch.at(0.15)] == [0]
    durations = []
    for beyond in (1e-8, 4e-8):
        (own,) = branch.at(TOUCHING + beyond)
        assert own.is_admissible
        durations.append(np.ptp([own.contacts["start"], own.contacts["end"]]))
    assert durations[1] / durations[0] == pytest.approx(2.0, rel=0.05)
    rows = branch.durations
    assert rows.shape == (len(branch), 1)
    assert np.array_equal(np.isnan(rows[:, 0]), branch.parameter < touch.parameter)
    assert branch.to_arrays()["durations"].shape == rows.shape


def random_scene(rng):
    """Return a scene of one to three coordinates before a stop, and the scale of its forcing at which that is touched."""
    n = int(rng.integers(1, 4))
    a, b = rng.standard_normal((2, n, n))
    mass, stiffness = np.eye(n) + 0.3 * a @ a.T / n, 0.3 * np.eye(n) + b @ b.T
    damping = 2 * rng.uniform(0.005, 0.1) * (0.3 * mass + 0.5 * stiffness)
    force, frequency, normal = rng.standard_normal(n), rng.uniform(0.4, 2.5), rng.standard_normal(n)
    normal /= np.linalg.norm(normal)
    release = RELEASES[rng.integers(4)]
    k = 10 ** rng.uniform(-1, 3)
    c = 0.0 if release is None else 10 ** rng.uniform(-1.5, 0.5) * np.sqrt(k)
    stop = vi.Stop(normal, 0.5, contact=vi.Spring(k, c, release=release))
    scene = vi.Scene(vi.LinearSystem(mass, damping, stiffness), vi.Harmonic(force, frequency), stop)
    response = np.linalg.solve(-(frequency**2) * mass + 1j * frequency * damping + stiffness, force)
    return scene, 0.5 / abs(normal @ response)


@pytest.mark.parametrize("seed", range(6))
def test_the_rule_of_numbers_agrees_with_where_the_branch_goes(seed):
    """Random scenes: the touch is where the steady response says, behind it orbits keep the rules and close, a fold is one."""
    rng = np.random.default_rng(seed)
    n_followed = 0
    for _ in range(8):
        scene, touching = random_scene(rng)
        scene = scene.replace(forcing_scale=0.5 * touching)
        try:
            begun = without_contact(scene)
        except vi.ConvergenceError:
            continue
        if begun.signature or not begun.is_admissible:
            continue
        branch = vi.continuation(begun, "forcing_scale", (0.5, 2.6))
        touch = touch_of(branch)
        assert touch.parameter == pytest.approx(2.0, abs=1e-10)
        has_contact = np.array([len(own.contacts) > 0 for own in branch])
        assert has_contact.any(), branch
        first = branch.parameter[np.argmax(has_contact)]
        assert (touch.outcome == "fold") == (first < touch.parameter), (touch.data, first)
        for k in rng.integers(len(branch), size=3):
            own = branch[k]
            assert own.is_admissible
            if own.scene.stops[0].contact.release == "force" or np.abs(own.floquet_multipliers).max() > 20:
                continue
            run = vi.simulate(own.scene, own.q0, own.v0, (0, own.period))
            assert np.allclose(np.concatenate(run.final), np.concatenate([own.q0, own.v0]), atol=1e-8)
        n_followed += 1
    assert n_followed >= 3


def test_a_doubling_by_the_rule_is_an_orbit_of_two_periods():
    """Where the numbers say so the branches that meet the touch have one, which keeps the rules of contact."""
    n_found = 0
    for seed in range(40):
        scene, touching = random_scene(np.random.default_rng(seed))
        scene = scene.replace(forcing_scale=0.5 * touching)
        try:
            branch = vi.continuation(without_contact(scene), "forcing_scale", (0.5, 2.6))
            touch = touch_of(branch)
        except (ValueError, vi.ConvergenceError):
            continue
        if touch.outcome == "doubling":
            double = [own for own in touch.branches() if own.orbit.n_periods == 2]
            assert any(own.is_admissible for own in double), (seed, touch)
            n_found += 1
        if n_found == 2:
            return
    pytest.fail("too few scenes double at their touch")


@pytest.mark.parametrize("release", ["gap", "force", "clipped"])
def test_two_stops_that_are_touched_together(release):
    """The symmetric motion goes through the touch of both, and its pitchfork bears two that are each other's images."""
    branch = vi.continuation(without_contact(oscillator(release, 0.1, stops=2)), "forcing_scale", (0.5, 20.0))
    touch = touch_of(branch)
    assert 0.1 * touch.parameter == pytest.approx(TOUCHING, abs=1e-13)
    assert branch.parameter[-1] == 20.0
    assert {event[1] for event in branch[-1].signature} == {"stop[0]", "stop[1]"}
    (fork, *_) = [own for own in branch.special if own.kind == "pitchfork"]
    (born,) = fork.branches()
    image = born.orbit.mirrored()
    durations = [own.contacts["end"] - own.contacts["start"] for own in (born.orbit, image)]
    assert born.is_admissible
    assert np.allclose(np.sort(durations[0]), np.sort(durations[1]), rtol=1e-9)
    assert not np.isclose(*durations[0], rtol=1e-6)


@pytest.mark.parametrize(("release", "preload"), [("gap", 0.0), ("force", 0.0), ("clipped", 0.0), ("gap", 0.3)])
def test_curves_of_touches_are_those_of_the_steady_response(release, preload):
    """Over the forcing and the clearance, and over the forcing and the frequency, from either side."""
    scene = oscillator(release, preload=preload)
    up = vi.continuation(without_contact(oscillator(release, 0.1, preload)), "forcing_scale", (0.5, 20.0))
    down = vi.continuation(met(scene), "forcing_scale", (0.05, 2.0))
    for branch, unit, between in ((up, 0.1, (0.5, 20.0)), (down, 1.0, (0.05, 2.0))):
        touch = touch_of(branch)
        line = vi.bifurcation_curve(touch, ("forcing_scale", "clearance"), (between, (0.1, 2.0)))
        assert line.kind == touch.kind
        assert len(line) > 5
        assert np.allclose(unit * line.x / line.y, TOUCHING / 0.5, rtol=1e-12)
        curve = vi.bifurcation_curve(touch, ("forcing_scale", "frequency"), (between, (0.3, 2.0)))
        response = 1.0 / np.hypot(1.0 - curve.y**2, 0.1 * curve.y)
        assert np.allclose(unit * curve.x * response, 0.5, rtol=1e-11)


@pytest.mark.parametrize(("release", "preload"), [("gap", 0.0), ("force", 0.0), ("clipped", 0.0), ("gap", 0.3)])
def test_derivatives_by_the_numbers_of_a_law(release, preload):
    """Of phase, speed, largest displacement and multipliers, by central differences of orbits found anew."""
    scene = oscillator(release, preload=preload)
    orbit = met(scene)
    numbers = {"contact_stiffness": 20.0, "contact_damping": 0.5, "clearance": 0.5} | ({"preload": preload} if preload else {})
    found = orbit.derivatives([name if name == "clearance" else f"{name}[0]" for name in numbers])
    assert not found.reason

    def at(name, value):
        own = vi.find_orbit(scene.replace(**{name: value}), orbit)
        return own.phase, own.v0[0], own.max_displacement[0], own.floquet_multipliers[0]

    for j, (name, value) in enumerate(numbers.items()):
        step = 1e-4 * value
        ends = zip(at(name, value + step), at(name, value - step), strict=True)
        wanted = [(high - low) / (2 * step) for high, low in ends]
        own = found.phase[j], found.v0[0, j], found.max_displacement[0, j], found.multipliers[0, j]
        assert np.allclose(own, wanted, rtol=1e-5, atol=1e-7), name


def test_a_preload_ends_a_branch():
    """As an impact that loses its speed; from the other side it is a graze, behind which orbits are born that are not stable."""
    down = vi.continuation(met(oscillator("gap", preload=0.3)), "forcing_scale", (0.05, 2.0))
    lost = touch_of(down)
    assert (lost.kind, lost.outcome, down.ends[0][0]) == ("lost_impact", None, "boundary")
    assert lost.parameter == pytest.approx(TOUCHING, abs=1e-13)
    assert any(own.orbit.signature == () for own in lost.branches())
    up = vi.continuation(without_contact(oscillator("gap", 0.1, 0.3)), "forcing_scale", (0.5, 20.0))
    graze = touch_of(up)
    assert (graze.kind, up.ends[1][0]) == ("graze", "boundary")
    assert any(own.orbit.signature and not own.is_stable for own in graze.branches())
    assert graze.accumulation() is None


def test_what_a_touch_says_is_kept_in_files(tmp_path):
    """Kind, outcome and numbers come back with the branch."""
    branch = vi.continuation(met(oscillator("force")), "forcing_scale", (0.05, 2.0))
    branch.save(tmp_path / "branch.npz")
    one, other = touch_of(branch), touch_of(vi.load(tmp_path / "branch.npz"))
    assert (other.kind, other.outcome, other.data) == (one.kind, one.outcome, one.data)
    # G18 of the references.
    assert other.data["trace_after"] == pytest.approx(-0.324756224549594, abs=1e-13)


def test_a_tree_goes_through_touches():
    """From the motion without contact to the one with it on one branch, and to the doubling beside it."""
    tree = vi.branch_tree(without_contact(oscillator("gap", 0.1)), "forcing_scale", (0.5, 20.0), depth=1)
    assert any(own.n_periods == 2 for own in tree.branches)
