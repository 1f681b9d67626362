"""Results as labelled arrays of xarray, with named dimensions.

Those of motions are written here: time, dof, impact, graze, segment. Those of records follow from what their fields declare.
"""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Trajectory

#: Variables, coordinates and attributes.
Parts = tuple[dict[str, Any], dict[str, Any], dict[str, Any]]


def dataset(variables: dict[str, Any], coordinates: dict[str, Any], attributes: dict[str, Any]) -> Any:
    """Return an ``xarray.Dataset``."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError('to_xarray needs xarray: pip install "vibroimpact[xarray]"') from error
    return xarray.Dataset(variables, coordinates, attributes | {"vibroimpact": _core.__version__})


def variable(dims: tuple[str, ...], values: NDArray[Any], unit: str = "") -> tuple[Any, ...]:
    """Return a variable over its dimensions, with its unit if it has one."""
    return (dims, values, {"units": unit}) if unit else (dims, values)


def table(row: str, rows: Any) -> dict[str, Any]:
    """Return the columns of a structured array, each named after its rows."""
    return {f"{row}_{column}": (row, np.ascontiguousarray(rows[column])) for column in rows.dtype.names}


def state(orbit: Orbit) -> dict[str, Any]:
    """Return the state of an orbit right after its first impact."""
    return {"q0": variable(("dof",), orbit.q0, "m"), "v0": variable(("dof",), orbit.v0, "m/s")}


def to_xarray(motion: Trajectory | Orbit) -> Any:
    """Return a motion as an ``xarray.Dataset``."""
    return dataset(*(_orbit(motion) if isinstance(motion, Orbit) else _trajectory(motion)))


def _trajectory(run: Any) -> Parts:
    arrays = run.to_arrays()
    units = {"q": "m", "v": "m/s"}
    final = zip("qv", run.final, strict=True)
    variables: dict[str, Any] = {f"final_{name}": variable(("dof",), values, units[name]) for name, values in final}
    coordinates: dict[str, Any] = {}
    if "t" in arrays:
        coordinates["time"] = variable(("time",), arrays["t"], "s")
        variables |= {name: variable(("time", "dof"), arrays[name], units[name]) for name in "qv"}
    variables |= table("impact", run.impacts) | table("graze", run.grazes)
    for name, values in run.derivatives.items():
        # At t_eval, which are the times that the run has then; or at the end.
        variables[f"derivatives_{name}"] = (("time", "state")[-values.ndim :], values)
    with contextlib.suppress(ValueError):  # the motion was not kept
        variables |= table("segment", run.segments)
    return variables, coordinates, {"t_end": run.t_end, "status": run.status, "message": run.message}


def _orbit(orbit: Any) -> Parts:
    variables = state(orbit)
    variables |= table("impact", orbit.impacts) | table("segment", orbit.segments)
    if orbit.floquet_multipliers is not None:
        variables["floquet_multipliers"] = ("multiplier", orbit.floquet_multipliers)
    attributes = {"period": orbit.period, "phase": orbit.phase, "n_periods": orbit.n_periods, "pattern": str(orbit.pattern)}
    attributes |= {name: str(getattr(orbit, name)) for name in ("is_admissible", "is_stable")}
    return variables, {}, attributes
