"""What a store keeps of the arguments that made it: as JSON, arrays as text, functions by what tells them apart."""

from __future__ import annotations

import base64
import hashlib
import json
from typing import Any

import numpy as np

from vibroimpact.results import encoding
from vibroimpact.run import fingerprint, own_code_fingerprint


def digest(told: Any) -> str:
    """Return a digest of what is told, by which changes of it are seen."""
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


class Arguments(encoding.Encoder):
    """Arguments that need not be made again: functions by what tells them apart."""

    def __init__(self, key: str | None = None) -> None:
        super().__init__({})
        self._key = key

    def encoded(self, value: Any, where: str) -> Any:
        """Return a value as JSON has it."""
        # A list that can be called is more than its items.
        return self.other(value, where) if callable(value) and not self._is_ours(value) else super().encoded(value, where)

    def known(self, value: Any, where: str) -> Any:
        """Return an object of the library as JSON has it."""
        try:
            return self.by_arguments(value, where)
        except TypeError as error:
            message = f"{where}: {type(value).__name__} cannot be told from others: {error}"
            raise ValueError(message) from None

    def other(self, value: Any, where: str) -> Any:
        """Return a number of NumPy or a function as JSON has it."""
        if isinstance(value, np.generic):
            return self.encoded(value.item(), where)
        return self.function(value, where)

    def function(self, value: Any, where: str) -> Any:
        """Return a callable, or what stands for one, as JSON has it."""
        try:
            return {"function": {"name": fingerprint.named(value), "parts": fingerprint.parts(value, self._key)}}
        except ValueError as error:
            message = f"{where}: {error}"
            raise ValueError(message) from None


class OwnCode(Arguments):
    """Arguments as they were told up to version 0.2.0, functions by their own code."""

    is_blind = False

    def function(self, value: Any, where: str) -> Any:
        """Return a callable as its own code tells it."""
        self.is_blind |= not own_code_fingerprint.was_told(value)
        return {"function": own_code_fingerprint.fingerprint(value)}


def encode(name: str, value: Any, encoder: Arguments | None = None) -> dict[str, Any]:
    """Return a value as JSON has it, its arrays as text."""
    encoder = encoder or Arguments()
    encoded = encoder.encoded(value, name)
    arrays = {
        key: [array.dtype.str, list(array.shape), base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()]
        for key, array in encoder.arrays.items()
    }
    return {"value": encoded, "arrays": arrays}


def decode(kept: dict[str, Any]) -> Any:
    """Return what was told, KeyError where it had functions, ValueError where it was changed."""
    if kept.get("hash", own := digest({name: kept[name] for name in ("value", "arrays")})) != own:
        message = "it is not that of its hash"
        raise ValueError(message)
    arrays = {}
    for key, (dtype, shape, text) in kept["arrays"].items():
        arrays[key] = np.frombuffer(base64.b64decode(text), dtype).reshape(shape).copy()
    return encoding.decoded(kept["value"], arrays, {})
