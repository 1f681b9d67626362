"""Scenes and results as tables, for notebooks: text escaped, no script, nothing loaded, in the colours of the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact._core import LinearSystem, Orbit, Scene, Trajectory

if TYPE_CHECKING:
    from vibroimpact._core import Orbits

#: What is shown of long ones.
MOST_ROWS = 8
MOST_ENTRIES = 6
#: Cells that look alike in notebooks of light and of dark ground.
_CELL = "text-align:left;vertical-align:top;padding:0.1em 1em 0.1em 0;border:none;background:none;color:inherit"
_RULE = "border-bottom:1px solid currentColor"

Rows = Iterable[Sequence[str]]


def table(rows: Rows, head: Sequence[str] = ()) -> str:
    """Return rows of cells, each already HTML, as a table."""

    def line(cells: Sequence[str], tag: str, style: str) -> str:
        return "<tr>" + "".join(f'<{tag} style="{style}">{cell}</{tag}>' for cell in cells) + "</tr>"

    top = f"<thead>{line(head, 'th', f'{_CELL};{_RULE}')}</thead>" if head else ""
    body = "".join(line(row, "td", _CELL) for row in rows)
    return f'<table style="border:none;border-collapse:collapse">{top}<tbody>{body}</tbody></table>'


def page(title: str, *parts: str) -> str:
    """Return a title over some parts."""
    return f'<div style="overflow-x:auto"><strong>{escape(title)}</strong>{"".join(parts)}</div>'


def cut(items: Iterable[Any], row: Any) -> list[Sequence[str]]:
    """Return a row of each of the first items, and one that says how many more there are."""
    items = list(items)
    rows = [row(item) for item in islice(items, MOST_ROWS)]
    if len(items) > MOST_ROWS:
        rows.append((f"and {len(items) - MOST_ROWS} more",))
    return rows


def number(x: complex) -> str:
    """Return a number to six digits."""
    value = complex(x)
    return f"{value.real:.6g}" if value.imag == 0.0 else f"{value.real:.6g}{value.imag:+.6g}i"


def numbers(values: Any) -> str:
    """Return a number, the first ones of a vector, or the first rows of a matrix."""
    array = np.asarray(values)
    if array.ndim == 0:
        return number(array.item())
    if array.ndim == 1:
        return ", ".join(_first(array))
    rows = [_first(row) for row in array[:MOST_ENTRIES]]
    return table([*rows, ["…"]] if array.shape[0] > MOST_ENTRIES else rows)


def _first(values: NDArray[Any]) -> list[str]:
    """Return the first numbers of a vector, and a sign that there are more."""
    more = ["…"] if values.size > MOST_ENTRIES else []
    return [number(x) for x in values[:MOST_ENTRIES]] + more


def _judged(is_so: bool | None, yes: str) -> str:
    """Return a verdict in words."""
    return {True: yes, False: f"not {yes}", None: "undecided"}[is_so]


def _stop(stop: Any) -> Sequence[str]:
    """Return the cells of a stop of any kind."""
    at = getattr(stop, "normal", getattr(stop, "bob", None))
    where = getattr(stop, "clearance", getattr(stop, "position", None))
    names = ("side", "reaction", "motion")
    rest = [getattr(stop, name, None) for name in names]
    shown = [escape(own) if isinstance(own, str) else escape(repr(own)) if own is not None else "" for own in rest]
    return (
        type(stop).__name__,
        numbers(at) if at is not None else "any gap",
        number(where) if where is not None else "",
        number(stop.restitution) if stop.restitution is not None else escape(repr(stop.contact)),
        *shown,
    )


def scene(own: Scene) -> str:
    """Return the numbers of a scene."""
    system, parts = own.system, []
    if isinstance(system, LinearSystem):
        names = ("mass", "damping", "stiffness", "load", "influence")
        given = ((name, getattr(system, name)) for name in names)
        parts.append(table((name, numbers(value)) for name, value in given if value is not None and np.any(value)))
    else:
        parts.append(table([("system", escape(repr(system)))]))
    forcing = own.forcing if isinstance(own.forcing, tuple) else (own.forcing,) if own.forcing is not None else ()
    if forcing:
        period = f" (period {number(own.period)} s)" if own.period is not None else ""
        parts.append(table(("forcing", escape(repr(one)) + period) for one in forcing))
    if own.stops:
        head = ("", "stop", "normal", "clearance", "restitution or law", "side", "reaction", "motion")
        every = list(enumerate(own.stops))
        parts.append(table(cut(every, lambda item: (str(item[0]), *_stop(item[1]))), head))
    return page(f"Scene of {own.n_dof} coordinate{'s' if own.n_dof > 1 else ''}", *parts)


def _impacts(impacts: Any) -> str:
    """Return a table of impacts."""

    def row(own: Any) -> Sequence[str]:
        return number(own["time"]), str(own["stop"]), number(own["speed_before"]), number(own["speed_after"])

    return table(cut(impacts, row), ("time [s]", "stop", "speed before", "speed after"))


def _pattern(pattern: Sequence[Any]) -> str:
    """Return the stops of a pattern, long ones cut."""
    more = f", … ({len(pattern)} in all)" if len(pattern) > MOST_ENTRIES else ""
    return escape(", ".join(map(str, pattern[:MOST_ENTRIES])) + more) or "none"


def orbit(own: Orbit) -> str:
    """Return the numbers of an orbit."""
    reason = own.violation.reason if own.violation is not None else ""
    rows = [
        ("stops hit", _pattern(own.pattern)),
        ("period [s]", f"{number(own.period)} ({own.n_periods} of the forcing)" if own.scene.period else number(own.period)),
        ("phase [rad]", number(own.phase)),
        ("position after the first impact", numbers(own.q0)),
        ("velocity", numbers(own.v0)),
        ("rules of contact", escape(f"{_judged(own.is_admissible, 'kept')} {reason}")),
        ("stability", _judged(own.is_stable, "stable")),
    ]
    multipliers = own.floquet_multipliers
    if multipliers is not None:
        rows.append(("multipliers", numbers(multipliers)))
    return page("Orbit", table(rows), _impacts(own.impacts) if len(own.impacts) else "")


def orbits(own: Orbits) -> str:
    """Return what a search found, an orbit a row."""

    def row(one: Orbit) -> Sequence[str]:
        speeds = one.impacts["speed_before"]
        multipliers = one.floquet_multipliers
        largest = "" if multipliers is None else number(np.abs(multipliers).max())
        verdicts = (_judged(one.is_admissible, "kept"), _judged(one.is_stable, "stable"))
        return (_pattern(one.pattern), number(one.phase), numbers(speeds), *verdicts, largest)

    head = ("stops hit", "phase [rad]", "speeds before", "rules of contact", "stability", "largest |multiplier|")
    reason = f"<div>{escape(own.reason)}</div>" if own.reason else ""
    return page(f"{len(own)} orbits: {own.verdict}", reason, table(cut(own, row), head) if len(own) else "")


def trajectory(own: Trajectory) -> str:
    """Return what a run came to."""
    q, v = own.final
    rows = [
        ("status", escape(f"{own.status}: {own.message}")),
        ("last position", numbers(q)),
        ("last velocity", numbers(v)),
    ]
    parts = [table(rows)]
    if len(own.impacts):
        parts.append(_impacts(own.impacts))
    return page(f"Trajectory to t = {number(own.t_end)} s", *parts)


def record(title: str, arrays: Iterable[tuple[str, Sequence[str], str, NDArray[Any]]]) -> str:
    """Return the arrays of a result: their names, dimensions with sizes, units and first values."""

    def row(own: tuple[str, Sequence[str], str, NDArray[Any]]) -> Sequence[str]:
        name, dims, unit, values = own
        sizes = ", ".join(f"{dim}: {size}" for dim, size in zip(dims, values.shape, strict=True))
        is_short = values.ndim <= 1 and values.dtype.kind in "bifc"
        return escape(name), escape(sizes), escape(unit), numbers(values) if is_short else escape(str(values.dtype))

    return page(title.splitlines()[0], table(map(row, arrays), ("array", "dimensions", "unit", "values")))
