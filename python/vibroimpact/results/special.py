"""Special points of branches, the orbits that meet them there, and what becomes of motions beyond."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import shown
from vibroimpact.results.attractors import Attractor
from vibroimpact.results.diagram import Pattern
from vibroimpact.results.labelled import Parts
from vibroimpact.results.record import Record, array

#: What happens at a special point.
KINDS: tuple[str, ...] = _core._SPECIAL_KINDS

#: The kinds that are boundaries.
BOUNDARIES = KINDS[KINDS.index("graze") :]

#: How a motion may go on beyond a boundary.
OUTCOMES: tuple[str, ...] = _core._BEYOND_OUTCOMES


class Candidate(Record):
    """An orbit near a special point of a branch, on another branch that meets it there.

    Attributes
    ----------
    orbit : Orbit
        The orbit.
    parameter : float
        The number of the branch at it [its own unit].
    side : {1, -1}
        Whether that is above the special point or below.
    pattern : list
        The stops that it hits in one period, a tuple at one instant.
    is_admissible, is_stable : bool or None
        Whether it keeps the rules of contact; whether small deviations die out.
    """

    orbit: Orbit
    parameter: float
    side: int

    @property
    def pattern(self) -> Pattern:
        """The stops hit in one period, a tuple at one instant."""
        return self.orbit.pattern

    @property
    def is_admissible(self) -> bool | None:
        """Whether the orbit keeps the rules of contact."""
        return self.orbit.is_admissible

    @property
    def is_stable(self) -> bool | None:
        """Whether small deviations from the orbit die out."""
        return self.orbit.is_stable

    def __repr__(self) -> str:
        """Say what is hit, where, and whether it can be seen."""
        where = "above" if self.side > 0 else "below"
        kept = {True: "admissible", False: "not admissible", None: "undecided"}[self.is_admissible]
        stable = {True: "stable", False: "unstable", None: "stability undecided"}[self.is_stable]
        periods = f"{self.orbit.n_periods} period{'s' if self.orbit.n_periods > 1 else ''}"
        return f"Candidate({self.pattern} in {periods} at {self.parameter:.10g}, {where}: {kept}, {stable})"


class Beyond(Record):
    """What becomes of a motion beyond a boundary.

    Attributes
    ----------
    outcome : {"continues", "nonsmooth_fold", "jumps", "undecided"}
        Beyond the boundary the motion goes on as near to the last orbit as one likes, on a stable orbit of another branch or as
        what simulations come to; the branch meets an orbit that is not stable and both end; neither, and simulations lead away
        however near to the boundary they begin; or that is not known.
    candidates : tuple of Candidate
        The branches that meet it there, as ``Special.branches`` has them.
    attractor : Attractor or None
        Unless it continues what a simulation comes to, which begins next to the orbit, beyond the boundary.
    reason : str
        How that was found, with the distance from the boundary and the length of the simulation.
    """

    outcome: str
    candidates: tuple[Candidate, ...]
    attractor: Attractor | None
    reason: str

    def _check_more(self) -> None:
        if self.outcome not in OUTCOMES:
            message = f"outcome is {self.outcome!r}, but it must be one of {OUTCOMES}"
            raise ValueError(message)

    def _labelled(self) -> Parts:
        variables, coordinates, attributes = super()._labelled()
        side, parameter = ([getattr(own, name) for own in self.candidates] for name in ("side", "parameter"))
        variables["side"] = ("candidate", np.array(side))
        return variables, coordinates | {"parameter": ("candidate", np.array(parameter))}, attributes

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return its numbers as arrays, for ``numpy.savez``."""
        return {"candidates": np.array([[own.parameter, own.side] for own in self.candidates])}

    def __repr__(self) -> str:
        """Say what happens."""
        to = "" if self.attractor is None else f", to {self.attractor!r}"
        return f"Beyond({self.outcome}{to}: {self.reason})"


