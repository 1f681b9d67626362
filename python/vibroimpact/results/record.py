"""A result: fields declared once, from which follows what all results have.

A class says of each field what it holds: by its annotation the type, of an array that of its entries, and by `array` or `items`
the names of its dimensions and its unit. Its checks, arrays, pickles, files, labelled arrays and tables follow. What one class
alone has, it adds in `_prepare`, `_sizes`, `_check_more` and `_labelled`.
"""

from __future__ import annotations

import dataclasses
import inspect
import itertools
import os
import sys
import types
import typing
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar, Never, Self, TypeVar, dataclass_transform, overload

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._validation import shown
from vibroimpact.results import html, labelled

#: Results by their names, as files have them.
RESULTS: dict[str, type[Record]] = {}

_KEY = "declared"


class _Given(typing.NamedTuple):
    """What a field says beside its annotation: its dimensions in each form that it may have."""

    forms: tuple[tuple[str, ...], ...]
    unit: str = ""
    coordinate: str | None = None
    as_text: bool = False
    least: int = 0


class Declared(typing.NamedTuple):
    """What is declared of a field: its types, of an array the kind of its entries, a letter of NumPy, of a tuple their type."""

    types: tuple[type, ...]
    kind: str | None
    of: type | None
    given: _Given


def _field(given: _Given, default: Any) -> Any:
    if default is dataclasses.MISSING:
        return dataclasses.field(metadata={_KEY: given})
    return dataclasses.field(default_factory=lambda: default, metadata={_KEY: given})


def array(*forms: str, unit: str = "", coordinate: str | None = None, default: Any = dataclasses.MISSING) -> Any:
    """Declare an array by the names of its dimensions ("run dof"), in each form that it may have.

    The first array of several forms decides which one all such arrays have. A coordinate labels its dimension.
    """
    return _field(_Given(tuple(tuple(form.split()) for form in forms), unit, coordinate), default)


def items(dimension: str, *, least: int = 0, coordinate: str | None = None, as_text: bool = False) -> Any:
    """Declare a tuple of so many objects at least, one for each place along a dimension; as text also an array of their `str`."""
    return _field(_Given(((dimension,),), "", coordinate, as_text, least), dataclasses.MISSING)


def _declared(hint: Any, given: _Given) -> Declared:
    """Return what an annotation says of a field, with what is given beside it."""
    members = typing.get_args(hint) if typing.get_origin(hint) in (typing.Union, types.UnionType) else (hint,)
    kind = of = None
    for own in members:
        arguments = typing.get_args(own)
        if typing.get_origin(own) is np.ndarray:
            kind = np.dtype(typing.get_args(arguments[1])[0]).kind
        elif typing.get_origin(own) is tuple and arguments[-1] is Ellipsis:
            one = arguments[0]
            of = one if typing.get_origin(one) is None and isinstance(one, type) and one is not Any else object
    return Declared(tuple(typing.get_origin(own) or own for own in members), kind, of, given)


