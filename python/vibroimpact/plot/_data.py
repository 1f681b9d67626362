"""What the figures read: the attributes of orbits, trajectories, modes and maps, written as protocols.

Arrays have time first, `(m, n)`.  At an impact the velocity has two values, chosen by `side`.  Anything with these
attributes can be drawn; the plots import nothing from the numerical core.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any, Literal, Protocol, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray: TypeAlias = NDArray[np.float64]


class Scene(Protocol):
    """The system, its forcing (None: unforced) and the forcing period, the number of coordinates and the stops."""

    @property
    def system(self) -> Any: ...
    @property
    def forcing(self) -> Any: ...
    @property
    def n_dof(self) -> int: ...
    @property
    def period(self) -> float | None: ...
    @property
    def stops(self) -> Sequence[Any]: ...


class Motion(Protocol):
    """What an orbit and a trajectory share."""

    @property
    def scene(self) -> Scene: ...
    @property
    def impacts(self) -> NDArray[Any]: ...
    def position(self, t: ArrayLike, /) -> FloatArray: ...
    def velocity(self, t: ArrayLike, /, side: Literal["after", "before"] = "after") -> FloatArray: ...
    def gap(self, stop: int, t: FloatArray, /) -> FloatArray: ...
    def contact_force(self, stop: int, t: FloatArray, /) -> FloatArray: ...


class Orbit(Motion, Protocol):
    """A periodic motion; its impacts lie in [0, period), the first at 0."""

    @property
    def period(self) -> float: ...


class Trajectory(Motion, Protocol):
    """A simulated motion and the rows it kept."""

    @property
    def t(self) -> FloatArray: ...
    @property
    def q(self) -> FloatArray: ...
    @property
    def v(self) -> FloatArray: ...


class Stability(Protocol):
    """Why an orbit is stable or not; multipliers for each order of the impacts."""

    @property
    def reason(self) -> str: ...
    @property
    def orders(self) -> Mapping[Hashable, ArrayLike | None]: ...


class Ramped(Trajectory, Protocol):
    """A trajectory along which numbers of its scene drift."""

    @property
    def ramp(self) -> Any: ...
    def parameter(self, t: ArrayLike, name: str, /) -> FloatArray: ...
    def phase(self, t: ArrayLike, /) -> FloatArray: ...


class StableOrbit(Protocol):
    """The part of an orbit that its stability is drawn from."""

    @property
    def floquet_multipliers(self) -> NDArray[np.complex128] | None: ...
    @property
    def stability(self) -> Stability | None: ...


class Modes(Protocol):
    """Natural frequencies and damping ratios (n,), shapes (n, n) with one mode a column."""

    @property
    def natural_frequencies(self) -> FloatArray: ...
    @property
    def shapes(self) -> FloatArray: ...
    @property
    def damping_ratios(self) -> FloatArray: ...


class ExistenceMap(Protocol):
    """Values x and y, and arrays (len(y), len(x)) of what was found at each pair."""

    @property
    def x(self) -> FloatArray: ...
    @property
    def y(self) -> FloatArray: ...
    @property
    def x_name(self) -> str | None: ...
    @property
    def y_name(self) -> str | None: ...
    @property
    def n_orbits(self) -> NDArray[Any]: ...
    @property
    def is_admissible(self) -> NDArray[Any]: ...
    @property
    def is_stable(self) -> NDArray[Any]: ...
    @property
    def multiplier(self) -> NDArray[Any]: ...


class BifurcationDiagram(Protocol):
    """Values and the ways in which they were gone through, (m,); points (p,), each with the place of its value."""

    @property
    def name(self) -> str | None: ...
    @property
    def parameter(self) -> FloatArray: ...
    @property
    def direction(self) -> NDArray[Any]: ...
    @property
    def n_periods(self) -> NDArray[Any]: ...
    @property
    def index(self) -> NDArray[Any]: ...
    @property
    def speed_before(self) -> FloatArray: ...
    @property
    def q(self) -> FloatArray: ...


class LyapunovExponents(Protocol):
    """Exponents and their errors (k,), and their means over batches (b, k)."""

    @property
    def exponents(self) -> FloatArray: ...
    @property
    def errors(self) -> FloatArray: ...
    @property
    def history(self) -> FloatArray: ...


class Basins(Protocol):
    """Values x and y with their names, labels (len(y), len(x)) and the attractors that they name."""

    @property
    def x(self) -> FloatArray: ...
    @property
    def y(self) -> FloatArray: ...
    @property
    def x_name(self) -> str: ...
    @property
    def y_name(self) -> str: ...
    @property
    def labels(self) -> NDArray[Any]: ...
    @property
    def attractors(self) -> Sequence[Any]: ...


class Branch(Protocol):
    """Orbits over a number: values, verdicts (m,), speeds and phases of impacts (m, k), what monitors gave."""

    def __iter__(self) -> Iterator[Any]: ...
    @property
    def parameter_name(self) -> str | None: ...
    @property
    def parameter(self) -> FloatArray: ...
    @property
    def arclength(self) -> FloatArray: ...
    @property
    def multipliers(self) -> NDArray[Any]: ...
    @property
    def is_stable(self) -> NDArray[Any]: ...
    @property
    def is_virtual(self) -> NDArray[Any]: ...
    @property
    def n_unstable(self) -> NDArray[Any]: ...
    @property
    def speeds_before(self) -> FloatArray: ...
    @property
    def phases(self) -> FloatArray: ...
    @property
    def durations(self) -> FloatArray: ...
    @property
    def monitor(self) -> Mapping[str, FloatArray]: ...
    @property
    def special(self) -> Sequence[Any]: ...


class BranchTree(Protocol):
    """Branches that meet each other."""

    @property
    def branches(self) -> tuple[Branch, ...]: ...


def require(data: object, attribute: str, rule: str) -> None:
    """Refuse data that lack an attribute; `rule` says what they must be."""
    if not hasattr(data, attribute):
        raise ValueError(f"{rule}, got {type(data).__name__}")


def is_orbit(motion: object) -> TypeGuard[Orbit]:
    """Tell an orbit from a trajectory by the attribute that only it has."""
    return hasattr(motion, "period")


def is_trajectory(motion: object) -> TypeGuard[Trajectory]:
    """Tell a trajectory from an orbit by the attributes that only it has."""
    return hasattr(motion, "t") and hasattr(motion, "q")


class Curve(Protocol):
    """Special points over two numbers."""

    @property
    def x(self) -> FloatArray: ...
    @property
    def y(self) -> FloatArray: ...
    @property
    def is_virtual(self) -> NDArray[Any]: ...
