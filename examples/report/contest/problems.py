"""The problems of the report: a scene, a start and an end each; what they are is said once, here.

Spans are chosen so that the condition number (`condition.py`, printed in the report) stays below 1e4: a longer chaotic run has
no digits left at the finest levels, for anybody; and so that SciPy ends within the bound at most tolerances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import vibroimpact as vi

from . import laws

STIFF_DAMPING = 0.02  # C = STIFF_DAMPING * K: the stiff mode is overdamped, as a stiff bearing or a contact layer is
GRAVITY = 9.81  # [m/s^2]
COUNT = (50, 40)  # starts of the ensembles, in a grid of two angles
EVERY = 100
DEPTHS = tuple(10.0 ** (-1 - 0.5 * k) for k in range(10))  # overshoots of the shallow contacts, in amplitudes


# Of problems whose equations are a user's function.
VALUES_ALONE = (
    "heyoka is given the equations as symbols, differentiates them, and compiles Taylor series whose order grows with the digits "
    "(see its compilation times); to the library they are a function, of which it has values alone, so that its steps are of "
    "fixed order p, and each digit asks for 10^(1/p) times as many of them: p = 8, and 5 where the motion is stiff."
)


@dataclass(frozen=True, eq=False)
class Problem:
    """What every contestant is asked for: the state at the end, and the times of impact on the way there.

    `first`: None, or the number of impacts that are asked for where the whole number is infinite. `behind`: why peers may lead.
    """

    name: str
    title: str
    scene: vi.Scene
    q0: tuple[float, ...]
    v0: tuple[float, ...]
    end: float
    first: int | None = None
    behind: str = ""

    @property
    def start(self) -> np.ndarray:
        """State at time zero, positions before velocities."""
        return np.array([*self.q0, *self.v0])

    @property
    def is_stiff(self) -> bool:
        """Whether implicit methods are worth a trial."""
        return self.name.startswith("stiff")


@dataclass(frozen=True, eq=False)
class Ensemble(Problem):
    """One scene from many starts at once, (k, 2 n); each `EVERY`-th trajectory has a reference."""

    starts: np.ndarray | None = None

    @property
    def sample(self) -> np.ndarray:
        """Indices of the trajectories that have a reference."""
        return np.arange(EVERY // 2, len(self.starts), EVERY)

    def member(self, index: int) -> Problem:
        """One trajectory."""
        n, start = self.scene.n_dof, tuple(self.starts[index].tolist())
        return Problem(self.name, self.title, self.scene, start[:n], start[n:], self.end)


@dataclass(frozen=True, eq=False)
class Compliant(Problem):
    """A scene whose stops give way: asked for are the times at which contacts begin, and a state may lie inside a stop."""


def oscillator() -> Problem:
    """One degree of freedom, forced below its resonance, one stop."""
    scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic(1, 0.8), vi.Stop(0, 0.5, 0.8))
    return Problem("oscillator", "One-degree oscillator with a stop", scene, (0.0,), (0.5,), 60.0)


def first_kind() -> Problem:
    """The paper's first kind, driven harder than its orbit needs, so that one pendulum hits and then the other."""
    scene = vi.paper_scene(kind=1).replace(forcing_scale=1.5, phase=1.3)
    return Problem("kind_1", "Two linear pendulums, the paper's first kind", scene, (0.7, 0.7), (-0.1, -0.2), 100.0)


def second_kind() -> Problem:
    """The paper's second kind: from nearby onto the orbit on which the upper pendulum hits."""
    scene = vi.paper_scene(kind=2).replace(phase=0.3)
    return Problem("kind_2", "Two linear pendulums, the paper's second kind", scene, (0.45, 0.34), (-0.2, 0.1), 150.0)


def third_kind() -> Problem:
    """The paper's third kind: onto the orbit on which the lower pendulum hits."""
    scene = vi.paper_scene(kind=3)
    return Problem("kind_3", "Two linear pendulums, the paper's third kind", scene, (0.02, -0.1), (0.0, 0.3), 150.0)


