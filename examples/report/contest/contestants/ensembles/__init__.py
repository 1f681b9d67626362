"""The contestants for many starts at once, in the form of those for one: a package without a file here is none.

A run gives the final states and the number of impacts of the trajectories that it followed, `rows`; a contestant too slow for
all of them follows some that have a reference, and its time is counted for all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Ends:
    """What a run found: indices of its trajectories, their final states (k, 2 n) and numbers of impacts (k,)."""

    rows: np.ndarray
    states: np.ndarray
    counts: np.ndarray
