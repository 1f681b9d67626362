"""Results read again, from files and from stores."""

from __future__ import annotations

import os
from pathlib import Path

from vibroimpact.results import archive
from vibroimpact.results.archive import Result
from vibroimpact.run import store

__all__ = ["load"]


def load(path: str | os.PathLike[str]) -> Result:
    """Read a result from a file that ``save`` wrote.

    Parameters
    ----------
    path : str or path-like
        The file, or the folder of a store of ``basins`` or ``existence_map``, finished or not.

    Returns
    -------
    Trajectory, Orbit, Orbits, ExistenceMap, Ensemble, PoincarePoints, BifurcationDiagram, LyapunovExponents, Attractor,
    Attractors, Basins, BasinFractions, Branch, Beyond, BranchTree, BifurcationCurve, CurvePoint, Candidate, Special,
    Derivatives, Fit or another result that has ``save``
        What was saved, equal to the bit.

    Raises
    ------
    ValueError
        A file or folder that is no result of this library, that was changed or cut, or that has a newer format; a motion that
        is none of its scene: it jumps, passes a stop, has not its impacts, or these are against the law of their stop, by more
        than a hundredth of the sizes of its terms. A store of basins of a scene made of functions, which the same call of
        ``basins`` opens.
    OSError
        A file that is not there or cannot be read.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import vibroimpact as vi
    >>> run = vi.simulate(vi.paper_scene(kind=3), [0, 0], [0, 0.1], (0, 20))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(pathlib.Path(folder) / "run.npz")
    ...     again = vi.load(pathlib.Path(folder) / "run.npz")
    >>> bool((again.q == run.q).all()), again.scene == run.scene
    (True, True)
    """
    return _stored(path) if Path(path).is_dir() else archive.read(path)


def _stored(path: str | os.PathLike[str]) -> Result:
    """Return what a store holds."""
    kind, contents, arrays = store.contents(path)
    try:
        result: Result = store.STORED_RESULTS[kind].make(contents, arrays)
    except Exception as error:
        raise archive.refused(path, f"it was changed: {error!r}") from error
    return result