def two_tones() -> Problem:
    """A mast of three masses between two stops, its foot and its top shaken at frequencies without a common period."""
    stiffness = np.array([[5.0, -3.0, 0.0], [-3.0, 5.0, -2.0], [0.0, -2.0, 2.0]])
    system = vi.LinearSystem([1.0, 0.8, 0.6], 0.02 * stiffness, stiffness)
    foot, top = vi.Harmonic([0.6, 0.0, 0.0], 0.7, 0.3), vi.Harmonic([0.0, 0.0, 0.4], 0.7 * 5**0.5, 1.1)
    stops = [vi.Stop(2, 0.5, 0.7), vi.Stop(1, 0.3, 0.6, side="lower")]
    title = "Mast of three masses under two tones, two stops"
    return Problem("two_tones", title, vi.Scene(system, [foot, top], stops), (0.0, 0.1, 0.2), (0.0, 0.0, 0.0), 90.0)


def gear_pair() -> Problem:
    """A loose gear between the flanks of another that turns unevenly: two stops that move, what opens one closes the other.

    Its drag, a constant part and one of its speed, leaves it faster than the flanks: none that a solver steps over overtakes it
    again within that step.
    """
    gear = vi.LinearSystem([1.0], [0.1], [0.0], load=[-0.05])
    flanks = [
        vi.Stop(0, 0.6, 0.8, motion=vi.Harmonic([0.3], 2.5)),
        vi.Stop(0, 0.6, 0.8, side="lower", motion=vi.Harmonic([-0.3], 2.5)),
    ]
    scene = vi.Scene(gear, None, flanks)
    return Problem("gear_pair", "Loose gear between flanks that move", scene, (0.3,), (0.8,), 60.0)


def pendulum() -> Problem:
    """The double pendulum of eq. (3) with angles up to half a radian and a stop for each."""
    scene = vi.paper_scene(kind=3, linear=False).replace(forcing_scale=3.0, clearance=0.5)
    return Problem("pendulum", "Nonlinear double pendulum, large angles", scene, (0.1, -0.3), (0.0, 0.6), 100.0)


def chain() -> Problem:
    """Five links, a plane wall for the fourth bob."""
    system = vi.PendulumChain([1.0, 0.8, 0.7, 0.6, 0.5], [0.5, 0.4, 0.35, 0.3, 0.25], 0.05)
    scene = vi.Scene(system, vi.BaseMotion(0.1, 4.0), vi.Wall(3, 0.15, 0.6))
    return Problem("chain", "Chain of five pendulums with a plane wall", scene, (0.1, 0.05, 0.0, -0.1, 0.2), (0.0,) * 5, 10.0)


def duffing() -> Problem:
    """A user's own equation of motion, Duffing's with a hardening spring and its drive, and a stop within its swing."""
    law = laws.duffing(damping=0.1, cubic=1.0, force=1.5, frequency=1.2)
    scene = vi.Scene(vi.NonlinearSystem(1, law, mass=1.0), None, vi.Stop(0, 0.8, 0.8))
    title = "Duffing's oscillator, a user's own equation"
    return Problem("duffing", title, scene, (0.0,), (0.5,), 60.0, behind=VALUES_ALONE)


def stiff(ratio: float) -> Problem:
    """A light mass on a soft spring, a heavy one on a spring `ratio` times as stiff behind it, a stop for the heavy one."""
    stiffness = np.array([[1.0 + ratio, -ratio], [-ratio, ratio]])
    system = vi.LinearSystem([[0.1, 0.0], [0.0, 1.0]], STIFF_DAMPING * stiffness, stiffness)
    scene = vi.Scene(system, vi.Harmonic([1.0, 0.0], 0.6), vi.Stop(1, 0.3, 0.7))
    title = f"Stiff pair, ratio 1e{round(np.log10(ratio))}, coordinates of the masses"
    return Problem(f"stiff_{round(np.log10(ratio))}", title, scene, (0.0, 0.0), (0.3, 0.3), 40.0)


