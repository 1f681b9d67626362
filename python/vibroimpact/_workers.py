"""Work in pieces for whatever runs it: threads of the core, an executor, or a map-like callable."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from typing import Any, TypeVar

Piece = TypeVar("Piece")

#: What ``workers=`` may be.
Workers = int | Executor | Callable[..., Iterable[Any]] | None


def threads(workers: Workers) -> int | None:
    """Return the number of threads that an integer asks for; None: one for each core.

    Raises
    ------
    ValueError
        A number below 1.
    """
    if workers is None:
        return None
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        message = f"workers is {workers!r}, but it must be at least 1, an executor, or a map-like callable"
        raise ValueError(message)
    return workers


def is_elsewhere(workers: Workers) -> bool:
    """Whether the pieces are run by something else than the core's own threads."""
    return workers is not None and not isinstance(workers, int)


def run(function: Callable[[Any], Piece], pieces: Sequence[Any], workers: Workers) -> list[Piece]:
    """Run the function on every piece, in order, by an executor or a map-like callable.

    Raises
    ------
    ValueError
        ``workers`` is neither.
    """
    if isinstance(workers, Executor) or hasattr(workers, "submit"):
        futures = [workers.submit(function, piece) for piece in pieces]  # type: ignore[union-attr]
        return [future.result() for future in futures]
    if callable(workers):
        return list(workers(function, pieces))
    message = f"workers is {workers!r}, but it must be an int, an executor, or a map-like callable"
    raise ValueError(message)
