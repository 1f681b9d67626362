"""The source paper's three kinds of motion over frequency and clearance: where each is born and lost, and by what.

A double pendulum on a shaken base hits a wall with the upper pendulum (kind 2), with the lower one (kind 3), or with both at once
(kind 1). For kinds 2 and 3 a map says where such a motion exists, keeps the rules of contact and is stable; each of its edges is
then followed as a curve of its own: a fold, a period doubling, a stop that is touched, an impact that has lost its speed. Kind 1
asks two stops for one instant, which takes one number more: it is a curve in the plane itself, drawn with what ends it.

You will see one picture of each kind; printed are the curves and how many edges of the map lie on one of them: all.

Run: python examples/paper_branches.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import vibroimpact as vi

#: Forcing periods in one period of the paper's orbit of each kind.
N_PERIODS = {1: 3, 2: 2, 3: 2}
#: Ranges of the frequency and of the clearance of both stops.
RANGES = {1: ((1.2, 1.8), (0.3, 1.5)), 2: ((1.3, 1.7), (0.2, 0.8)), 3: ((1.3, 1.7), (0.05, 0.3))}
NAMES = ("frequency", "clearance")
CELLS = 60
SEEDS = 5  # along each side of the map


def mapped(kind: int) -> vi.ExistenceMap:
    """Return the map of a kind."""
    axes = [(name, np.linspace(*ends, CELLS)) for name, ends in zip(NAMES, RANGES[kind], strict=True)]
    return vi.existence_map(vi.paper_scene(kind), vi.KINDS[kind], *axes, N_PERIODS[kind])


def special_points(kind: int) -> Iterator[vi.Special]:
    """Give the special points of branches over both numbers, from orbits all over the plane."""
    scene = vi.paper_scene(kind)
    for x in np.linspace(*RANGES[kind][0], SEEDS + 2)[1:-1]:
        for y in np.linspace(*RANGES[kind][1], SEEDS + 2)[1:-1]:
            there = scene.replace(frequency=x, clearance=y)
            for orbit in vi.periodic_orbits(there, vi.KINDS[kind], N_PERIODS[kind]):
                for name, between in zip(NAMES, RANGES[kind], strict=True):
                    branch = vi.continuation(orbit, name, between, virtual="keep" if orbit.is_admissible is False else "stop")
                    yield from branch.special


def place(special: vi.Special) -> tuple[float, float]:
    """Return where a special point lies in the plane."""
    scene = special.orbit.scene
    return scene.forcing.frequency, scene.stops[0].clearance


def curves(kind: int) -> list[vi.BifurcationCurve]:
    """Return the curves of all special points, each once."""
    found: list[vi.BifurcationCurve] = []
    for special in special_points(kind):
        if special.kind in ("torus", "branch_point", "corner") or any(near(own, special, kind) for own in found):
            continue
        found.append(vi.bifurcation_curve(special, NAMES, RANGES[kind]))
    return found


def near(curve: vi.BifurcationCurve, special: vi.Special, kind: int) -> bool:
    """Whether a special point lies on a curve of its kind."""
    if curve.kind != special.kind:
        return False
    return bool(distance(curve, np.array([place(special)]), kind)[0] < 2e-3)


def distance(curve: vi.BifurcationCurve, points: NDArray[np.float64], kind: int) -> NDArray[np.float64]:
    """Return the distances of points from the chords of a curve, in parts of the ranges."""
    span = np.array([high - low for low, high in RANGES[kind]])
    nodes, points = np.stack([curve.x, curve.y], axis=1) / span, points / span
    start, way = nodes[:-1], np.diff(nodes, axis=0)
    along = np.einsum("pkd,kd->pk", points[:, None] - start, way) / np.maximum((way**2).sum(axis=1), 1e-30)
    off = points[:, None] - start - np.clip(along, 0.0, 1.0)[..., None] * way
    return np.asarray(np.sqrt((off**2).sum(axis=2)).min(axis=1))


def edges(found: vi.ExistenceMap) -> NDArray[np.float64]:
    """Return the middles of all edges between cells of the map that are not alike."""
    x, y = np.asarray(found.x), np.asarray(found.y)
    kinds = np.stack([found.n_orbits > 0, found.is_admissible, found.is_admissible & found.is_stable])
    beside = (kinds[:, :, 1:] != kinds[:, :, :-1]).any(axis=0)
    above = (kinds[:, 1:] != kinds[:, :-1]).any(axis=0)
    middle = 0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1])
    own = [(middle[0][j], y[i]) for i, j in np.argwhere(beside)] + [(x[j], middle[1][i]) for i, j in np.argwhere(above)]
    return np.array(own)


def together() -> vi.BifurcationCurve:
    """Return the curve of kind 1, whose stops are hit at one instant: of every frequency some clearances."""
    scene = vi.paper_scene(1)
    orbit = vi.periodic_orbits(scene, vi.KINDS[1], N_PERIODS[1], free="clearance")[0]
    start = (orbit.scene.forcing.frequency, orbit.scene.stops[0].clearance)
    return vi.bifurcation_curve(orbit, lambda x, y: scene.replace(frequency=x, clearance=y), RANGES[1], start=start)


def verdicts(curve: vi.BifurcationCurve) -> list[str]:
    """Return of each orbit of a curve what it is."""
    names = {True: "stable", False: "not stable", None: "not decided"}
    return ["not admissible" if orbit.is_admissible is False else names[orbit.is_stable] for orbit in curve]


def changes(curve: vi.BifurcationCurve) -> None:
    """Print where the orbits of a curve become something else, and why."""
    found = verdicts(curve)
    print(f"kind 1: {curve}")
    for k in range(1, len(curve)):
        if found[k] != found[k - 1]:
            broken = next((own.violation for own in (curve[k], curve[k - 1]) if own.violation is not None), None)
            why = "a multiplier leaves the unit circle" if broken is None else broken.reason
            print(f"  at frequency {curve.x[k]:.4f}, clearance {curve.y[k]:.4f}: {found[k - 1]}, then {found[k]} ({why})")


def draw_together(curve: vi.BifurcationCurve, output: Path) -> None:
    """Draw the curve of kind 1, a colour for each verdict."""
    figure, ax = plt.subplots(figsize=(7.0, 5.0), layout="constrained")
    colours = {"stable": "#1d3a66", "not stable": "#b8503f", "not decided": "0.5", "not admissible": "#efc16a"}
    found = np.array(verdicts(curve))
    for name, colour in colours.items():
        if (found == name).any():
            mine = (found == name) | np.append(found[1:] == name, False)
            ax.plot(np.where(mine, curve.x, np.nan), np.where(mine, curve.y, np.nan), color=colour, linewidth=2.0, label=name)
    for point in curve.special:
        ax.plot(*point.parameter, "o", color="black", markerfacecolor="white", label=point.kind.replace("_", " "))
    ax.set(xlabel=NAMES[0], ylabel=NAMES[1], title="kind 1: both stops at one instant")
    ax.legend(fontsize="small")
    figure.savefig(output / "paper_branches_1.png", dpi=150)


def draw(kind: int, plane: vi.ExistenceMap, found: list[vi.BifurcationCurve], output: Path) -> None:
    """Draw the curves of a kind on its map."""
    figure, ax = plt.subplots(figsize=(7.0, 5.0), layout="constrained")
    vi.plot.existence_map(plane, ax)
    vi.plot.bifurcation_curves(found, ax)
    ax.set(title=f"kind {kind}: the {('upper', 'lower')[kind - 2]} pendulum hits")
    figure.savefig(output / f"paper_branches_{kind}.png", dpi=150)


def main() -> None:
    """Map, follow, check and draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figures")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    joint = together()
    changes(joint)
    draw_together(joint, output)
    for kind in (2, 3):
        plane, found = mapped(kind), curves(kind)
        off = np.min([distance(own, edges(plane), kind) for own in found], axis=0)
        unexplained = int((off > 1.5 / CELLS).sum())
        print(f"kind {kind}: {len(off)} edges between cells of the map, {unexplained} of them on none of the {len(found)} curves")
        for curve in found:
            print(curve)
        assert unexplained == 0, "every edge is a curve"
        draw(kind, plane, found, output)
    print(f"figures in {output}/")


if __name__ == "__main__":
    main()
