"""Rectangles of the cells of a plane: the tiles that are worked out, the chunks of a store."""

from __future__ import annotations

#: A rectangle of cells: the slices of its rows and of its columns.
Tile = tuple[slice, slice]


def tile_shape(cells: int, nx: int) -> tuple[int, int]:
    """Return rows and columns of a tile of about so many cells, of a plane of nx columns: whole rows, or a part of one."""
    nx = max(nx, 1)
    return max(cells // nx, 1), min(max(cells, 1), nx)


def tiles(rows: range, columns: range, cells: int) -> list[Tile]:
    """Cut a rectangle into tiles of about so many cells, row by row."""
    down, across = tile_shape(cells, len(columns))
    corners = ((j, i) for j in rows[::down] for i in columns[::across])
    return [(slice(j, min(j + down, rows.stop)), slice(i, min(i + across, columns.stop))) for j, i in corners]
