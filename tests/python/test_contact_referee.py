"""Runs with stops that give way, beside rigid ones, against an exact twin that shares nothing with the library."""

import os

import numpy as np
import pytest
from contact_referee import disagreement, some_case
from contact_twin import Stop, Twin, run

#: A soak asks for more, at seeds of its own.
COUNT = int(os.environ.get("VIBROIMPACT_SOAK_CONTACTS", "300"))
SEED = int(os.environ.get("VIBROIMPACT_SOAK_CONTACTS_SEED", "1"))

#: x at t = 20 of a forced oscillator between stops at 0.5 (k = 20, c = 0.5) and -0.9 (k = 35, c = 0.5), from rest at 0 but
#: for v = 0.3: by steps in 34 digits and by exponentials, by releases.
REFERENCES = {"gap": -0.813048690801954, "force": -0.811734034490746}


@pytest.mark.parametrize("release", REFERENCES)
def test_the_twin_ends_where_the_reference_says(release):
    """The referee is right where the motion is known to 14 digits."""
    stops = [
        Stop(np.array([1.0]), clearance, None, stiffness, 0.5, release, 0.0, side)
        for clearance, stiffness, side in ((0.5, 20.0, "upper"), (0.9, 35.0, "lower"))
    ]
    one = np.array([[1.0]])
    twin = Twin(one, 0.1 * one, one, np.array([1.0]), 0.8, stops)
    own = run(twin, np.array([0.0]), np.array([0.3]), 20.0)
    assert own.q[0] == pytest.approx(REFERENCES[release], abs=1e-12)


def test_random_scenes_move_as_the_twin_says():
    """Contacts, regimes and ends of random scenes of all releases are those of the twin."""
    wrong = []
    for number in range(COUNT):
        case = some_case(SEED, number)
        found = disagreement(case.twin, case.q0, case.v0, case.end)
        if found:
            wrong.append(f"{SEED} {number}: {found}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("number", [477, 849])
def test_what_an_impact_does_beside_stops_that_give_way(number):
    """An impact holds one stop, and puts a force on another that cannot move then; and holds one as another begins to push."""
    case = some_case(101, number)
    assert disagreement(case.twin, case.q0, case.v0, case.end) is None
