"""The impact oscillator: what a driven mass before a stop settles on, over the force that drives it.

`x'' + 0.1 x' + x = F cos 2.4 t` with a stop at x = 1 and restitution 0.8. Below the graze F_g the mass swings without an impact;
above the doubling F_p it hits once in each period; both forces have closed forms. Between them lie chaos and windows of other
orbits.

You will see, as three pictures: the bifurcation diagram, up and down, above the Lyapunov exponents with their errors, and the
basins of the two orbits that attract at F = 9. Printed are the forces at which the diagram changes beside the closed forms, and
the exponents at F = 5 beside those of a long run.

Run: python examples/impact_oscillator.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

DAMPING, FREQUENCY, CLEARANCE, RESTITUTION = 0.1, 2.4, 1.0, 0.8
FORCES = np.linspace(4.0, 10.0, 241)
LONG = (0.1179, 0.0005)  # the largest exponent at F = 5 and its error, of a run a hundred times as long


def closed_forms() -> tuple[float, float]:
    """Return the force at which the stop is grazed, and that above which one impact in each period is stable.

    With the propagator over a period, `S` from speed to position, `Cp` and `Cm` on the diagonal, `E` its determinant and
    `D = 1 - Cp - Cm + E`, an impact of speed u closes where `(d + al u)^2 + (be u / w)^2 = (F / Z)^2`; the doubling is `1 + tr +
    det = 0` of the return map.
    """
    e, w, d, eta = RESTITUTION, FREQUENCY, CLEARANCE, 0.5 * DAMPING
    period, turn = 2.0 * np.pi / w, np.sqrt(1.0 - eta**2)
    decay = np.exp(-eta * period)
    slope = decay * np.sin(turn * period) / turn
    plus, minus = decay * np.cos(turn * period) + eta * slope, decay * np.cos(turn * period) - eta * slope
    determinant = decay**2
    closing = 1.0 - plus - minus + determinant
    impedance = abs(1.0 - w**2 + 2j * eta * w)
    al, be = (1.0 + e) * slope / closing, 1.0 + (1.0 + e) * (minus - determinant) / closing
    rest = (1.0 - w**2) * al + 2.0 * eta * be
    speed = (1.0 + e) * slope * w**2 * d / (1.0 + e**2 * determinant - e * (plus + minus) + (1.0 + e) * slope * rest)
    return d * impedance, float(impedance * np.hypot(d + al * speed, be * speed / w))


def oscillator() -> vi.Scene:
    """Return the scene, its force of one."""
    return vi.Scene(vi.LinearSystem(1.0, DAMPING, 1.0), vi.Harmonic([1.0], FREQUENCY), vi.Stop(0, CLEARANCE, RESTITUTION))


def follow(scene: vi.Scene) -> tuple[vi.BifurcationDiagram, list[vi.LyapunovExponents]]:
    """Return the diagram, and the exponents at every fourth force."""
    diagram = vi.bifurcation_diagram(scene, ("forcing_scale", FORCES), direction="both", section="impact")
    exponents = []
    for force in FORCES[::4]:
        span = (0.0, 2000.0 * scene.period)
        exponents.append(vi.lyapunov_exponents(scene.replace(forcing_scale=force), 0.0, 0.0, span, skip=0.2 * span[1]))
    return diagram, exponents


def check(diagram: vi.BifurcationDiagram, scene: vi.Scene) -> None:
    """Print and check where the diagram changes, and the exponents of chaos."""
    graze, doubling = closed_forms()
    step = FORCES[1] - FORCES[0]
    hit = diagram.parameter[(diagram.n_impacts > 0) & (diagram.direction == 1)].min()
    down = diagram.direction == -1
    once = diagram.parameter[down & (diagram.n_periods == 1) & (diagram.n_impacts > 0)].min()
    print("                            diagram  closed form")
    print(f"the stop is hit from F =   {hit:8.4f}     {graze:8.4f}")
    print(f"once in each period from   {once:8.4f}     {doubling:8.4f}")
    assert abs(hit - graze) <= step, "the graze is where it must be"
    assert abs(once - doubling) <= 2.0 * step, "and the doubling"
    chaos = vi.lyapunov_exponents(scene.replace(forcing_scale=5.0), 0.0, 0.0, (0.0, 12_000.0), skip=1000.0)
    print(f"\nat F = 5: {chaos}")
    print(f"their sum is {chaos.sum:.12f}, as damping and impacts make it {chaos.expected_sum:.12f}")
    assert chaos.verdict == "chaotic"
    assert abs(chaos.exponents[0] - LONG[0]) < 4.0 * np.hypot(chaos.errors[0], LONG[1])
    assert abs(chaos.sum - chaos.expected_sum) < 1e-9


def draw(diagram: vi.BifurcationDiagram, exponents: list[vi.LyapunovExponents], plane: vi.Basins, output: Path) -> None:
    """Draw the diagram above the exponents, and the basins."""
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7.0, 6.0), layout="constrained", height_ratios=(3, 2))
    vi.plot.bifurcation_diagram(diagram, above, along="speed_before")
    vi.plot.lyapunov((FORCES[::4], exponents), below, name="force F")
    for force in closed_forms():
        above.axvline(force, color="0.7", linewidth=0.8, zorder=0)
        below.axvline(force, color="0.7", linewidth=0.8, zorder=0)
    above.set_xlabel("")
    figure.savefig(output / "impact_oscillator_diagram.png", dpi=150)
    figure, ax = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    vi.plot.basins(plane, ax)
    ax.set(xlabel="position q", ylabel="velocity v")
    figure.savefig(output / "impact_oscillator_basins.png", dpi=150)


def main() -> None:
    """Follow, check and draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figures")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    scene = oscillator()
    diagram, exponents = follow(scene)
    check(diagram, scene)
    plane = vi.basins(scene.replace(forcing_scale=9.0), q=(-9.5, 1.0, 200), v=(-8.0, 8.0, 200))
    print(f"\nat F = 9: {plane}\n{plane.attractors}")
    dimension = plane.boundary_dimension()
    print(f"the boundary has dimension {dimension.value:.2f} +- {dimension.error:.2f}")
    assert sorted(one.n_periods for one in plane.attractors) == [1, 3]
    draw(diagram, exponents, plane, output)
    print(f"figures in {output}/")


if __name__ == "__main__":
    main()
