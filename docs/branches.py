"""Write docs/branches.md: what is proved about a branch, what is not, and a sketch of each boundary.

Run by hand, ``python docs/branches.py``, with the package and matplotlib installed.
"""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi
from vibroimpact.results.special import BOUNDARIES

HERE = Path(__file__).parent
FORCE = 0.1  # where the oscillator of examples/grazing.py just touches its stop
STEPS = (0.2, 0.05, 0.0125)

TEXT = """# What a branch proves, and what it does not

`continuation` gives the orbits of a branch at points, and between two points nothing but that they lie on one curve. This page says
what holds where. Written by `docs/branches.py`; the mechanics are in [theory.md](theory.md), sections 19 and 20.

## At a point

- *It is an orbit*: the motion closes to 1e-11 of its size, and every impact obeys its law; and it closes when it is followed once more by another
  route than the one that made it.
- *Whether it keeps the rules of contact is proved*: between two impacts the whole flight is searched for a gap below zero, with bounds, not with
  samples. `is_virtual` is the broken ones; an orbit that touches within rounding is undecided, and no more is said.
- *Its multipliers* are those of the maps as executed. Beside a graze they are as uncertain as the motion's speed over the impact's, in
  roundings.
- *Of many modes the multipliers outside the unit circle are counted*, by how often a determinant winds about zero along it, with steps
  that the multipliers of the modes prescribe. That the determinant does not turn twice between two points is likely, not proved.

## Between two points

- *That no other branch is jumped to* is made likely, not proved: a step is refused where Newton's method does not converge at once, the
  branch turns by more than 0.35, or an impact moves by more than 0.5 in phase.
- *A sign that changes and changes back within one step is not seen*: two folds, two doublings, a stop that is passed and not passed again.
  Smaller steps see more. How many multipliers leave the unit circle on a step, and how many come into it, has to agree with the points found,
  else the step is halved, down to 1e-5 of arclength.
- *What is found is located*: `special.error` is the last change of the search, or the width of what the point was shut in, 1e-10 of the
  range or less. Newton's method fails where branches cross without a symmetry: there it is the change of an interpolation between points on
  both sides.

The fold of `examples/grazing.py` lies {part:.1e} of its force below the graze. From F = 1 the branch finds it at

| largest step | points | fold at F | off by |
|---:|---:|---:|---:|
{rows}

## At a boundary

The branch ends at the last orbit that keeps the rules of contact. Before it (solid), at it (dashed), beyond it (dotted):

![Gaps before a boundary, at it, and beyond](figures/boundaries.png)

| `special.kind` | at the boundary | beyond it |
|---|---|---|
| `graze` | a stop that is not hit is touched | it would be passed |
| `lost_impact` | an impact has no speed left | the impact would have to pull |
| `corner` | two stops are hit at one instant | they would be hit in the other order |
| `chatter_border` | the contact behind impacts that accumulate lasts no time | they do not come to rest |
| `landing_border` | behind an impact with e = 0 the motion has no acceleration either | it is held where it left, or leaves where it was held |
| `rise` | the contact force is zero while a stop is held | it would have to pull |
| `release_border` | a flight from a release to the next landing takes no time | the contact is not left |
| `vanishing_impacts` | all impacts of the period lose their speed at once, and contact goes on | there are others, earlier or later |

- `special.branches()` looks for what is born there near the point, and says of each orbit found whether it keeps the rules. That
  nothing else is born is not proved: orbits with two impacts more, or one in more than six rounds, are not looked for.
- `special.branches()` gives no orbit that breaks the law of impact: a stop that is held where another is hit stays held only if the law says so.
  Where what is looked for is not found, the orbit beyond is the one that a simulation comes near.
- `special.beyond()` says "continues" where a stable orbit stands beyond, which its reason names, or where simulations from the last orbit come to the nearer
  to it the nearer to the boundary they begin; "jumps" where they stay as far from it; "nonsmooth fold" where they do and an orbit was found before that keeps the
  rules and is not stable; "undecided" where neither is seen. Simulations are no proof: they are three to five, of 500 periods each. The
  attractor is what one of them came to. Of a branch that is not stable at its end a stable orbit may stand beyond, though a motion that leaves the last
  orbit goes elsewhere: it "continues" all the same.
- A doubled branch has no boundary where both its rounds become one: it ends at that doubling with the reason "doubling", as it would
  come back over itself, and the point is known as the doubling of the branch of half the period is.
- Beyond a chatter border the motion goes on, with ever more impacts, at a distance in proportion to that from the border.
- Vanishing impacts need a symmetry, such as no damping at all: `x'' + x = cos(w t)` before a stop at 0 has them at w = 1/3.
- A chatter border is the limit of a power law. From its other side infinitely many grazes come towards it, and nothing can be
  followed through it: `special.accumulation()` of one of these grazes follows up to forty and extrapolates. Its `error` is the last change
  of the extrapolation, no bound.

## On a curve over two numbers

`bifurcation_curve` follows a special point itself. Where something else happens at once, `curve.special` has a point:

| `point.kind` | on a curve of | what meets there |
|---|---|---|
| `cusp` | folds | two curves of folds, which end |
| `strong_1_1`, `strong_1_2` | folds, doublings, tori | two multipliers are 1, or -1: a curve of tori ends on one of folds, or of doublings |
| `strong_1_3`, `strong_1_4` | tori | small deviations turn by a third of a turn, or a quarter, in a period |
| `fold_flip` | folds, doublings | a curve of folds and one of doublings, of the same orbits |
| `resonant_graze`, `graze_fold` | folds, doublings, tori; grazes | an impact without speed: curves of folds and doublings end on one of grazes |
| `double_graze` | grazes | two touches in one motion |
| `degenerate_graze` | grazes, lost impacts | there is no acceleration at the touch |
| `graze_corner` | stops hit together, grazes | two stops at one instant, and a touch |
| the name of a boundary | all | the orbits of the curve begin to break a rule of contact there, or cease to |

The last are found by halves from points that keep the rules and points that do not; a rule broken and kept again between two points is not seen.

## Not looked for

Motions with a frequency more behind a torus (its rotation number is given), sequences of corner impacts, the zero of a monitor within a fold; of a
crossing without symmetry the direction of the other branch (it is looked for at right angles to this one); what grows from the points of a curve
at which two things happen at once; other meetings of two curves than those that `BifurcationCurve` names.
"""


