"""Cells of a plane, worked out tile by tile by whatever runs them, and kept in a store where one is given."""

from __future__ import annotations

from collections import Counter
from contextlib import closing
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact.run import pool
from vibroimpact.run.store import Store
from vibroimpact.run.tiles import Tile, tiles

#: What is found in each cell: the type of each array, and what stands where nothing has been found yet.
Columns = dict[str, tuple[str, Any]]

#: The same of a tile.
Found = dict[str, NDArray[Any]]


def worked_out(
    work: pool.Work[Found],
    shared: Any,
    shape: tuple[int, int],
    columns: Columns,
    pieces: int,
    workers: pool.Workers,
    progress: bool,
    store: Store | None,
) -> dict[str, NDArray[Any]]:
    """Return what is found in all cells, worked out in so many pieces at least.

    With a store only what it lacks is worked out, and each of its chunks is written as soon as all its cells are known.
    """
    most = -(-shape[0] * shape[1] // max(pieces, 1))
    whole = range(shape[0]), range(shape[1])
    if store is None:
        arrays = {name: np.full(shape, fill, dtype) for name, (dtype, fill) in columns.items()}
        chunks = [(slice(0, shape[0]), slice(0, shape[1]))]
    else:
        arrays = store.read()
        chunks = [chunk for chunk in tiles(*whole, store.cells) if store.lacks(arrays, chunk)]
    left = [(tile, chunk) for chunk in range(len(chunks)) for tile in _parts(chunks[chunk], most)]
    open_tiles = Counter(chunk for _, chunk in left)
    done = pool.completed(work, shared, [tile for tile, _ in left], workers, progress=progress)
    with closing(done):
        for place, found in done:
            tile, chunk = left[place]
            for name, array in arrays.items():
                array[tile] = found[name].reshape(array[tile].shape)
            open_tiles[chunk] -= 1
            if store is not None and open_tiles[chunk] == 0:
                store.write(arrays, chunks[chunk])
    return arrays


def _parts(chunk: Tile, cells: int) -> list[Tile]:
    rows, columns = chunk
    return tiles(range(rows.start, rows.stop), range(columns.start, columns.stop), cells)