class Special(Record):
    """A special point of a branch.

    Attributes
    ----------
    kind : str
        "fold": the branch turns back. "period_doubling": a multiplier passes through -1; of a doubled branch its end, with the
        orbit of half the period. "torus": two conjugate multipliers pass through the unit circle beside 1 and -1. "pitchfork":
        a motion that was its own mirror image ceases to be stable as such. "branch_point": another branch of the same pattern
        is crossed. Where a stop that gives way is touched, and the branch goes on with a contact more or less: "touch", its
        multipliers do so too; "border_collision", they jump. At a boundary, where the branch ends: "graze", a stop is touched;
        "lost_impact", an impact has lost its speed; "corner", two stops are hit at one instant; "chatter_border", lasting
        contact has no duration left; "landing_border", behind an impact with e = 0 the stop is left instead of held, or held
        instead of left; "rise", the contact force comes to zero while a stop is held; "release_border", the same from behind: a
        flight from a release to the next landing on that stop has no duration left; "vanishing_impacts", all impacts of the
        period lose their speed at once, and contact goes on.
        "user:name": a monitor of that name is zero.
    parameter, error : float
        The number of the branch there, and how far it is known [its own unit].
    arclength : float
        How far along the branch it is [-].
    orbit : Orbit
        The orbit there; of a boundary the last one before it.
    stop : int or None
        The stop that a boundary is about.
    time : float or None
        The time of its touch or impact [s], counted from the first impact.
    data : dict of str to float
        Of a torus "rotation_number": by what part of a turn a small deviation turns in a period, in (0, 1/2). Of a touch or a
        border collision the numbers of real multipliers above 1 and below -1 of the orbits before and behind it, as they come
        near to it, "n_above_1_before", "n_above_1_after", "n_below_minus_1_before", "n_below_minus_1_after", and the sums of
        all multipliers, "trace_before", "trace_after"; none of these where several stops are hit at one instant.
    direction : ndarray, shape (k,)
        The direction of the branch there [-]: first state and instants in scaled unknowns, the number in parts of the range. At
        the end of a doubled branch it is the difference of its two rounds, and the number stays.
    parameter_name : str or None
        The number, None of a branch made by a callable.
    between : (float, float)
        The range of the branch.
    outcome : str or None
        Of a touch or a border collision what those numbers say by Feigin's rule: "fold", the orbits before and behind it are on
        the same side; "doubling", an orbit of twice the period is born; "persists". None without them.
    is_virtual : bool
        Whether the orbit breaks a rule of contact.
    """

    kind: str
    parameter: float
    error: float
    arclength: float
    orbit: Orbit
    stop: int | None
    time: float | None
    data: dict[str, float]
    direction: NDArray[np.float64] = array("unknown")
    parameter_name: str | None
    between: tuple[float, float]

    def _prepare(self) -> None:
        self._set("between", tuple(self.between))

    def _check_more(self) -> None:
        if self.kind not in KINDS and not self.kind.startswith("user:"):
            message = f"kind is {self.kind!r}, but it must be one of {KINDS}"
            raise ValueError(message)
        if len(self.between) != 2:
            message = f"between is {self.between!r}, but (low, high) is needed"
            raise ValueError(message)

    @property
    def outcome(self) -> str | None:
        """What becomes of the branch at a touch or a border collision, by Feigin's rule; None elsewhere or without numbers."""
        if "n_above_1_before" not in self.data:
            return None
        sides = ("before", "after")
        above, below = ([int(self.data[f"{name}_{side}"]) for side in sides] for name in ("n_above_1", "n_below_minus_1"))
        return _core._touch_outcome(above, below)

    @property
    def is_virtual(self) -> bool:
        """Whether the orbit breaks a rule of contact."""
        return self.orbit.is_admissible is False

    @classmethod
    def _of(
        cls, own: dict[str, Any], name: str | None, between: tuple[float, float], make: Callable[[float], Scene] | None
    ) -> Special:
        """Return one of what the core found, which knows the callable that made its branch."""
        special = cls(parameter_name=name, between=between, **own)
        # Not a part of the result: functions are not saved.
        special._set("_make", make)
        return special

    def _made_by(self) -> Callable[[float], Scene] | None:
        """Return the callable that made its branch, if one did."""
        make: Callable[[float], Scene] | None = getattr(self, "_make", None)
        if self.parameter_name is None and make is None:
            message = f"special is {self!r}, but the callable that made its branch was not saved with it"
            raise ValueError(message)
        return make

    def branches(self) -> list[Candidate]:
        """Return the branches that meet this one at the point, an orbit of each near it, for ``continuation``.

        Returns
        -------
        list of Candidate
            At a period doubling the orbit of twice the period; at a pitchfork one that is not its own mirror image (the other
            is ``candidate.orbit.mirrored()``); at a branch point the orbits of the other branch, both ways; at a graze, a touch
            or a border collision those with an impact or a contact more, in one to six rounds of the orbit; at a lost impact
            the orbit without it, and the others that are born there; at a corner the orbit that hits the two stops in the other
            order, if there is one; at a rise the one that leaves the stop there and lands on it again, at a release border the
            one that does not; at a landing border the one with a stay or a flight more, or less. Where none of these keeps the
            rules beyond a boundary, the orbit that the motion there is near, if it comes to the last one with the number. None
            at a fold or a torus. Those that keep them come first. What is not found near the point is left out.

        Raises
        ------
        ValueError
            The callable that made the branch was not saved with it.
        ConvergenceError
            An orbit that does not close in the scene of its value.

        Notes
        -----
        An impact that is born has some 1e-3 of the motion's speed; with it the number changes in proportion, so that a branch
        leaves a graze like others [1]_. Each is unstable there, as its impact multiplies deviations by something like 1/speed.

        References
        ----------
        .. [1] A. B. Nordmark, "Non-periodic motion caused by grazing incidence in an impact oscillator", Journal of Sound and
           Vibration 145 (1991) 279.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
        >>> branch = vi.continuation(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.1, 1.5))
        >>> doubled = branch.special[1].branches()[0]
        >>> doubled.orbit.n_periods, doubled.is_stable
        (2, True)
        >>> vi.continuation(doubled, "forcing_scale", (0.7, 1.5)).special[0].kind
        'period_doubling'
        """
        return [Candidate(**own) for own in _core._branches(self, self._made_by())]

    def accumulation(self, *, progress: bool = False) -> Special | None:
        """Return the border of a chatter towards which grazes accumulate of which this is one.

        Behind such a graze an impact more is born, at the end of those that become ever slower, and its branch ends at the next
        one: they come nearer to each other by the same factor each time, and beyond their limit the impacts come to rest.

        Parameters
        ----------
        progress : bool, default False
            Show a progress bar (needs tqdm): where in the range of the branch the search is.

        Returns
        -------
        Special or None
            The "chatter_border", with the last orbit that touches; its ``arclength`` is nan, as it is on none of the branches.
            None where grazes do not accumulate, or were not followed to six of them.

        Raises
        ------
        ValueError
            A special point that is no graze; the callable that made the branch was not saved with it.
        KeyboardInterrupt
            On Ctrl-C.

        Notes
        -----
        Up to 40 branches are followed, one from the graze of the other. The border is their limit extrapolated twice, ``error``
        is by how much the second time changed it [1]_. From the side on which the impacts come to rest a branch ends there and
        knows it to 1e-8 of the range.

        References
        ----------
        .. [1] C. J. Budd and F. Dux, "Chattering and related behaviour in impact oscillators", Philosophical Transactions of
           the Royal Society A 347 (1994) 365.

        Examples
        --------
        >>> import numpy as np
        >>> import vibroimpact as vi
        >>> scene = vi.Scene(vi.LinearSystem(1, 0, 1), vi.Harmonic([1.0], 0.5), vi.Stop(0, 0.25, 0.5))
        >>> run = vi.simulate(scene, [-0.5], [0.0], (0.0, 40 * scene.period))
        >>> branch = vi.continuation(vi.find_orbit(scene, run), "clearance", (0.0, 0.5), direction="down")
        >>> border = branch.special[0].accumulation()
        >>> border.kind, border.error < 1e-6
        ('chatter_border', True)
        """
        found = _core._accumulation(self, self._made_by(), progress)
        if found is None:
            return None
        return Special._of(found, self.parameter_name, self.between, getattr(self, "_make", None))

    def beyond(self, delta: float | None = None, periods: int = 500, rng: int | np.random.Generator = 0) -> Beyond:
        """Say what becomes of a motion beyond a boundary at which its branch ends.

        Parameters
        ----------
        delta : float, optional
            How far beyond it is looked, 1e-3 of the range by default.
        periods : int, default 500
            Periods of the forcing that a simulation is given to settle.
        rng : int or numpy.random.Generator, default 0
            What the simulation is kicked with.

        Returns
        -------
        Beyond
            A value, never an exception: where nothing is found it says so, and where it cannot be known it is "undecided", with
            the reason. What a simulation comes to is what it came to, from one start, at one value.

        Raises
        ------
        ValueError
            A special point that is no boundary; a distance or a count that is not above zero.

        Notes
        -----
        A candidate beyond that is stable and keeps the rules of contact, at the value that is looked at or nearer to the
        boundary, "continues". Else simulations begin at the last orbit, kicked by 1e-6 of its size, at the distance ``delta``, a
        tenth of it, a hundredth and up to 1e-4 of it: where what they come to is the nearer to the last orbit the nearer they
        begin, the motion "continues"; where it stays as far, it "jumps", or meets a "nonsmooth_fold" if a candidate before the
        boundary keeps the rules and is not stable (theory 19, "Grazing"). Where neither is seen it is "undecided".

        Examples
        --------
        >>> import vibroimpact as vi
        >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
        >>> branch = vi.continuation(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.1, 1.5))
        >>> branch.special[0].beyond().outcome
        'continues'
        """
        if self.kind not in BOUNDARIES:
            message = f"special is {shown(self)}, but beyond is asked of a boundary: {', '.join(BOUNDARIES)}"
            raise ValueError(message)
        if self.parameter_name == "energy":
            message = f"special is {shown(self)}, of motions that keep their energy: they settle on nothing beyond it"
            raise ValueError(message)
        if not isinstance(periods, int) or isinstance(periods, bool) or periods < 1:
            message = f"periods is {periods!r}, but it must be at least 1"
            raise ValueError(message)
        far = None if delta is None else float(_core._numbers("delta", delta))
        found = _core._beyond(
            self, self._made_by(), far, periods, lambda count: np.random.default_rng(rng).uniform(-1.0, 1.0, count)
        )
        candidates = tuple(Candidate(**own) for own in found.pop("candidates"))
        attractor = found.pop("attractor")
        return Beyond(candidates=candidates, attractor=None if attractor is None else Attractor(**attractor), **found)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return its numbers as arrays, for ``numpy.savez``."""
        arrays = {name: np.array(getattr(self, name)) for name in ("kind", "parameter", "error", "arclength", "direction")}
        return arrays | {name: np.array(value) for name, value in self.data.items()}

    def __repr__(self) -> str:
        """Say what happens, and where."""
        stop = "" if self.stop is None else f", stop {self.stop}"
        return f"Special({self.kind} at {self.parameter:.10g}{stop}, error {self.error:.1g})"
