"""Stores: results over a plane that are written while they are worked out, and gone on with by the same call again.

A store is a group of zarr. Its attributes say what it was made with, its arrays hold what was found; one of them, written last in
each chunk, says where something was.
"""

from __future__ import annotations

import contextlib
import json
import os
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact.run.stored_arguments import Arguments, OwnCode, decode, digest, encode
from vibroimpact.run.tiles import Tile, tile_shape, tiles

#: Counts what older libraries cannot read.
FORMAT = 1

#: Versions whose stores this one goes on with.
_GOES_ON = ("0.2.0",)

#: Defaults of arguments that were others up to a version: a store has what was used, whether or not it was given.
_WERE_DEFAULTS = {"atol": (1e-12, "0.2.0")}

#: Cells of a chunk: so many at least, and no more chunks than these.
_CELLS, _CHUNKS = 1 << 14, 1 << 10


class Restored(NamedTuple):
    """How a store of a kind is read: its arrays, with what stands where nothing was found yet, and what makes the result."""

    columns: dict[str, tuple[str, Any]]
    make: Callable[[dict[str, Any], dict[str, NDArray[Any]]], Any]


#: The kinds of results that stores hold; an analysis that writes one puts it here.
STORED_RESULTS: dict[str, Restored] = {}


def check_options(overwrite: object, key: object) -> None:
    """Refuse an `overwrite` that is neither True nor False, a `key` that is no text."""
    if not isinstance(overwrite, bool):
        message = f"overwrite is {overwrite!r}, but True or False is needed"
        raise TypeError(message)
    if not isinstance(key, (str, type(None))):
        message = f"key is {key!r}, but a text is needed, or None"
        raise TypeError(message)


