"""What branches meet at boundaries, and what becomes of motions beyond: scenes whose answer is known."""

import numpy as np
import pytest

import vibroimpact as vi


def twice(mass, damping, stiffness, force, frequency, stops):
    """Return a scene of two masses under three harmonics."""
    return vi.Scene(vi.LinearSystem(mass, damping, stiffness), vi.Fourier(force, frequency), stops)


def settled(scene, periods, start=None):
    """Return the orbit that a motion from rest comes to."""
    n = scene.system.n_dof
    q = np.zeros(n) if start is None else np.array(start)
    return vi.find_orbit(scene, vi.simulate(scene, q, np.zeros(n), (0.0, periods * scene.period)))


#: Two masses that are coupled by their inertia, before a stop that takes all speed and one that does not.
COUPLED = np.array([[0.6802586272588459, -0.07101927751465109], [-0.07101927751465109, 1.3197429036202228]])
E = 0.3


@pytest.fixture(scope="module")
def graze():
    """Return a graze of stop 1 while stop 0 is held: an impact there throws the motion off stop 0."""
    damping = [[0.21764562973552043, 0.026726306873130334], [0.02672630687313032, 0.21200460112190958]]
    stiffness = [[7.41110983476109, -1.64002530945409], [-1.64002530945409, 2.3976750026872446]]
    force = [
        [-1.2626969784731117 - 0.11298286278480728j, -0.801961465830822 + 0.26432356809025925j],
        [0.33110217920174895 - 0.1263176769414653j, 0.15929533800163626 + 0.19795879588070892j],
        [1.0061741628716825 - 0.3318316518565526j, 0.13978452935717967 - 0.0796141628623146j],
    ]
    w = 0.8301776797122838
    motion = vi.Harmonic([0.06506016186405365], w, 0.19213107852483446)
    stops = [
        vi.Stop(0, 0.08133819692711536, 0.0, side="lower", motion=motion),
        vi.Stop(1, 0.35616798413132217, E, side="lower"),
    ]
    orbit = settled(twice(COUPLED, damping, stiffness, force, w, stops), 150)
    branch = vi.continuation(orbit, "frequency", (0.5959816972361576, 1.2832220408083732))
    return next(own for own in branch.special if own.kind == "graze")


class TestAHeldStop:
    def test_candidates_obey_the_law_of_impact(self, graze):
        hops = 0
        for own in graze.branches():
            if not own.is_admissible:
                continue
            orbit = own.orbit
            for row in orbit.impacts[orbit.impacts["stop"] == 1]:
                t = float(row["time"])
                before = orbit.velocity(t if t > 0.0 else orbit.period, side="before")
                after = orbit.velocity(t)
                # The motion is before q1 = -0.356: the impulse pushes up.
                push = np.linalg.solve(COUPLED, [0.0, 1.0])
                impulse = (1.0 + E) * row["speed_before"] / push[1]
                assert np.abs(after - before - push * impulse).max() < 1e-11
                held = [bool(s["kind"] == "stick" and s["stop"] == 0 and abs(s["start"] - t) < 1e-12) for s in orbit.segments]
                # Stop 0 opens, as the impulse pushes the first mass up too.
                assert push[0] > 0.0
                assert not any(held)
                hops += 1
            # From its own state a run comes back to it, with as many impacts.
            late = 0.5 * (orbit.impacts["time"][-1] + orbit.period)
            phase = float(orbit.phase + 2.0 * np.pi * orbit.n_periods * late / orbit.period)
            scene = orbit.scene.replace(phase=phase)
            run = vi.simulate(scene, orbit.position(late), orbit.velocity(late), (0.0, orbit.period))
            assert np.abs(run.final[0] - orbit.position(late)).max() < 1e-7
        assert hops > 0

    def test_beyond_is_a_value(self, graze):
        assert graze.beyond().outcome in {"continues", "nonsmooth_fold", "jumps", "undecided"}


MASS = [[1.4429645740044468, -0.2024776376631543], [-0.20247763766315433, 0.5461516587375783]]
DAMPING = [[0.03837848068005368, 0.00014217311966984182], [0.00014217311966984182, 0.02055870348064374]]
STIFFNESS = [[7.78250583676809, -1.4739462051231504], [-1.4739462051231507, 5.410448363444805]]
FORCE = [
    [-0.6117521762548075 - 1.11826609024127j, 1.356291764779191 + 1.4829799260065495j],
    [-0.852856167068701 - 0.05826252919278024j, 0.412462415343785 - 0.5458722107754636j],
    [0.7200553457777867 - 0.3285306898903273j, -0.11403856012529952 + 0.9137046482609121j],
]