def stiff_by_elongation(ratio: float) -> Problem:
    """The same pair, with the elongation of the stiff spring as second coordinate: no entry hides digits of another."""
    stiffness = np.diag([1.0, ratio])
    system = vi.LinearSystem([[1.1, 1.0], [1.0, 1.0]], STIFF_DAMPING * stiffness, stiffness)
    scene = vi.Scene(system, vi.Harmonic([1.0, 0.0], 0.6), vi.Stop([1.0, 1.0], 0.3, 0.7))
    title = f"Stiff pair, ratio 1e{round(np.log10(ratio))}, coordinate of the stiff spring"
    return Problem(f"stiff_{round(np.log10(ratio))}_spring", title, scene, (0.0, 0.0), (0.3, 0.0), 40.0)


def stiff_cubic() -> Problem:
    """A light mass on a soft spring, a heavy one behind a cubic spring 1e6 times as stiff and its damper, a stop for that one.

    The damper makes it stiff: it settles the pair's speeds within 5e-5, while the spring creeps over seconds.
    """
    light, cubic, damping = 0.1, 1e6, 2e3
    system = vi.NonlinearSystem(2, laws.cubic_pair(light, damping, cubic), mass=[[light, 0.0], [0.0, 1.0]])
    scene = vi.Scene(system, vi.Harmonic([1.0, 0.0], 0.6), vi.Stop(1, 0.3, 0.7))
    title = "Stiff pair, a cubic spring 1e6 times as stiff"
    return Problem("stiff_cubic", title, scene, (0.01, 0.0), (0.3, 0.3), 20.0, behind=VALUES_ALONE)


def equal_pair(ratio: float) -> Problem:
    """Equal masses on soft springs, one `ratio` times as stiff between them, a stop on which one of them bounces to rest.

    The other mass pushes it back: each hit takes more of the pair's speed than the coefficient of restitution says.
    """
    stiffness = np.array([[1.0 + ratio, -ratio], [-ratio, 1.0 + ratio]])
    system = vi.LinearSystem(np.eye(2), STIFF_DAMPING * stiffness, stiffness, load=[0.3, 0.0])
    scene = vi.Scene(system, vi.Harmonic([1.5, 0.0], 0.7), vi.Stop(1, 0.3, 0.7))
    title = f"Stiff equal masses, ratio 1e{round(np.log10(ratio))}, chattering"
    return Problem(f"stiff_{round(np.log10(ratio))}_chatter", title, scene, (0.0, 0.0), (0.3, 0.3), 40.0, first=5)


def ball() -> Problem:
    """A ball dropped from one metre: infinitely many bounces in 8.6 s, then at rest."""
    system = vi.LinearSystem([1.0], [0.0], [0.0], load=[-GRAVITY])
    scene = vi.Scene(system, None, vi.Stop(0, 0.0, 0.9, side="lower"))
    return Problem("ball", "Bouncing ball to rest", scene, (1.0,), (0.0,), 10.0, first=20)


def shallow() -> Problem:
    """Free oscillators side by side, each of which passes its stop once, by a tenth to 3e-6 of its amplitude."""
    w = 1.0 + 0.13 * np.arange(len(DEPTHS))
    damping = 0.02
    stops = [vi.Stop(i, peak(w[i], damping) * (1.0 - depth), 0.8) for i, depth in enumerate(DEPTHS)]
    scene = vi.Scene(vi.LinearSystem(np.ones(len(w)), 2.0 * damping * w, w**2), None, stops)
    return Problem("shallow", "Shallow contacts, ten oscillators", scene, (0.0,) * len(w), tuple(w.tolist()), 6.0)


def peak(frequency: float, damping: float) -> float:
    """Height of the first peak of an oscillator that starts from zero at the speed of its frequency."""
    ring = np.sqrt(1.0 - damping**2)
    time = np.arctan2(ring, damping) / (frequency * ring)
    return float(np.exp(-damping * frequency * time) * np.sin(frequency * ring * time) / ring)


