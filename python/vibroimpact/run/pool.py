"""Work in pieces for whatever runs it: threads of the core, an executor, or a map-like callable.

A piece asks from time to time whether its sweep goes on. One that runs in this process hears that it does not; one
elsewhere works on to its end, but none that waits is begun.
"""

from __future__ import annotations

import itertools
import uuid
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import closing, contextmanager
from functools import partial
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np

from vibroimpact._validation import shown

Part = TypeVar("Part")


@runtime_checkable
class Client(Protocol):
    """What gives an executor, such as a client of Dask."""

    def get_executor(self, **options: Any) -> Executor:
        """Give an executor."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, pure: bool) -> Any:
        """Begin a call."""


#: What ``workers=`` may be.
Workers = int | Executor | Client | Callable[..., Iterable[Any]] | None

#: Asks whether to go on; raises where not.
Ask = Callable[[], None]

#: What the core takes in the end: threads (None: one for each core), whether it shows progress, what it asks.
Own = tuple[int | None, bool, Ask | None]

#: Takes what all pieces share, its piece, and its own.
Work = Callable[[Any, Any, Own], Part]

#: Pieces handed to an executor: enough to share evenly, each long enough to be worth sending.
_PIECES = 64

_ANSWER = 0.1  # [s] between two looks for what is done

#: The sweeps of this process that were broken off: what is left of their pieces is not wanted.
_broken_off: set[str] = set()


def cut(total: int, workers: Workers) -> list[tuple[int, int]]:
    """Cut ``range(total)`` into pieces of nearly equal length for whatever runs them: the core's threads share one."""
    edges = np.linspace(0, total, min(max(total, 1), count(workers)) + 1).astype(int)
    return [(int(a), int(b)) for a, b in itertools.pairwise(edges)]


def count(workers: Workers) -> int:
    """Return the number of pieces that work is cut into at least."""
    return _PIECES if is_elsewhere(workers) else 1


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
        message = f"workers is {shown(workers)}, but it must be at least 1, an executor, or a map-like callable"
        raise ValueError(message)
    return workers


def is_elsewhere(workers: Workers) -> bool:
    """Whether the pieces are run by something else than the core's own threads."""
    return workers is not None and not isinstance(workers, int)


def run(work: Work[Part], shared: Any, pieces: Sequence[Any], workers: Workers, *, progress: bool = False) -> list[Part]:
    """Do every piece and return the parts in order; as `completed`."""
    parts: dict[int, Part] = {}
    with closing(completed(work, shared, pieces, workers, progress=progress)) as done:
        parts.update(done)
    return [parts[place] for place in range(len(pieces))]


def completed(
    work: Work[Part], shared: Any, pieces: Sequence[Any], workers: Workers, *, progress: bool = False
) -> Generator[tuple[int, Part], None, None]:
    """Do every piece, and give each part, with the place of its piece, as soon as it is done.

    Threads of the core do one piece after another, and show the progress of a single one themselves. A piece that fails,
    Ctrl-C, or an end before all are taken breaks the sweep off at once: the pieces that wait are cancelled.

    Raises
    ------
    ValueError
        ``workers`` is nothing that runs pieces.
    """
    if not is_elsewhere(workers) and len(pieces) == 1:
        yield 0, work(shared, pieces[0], (threads(workers), progress, None))
        return
    with _bar(len(pieces), progress) as advance:
        for so_far, done in enumerate(_parts(work, shared, pieces, workers), start=1):
            yield done
            advance(so_far)


def _parts(work: Work[Part], shared: Any, pieces: Sequence[Any], workers: Workers) -> Iterator[tuple[int, Part]]:
    if not is_elsewhere(workers):
        own = (threads(workers), False, None)
        yield from ((place, work(shared, piece, own)) for place, piece in enumerate(pieces))
        return
    sweep = uuid.uuid4().hex
    task = partial(_piece, work, sweep)
    try:
        if isinstance(workers, Client):  # what is shared goes to its workers once, and is made again if one dies
            data, executor = workers.submit(_itself, shared, pure=False), workers.get_executor(pure=False)
            yield from _submitted(executor, task, data, pieces, lambda _: executor.shutdown(wait=False))
        elif isinstance(workers, Executor) or hasattr(workers, "submit"):
            yield from _submitted(workers, task, shared, pieces, _cancel)
        elif callable(workers):
            yield from enumerate(workers(partial(task, shared), pieces))
        else:
            message = f"workers is {shown(workers)}, but it must be an int, an executor, or a map-like callable"
            raise ValueError(message)
    except BaseException:
        _broken_off.add(sweep)
        raise


def _itself(shared: Part) -> Part:
    return shared


def _piece(work: Work[Part], sweep: str, shared: Any, piece: Any) -> Part:
    ask = partial(_go_on, sweep)
    ask()
    return work(shared, piece, (1, False, ask))


def _go_on(sweep: str) -> None:
    if sweep in _broken_off:
        message = "the sweep that this piece belongs to was broken off"
        raise RuntimeError(message)


def _cancel(futures: Iterable[Any]) -> None:
    for future in futures:
        future.cancel()


def _submitted(
    executor: Any, task: Any, shared: Any, pieces: Sequence[Any], cancel: Callable[[Iterable[Any]], None]
) -> Iterator[tuple[int, Any]]:
    """Give the parts of the pieces as they are done; where something fails, cancel the others."""
    places: dict[Future[Any], int] = {}
    try:
        for place, piece in enumerate(pieces):
            places[executor.submit(task, shared, piece)] = place
        if not all(isinstance(future, Future) for future in places):
            for future in list(places):
                yield places.pop(future), future.result()
        waiting = set(places)
        while waiting:
            done, waiting = wait(waiting, timeout=_ANSWER, return_when=FIRST_COMPLETED)
            for future in sorted(done, key=places.__getitem__):
                yield places.pop(future), future.result()
    except BaseException:
        cancel(places)
        raise


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
