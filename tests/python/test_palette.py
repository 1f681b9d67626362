"""Colours: seen against the ground, and told apart in grey and by those who do not see green."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from vibroimpact.plot import _contact, _solid, curves, diagram, existence, exponents
from vibroimpact.plot.basins import COLOURS, OTHERS
from vibroimpact.plot.branch import COLOUR, MARKS

#: Colours of linear light as one without green cones sees them (Machado, Oliveira, Fernandes 2009, severity 1).
DEUTERANOPIA = np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]])
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([0.9505, 1.0, 1.089])

CLASSES = {
    "existence_map": [colour for _, colour in existence.CATEGORIES],
    "basins": [*COLOURS, OTHERS[-1][1], OTHERS[-2][1]],
    "exponents": exponents.COLOURS,
    "ways of a diagram": [colour for _, colour, _ in diagram.WAYS.values()],
    "contact": list(_contact.CONTACT_COLOURS.values()),
}
LINES = [
    *exponents.COLOURS,
    COLOUR,
    _solid.FLASH_COLOUR,
    *CLASSES["ways of a diagram"],
    *(own[0] for own in curves.LINES.values()),
]


def linear(colour):
    rgb = np.array(to_rgb(colour))
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(light):
    ratio = TO_XYZ @ np.clip(light, 0.0, 1.0) / WHITE
    x, y, z = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16.0 / 116.0)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def seen_without_green(colour):
    return lab(DEUTERANOPIA @ linear(colour))


def contrast(one, other):
    high, low = sorted((TO_XYZ[1] @ linear(colour) for colour in (one, other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", CLASSES)
def test_classes_differ_in_grey_and_without_green(name):
    for one, other in combinations(CLASSES[name], 2):
        grey = abs(lab(linear(one))[0] - lab(linear(other))[0])
        apart = np.linalg.norm(seen_without_green(one) - seen_without_green(other))
        # Classes of a plane touch: a step in lightness that the eye sees at an edge.
        assert grey > 3.0, (one, other, grey)
        assert apart > 10.0, (one, other, apart)


@pytest.mark.parametrize("colour", sorted(set(LINES)))
def test_lines_stand_out_from_the_ground(colour):
    assert contrast(colour, "white") > 2.0


def test_kinds_of_curves_differ_by_their_lines_in_grey_and_by_their_colours_without_green():
    for (_, one), (_, other) in combinations(curves.LINES.items(), 2):
        grey = abs(lab(linear(one[0]))[0] - lab(linear(other[0]))[0])
        assert one[1] != other[1] or grey > 10.0, (one, other)
        apart = np.linalg.norm(seen_without_green(one[0]) - seen_without_green(other[0]))
        assert one[1] != other[1] or apart > 10.0, (one, other)


def test_every_kind_of_point_has_a_mark_of_its_own():
    marks = [mark for mark, _ in MARKS.values()]
    assert len(set(marks)) == len(marks)
    both = [*curves.TWO_AT_ONCE.values(), *marks]
    shared = {mark for mark in both if both.count(mark) > 1}
    # A star is a crossing on a branch and a cusp on a curve, a square a doubling and a fold-flip, a circle a fold and a graze.
    assert shared <= {"*", "s", "o", "P"}
