"""What branches meet at boundaries, and what becomes of the motion there, of random scenes: the referee's laws and runs."""

import os

import numpy as np
import pytest
from beyond_referee import are_one, misses, seen, some_twin, stands

import vibroimpact as vi
from vibroimpact.results.special import BOUNDARIES

CASES = int(os.environ.get("VIBROIMPACT_CASES", "8"))
SEED = int(os.environ.get("VIBROIMPACT_SEED", "7"))
ONE = os.environ.get("VIBROIMPACT_CASE")
NUMBERS = range(CASES) if ONE is None else [int(ONE)]

#: What an orbit may miss its laws by: it closes to 1e-11, and what is left of a chatter is as much as the root of that.
LAWS = 1e-7


def counted(orbit):
    """Return an orbit counted from each of its impacts, the first four, where none accumulate."""
    if any(str(row["kind"]) != "flight" for row in orbit.segments):
        return [orbit]
    found = [orbit]
    for k in range(1, min(len(orbit.impacts), 4)):
        t = float(orbit.impacts["time"][k]) + 1e-9 * orbit.period
        phase = float(orbit.phase + 2.0 * np.pi * orbit.n_periods * t / orbit.period) % (2.0 * np.pi)
        state = (orbit.position(t), orbit.velocity(t))
        try:
            own = vi.find_orbit(orbit.scene.replace(phase=phase), state, orbit.n_periods)
        except (ValueError, vi.ConvergenceError):
            continue
        if are_one(orbit, own):
            found.append(own)
    return found


def followed(twin, name, between, start):
    """Return the branches of what a motion comes to, counted from each impact; none where there is no orbit."""
    scene = twin.scene()
    if not all(scene.gaps(start, 0.0) > 0.0):
        return []
    try:
        orbit = vi.find_orbit(scene, vi.simulate(scene, start, 0.0 * start, (0.0, 300.0 * scene.period)))
        if not orbit.is_admissible:
            return []
        return [vi.continuation(own, name, between) for own in counted(orbit)]
    except (ValueError, vi.ConvergenceError):
        return []


@pytest.mark.parametrize("number", NUMBERS)
def test_what_is_beyond_boundaries(number):
    rng = np.random.default_rng([SEED, number])
    wrong = []
    twin, name, between = some_twin(rng)
    outcomes = {}
    branches = followed(twin, name, between, rng.normal(size=len(twin.force)) * rng.choice([0.0, 0.3]))
    for counted_from, branch in enumerate(branches):
        for special in branch.special:
            if special.kind not in BOUNDARIES:
                continue
            found = special.beyond()
            own = (special.kind, found.outcome)
            outcomes.setdefault(round(special.parameter / (between[1] - between[0]), 5), {})[counted_from] = own
            for candidate in found.candidates:
                there = twin.with_value(name, candidate.parameter)
                if candidate.is_admissible:
                    miss, what = misses(there, candidate.orbit)
                    if miss > LAWS:
                        wrong.append(f"{special}: {candidate} misses a law by {miss:.1e}: {what}")
                if any(are_one(orbit, candidate.orbit) for orbit in branch.at(candidate.parameter)):
                    wrong.append(f"{special}: {candidate} is the branch itself")
            if counted_from > 0:
                continue
            far = 1 if special.direction[-1] >= 0.0 else -1
            said, apart = seen(twin, special, far, 1e-3 * (between[1] - between[0]))
            print(number, special, found, said, [f"{x:.1e}" for x in apart])
            # Where the branch is not stable runs from its last orbit lead away on both sides: what stands beyond is looked at.
            there = [own for own in found.candidates if own.side == far and own.is_admissible and own.is_stable]
            is_beside = not special.orbit.is_stable and any(stands(own) for own in there)
            if (said, found.outcome) in (("goes on", "jumps"), ("goes on", "nonsmooth_fold")) or (
                (said, found.outcome) == ("elsewhere", "continues") and not is_beside
            ):
                wrong.append(f"{special}: {found}, but runs: {said}, {apart}")
            if special.orbit.is_stable:
                said, apart = seen(twin, special, -far, 1e-3 * (between[1] - between[0]))
                if said == "elsewhere":
                    wrong.append(f"{special}: before it runs are elsewhere, {apart}")
    for value, each in outcomes.items():
        if len(set(each.values())) > 1:
            wrong.append(f"outcomes at {value} of the range by the impact counted from: {each}")
    assert not wrong, "\n".join(wrong)