class Store:
    """Arrays over the cells of a plane, shape (ny, nx), written chunk by chunk.

    `key` stands for code that cannot be looked through.

    Raises
    ------
    ValueError
        A file, a folder or a group with something else in it, a store that other arguments have made.
    ImportError
        Without zarr.
    """

    def __init__(
        self,
        store: Any,
        kind: str,
        arguments: dict[str, Any],
        axes: dict[str, NDArray[np.float64]],
        columns: dict[str, tuple[str, Any]],
        *,
        overwrite: bool,
        key: str | None = None,
    ) -> None:
        self._zarr, self._store, self._name = _zarr(), store, _shown(store)
        keyed = arguments if key is None else arguments | {"key": key}
        made = _made(kind, {name: encode(name, value, Arguments(key)) for name, value in keyed.items()})
        group = _opened(self._zarr, store)
        known = self._take_over(group, made, arguments) if group is not None and key is None else made
        is_other = group is not None and self._is_other(dict(group.attrs), known, overwrite)
        if group is None or is_other:
            group = self._created(made, is_other)
        self._group = group
        ny, nx = axes["y"].size, axes["x"].size
        self.cells = max(_CELLS, -(-nx * ny // _CHUNKS))
        # With a checksum, by which changed bytes are seen.
        packed = {"compressors": self._zarr.codecs.ZstdCodec(checksum=True)}
        wanted = {"shape": (ny, nx), "chunks": tile_shape(self.cells, nx), "dimension_names": ("y", "x"), **packed}
        for name, values in axes.items():
            self._array(name, data=values, dimension_names=(name,), **packed)
        self._arrays = {
            name: self._array(name, dtype=dtype, fill_value=fill, **wanted) for name, (dtype, fill) in columns.items()
        }

    def _created(self, made: dict[str, Any], overwrite: bool) -> Any:
        """Return the group, new, or as another process has just made it."""
        try:
            return self._tried(
                lambda: self._zarr.create_group(self._store, overwrite=overwrite, attributes={"vibroimpact": made})
            )
        except self._zarr.errors.ContainsGroupError:
            group = _opened(self._zarr, self._store)
            self._is_other(dict(group.attrs), made, False)
            return group

    def _is_other(self, attributes: dict[str, Any], made: dict[str, Any], overwrite: bool) -> bool:
        """Whether another call made a store: refused unless it may be replaced, as is a group that is no store."""
        found = attributes.get("vibroimpact")
        if not isinstance(found, dict):
            message = f"store is {self._name}, but it is a group of zarr with something else in it"
            raise ValueError(message)
        differs = _difference(found, made)
        if differs is not None and not overwrite:
            message = f"store is {self._name}, but {differs}: overwrite=True replaces it"
            raise ValueError(message)
        return differs is not None

    def _take_over(self, group: Any, made: dict[str, Any], arguments: dict[str, Any]) -> dict[str, Any]:
        """Go on with a store that knows functions by their own code, where that is the same; it knows the rest from now on.

        Returns what the store is to be compared with: the call as it was told then, where plain values alone differ from that.
        """
        found = group.attrs.get("vibroimpact")
        if not isinstance(found, dict) or found.get("hash") == made["hash"] or not _knows_own_code(found):
            return made
        encoders = {name: OwnCode() for name in arguments}
        try:
            own = _made(made["type"], {name: encode(name, value, encoders[name]) for name, value in arguments.items()})
        except ValueError:
            return made
        if any(encoder.is_blind for encoder in encoders.values()):
            return made
        if _difference(found, own) is not None:
            theirs = found.get("arguments", {})
            others = [name for name in own["arguments"] if theirs.get(name) != own["arguments"][name]]
            return own if all(_plain(name, theirs, own["arguments"]) for name in others) else made
        self._tried(lambda: group.update_attributes({"vibroimpact": made}))
        warnings.warn(
            f"store {self._name} was made by a version that told functions by their own code alone, which is the same: it goes "
            "on, and from now on what they read and call is told too; whether that has changed since cannot be said",
            stacklevel=5,
        )
        return made

    def _array(self, name: str, **options: Any) -> Any:
        """Return an array of the group, made if it is not there."""
        if name not in self._group:
            try:
                return self._tried(lambda: self._group.create_array(name, **options))
            except self._zarr.errors.ContainsArrayError:  # another process was faster
                pass
        return self._group[name]

    def _tried(self, write: Any) -> Any:
        """Write; an error of the system names the store."""
        try:
            return write()
        except OSError as error:
            reason = error.strerror or str(error)
            raise OSError(error.errno, f"store {self._name}: {reason}; what it had before is kept") from error

    def kept(self, name: str) -> Any:
        """Return what was kept beside the arrays, None if nothing was."""
        found = self._group.attrs.get(name)
        try:
            return None if found is None else decode(found)
        except Exception as error:
            message = f"store is {self._name}, but its {name} were changed or cut: overwrite=True does not mend it, remove it"
            raise ValueError(message) from error

    def keep(self, name: str, value: Any) -> None:
        """Keep a value beside the arrays."""
        kept = encode(name, value)
        self._tried(lambda: self._group.update_attributes({name: kept | {"hash": digest(kept)}}))

    def read(self) -> dict[str, NDArray[Any]]:
        """Return the arrays as they are now; a chunk that was cut or changed is one that has not been written."""
        try:
            return {name: np.asarray(array[:]) for name, array in self._arrays.items()}
        except OSError:
            raise
        except Exception:  # whatever its codecs make of other bytes: look for the chunks that can be read
            shape = next(iter(self._arrays.values())).shape
            found = {name: np.full(shape, array.fill_value, array.dtype) for name, array in self._arrays.items()}
            for chunk in tiles(range(shape[0]), range(shape[1]), self.cells):
                try:
                    parts = {name: np.asarray(array[chunk]) for name, array in self._arrays.items()}
                except OSError:
                    raise
                except Exception:
                    continue
                for name, part in parts.items():
                    found[name][chunk] = part
            return found

    def lacks(self, arrays: dict[str, NDArray[Any]], chunk: Tile) -> bool:
        """Whether cells of a chunk have not been found, by the last array."""
        last = list(arrays)[-1]
        return bool((arrays[last][chunk] == self._arrays[last].fill_value).any())

    def write(self, arrays: dict[str, NDArray[Any]], chunk: Tile) -> None:
        """Write a chunk, the last array last."""

        def written() -> None:
            if _opened(self._zarr, self._store) is None:
                raise FileNotFoundError(2, "it is not there any more")
            for name, array in self._arrays.items():
                array[chunk] = arrays[name][chunk]

        self._tried(written)


def _difference(found: dict[str, Any], made: dict[str, Any]) -> str | None:
    """Return the first thing in which a store differs from what a call makes, in words."""
    for name in ("format", "version", "type"):
        if found.get(name) != made[name] and not (name == "version" and found.get(name) in _GOES_ON):
            return f"its {name} is {found.get(name)!r}, not {made[name]!r}"
    if found.get("hash") == made["hash"]:
        return None
    own, theirs = made["arguments"], found.get("arguments", {})
    others = [name for name in {**own, **theirs} if theirs.get(name) != own.get(name)]
    if others and all(_plain(name, theirs, own) for name in others):
        return _other_values(others, theirs, own)
    first = others[0] if others else "hash"
    if _knows_own_code(found) and '"parts"' in json.dumps(own.get(first)):
        return f"a version made it that did not look through all code: that of {first} is another, or it did not see it"
    functions = [list(_functions(one.get(first))) for one in (own, theirs)]
    for mine, other in zip(*functions, strict=False):
        changed = sorted(name for name in {**mine, **other} if mine.get(name) != other.get(name))
        if changed:
            # What leads to others changes where these are not the same ones.
            return f"it was made with another {first}: {', '.join(changed[:4])}{' ...' if changed[4:] else ''} changed"
    return f"it was made with another {first}"


def _plain(name: str, *arguments: dict[str, Any]) -> bool:
    """Whether an argument is a number, a text or None in all that was told."""
    values = [told.get(name) for told in arguments]
    return all(isinstance(told, dict) and isinstance(told.get("value", ()), (str, int, float, type(None))) for told in values)


def _other_values(names: list[str], theirs: dict[str, Any], own: dict[str, Any]) -> str:
    """Return in words that some plain arguments of a store are others: which, and what goes on with it."""
    kept, given = ({name: told[name]["value"] for name in names} for told in (theirs, own))
    differ = ", ".join(f"another {name}, {kept[name]!r}, not {given[name]!r}" for name in names)
    notes = [
        f"{value!r} was the default of {name} up to version {version}, which a store has where none was given"
        for name, (value, version) in _WERE_DEFAULTS.items()
        if name in names and (kept[name], given[name]) == (value, None)
    ]
    goes_on = ", ".join(f"{name}={kept[name]!r}" for name in names)
    return f"it was made with {differ} ({'; '.join([*notes, f'{goes_on} goes on with it'])})"


def _made(kind: str, arguments: dict[str, Any]) -> dict[str, Any]:
    """Return what a store keeps of the call that makes it."""
    return {"format": FORMAT, "version": _core.__version__, "type": kind, "arguments": arguments, "hash": digest(arguments)}


def _functions(told: Any) -> Iterator[dict[str, str]]:
    """Iterate over the parts of all callables in what was told."""
    if isinstance(told, dict):
        if isinstance(told.get("parts"), dict):
            yield told["parts"]
        else:
            told = list(told.values())
    if isinstance(told, list):
        for one in told:
            yield from _functions(one)


def _knows_own_code(found: dict[str, Any]) -> bool:
    """Whether a store tells callables as up to version 0.2.0."""
    text = json.dumps(found.get("arguments"))
    return '"function"' in text and '"parts"' not in text


def contents(path: str | os.PathLike[str]) -> tuple[str, dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the type of a store, its attributes and its arrays, those of its axes too.

    Raises
    ------
    ValueError
        A folder that is no store, one of a newer format, or one that was changed or cut.
    """
    zarr = _zarr()
    try:
        group = zarr.open_group(path, mode="r")
    except FileNotFoundError:
        group = None
    except (OSError, ImportError):
        raise
    except Exception as error:  # whatever zarr makes of files that are not its own
        raise _changed(path, error) from error
    attributes = {} if group is None else dict(group.attrs)
    made = attributes.get("vibroimpact")
    if group is None or not isinstance(made, dict) or not isinstance(made.get("format"), int):
        message = f"path is {_shown(path)}, but it is no result of vibroimpact"
        raise ValueError(message)
    if made["format"] > FORMAT:
        newer = f"its format {made['format']} is newer than {FORMAT}, the newest that this version reads"
        message = f"path is {_shown(path)}, but {newer}"
        raise ValueError(message)
    try:
        kind, arguments = str(made["type"]), made["arguments"]
        if made["hash"] != digest(arguments):
            raise ValueError("its arguments are not those of its hash")
        of_functions = kind == "Basins" and any(_is_function(arguments["scene"]["value"]))
        arrays = {} if of_functions else _arrays(group, STORED_RESULTS[kind].columns)
    except (OSError, ImportError):
        raise
    except Exception as error:
        raise _changed(path, error) from error
    if of_functions:
        reason = "its scene is made of functions, which it does not hold: the same call of basins opens it"
        message = f"path is {_shown(path)}, but {reason}"
        raise ValueError(message)
    return kind, attributes | {"arguments": arguments}, arrays


def _changed(path: Any, error: Exception) -> ValueError:
    return ValueError(f"path is {_shown(path)}, but it was changed or cut: {error!r}")


def _is_function(told: Any) -> Iterator[bool]:
    """Iterate over what was told: whether it stands for a callable."""
    if isinstance(told, dict):
        yield "function" in told
        told = list(told.values())
    if isinstance(told, list):
        for one in told:
            yield from _is_function(one)


def _arrays(group: Any, columns: dict[str, tuple[str, Any]]) -> dict[str, NDArray[Any]]:
    """Return the arrays of a store, which are those that it was made with."""
    found = dict(group.arrays())
    shape = tuple(found[axis].shape[0] for axis in ("y", "x"))
    wanted = {"x": ("f8", 0.0), "y": ("f8", 0.0)} | columns
    if set(found) != set(wanted):
        message = f"it has arrays {sorted(found)}, not {sorted(wanted)}"
        raise ValueError(message)
    for name, (dtype, fill) in wanted.items():
        array = found[name]
        is_same = array.fill_value == fill or (fill != fill and array.fill_value != array.fill_value)
        if array.dtype != np.dtype(dtype) or not is_same or (name in columns and array.shape != shape):
            message = (
                f"its array {name!r} is of type {array.dtype} and shape {array.shape}, with {array.fill_value!r} where it is open"
            )
            raise ValueError(message)
    return {name: np.asarray(array[:]) for name, array in found.items()}


def check_axes(arrays: dict[str, NDArray[Any]], x: NDArray[np.float64], y: NDArray[np.float64]) -> None:
    """Refuse axes in a store that are not those of its arguments."""
    if not (np.array_equal(arrays["x"], x) and np.array_equal(arrays["y"], y)):
        message = "its axes are not those of its arguments"
        raise ValueError(message)


def _zarr() -> Any:
    try:
        import zarr
    except ImportError as error:
        raise ImportError('a store needs zarr: pip install "vibroimpact[store]"') from error
    return zarr


def _shown(store: Any) -> str:
    return repr(os.fspath(store)) if isinstance(store, (str, os.PathLike)) else repr(store)


def _opened(zarr: Any, store: Any) -> Any:
    """Return the group of a store, None where there is nothing yet."""
    if isinstance(store, (bool, int, float, bytes)):
        message = f"store is {store!r}, but a folder, or a store of zarr, is needed"
        raise TypeError(message)
    path = Path(store) if isinstance(store, (str, os.PathLike)) and "://" not in os.fspath(store) else None
    if path is not None and path.exists() and not path.is_dir():
        message = f"store is {_shown(store)}, but that is a file: a folder is needed"
        raise ValueError(message)
    with contextlib.suppress(FileNotFoundError):
        return zarr.open_group(store, mode="r+")
    if path is not None and path.is_dir() and any(not entry.name.endswith(".partial") for entry in path.iterdir()):
        # Another process may have made the store since.
        with contextlib.suppress(FileNotFoundError):
            return zarr.open_group(store, mode="r+")
        message = f"store is {_shown(store)}, but that folder has something else in it"
        raise ValueError(message)
    return None