def oscillator() -> vi.Scene:
    """Return the oscillator of examples/grazing.py, its force of one."""
    return vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 1.0), vi.Stop(0, 1.0, 0.8))


def fold_in_closed_form() -> float:
    """Return the force of the fold (theory 19, "Closed forms")."""
    e, eta = 0.8, 0.05
    period, turn = 2.0 * np.pi, np.sqrt(1.0 - eta**2)
    decay = np.exp(-eta * period)
    slope, cosine, end = decay * np.sin(turn * period) / turn, decay * np.cos(turn * period), decay**2
    closing = 1.0 - 2.0 * cosine + end
    a, b = (1.0 + e) * slope / closing, 1.0 + (1.0 + e) * (cosine - eta * slope - end) / closing
    speed = -a / (a**2 + b**2)
    return float(2.0 * eta * np.hypot(1.0 + a * speed, b * speed))


def rows(fold: float) -> str:
    """Return the lines of the table: the fold by steps of several sizes."""
    lines = []
    orbit = vi.periodic_orbits(oscillator(), [0])[0]
    for largest in STEPS:
        branch = vi.continuation(orbit, "forcing_scale", (0.05, 1.2), step=(1e-8, 1e-3, largest))
        found = next((own.parameter for own in branch.special if own.kind == "fold"), np.nan)
        lines.append(f"| {largest:g} | {len(branch)} | {found:.12f} | {abs(found - fold):.0e} |")
    return "\n".join(lines)


