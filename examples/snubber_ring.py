"""A rotor in a snubber ring: how far an unbalance throws it, up through its critical speed and down again.

A disk on a flexible shaft turns with an unbalance inside a ring that gives way by a spring: a stop all around, with the gap
`c - sqrt(x^2 + y^2)`, without friction. Below the ring it whirls as the linear rotor does; in the ring the circular whirl has a
closed form too, the root of a quadratic, whose resonance bends to higher speeds. So the disk stays in the ring long past its
critical speed on the way up, and meets it late on the way down: between both there are two whirls.

You will see the radius of the whirl over the speed, up and down, beside the closed form, and the orbit of the disk where it comes
into the ring. A push from one side at one speed shows which whirl it then settles on.

Run: python examples/snubber_ring.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

RATIO, UNBALANCE = 0.05, 0.15  # damping of the shaft [-], eccentricity over the clearance
RING = 2.0  # stiffness over that of the shaft
SPEEDS = np.linspace(0.6, 1.8, 61)
BOTH = 1.3  # a speed with two whirls


def ring() -> vi.NonlinearStop:
    """Return the ring of clearance one; at its very middle no direction is that of the gap."""

    def gradient(q: np.ndarray) -> np.ndarray:
        radius = np.hypot(*q)
        return -q / radius if radius > 0.0 else np.array([-1.0, 0.0])

    return vi.NonlinearStop(lambda q: 1.0 - np.hypot(*q), gradient, contact=vi.Spring(RING))


def rotor(speed: float, stop: vi.NonlinearStop) -> vi.Scene:
    """Return the rotor at a speed; its unbalance pulls along x and, a quarter of a turn later, along y."""
    shaft = vi.LinearSystem(np.ones(2), 2.0 * RATIO * np.ones(2), np.ones(2))
    return vi.Scene(shaft, vi.Harmonic(UNBALANCE * speed**2 * np.array([1.0, -1.0j]), speed), stop)


def whirls(speed: float) -> list[float]:
    """Return the radii of all circular whirls, smallest first.

    Inside the ring `|1 - w^2 + 2 i D w| r = e w^2`; in it `((1 + k - w^2) r - k)^2 + (2 D w r)^2 = (e w^2)^2`.
    """
    force, damping = UNBALANCE * speed**2, 2.0 * RATIO * speed
    free = force / np.hypot(1.0 - speed**2, damping)
    elastic = 1.0 + RING - speed**2
    pressed = np.roots([elastic**2 + damping**2, -2.0 * RING * elastic, RING**2 - force**2])
    inside = [float(free)] if free < 1.0 else []
    return sorted(inside + [float(r.real) for r in pressed if r.imag == 0.0 and r.real > 1.0])


def settled(speed: float, stop: vi.NonlinearStop, q: np.ndarray, v: np.ndarray) -> vi.Trajectory:
    """Return the last two turns after a hundred and twenty of them; the phase of the unbalance is that of the start."""
    scene = rotor(speed, stop)
    before = vi.simulate(scene, q, v, (0.0, 120.0 * scene.period), keep="final", rtol=1e-9)
    assert before.status == "finished", before.message
    return vi.simulate(scene, *before.final, (0.0, 2.0 * scene.period), rtol=1e-9)


def radii(motion: vi.Trajectory) -> np.ndarray:
    """Return how far the disk is from the middle."""
    return np.hypot(*motion.position(np.linspace(0.0, motion.t_end, 200)).T)


def swept(speeds: np.ndarray, stop: vi.NonlinearStop) -> np.ndarray:
    """Return the radius at each speed, the motion going on from one to the next, each beside the closed form."""
    found, q, v = [], np.zeros(2), np.zeros(2)
    for speed in speeds:
        motion = settled(speed, stop, q, v)
        q, v = motion.final
        radius = radii(motion)
        found.append(radius.mean())
        assert min(abs(radius.mean() - each) for each in whirls(speed)) < 1e-4
        assert np.ptp(radius) < 1e-3, "the whirl is a circle"
    return np.array(found)


def check_pushes(stop: vi.NonlinearStop) -> list[vi.Trajectory]:
    """Print which whirl the disk settles on after a push, and return both runs from the push on."""
    small, _, large = whirls(BOTH)
    print(f"\nat w = {BOTH}: whirls of radius {small:.4f} inside the ring and {large:.4f} in it")
    runs = []
    for push, wanted in ((0.0, small), (2.5, large)):
        q, v = np.zeros(2), np.array([0.0, push])
        runs.append(vi.simulate(rotor(BOTH, stop), q, v, (0.0, 60.0), rtol=1e-9))
        radius = radii(settled(BOTH, stop, q, v)).mean()
        print(f"from a push of {push}: {len(runs[-1].contacts)} contacts in 60 units of time, then radius {radius:.6f}")
        assert abs(radius - wanted) < 1e-5
    return runs


def draw(up: np.ndarray, down: np.ndarray, runs: list[vi.Trajectory], output: Path) -> None:
    """Draw the radius over the speed, and both pushes."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.6), layout="constrained", width_ratios=(5, 4))
    speeds = np.linspace(SPEEDS[0], SPEEDS[-1], 1201)
    known = [(speed, radius) for speed in speeds for radius in whirls(speed)]
    left.plot(*np.array(known).T, ".", color="0.75", markersize=1.5, label="closed form")
    left.plot(SPEEDS, up, "o", color="#1d3a66", markersize=4, label="up")
    left.plot(SPEEDS, down, "x", color="#b8503f", markersize=5, label="down")
    left.axhline(1.0, color="0.6", linewidth=0.8)
    left.set(xlabel="speed / critical speed", ylabel="radius of the whirl / clearance", ylim=(0.0, None))
    left.legend()
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    right.plot(np.cos(turn), np.sin(turn), color="0.6", linewidth=0.8)
    for run, color, name in zip(runs, ("#1d3a66", "#b8503f"), ("from rest", "after a push"), strict=True):
        right.plot(*run.position(np.linspace(0.0, run.t_end, 4000)).T, color=color, linewidth=0.6, label=name)
    right.set(aspect="equal", xlabel="x", ylabel="y", title=f"w = {BOTH:g}")
    right.legend(loc="upper right", fontsize="small")
    figure.savefig(output / "snubber_ring.png", dpi=130)


def main() -> None:
    """Sweep, push, check and draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    stop = ring()
    up, down = swept(SPEEDS, stop), swept(SPEEDS[::-1], stop)[::-1]
    leaves, meets = SPEEDS[up > 1.0].max(), SPEEDS[down > 1.0].max()
    print(f"in the ring up to w = {leaves:.2f} on the way up, from w = {meets:.2f} on the way down")
    assert leaves > meets
    draw(up, down, check_pushes(stop), output)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()
