"""Branches that meet each other."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact._core import Orbit
from vibroimpact._validation import shown
from vibroimpact.results.branch import Branch
from vibroimpact.results.labelled import Parts
from vibroimpact.results.record import ItemsRecord, items


class BranchTree(ItemsRecord[Branch]):
    """Branches that meet each other: a sequence of them, each once.

    Attributes
    ----------
    branches : tuple of Branch
        The branches; the first is that of the orbit that was given.
    parents : tuple of (int, int) or None
        Of each the branch that it goes off from and the place of the special point among its ``special``; None of the first.
    """

    branches: tuple[Branch, ...] = items("branch", least=1)
    parents: tuple[tuple[int, int] | None, ...]

    def _prepare(self) -> None:
        given = self.parents
        if not all(own is None or (isinstance(own, (tuple, list)) and len(own) == 2) for own in given):
            message = f"parents is {shown(given)}, but for each branch a pair, or None, is needed"
            raise ValueError(message)
        self._set("parents", tuple(None if own is None else (int(own[0]), int(own[1])) for own in given))

    def _check_more(self) -> None:
        parents = self.parents
        if len(parents) != len(self.branches) or any(own is not None and own[0] >= k for k, own in enumerate(parents)):
            message = f"parents is {shown(parents)}, but for each branch an earlier one, or None, is needed"
            raise ValueError(message)

    def _items(self) -> tuple[Branch, ...]:
        return self.branches

    def at(self, value: float) -> list[Orbit]:
        """Return every orbit that the branches have at a value of their number.

        Parameters
        ----------
        value : float
            The value.

        Returns
        -------
        list of Orbit
            Branch by branch, as ``Branch.at``.
        """
        return [orbit for branch in self.branches for orbit in branch.at(value)]

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of all branches, their place before each name, for ``numpy.savez``."""
        each = enumerate(self.branches)
        return {f"branch_{k}_{name}": array for k, own in each for name, array in own.to_arrays().items()}

    def _labelled(self) -> Parts:
        branch = np.repeat(np.arange(len(self)), [len(own) for own in self])
        names = ("is_stable", "is_admissible", "n_unstable")
        joined = {name: np.concatenate([getattr(own, name) for own in self]) for name in (*names, "parameter")}
        coordinates = {"parameter": ("orbit", joined.pop("parameter")), "branch": ("orbit", branch)}
        parents = {f"parent_{k}": str(own) for k, own in enumerate(self.parents)}
        return {name: ("orbit", values) for name, values in joined.items()}, coordinates, parents

    def __repr__(self) -> str:
        """Say what each branch is and where it goes off."""
        lines = [f"BranchTree({len(self)} branches)"]
        for k, (branch, parent) in enumerate(zip(self.branches, self.parents, strict=True)):
            low, high = branch.parameter.min(), branch.parameter.max()
            off = "" if parent is None else f", off {parent[0]} at {self.branches[parent[0]].special[parent[1]]!r}"
            lines.append(f"  {k}: {branch.pattern} in {branch.n_periods} from {low:.6g} to {high:.6g}{off}")
        return "\n".join(lines)
