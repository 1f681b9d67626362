"""What becomes of a motion beyond a boundary."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene, Trajectory
from vibroimpact._validation import shown
from vibroimpact.analysis.continuation import continuation
from vibroimpact.analysis.find_attractors import find_attractors
from vibroimpact.errors import ConvergenceError
from vibroimpact.results.attractors import Attractor
from vibroimpact.results.special import BOUNDARIES, Beyond, Candidate, Special

__all__ = ["look_beyond"]

#: A kick in parts of the motion's size, and the box of starts in which it is looked for, in its sizes.
_KICK = 1e-6
_BOX = 10.0

#: By what factor a simulation begins nearer to a boundary each time, how often at least and at most, and how many errors of the
#: boundary away from it.
_NEARER = 0.1
_LEAST, _MOST = 3, 5
_ERRORS = 10.0
#: Periods over which a motion that has settled is compared with the last orbit, and times in each.
_COMPARED = 40
_TIMES = 64
#: A motion goes on if in the end its distance from the last orbit shrinks by so much from one start to the next but one, a
#: hundred times nearer to the boundary (by 0.1 where it goes like the root), and at each of both, and jumps if it keeps this part
#: of it.
_SHRINKS = 0.3
_EACH = 0.6
_STAYS = 0.5
#: A motion that is so many times farther away after twice as many periods has not settled.
_LEAVES = 2.0
#: Distances below this part of the motion are the kick that is left, and none from which a motion has jumped.
_NONE = 1e-5


def look_beyond(special: Special, delta: float | None, periods: int, rng: int | np.random.Generator) -> Beyond:
    """Say what becomes of a motion beyond a boundary; documented at ``Special.beyond``."""
    if special.kind not in BOUNDARIES:
        message = f"special is {shown(special)}, but beyond is asked of a boundary: {', '.join(BOUNDARIES)}"
        raise ValueError(message)
    if special.parameter_name == "energy":
        message = f"special is {shown(special)}, of motions that keep their energy: they settle on nothing beyond it"
        raise ValueError(message)
    low, high = special.between
    delta = 1e-3 * (high - low) if delta is None else float(_core._numbers("delta", delta))
    if not (np.isfinite(delta) and delta > 0.0):
        message = f"delta is {delta}, but it must be above 0"
        raise ValueError(message)
    if not isinstance(periods, int) or isinstance(periods, bool) or periods < 1:
        message = f"periods is {periods!r}, but it must be at least 1"
        raise ValueError(message)
    far = 1 if special.direction[-1] >= 0.0 else -1
    value = special.parameter + far * delta
    try:
        candidates = tuple(special.branches())
    except (ValueError, ConvergenceError):
        # What does not close, or has no scene, is none; a callable that was not saved is asked for.
        special._made_by()
        candidates = ()
    for own in candidates:
        at = _goes_on(special, own, value) if own.side == far else None
        if at is not None:
            return Beyond("continues", candidates, None, f"a stable orbit goes on at {at:.10g}")
    outcome, seen = _simulated(special, far * delta, periods, rng)
    if outcome == "continues":
        return Beyond(outcome, candidates, None, seen)
    met = any(own.side == -far and own.is_admissible and own.is_stable is False for own in candidates)
    attractor, reason = _settled(special, value, periods, rng)
    if outcome == "jumps" and met:
        outcome = "nonsmooth_fold"
    return Beyond(outcome, candidates, attractor, reason if outcome != "undecided" else f"{seen}; {reason}")


def _goes_on(special: Special, candidate: Candidate, value: float) -> float | None:
    """Return where a candidate is stable and keeps the rules of contact: at a value, or nearer to the boundary."""
    if candidate.is_admissible is False:
        return None
    between = (min(special.parameter, value), max(special.parameter, value))
    if between[0] <= candidate.parameter <= between[1]:
        make = getattr(special, "_make", None)
        try:
            branch = continuation(candidate, special.parameter_name or make, between)  # type: ignore[arg-type]
            if any(orbit.is_stable and orbit.is_admissible for orbit in branch.at(value)):
                return value
        except (ValueError, ConvergenceError):
            # It ends before the value.
            pass
    return candidate.parameter if candidate.is_stable and candidate.is_admissible else None


def _simulated(special: Special, ahead: float, periods: int, rng: int | np.random.Generator) -> tuple[str, str]:
    """Return what becomes of a motion by simulations that begin ever nearer to the boundary, and how that was seen."""
    offs: list[float] = []
    apart: list[float] = []
    off = ahead
    reason = "the boundary is not known well enough"
    while len(apart) < _MOST and abs(off) > _ERRORS * special.error:
        try:
            apart.append(_distance(special, special.parameter + off, periods, rng))
        except (ValueError, RuntimeError) as error:
            reason = str(error)
            break
        offs.append(off)
        off *= _NEARER
        if len(apart) < _LEAST:
            continue
        last = np.array(apart[-_LEAST:])
        said = (
            f"simulations of {periods} periods from the last orbit, kicked by {_KICK:g} of its size, come to "
            + ", ".join(f"{x:.2g}" for x in apart)
            + " of its size from it at "
            + ", ".join(f"{x:.2g}" for x in offs)
            + " beyond"
        )
        if last[-1] <= max(_SHRINKS * last[0], _NONE) and (last[1:] <= np.maximum(_EACH * last[:-1], _NONE)).all():
            return "continues", said
        if last.min() >= max(_STAYS * last.max(), _NONE):
            return "jumps", said
        reason = said
    return "undecided", reason


def _distance(special: Special, value: float, periods: int, rng: int | np.random.Generator) -> float:
    """Return how far from the last orbit a motion comes to be that begins next to it, in parts of its size."""
    orbit = special.orbit
    scene, state, t0, _ = _begun(special, value, rng)
    once = orbit.period / orbit.n_periods
    period = scene.period if scene.period is not None else once
    count = np.arange(_COMPARED * _TIMES) / _TIMES
    size = float(np.abs(orbit.max_displacement).max())
    apart = []
    for gone in (periods, 2 * periods):
        # Whole periods later the forcing has the phase that it had.
        state = _ended(_core.simulate(scene, *state, (0.0, periods * period), keep="final")).final
        run = _ended(_core.simulate(scene, *state, (0.0, _COMPARED * period)))
        q = run.position(count * period)
        if scene.period is None:
            apart.append(_farthest(np.hstack([q, run.velocity(count * period)]), orbit))
        else:
            then = (t0 + (gone + count) * once) % orbit.period
            apart.append(float(np.abs(q - orbit.position(then)).max()) / size)
    if apart[1] > _LEAVES * max(apart[0], _NONE):
        message = f"at {value:.10g} the motion still leaves the last orbit after {periods} periods"
        raise RuntimeError(message)
    return max(apart)


def _ended(run: Trajectory) -> Trajectory:
    """Return a run that came to its end."""
    if run.status != "finished":
        raise RuntimeError(run.message)
    return run


def _farthest(states: NDArray[np.float64], orbit: Orbit) -> float:
    """Return the largest distance of states from an orbit at any time, coordinates and velocities in parts of their largest."""
    t = np.linspace(0.0, orbit.period, 2001)
    path = np.hstack([orbit.position(t), orbit.velocity(t)])
    half = path.shape[1] // 2
    sizes = np.repeat([np.abs(path[:, :half]).max(), np.abs(path[:, half:]).max()], half)
    path = path / sizes
    start, way = path[:-1], np.diff(path, axis=0)
    length = np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
    most = 0.0
    for x in states / sizes:
        # From the nearest of the chords between neighbouring states.
        part = np.clip(((x - start) * way).sum(axis=1) / length, 0.0, 1.0)
        off = x - start - part[:, None] * way
        most = max(most, float(np.sqrt((off**2).sum(axis=1).min())))
    return most


def _begun(
    special: Special, value: float, rng: int | np.random.Generator
) -> tuple[Scene, tuple[NDArray[np.float64], NDArray[np.float64]], float, float]:
    """Return the scene of a value, a kicked state of the last orbit, its time on that, its phase."""
    orbit = special.orbit
    scene = _core._scene_at(orbit.scene, special.parameter_name, getattr(special, "_make", None), special.parameter, value)
    t = np.linspace(0.0, orbit.period, 65)
    q, v = orbit.position(t), orbit.velocity(t)
    sizes = _sizes(q, v)
    # From where the motion is farthest from all stops: a kick on a stop may lead into it.
    gaps = np.array([orbit.gap(stop, t) for stop in range(len(orbit.scene.stops))]).min(axis=0)
    far = int(gaps.argmax())
    kick = _KICK * sizes * np.random.default_rng(rng).uniform(-1.0, 1.0, sizes.size)
    start = np.concatenate([q[far], v[far]]) + kick
    phase = float(orbit.phase + 2.0 * np.pi * orbit.n_periods * t[far] / orbit.period) % (2.0 * np.pi)
    if scene.period is not None:
        scene = scene.replace(phase=phase)
    n = q.shape[1]
    return scene, (start[:n], start[n:]), float(t[far]), phase


def _sizes(q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sizes of coordinates and velocities."""
    sizes = np.concatenate([np.abs(q).max(axis=0), np.abs(v).max(axis=0)])
    return np.asarray(np.maximum(sizes, 1e-12 + 1e-3 * sizes.max()))


def _settled(special: Special, value: float, periods: int, rng: int | np.random.Generator) -> tuple[Attractor | None, str]:
    """Return what a simulation from the orbit of a special point comes to at a value, and how that was found."""
    orbit = special.orbit
    said = f"{periods} periods from the last orbit, kicked by {_KICK:g} of its size, at {value:.10g}"
    try:
        scene, (q, v), _, phase = _begun(special, value, rng)
    except ValueError as error:
        return None, f"there is no scene at {value:.10g}: {error}"
    t = np.linspace(0.0, orbit.period, 65)
    sizes = _sizes(orbit.position(t), orbit.velocity(t))
    box = np.stack([-_BOX * sizes, _BOX * sizes], axis=1)
    start = np.concatenate([q, v])
    try:
        found = find_attractors(scene, box, seeds=start[None], phase=phase, transient=periods, max_periods=max(2000, 2 * periods))
    except ValueError as error:
        return None, f"not simulated: {error}"
    if not found:
        return None, f"undecided after {said}"
    return found[0], said