def sticking() -> Problem:
    """An oscillator pressed on its stop: in each period it bounces to rest, sticks and is let go."""
    scene = vi.Scene(vi.LinearSystem(1, 0.2, 1, load=[0.5]), vi.Harmonic(1.5, 0.7), vi.Stop(0, 0.4, 0.5))
    return Problem("sticking", "Chattering and sticking oscillator", scene, (0.0,), (0.0,), 40.0, first=5)


def elastic_stop() -> Compliant:
    """An oscillator whose motion without the stop would come within a hundredth of it, before a spring 29 times its own."""
    w = 0.8
    scene = vi.Scene(vi.LinearSystem(1, 0.02, 1), vi.Harmonic(0.7 * w**2, w), vi.Stop(0, 1.26, contact=vi.Spring(29.0)))
    return Compliant("elastic_stop", "One elastic stop", scene, (0.0,), (0.5,), 100.0)


def kelvin_voigt() -> Compliant:
    """An oscillator between two springs with dashpots, which pull at the end of each contact."""
    stops = [
        vi.Stop(0, 0.5, contact=vi.Spring(20.0, 0.5, release="gap")),
        vi.Stop(0, 0.9, side="lower", contact=vi.Spring(35.0, 0.5, release="gap")),
    ]
    scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic(1, 0.8), stops)
    return Compliant("kelvin_voigt", "Two Kelvin-Voigt stops", scene, (0.0,), (0.3,), 60.0)


def four_masses() -> Compliant:
    """Four masses, each on a soft spring of its own, with bumpers between neighbours; the first one is driven."""
    bumper = vi.Spring(40.0, 0.3, release="gap")
    between = ([1.0, -1.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0], [0.0, 0.0, 1.0, -1.0])
    stops = [vi.Stop(normal, gap, contact=bumper) for normal, gap in zip(between, (0.2, 0.1, 0.15), strict=True)]
    system = vi.LinearSystem([1.0, 0.8, 1.2, 1.0], [0.05, 0.05, 0.05, 0.05], [1.0, 1.5, 0.8, 2.0])
    scene = vi.Scene(system, vi.Harmonic([1.0, 0.0, 0.0, 0.0], 1.1), stops)
    return Compliant("four_masses", "Four masses with gaps", scene, (0.0,) * 4, (0.5, 0.0, 0.0, 0.0), 40.0)


def many(name: str, title: str, scene: vi.Scene) -> Ensemble:
    """Two thousand starts at rest, ten periods of the forcing each."""
    grid = np.meshgrid(np.linspace(-0.1, 0.05, COUNT[0]), np.linspace(-0.2, 0.05, COUNT[1]))
    q = np.column_stack([each.ravel() for each in grid])
    start = tuple(q[0].tolist())
    return Ensemble(name, title, scene, start, (0.0, 0.0), 10 * scene.period, starts=np.hstack([q, 0.0 * q]))


def ensembles() -> list[Ensemble]:
    """The paper's third kind from many starts, linear and not."""
    return [
        many("many_linear", "2000 starts at once, linear pendulums", vi.paper_scene(kind=3)),
        many("many_pendulums", "2000 starts at once, nonlinear pendulums", vi.paper_scene(kind=3, linear=False)),
    ]


def problems() -> list[Problem]:
    """All of them, the simplest first."""
    return [
        oscillator(),
        first_kind(),
        second_kind(),
        third_kind(),
        two_tones(),
        gear_pair(),
        pendulum(),
        chain(),
        duffing(),
        stiff(1e4),
        stiff(1e8),
        stiff_by_elongation(1e4),
        stiff_by_elongation(1e8),
        stiff_cubic(),
        equal_pair(1e4),
        equal_pair(1e8),
        ball(),
        shallow(),
        sticking(),
        elastic_stop(),
        kelvin_voigt(),
        four_masses(),
        *ensembles(),
    ]
