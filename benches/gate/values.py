"""Every value of a result under a name of its own, as arrays."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

import vibroimpact as vi

SAMPLES = 33  # instants at which a motion is read
MANY = 300  # impacts times coordinates beyond which what is made for drawing, and the ledger, are left out
DRAWN = ("t", "q", "v", "energy")
OWN = tuple(kind for kind in map(vars(vi).get, vi.__all__) if isinstance(kind, type) and kind is not vi.ConvergenceError)

Named = Iterator[tuple[str, np.ndarray]]


def values(result: Any, name: str) -> Named:
    """Yield the values of a result: numbers, texts and arrays as they are, of what holds others those, by name or place."""
    if isinstance(result, np.ndarray) and result.dtype.names:
        for field in result.dtype.names:
            yield f"{name}.{field}", result[field].copy()
    elif isinstance(result, np.ndarray):
        yield name, result.copy()
    elif result is None or isinstance(result, (bool, int, float, complex, str, np.generic)):
        yield name, np.asarray("None" if result is None else result)
    elif isinstance(result, BaseException):
        yield name, np.asarray(f"{type(result).__name__}: {result}")
    elif isinstance(result, OWN):
        yield from parts(result, name)
    elif isinstance(result, Mapping):
        for key, value in result.items():
            yield from values(value, f"{name}[{key}]")
    elif isinstance(result, Sequence):
        yield f"{name}.len", np.asarray(len(result))
        for k, value in enumerate(result):
            yield from values(value, f"{name}[{k}]")
    elif not (callable(result) or hasattr(result, "ctypes")):
        raise TypeError(f"{name} is a {type(result).__name__}, which has no numbers that are known")


def parts(result: Any, name: str) -> Named:
    """Yield what an object of the library says of itself; what it refuses to say, as that refusal."""
    is_long = isinstance(result, vi.Trajectory) and result.stats.n_impacts * result.scene.n_dof > MANY
    left_out = DRAWN if is_long else ()
    for attribute in dir(type(result)):
        if not attribute.startswith("_") and attribute not in left_out:
            yield from values(told(lambda of=attribute: getattr(result, of)), f"{name}.{attribute}")
    if isinstance(result, Sequence):
        for k, each in enumerate(result):
            yield from values(each, f"{name}[{k}]")
    if isinstance(result, vi.Orbit):
        yield from read(result, np.linspace(-0.3, 1.7, SAMPLES) * result.period, name)
    if isinstance(result, vi.Trajectory):
        yield from read(result, np.linspace(0.0, 1.0, SAMPLES) * result.t_end, name)


def read(motion: Any, times: np.ndarray, name: str) -> Named:
    """Yield positions and velocities at some instants."""
    yield from values(told(lambda: motion.position(times)), f"{name}.position")
    yield from values(told(lambda: motion.velocity(times)), f"{name}.velocity")


def told(ask: Any) -> Any:
    """Return the answer, or the error that stands for it."""
    try:
        return ask()
    except (ValueError, RuntimeError, AttributeError) as error:
        return error