@dataclass_transform(eq_default=False, frozen_default=True, field_specifiers=(array, items))
class Record:
    """A frozen dataclass that declares what its fields hold."""

    _fields: ClassVar[types.MappingProxyType[str, Declared]]

    def __init_subclass__(cls) -> None:
        """Make it a dataclass, read what it declares, and let files know it."""
        super().__init_subclass__()
        dataclasses.dataclass(frozen=True, eq=False, repr=cls.__repr__ is object.__repr__)(cls)
        # As types, not as texts: what they name is known in the file of the class, not where it is made public.
        texts = types.SimpleNamespace(__annotations__=inspect.get_annotations(cls))
        own = cls.__annotations__ = typing.get_type_hints(texts, vars(sys.modules[cls.__module__]))
        declared = {
            one.name: _declared(own[one.name], one.metadata.get(_KEY, _Given(())))
            for one in fields(cls)  # type: ignore[arg-type]
            if one.name in own
        }
        cls._fields = types.MappingProxyType({**getattr(cls, "_fields", {}), **declared})
        if cls._fields and cls.__module__.startswith("vibroimpact."):
            RESULTS[cls.__name__] = cls

    if not TYPE_CHECKING:  # to which an unknown attribute is an error

        def __getattr__(self, name: str) -> Never:
            """Answer with the name that exists here, or with all."""
            if name.startswith("_"):
                raise AttributeError(name)
            kind = type(self)
            names = sorted({*(own for own in dir(kind) if not own.startswith("_")), *kind._fields})
            raise AttributeError(_core._unknown(kind.__name__, name, names))

    def __post_init__(self) -> None:
        """Refuse what does not fit the declaration, or each other; lists become tuples."""
        self._prepare()
        for name, own in self._fields.items():
            if own.of is not None:
                self._check_items(name, own, own.of)
            elif own.kind is None:
                self._check_type(name, own)
        self._check_arrays()
        self._check_more()

    def _prepare(self) -> None:
        """Bring fields into their own types before they are looked at."""

    def _sizes(self) -> dict[str, int]:
        """Return the sizes of dimensions that something else than the arrays themselves decides."""
        return {}

    def _check_more(self) -> None:
        """Refuse what the declaration does not know of."""

    def _set(self, name: str, content: Any) -> None:
        """Set a field of the frozen record, while it is made."""
        object.__setattr__(self, name, content)

    def _check_items(self, name: str, own: Declared, of: type) -> None:
        """Make a tuple of a list, and refuse items of another type."""
        content = getattr(self, name)
        if not isinstance(content, tuple) and len(own.types) > 1 and isinstance(content, own.types):
            return  # another of its types
        content = tuple(content)
        self._set(name, content)
        if len(content) < own.given.least or not all(isinstance(one, of) for one in content):
            least = ", one at least," if own.given.least else ""
            message = f"{name} is {shown(content)}, but a sequence of {of.__name__}{least} is needed"
            raise TypeError(message)

    def _check_type(self, name: str, own: Declared) -> None:
        """Refuse what is of another type."""
        content = getattr(self, name)
        if not isinstance(content, own.types) or (isinstance(content, bool) and bool not in own.types):
            kind = own.types[0] if len(own.types) == 1 else own.types
            message = f"{name} is {content!r}, but it must be of type {kind}"
            raise TypeError(message)

    def _check_arrays(self) -> None:
        """Refuse what has not the shape that most others have, or entries of another kind."""
        dimensions, sizes = self._dimensions(), self._sizes()
        votes: dict[str, Counter[int]] = {}
        for name, dims in dimensions.items():
            content = getattr(self, name)
            shape = np.shape(content) if self._fields[name].kind is not None else (len(content),)
            for dim, size in zip(dims, shape, strict=False):
                votes.setdefault(dim, Counter())[size] += 1
        sizes = {dim: count.most_common(1)[0][0] for dim, count in votes.items()} | sizes
        for name, dims in dimensions.items():
            own, content = self._fields[name], getattr(self, name)
            shape = tuple(sizes.get(dim, dim) for dim in dims)
            if own.kind is None:
                if (len(content),) != shape:
                    message = f"{name} has {len(content)} entries, but {shape[0]} are needed"
                    raise ValueError(message)
                continue
            if not isinstance(content, np.ndarray) or content.shape != shape:
                message = f"{name} has shape {np.shape(content)}, but an array of shape {shape} is needed"
                raise ValueError(message)
            if content.dtype.kind != own.kind:
                message = f"{name} has dtype {content.dtype}, but one of kind {own.kind!r} is needed"
                raise ValueError(message)

    def _dimensions(self) -> dict[str, tuple[str, ...]]:
        """Return the names of the dimensions of each array and tuple that there is, in the form that the first one has."""
        form, found = None, {}
        for name, own in self._fields.items():
            forms, content = own.given.forms, getattr(self, name)
            if not forms or (content is None and type(None) in own.types):
                continue
            if form is None and len(forms) > 1:
                form = next((k for k, dims in enumerate(forms) if len(dims) == np.ndim(content)), 0)
            found[name] = forms[(form or 0) if len(forms) > 1 else 0]
        return found

    def _arrays(self) -> Iterator[tuple[str, tuple[str, ...], NDArray[Any]]]:
        """Go through the arrays that there are, with the names of their dimensions."""
        for name, dims in self._dimensions().items():
            if self._fields[name].kind is not None:
                yield name, dims, getattr(self, name)
            elif self._fields[name].given.as_text:
                yield name, dims, np.array([str(one) for one in getattr(self, name)], dtype=np.str_)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the result, for ``numpy.savez``."""
        return {name: content for name, _, content in self._arrays()}

    @classmethod
    def joined(cls, parts: Sequence[dict[str, Any]], **rest: Any) -> Self:
        """Return the result of pieces, whose arrays and tuples follow each other, and of the fields that they share."""
        for name, own in cls._fields.items():
            if name not in rest:
                each = [part[name] for part in parts]
                dtype = np.str_ if own.kind == "U" else None
                rest[name] = tuple(itertools.chain(*each)) if own.kind is None else np.concatenate(each, dtype=dtype)
        return cls(**rest)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the arguments, which are looked at again."""
        return type(self), tuple(getattr(self, name) for name in self._fields)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file, an ``.npz`` archive with a header in JSON, from which ``load`` reads it again."""
        from vibroimpact.results import archive

        archive.save(self, path)

    def to_xarray(self) -> Any:
        """Return the result as an ``xarray.Dataset``; needs xarray, the extra "xarray".

        Returns
        -------
        xarray.Dataset
            The arrays over named dimensions: x and y of a map; run, time and dof of an ensemble; point and dof of a section,
            and value of a diagram; exponent and batch of exponents; orbit of a branch; number of
            derivatives. Arrays that have a unit say it in their attribute "units".

        Raises
        ------
        ImportError
            Without xarray.
        """
        return labelled.dataset(*self._labelled())

    def _labelled(self) -> labelled.Parts:
        """Return the variables, the coordinates and the attributes of labelled arrays."""
        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {}
        for name, dims, content in self._arrays():
            own = self._fields[name]
            if own.kind == "V":
                variables |= labelled.table(dims[0], content)
            elif own.given.coordinate is not None:
                coordinates[own.given.coordinate] = labelled.variable(dims, content, own.given.unit)
            else:
                variables[name] = labelled.variable(dims, content, own.given.unit)
        attributes: dict[str, Any] = {}
        for name, own in self._fields.items():
            content = getattr(self, name)
            if own.kind is None and own.given.coordinate is not None and content is not None:
                coordinates[own.given.coordinate] = list(content)
            elif own.types == (_core.Orbit,):
                variables |= labelled.state(content)
            elif own.types == (list,):
                attributes[name] = str(content)
            elif isinstance(content, (str, int, float)) and not isinstance(content, bool):
                attributes[name] = content
        return variables, coordinates, attributes

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""
        rows = [(name, dims, self._fields[name].given.unit, content) for name, dims, content in self._arrays()]
        return html.record(repr(self), rows)


Item = TypeVar("Item")


class ItemsRecord(Record, Sequence[Item]):
    """A record of arrays beside a tuple of items, of which it is a sequence."""

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
