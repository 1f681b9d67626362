"""What results that are made of arrays have in common: their arrays are looked at, they are pickled and saved."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Never, TypeVar, overload

import numpy as np

from vibroimpact import _core


class ArrayResult:
    """A frozen dataclass of arrays."""

    if not TYPE_CHECKING:  # to which an unknown attribute is an error

        def __getattr__(self, name: str) -> Never:
            """Answer with the name that exists here, or with all."""
            if name.startswith("_"):
                raise AttributeError(name)
            kind = type(self)
            names = sorted({*(own for own in dir(kind) if not own.startswith("_")), *(own.name for own in fields(kind))})
            raise AttributeError(_core._unknown(kind.__name__, name, names))

    def _check(self, arrays: dict[str, tuple[str, tuple[int, ...]]]) -> None:
        """Refuse what is no array of the kind (a letter of NumPy) and shape that it must have."""
        for name, (kind, shape) in arrays.items():
            array = getattr(self, name)
            if not isinstance(array, np.ndarray) or array.shape != shape:
                message = f"{name} has shape {np.shape(array)}, but an array of shape {shape} is needed"
                raise ValueError(message)
            if array.dtype.kind != kind:
                message = f"{name} has dtype {array.dtype}, but one of kind {kind!r} is needed"
                raise ValueError(message)

    def _check_types(self, types: dict[str, type | tuple[type, ...]]) -> None:
        """Refuse what is of another type."""
        for name, kind in types.items():
            value = getattr(self, name)
            if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
                message = f"{name} is {value!r}, but it must be of type {kind}"
                raise TypeError(message)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the arguments, which are looked at again."""
        return type(self), tuple(getattr(self, own.name) for own in fields(self))  # type: ignore[arg-type]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file, an ``.npz`` archive with a header in JSON, from which ``load`` reads it again."""
        from vibroimpact import _files

        _files.save(self, path)

    def to_xarray(self) -> Any:
        """Return the result as an ``xarray.Dataset``; needs xarray, the extra "xarray".

        Returns
        -------
        xarray.Dataset
            The arrays over named dimensions: x and y of a map; run, time and dof of an ensemble; point and dof of a section,
            and value of a diagram; exponent and batch of exponents; orbit of a branch; number of
            derivatives.

        Raises
        ------
        ImportError
            Without xarray.
        """
        from vibroimpact import _xarray

        return _xarray.to_xarray(self)


Item = TypeVar("Item")


class ItemsResult(ArrayResult, Sequence[Item]):
    """A frozen dataclass of arrays beside a tuple of items, of which it is a sequence."""

    def _items(self) -> tuple[Item, ...]:
        """Return the items."""
        raise NotImplementedError

    def __len__(self) -> int:
        """Count the items."""
        return len(self._items())

    @overload
    def __getitem__(self, index: int) -> Item: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Item, ...]: ...
    def __getitem__(self, index: int | slice) -> Item | tuple[Item, ...]:
        """Return an item, or several."""
        return self._items()[index]

    def __iter__(self) -> Iterator[Item]:
        """Go through the items."""
        return iter(self._items())