def sketch() -> None:
    """Draw the gap, or the contact force, before each boundary, at it and beyond."""
    t = np.linspace(-1.0, 1.0, 401)
    figure, grid = plt.subplots(2, 4, figsize=(10.0, 5.0), layout="constrained", sharey=True)
    axes = list(grid.flat)
    for ax, kind in zip(axes, BOUNDARIES, strict=True):
        ax.axhline(0.0, color="0.5", linewidth=3.0, solid_capstyle="butt")
        ax.set(title=kind, xticks=[], yticks=[], ylim=(-0.35, 1.0), xlabel="time")
    for ax in grid[:, 0]:
        ax.set_ylabel("gap")
    # A parabola above the stop, on it, below it.
    for height, line in ((0.25, "-"), (0.0, "--"), (-0.2, ":")):
        axes[0].plot(t, height + t**2, line, color="C0")
    # An impact of some speed, of none; beyond it the motion turns above the stop.
    for speed, line in ((1.2, "-"), (0.5, "-"), (0.0, "--")):
        axes[1].plot(t, np.where(t < 0.0, -speed * t, 0.7 * speed * t) + t**2, line, color="C0")
    # Two stops, hit one after the other, together, in the other order.
    for late, line in ((0.35, "-"), (0.0, "--"), (-0.2, ":")):
        axes[2].plot(t, np.abs(t) * np.where(t < 0.0, 1.2, 0.8), "-", color="C0")
        axes[2].plot(t, np.abs(t - late) * np.where(t < late, 0.9, 0.6), line, color="C1")
    # Bounces that accumulate, then contact up to the release; and as many that leave before they rest.
    for lift, line in ((0.0, "-"), (0.1, ":")):
        at, height, width = -1.0, 0.7, 0.6
        while width > 0.03:
            s = np.linspace(0.0, 1.0, 40)
            axes[3].plot(
                at + s * width, lift * (at + s * width + 1.0) + 4.0 * height * s * (1.0 - s), line, color="C0", linewidth=1.0
            )
            at, height, width = at + width, 0.4 * height, 0.62 * width
        if lift == 0.0:
            axes[3].plot([at, 0.7], [0.0, 0.0], "-", color="C0", linewidth=2.0)
            axes[3].plot(t[t >= 0.7], 3.0 * (t[t >= 0.7] - 0.7) ** 2, "-", color="C0")
    # Behind a landing without speed: left at once, with no acceleration, held for a while.
    for start, pull, line in ((-0.5, 0.7, "-"), (-0.5, 0.0, "--"), (0.0, 0.0, ":")):
        s = np.clip(t - start, 0.0, None)
        fall = np.where(t < -0.5, -1.2 * (t + 0.5), 0.0)
        axes[4].plot(t, fall + pull * s**2 + 0.45 * s**3, line, color="C0")
    # A contact force that stays above zero, comes to it, would pull.
    for least, line in ((0.25, "-"), (0.0, "--"), (-0.2, ":")):
        axes[5].plot(t, least + 0.9 * t**2, line, color="C3")
    axes[5].text(0.0, 0.75, "contact force", ha="center", color="C3")
    # A flight that is shorter and lower, then none.
    for part, line in ((0.25, "-"), (0.18, "-"), (0.0, "--")):
        gap = np.clip((t + part) ** 3 * (3.0 * part - t), 0.0, None)
        axes[6].plot(t, np.where(np.abs(t - part) < 2.0 * part, 7.0 * gap, 0.0), line, color="C0")
    # A flight that comes back later, without speed as the force begins to press, earlier; then contact.
    for late, line in ((0.3, "-"), (0.0, "--"), (-0.25, ":")):
        at = np.cbrt(late)
        back = np.where(t < at, 0.5 * late - 0.5 * np.minimum(t, at) ** 3, 0.0)
        bounce = np.clip((t - at) * (at + 0.7 * abs(at) - t), 0.0, None) if late else 0.0 * t
        axes[7].plot(t, np.where(t < at, np.minimum(back, 1.2), 1.5 * bounce), line, color="C0")
    figure.savefig(HERE / "figures" / "boundaries.png", dpi=110)


def main() -> None:
    """Measure, draw and write."""
    fold = fold_in_closed_form()
    sketch()
    (HERE / "branches.md").write_text(TEXT.format(part=(FORCE - fold) / FORCE, rows=rows(fold)), encoding="utf-8")


if __name__ == "__main__":
    main()
