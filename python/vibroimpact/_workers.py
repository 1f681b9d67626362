"""Work in pieces for whatever runs it: threads of the core, an executor, or a map-like callable.

A piece asks from time to time whether its sweep goes on. One that runs in this process hears that it does not; one
elsewhere works on to its end, but none that waits is begun.
"""

from __future__ import annotations

import itertools
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar

import numpy as np

Part = TypeVar("Part")

#: What ``workers=`` may be.
Workers = int | Executor | Callable[..., Iterable[Any]] | None

#: Asks whether to go on; raises where not.
Ask = Callable[[], None]

#: Pieces handed to an executor: enough to share evenly, each long enough to be worth sending.
_PIECES = 64

_ANSWER = 0.1  # [s] between two looks for what is done

#: The sweeps of this process that were broken off: what is left of their pieces is not wanted.
_broken_off: set[str] = set()


def bounds(total: int, pieces: int = _PIECES) -> list[tuple[int, int]]:
    """Cut ``range(total)`` into pieces of nearly equal length."""
    edges = np.linspace(0, total, min(total, pieces) + 1).astype(int)
    return [(int(a), int(b)) for a, b in itertools.pairwise(edges)]


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


def run(function: Callable[[Any, Ask], Part], pieces: Sequence[Any], workers: Workers, *, progress: bool = False) -> list[Part]:
    """Run the function on every piece, in order, by an executor or a map-like callable.

    A piece that fails, or Ctrl-C, breaks the sweep off at once: the pieces that wait are cancelled.

    Raises
    ------
    ValueError
        ``workers`` is neither.
    """
    sweep = uuid.uuid4().hex
    task = partial(_piece, function, sweep)
    with _bar(len(pieces), progress) as advance:
        try:
            if isinstance(workers, Executor) or hasattr(workers, "submit"):
                return _submitted(task, pieces, workers, advance)
            if callable(workers):
                return _mapped(task, pieces, workers, advance)
        except BaseException:
            _broken_off.add(sweep)
            raise
    message = f"workers is {workers!r}, but it must be an int, an executor, or a map-like callable"
    raise ValueError(message)


def _piece(function: Callable[[Any, Ask], Part], sweep: str, piece: Any) -> Part:
    ask = partial(_go_on, sweep)
    ask()
    return function(piece, ask)


def _go_on(sweep: str) -> None:
    if sweep in _broken_off:
        message = "the sweep that this piece belongs to was broken off"
        raise RuntimeError(message)


def _mapped(task: Any, pieces: Sequence[Any], workers: Any, advance: Callable[[int], None]) -> list[Any]:
    parts = []
    for part in workers(task, pieces):
        parts.append(part)
        advance(len(parts))
    return parts


def _submitted(task: Any, pieces: Sequence[Any], workers: Any, advance: Callable[[int], None]) -> list[Any]:
    futures: list[Any] = []
    try:
        for piece in pieces:
            futures.append(workers.submit(task, piece))
        if all(isinstance(future, Future) for future in futures):
            _await(futures, advance)
        return [future.result() for future in futures]
    except BaseException:
        for future in futures:
            future.cancel()
        raise


def _await(futures: list[Future[Any]], advance: Callable[[int], None]) -> None:
    """Wait until all are done, or raise what one of them raised."""
    waiting = set(futures)
    while waiting:
        done, waiting = wait(waiting, timeout=_ANSWER, return_when=FIRST_COMPLETED)
        for future in futures:
            if future in done:
                future.result()
        advance(len(futures) - len(waiting))


@contextmanager
def _bar(total: int, wanted: bool) -> Iterator[Callable[[int], None]]:
    """Give a function that shows how many of so many pieces are done, as the core shows its progress."""
    if not wanted:
        yield lambda done: None
        return
    try:
        from tqdm.auto import tqdm
    except ImportError:
        message = 'progress=True needs tqdm: pip install "vibroimpact[progress]"'
        raise ImportError(message) from None
    with tqdm(total=1.0, bar_format="{l_bar}{bar}| {elapsed}<{remaining}") as bar:

        def advance(done: int) -> None:
            bar.n = done / total
            bar.refresh()

        yield advance
