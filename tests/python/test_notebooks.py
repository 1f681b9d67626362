"""What notebooks show of scenes and results: well formed, escaped, short, with nothing loaded."""

from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1.25, 0.1, 1), vi.Harmonic([7.0], 2.4), vi.Stop(0, 1.0, 0.8))
ORBITS = vi.periodic_orbits(SCENE, [0])
BRANCH = vi.continuation(ORBITS[0], "forcing_scale", (0.5, 2.0))
RUN = vi.simulate(SCENE, [0.0], [0.0], (0, 200))


class Balance(HTMLParser):
    """Counts tags, and keeps the words."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.words = [], set(), []

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)
        self.tags.add(tag)
        assert not {name for name, _ in attrs} & {"src", "href", "onclick", "class", "id"}

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(result):
    found = Balance()
    text = result._repr_html_()
    found.feed(text)
    assert found.open == []
    assert "script" not in found.tags
    assert len(text) < 25_000
    return " ".join(found.words)


@pytest.mark.parametrize("result", [SCENE, ORBITS, ORBITS[0], BRANCH, RUN], ids=lambda own: type(own).__name__)
def test_a_table_is_well_formed_and_loads_nothing(result):
    assert read(result)


def test_basins_show_how_much_leads_where():
    plane = vi.basins(SCENE, q=(-1.0, 0.5, 4), v=(0.0, 1.0, 2))
    assert f"{plane.fractions[0]:.1%}" in read(plane)


def test_a_scene_shows_the_numbers_of_its_model():
    words = read(SCENE)
    for number in ("1.25", "0.1", "2.4", "0.8", "upper"):
        assert number in words


def test_an_orbit_shows_what_is_asked_first():
    words = read(ORBITS[0])
    assert f"{ORBITS[0].period:.6g}" in words
    assert "kept" in words
    assert f"{ORBITS[0].impacts['speed_before'][0]:.6g}" in words


def test_a_branch_shows_its_special_points_and_ends():
    words = read(BRANCH)
    assert "lost_impact" in words
    assert f"{BRANCH.special[0].parameter:.10g}" in words
    assert "the range ends at 2" in words


def test_text_is_escaped():
    ends = (("range", "<b>&"), ("range", "x"))
    assert "<b>&" in read(replace(BRANCH, ends=ends))
    assert "&lt;b&gt;&amp;" in replace(BRANCH, ends=ends)._repr_html_()


def test_long_ones_are_cut():
    many = vi.LinearSystem(np.ones(40), 0.1 * np.eye(40), np.eye(40))
    stops = [vi.Stop(k, 1.0, 0.8) for k in range(30)]
    words = read(vi.Scene(many, vi.Harmonic(np.ones(40), 2.0), stops))
    assert "…" in words
    assert "and 22 more" in words
    assert "and" in read(RUN)
    assert len(RUN.impacts) > 20


@pytest.mark.parametrize(
    "scene",
    [
        vi.Scene(vi.DoublePendulum(1.0, 1.0), vi.BaseMotion(0.1, 3.0), vi.Wall(1, 0.2, 0.7)),
        vi.paper_scene(kind=2),
        vi.Scene(vi.LinearSystem(1, 0, 1)),
        vi.Scene(vi.LinearSystem(1, 0, 1), [vi.Harmonic([1.0], 1.0), vi.Harmonic([1.0], 1.5)]),
    ],
)
def test_every_kind_of_scene_is_shown(scene):
    assert read(scene)