class TestAReleaseMeetsAnImpact:
    def make(self, w):
        """Return the scene of a frequency."""
        one = vi.Harmonic([0.17800866525189885], w, -2.291270813153048)
        other = vi.Harmonic([0.08619767059564229], w, -2.927919591743488)
        stops = [
            vi.Stop([0.34020730555611267, 1.3428940150295683], 0.13799251018477132, 0.0, motion=one),
            vi.Stop(
                [-2.0070058319129642, -0.9658949742708689], 0.15893876893240555, 0.801485774178968, side="lower", motion=other
            ),
        ]
        return twice(MASS, DAMPING, STIFFNESS, FORCE, w, stops)

    def test_the_impact_ends_the_contact_instead(self):
        branch = vi.continuation(settled(self.make(1.8315), 600), "frequency", (1.28, 2.56), direction="down")
        point = branch.special[0]
        found = point.beyond()
        assert found.outcome == "continues"
        # Beyond, below: the contact with stop 0 ends at the impact on stop 1, at which the last orbit lets it go.
        own = next(own for own in found.candidates if own.side == -1 and own.is_admissible)
        assert own.is_stable
        first = own.orbit.segments[0]
        assert (str(first["kind"]), int(first["stop"])) == ("stick", 0)
        hit = own.orbit.impacts[own.orbit.impacts["stop"] == 1]["time"]
        assert np.abs(hit - first["end"]).min() == 0.0
        t = np.linspace(0.0, 1.0, 50)
        off = np.abs(own.orbit.position(t * own.orbit.period) - point.orbit.position(t * point.orbit.period)).max()
        assert off < 10.0 * abs(own.parameter - point.parameter)


def counted_from_each(orbit):
    """Return an orbit counted from each of its impacts."""
    for t in orbit.impacts["time"] + 1e-9 * orbit.period:
        phase = float(orbit.phase + 2.0 * np.pi * orbit.n_periods * t / orbit.period)
        yield vi.find_orbit(orbit.scene.replace(phase=phase), (orbit.position(t), orbit.velocity(t)), orbit.n_periods)


def test_one_motion_has_one_outcome_from_whichever_impact_it_is_counted():
    system = vi.LinearSystem(1.8229324317007218, 0.04676220609206483, 3.778975976233941)
    stops = [
        vi.Stop([-0.007950127279143944], 0.005917726300078052, 0.6142357665082107),
        vi.Stop([-0.7706139768768453], 1.0843278994789941, 0.4, side="lower"),
    ]
    scene = vi.Scene(system, vi.Harmonic([31.315927009350653], 3.8388516498992367), stops)
    orbit = vi.find_orbit(scene.replace(phase=5.8473010358816), ([1.407096071464435], [-2.1972968467928507]), 1)
    outcomes, patterns = set(), set()
    for own in counted_from_each(orbit):
        (lost,) = [s for s in vi.continuation(own, "clearance[0]", (0.001, 0.02)).special if s.kind == "lost_impact"]
        patterns.add(str(own.pattern))
        found = lost.beyond()
        outcomes.add((round(lost.parameter, 9), found.outcome, len(found.candidates)))
        # The branch has as many impacts in as many periods.
        like = [c for c in found.candidates if c.orbit.n_periods == 1 and len(c.orbit.impacts) == len(own.impacts)]
        assert not like
    assert len(patterns) == 3
    assert len(outcomes) == 1, outcomes


def free(w, clearance=0.0):
    """Return x'' + x = cos w t before a stop, e = 0.8."""
    return vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), vi.Harmonic([1.0], w), vi.Stop(0, clearance, 0.8))


class TestVanishingImpacts:
    @pytest.mark.parametrize(("w", "direction"), [(0.3, "up"), (0.334, "down")])
    def test_they_are_found_at_one_place_and_the_motion_goes_on(self, w, direction):
        branch = vi.continuation(settled(free(w), 60, [-0.5]), "frequency", (0.25, 0.45), direction=direction)
        (own,) = branch.special
        assert own.kind == "vanishing_impacts"
        assert abs(own.parameter - 1.0 / 3.0) <= own.error < 1e-8
        assert max(own.orbit.impacts["speed_before"]) < 1e-3
        longest = max(s["end"] - s["start"] for s in own.orbit.segments if s["kind"] == "stick")
        assert longest == pytest.approx(3.0 * np.pi, abs=0.1)
        found = own.beyond()
        assert found.outcome == "continues"


def test_beyond_the_border_of_a_chatter_the_motion_goes_on():
    # The stick shrinks to nothing at a clearance that is known to 18 digits.
    branch = vi.continuation(settled(free(0.3), 40, [-0.5]), "clearance", (-0.2, 0.3), direction="up")
    border = branch.special[-1]
    assert border.kind == "chatter_border"
    assert border.parameter == pytest.approx(0.12344859784802915, abs=1e-9)
    assert border.beyond().outcome == "continues"
