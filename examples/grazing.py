"""Grazing: what is born where a driven mass just touches its stop, and what the mass does beyond.

`x'' + 0.1 x' + x = F cos t` with a stop at x = 1 and restitution 0.8, driven at its own frequency: the example of an impact
oscillator that comes with COCO. Up to F = 0.1 the mass swings without an impact. The motion with one impact in each period comes
down from large forces to F = 0.09997, turns there by a fold, and meets the other at F = 0.1, where its impact has lost its speed:
a part of 3e-5 of the force, in which two attractors stand beside each other and an unstable motion lies between.

You will see that branch with its fold beside its closed form; what is born at the graze, on which side and whether it can be
seen; what becomes of the motion beyond; and a picture of all branches that meet there, with the neighbourhood of the graze
enlarged.

Run: python examples/grazing.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

DAMPING, FREQUENCY, CLEARANCE, RESTITUTION = 0.1, 1.0, 1.0, 0.8


def oscillator() -> vi.Scene:
    """Return the scene, its force of one: a factor on the force is the force."""
    return vi.Scene(vi.LinearSystem(1.0, DAMPING, 1.0), vi.Harmonic([1.0], FREQUENCY), vi.Stop(0, CLEARANCE, RESTITUTION))


def closed_forms() -> tuple[float, float, float]:
    """Return the force at which the stop is touched, that of the fold, and the speed of the impact there (theory 19)."""
    e, w, d, eta = RESTITUTION, FREQUENCY, CLEARANCE, 0.5 * DAMPING
    period, turn = 2.0 * np.pi / w, np.sqrt(1.0 - eta**2)
    decay = np.exp(-eta * period)
    slope, cosine, end = decay * np.sin(turn * period) / turn, decay * np.cos(turn * period), decay**2
    closing = 1.0 - 2.0 * cosine + end
    a, b = (1.0 + e) * slope / closing, 1.0 + (1.0 + e) * (cosine - eta * slope - end) / closing
    impedance = float(abs(1.0 - w**2 + 2j * eta * w))
    speed = -a * d / (a**2 + (b / w) ** 2)
    return d * impedance, float(impedance * np.hypot(d + a * speed, b * speed / w)), float(speed)


def follow() -> tuple[vi.Branch, vi.Branch]:
    """Return the branch of one impact in each period, and that of the motion without any."""
    scene = oscillator()
    hit = vi.continuation(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.05, 1.2))
    rest = vi.periodic_orbits(scene.replace(forcing_scale=0.05), [])[0]
    free = vi.continuation(rest, made, (0.01, 1.2), start=0.05)
    return hit, free


def check(hit: vi.Branch, free: vi.Branch) -> None:
    """Print and check the fold and the graze beside their closed forms, and what is born there."""
    graze, fold, speed = closed_forms()
    turned = next(own for own in hit.special if own.kind == "fold")
    touched = next(own for own in free.special if own.kind == "graze")
    print("                                 branch         closed form")
    print(f"the stop is touched at F =   {touched.parameter:.12f}  {graze:.12f}")
    print(f"the branch turns at F =      {turned.parameter:.12f}  {fold:.12f}")
    print(f"  with an impact of speed    {turned.orbit.impacts['speed_before'][0]:.9f}     {speed:.9f}")
    assert abs(touched.parameter - graze) < 1e-9
    assert abs(turned.parameter - fold) < 1e-10
    assert abs(turned.orbit.impacts["speed_before"][0] - speed) < 1e-4
    print("\nborn where the stop is touched, one impact in so many periods:")
    for own in touched.branches():
        print(f"  {own}")
    beyond = touched.beyond(delta=1e-4)
    print(f"\nbeyond: {beyond}")
    assert beyond.outcome == "nonsmooth_fold", "the impacts of the branch that is born are before the graze"


def made(force: float) -> vi.Scene:
    """Return the scene of a force."""
    return oscillator().replace(forcing_scale=force)


def draw(start: vi.Orbit, force: float, output: Path) -> None:
    """Draw all branches that meet, and once more where they do: steps count in parts of the range."""
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
    close, at = start, force
    for ax, between in zip(axes, ((0.05, 1.2), (0.09996, 0.10002)), strict=True):
        # From range to range, as points are as far apart as the range is wide.
        while at > between[1]:
            beside, at = (0.0999, at), max(between[1], 0.1 + 0.1 * (at - 0.1))
            close = vi.continuation(close, made, beside, start=beside[1], direction="down").at(at)[0]
        tree = vi.branch_tree(close, made, between, start=at, depth=1)
        print(f"\n{tree}")
        vi.plot.branch(tree, ax)
        ax.set(xlabel="force F")
    axes[1].set(title="where the stop is touched")
    axes[1].ticklabel_format(useOffset=False)
    axes[1].tick_params(axis="x", labelrotation=30)
    axes[1].get_legend().remove()
    figure.savefig(output / "grazing.png", dpi=150)


def main() -> None:
    """Follow, check and draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figures")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    hit, free = follow()
    check(hit, free)
    draw(hit[-1], hit.parameter[-1], output)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()
