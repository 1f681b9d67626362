"""Branches that meet each other, followed from one to the next."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import few, shown
from vibroimpact.analysis.continuation import continuation
from vibroimpact.results.branch import Branch
from vibroimpact.results.branch_tree import BranchTree
from vibroimpact.results.special import BOUNDARIES, Candidate, Special
from vibroimpact.run import pool

__all__ = ["branch_tree"]


def branch_tree(
    orbit: Orbit | Special | Candidate,
    parameter: str | Callable[[float], Scene],
    between: tuple[float, float],
    *,
    start: float | None = None,
    depth: int = 2,
    through: bool = True,
    max_branches: int = 50,
    workers: pool.Workers = None,
    progress: bool = False,
    **options: Any,
) -> BranchTree:
    """Follow an orbit, and the branches that meet its branch, and those that meet them.

    Parameters
    ----------
    orbit, parameter, between, start
        As for ``continuation``.
    depth : int, default 2
        From branch to branch so often: 0 is the branch of the orbit alone.
    through : bool, default True
        Whether across boundaries of motion too, to the branches with an impact more or less. Only orbits that keep the rules of
        contact are followed.
    max_branches : int, default 50
        Branches at the most.
    workers : int, Executor or callable, optional
        Executors and map-like callables as for ``simulate_many``, which branches of one depth are handed to; otherwise they are
        followed one after another. The result is the same with any.
    progress : bool, default False
        Show a progress bar (needs tqdm).
    **options
        Others of ``continuation``: ``max_points``, ``step``, ``monitor``, ``virtual``, ``symmetric``.

    Returns
    -------
    BranchTree
        Each branch once: two are one if they share an orbit at a value, or one has the mirror image of an orbit of the other.

    Raises
    ------
    ValueError
        As ``continuation``; a depth below 0, ``max_branches`` below 1.

    Notes
    -----
    A branch goes off in both directions from its candidate; those that go off are looked at in the order of the special points,
    so the tree does not depend on ``workers``.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    >>> tree = vi.branch_tree(vi.periodic_orbits(scene, [0])[0], "forcing_scale", (0.3, 1.2), depth=1)
    >>> [(branch.pattern, branch.n_periods) for branch in tree]
    [([0], 1), ([], 1), ([0], 2), ([0, 0], 2)]
    """
    for name, value, least in (("depth", depth, 0), ("max_branches", max_branches, 1)):
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            message = f"{name} is {shown(value)}, but it must be at least {least}"
            raise ValueError(message)
    low, high = few("between", between, ("low", "high"))
    branches = [continuation(orbit, parameter, between, start=start, **options)]
    parents: list[tuple[int, int] | None] = [None]
    shared = (parameter, between, options)
    begin = 0
    for _ in range(depth):
        level = range(begin, len(branches))
        begin = len(branches)
        offers = [
            (k, j, own) for k in level for j, own in enumerate(branches[k].special) if through or own.kind not in BOUNDARIES
        ]
        born = [(k, j, own) for k, j, special in offers for own in special.branches() if low <= own.parameter <= high]
        pieces = [piece for piece in born if piece[2].is_admissible and not _is_known(piece[2], branches)]
        followed = pool.run(_followed, shared, [piece[2] for piece in pieces], workers, progress=progress)
        for (k, j, candidate), branch in zip(pieces, followed, strict=True):
            # Next to a fold a branch may be found twice by candidates that no point of it is beside: three orbits of it tell.
            some = [
                Candidate(branch[i], float(branch.parameter[i]), 1) for i in np.linspace(0, len(branch) - 1, 5)[1:-1].astype(int)
            ]
            if len(branches) < max_branches and not any(_is_known(own, branches) for own in (candidate, *some)):
                branches.append(branch)
                parents.append((k, j))
    return BranchTree(tuple(branches), tuple(parents))


def _followed(shared: tuple[Any, ...], candidate: Candidate, _: pool.Own) -> Branch:
    """Return the branch of a candidate."""
    parameter, between, options = shared
    return continuation(candidate, parameter, between, **options)


def _is_known(candidate: Candidate, branches: list[Branch]) -> bool:
    """Whether one of some branches has the orbit of a candidate, or its mirror image."""
    return any(_core._is_on_branch(own, getattr(own, "_make", None), candidate.orbit, candidate.parameter) for own in branches)
