"""Results as labelled arrays of xarray, with named dimensions.

Those of trajectories: time, dof, impact, graze, segment; of maps x and y; of ensembles run; of diagrams value and point; of
exponents exponent and batch; of branches orbit; of derivatives number.
"""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np

from vibroimpact import _core
from vibroimpact._core import Orbit, Trajectory
from vibroimpact._results import ArrayResult

#: Tables of a result, and the dimension of their rows.
TABLES = {"impacts": "impact", "grazes": "graze", "segments": "segment"}


def to_xarray(result: Trajectory | Orbit | ArrayResult) -> Any:
    """Return a result as an ``xarray.Dataset``."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError('to_xarray needs xarray: pip install "vibroimpact[xarray]"') from error
    variables, coordinates, attributes = _MAKE[type(result).__name__](result)
    return xarray.Dataset(variables, coordinates, attributes | {"vibroimpact": _core.__version__})


_Parts = tuple[dict[str, Any], dict[str, Any], dict[str, Any]]


def _table(name: str, rows: Any) -> dict[str, Any]:
    """Return the columns of a structured array, each named after its rows."""
    row = TABLES[name]
    return {f"{row}_{column}": (row, np.ascontiguousarray(rows[column])) for column in rows.dtype.names}


def _trajectory(run: Any) -> _Parts:
    arrays = run.to_arrays()
    variables: dict[str, Any] = {f"final_{name}": ("dof", values) for name, values in zip("qv", run.final, strict=True)}
    coordinates: dict[str, Any] = {}
    if "t" in arrays:
        coordinates["time"] = arrays["t"]
        variables |= {name: (("time", "dof"), arrays[name]) for name in "qv"}
    variables |= _table("impacts", run.impacts) | _table("grazes", run.grazes)
    for name, values in run.derivatives.items():
        # At t_eval, which are the times that the run has then; or at the end.
        variables[f"derivatives_{name}"] = (("time", "state")[-values.ndim :], values)
    with contextlib.suppress(ValueError):  # the motion was not kept
        variables |= _table("segments", run.segments)
    return variables, coordinates, {"t_end": run.t_end, "status": run.status, "message": run.message}


def _orbit(orbit: Any) -> _Parts:
    variables: dict[str, Any] = {"q0": ("dof", orbit.q0), "v0": ("dof", orbit.v0)}
    variables |= _table("impacts", orbit.impacts) | _table("segments", orbit.segments)
    if orbit.floquet_multipliers is not None:
        variables["floquet_multipliers"] = ("multiplier", orbit.floquet_multipliers)
    attributes = {"period": orbit.period, "phase": orbit.phase, "n_periods": orbit.n_periods, "pattern": str(orbit.pattern)}
    attributes |= {name: str(getattr(orbit, name)) for name in ("is_admissible", "is_stable")}
    return variables, {}, attributes


def _map(found: Any) -> _Parts:
    names = ("n_orbits", "is_admissible", "is_stable", "multiplier")
    attributes = {name: value for name in ("x_name", "y_name") if (value := getattr(found, name)) is not None}
    return {name: (("y", "x"), getattr(found, name)) for name in names}, {"x": found.x, "y": found.y}, attributes


def _ensemble(ends: Any) -> _Parts:
    dimensions = ("run", "dof") if ends.q.ndim == 2 else ("run", "time", "dof")
    variables: dict[str, Any] = {name: (dimensions, getattr(ends, name)) for name in "qv"}
    variables |= {name: ("run", getattr(ends, name)) for name in ("n_impacts", "status")}
    return variables | ({} if ends.impacts is None else _table("impacts", ends.impacts)), {}, {}


def _points(points: Any) -> _Parts:
    columns = [name for name in ("t", "index", "stop", "speed_before", "phase") if hasattr(points, name)]
    variables: dict[str, Any] = {name: ("point", getattr(points, name)) for name in columns}
    return variables | {name: (("point", "dof"), getattr(points, name)) for name in "qv"}, {}, {}


def _diagram(diagram: Any) -> _Parts:
    variables, coordinates, attributes = _points(diagram)
    arrays = diagram.to_arrays()
    variables |= {name: ("value", arrays[name]) for name in ("direction", "n_periods", "n_impacts", "pattern", "status")}
    named = {} if diagram.name is None else {"name": diagram.name}
    return variables, coordinates | {"parameter": ("value", diagram.parameter)}, attributes | named


def _exponents(found: Any) -> _Parts:
    variables: dict[str, Any] = {name: ("exponent", getattr(found, name)) for name in ("exponents", "errors")}
    names = ("sum", "expected_sum", "n_impacts", "n_landings", "n_grazes", "n_clashes", "verdict", "status")
    attributes = {name: getattr(found, name) for name in names}
    return variables | {"history": (("batch", "exponent"), found.history)}, {}, attributes


def _attractor(one: Any) -> _Parts:
    attributes = {"kind": one.kind, "n_periods": one.n_periods, "pattern": str(one.pattern), "fraction": one.fraction}
    variables: dict[str, Any] = {"points": (("point", "state"), one.points), "exponents": ("exponent", one.exponents)}
    return variables, {}, attributes


def _attractors(found: Any) -> _Parts:
    columns = {name: ("attractor", [getattr(one, name) for one in found]) for name in ("kind", "n_periods", "fraction")}
    variables: dict[str, Any] = {"seeds": (("seed", "state"), found.seeds), "of_seed": ("seed", found.of_seed)}
    return variables | columns | {"pattern": ("attractor", [str(one.pattern) for one in found])}, {}, {"phase": found.phase}


def _basins(plane: Any) -> _Parts:
    variables: dict[str, Any] = {name: (("y", "x"), getattr(plane, name)) for name in ("labels", "iterations")}
    named = {"x_name": plane.x_name, "y_name": plane.y_name}
    return variables | {"fractions": ("attractor", plane.fractions)}, {"x": plane.x, "y": plane.y}, named


def _fractions(sampled: Any) -> _Parts:
    dimensions = ("attractor",) if sampled.fractions.ndim == 1 else ("value", "attractor")
    variables: dict[str, Any] = {name: (dimensions, getattr(sampled, name)) for name in ("fractions", "errors")}
    named = {} if sampled.name is None else {"name": sampled.name}
    coordinates = {} if sampled.values is None else {"parameter": ("value", sampled.values)}
    return variables | {"undecided": (dimensions[:-1], sampled.undecided)}, coordinates, named


def _branch(branch: Any) -> _Parts:
    arrays = branch.to_arrays()
    coordinates = {"parameter": ("orbit", arrays.pop("parameter"))}
    widths = {"multipliers": "multiplier", "speeds_before": "impact", "phases": "impact"}
    variables: dict[str, Any] = {name: (("orbit", widths[name]) if name in widths else "orbit", x) for name, x in arrays.items()}
    named = {} if branch.parameter_name is None else {"name": branch.parameter_name}
    ends = {f"end_{k}": f"{reason}: {detail}" for k, (reason, detail) in enumerate(branch.ends)}
    return variables, coordinates, named | ends | {"pattern": str(branch.pattern), "n_periods": branch.n_periods}


def _special(own: Any) -> _Parts:
    names = ("kind", "parameter", "error", "arclength")
    variables: dict[str, Any] = {"q0": ("dof", own.orbit.q0), "v0": ("dof", own.orbit.v0)}
    return variables, {}, {name: getattr(own, name) for name in names}


def _beyond(own: Any) -> _Parts:
    sides = np.array([candidate.side for candidate in own.candidates])
    parameters = ("candidate", np.array([candidate.parameter for candidate in own.candidates]))
    return {"side": ("candidate", sides)}, {"parameter": parameters}, {"outcome": own.outcome, "reason": own.reason}


def _curve(curve: Any) -> _Parts:
    names = {} if curve.parameter_names is None else dict(zip(("name_x", "name_y"), curve.parameter_names, strict=True))
    variables: dict[str, Any] = {name: ("orbit", getattr(curve, name)) for name in ("arclength", "is_virtual")}
    return variables, {"x": ("orbit", curve.x), "y": ("orbit", curve.y)}, {"kind": curve.kind} | names


def _curve_point(own: Any) -> _Parts:
    variables: dict[str, Any] = {"q0": ("dof", own.orbit.q0), "v0": ("dof", own.orbit.v0)}
    return variables, {}, {"kind": own.kind, "x": own.parameter[0], "y": own.parameter[1]}


def _branch_tree(tree: Any) -> _Parts:
    branch = np.repeat(np.arange(len(tree)), [len(own) for own in tree])
    joined = {name: np.concatenate([getattr(own, name) for own in tree]) for name in ("is_stable", "is_admissible", "n_unstable")}
    variables: dict[str, Any] = {name: ("orbit", values) for name, values in joined.items()}
    coordinates = {"parameter": ("orbit", np.concatenate([own.parameter for own in tree])), "branch": ("orbit", branch)}
    return variables, coordinates, {f"parent_{k}": str(own) for k, own in enumerate(tree.parents)}


def _candidate(own: Any) -> _Parts:
    variables: dict[str, Any] = {"q0": ("dof", own.orbit.q0), "v0": ("dof", own.orbit.v0)}
    return variables, {}, {"parameter": own.parameter, "side": own.side}


def _derivatives(found: Any) -> _Parts:
    rows = {"q0": "dof", "v0": "dof", "max_displacement": "dof", "speeds_before": "impact", "times": "impact", "min_gap": "stop"}
    rows["multipliers"] = "multiplier"
    arrays = found.to_arrays()
    variables: dict[str, Any] = {name: ((rows[name], "number") if name in rows else "number", x) for name, x in arrays.items()}
    coordinates = {} if found.parameters is None else {"number": list(found.parameters)}
    return variables, coordinates, {"reason": found.reason}


def _fit(fit: Any) -> _Parts:
    return {"counts": ("size", fit.counts)}, {"size": fit.sizes}, {"value": fit.value, "error": fit.error}


_MAKE = {
    "Trajectory": _trajectory,
    "Orbit": _orbit,
    "ExistenceMap": _map,
    "Ensemble": _ensemble,
    "PoincarePoints": _points,
    "BifurcationDiagram": _diagram,
    "LyapunovExponents": _exponents,
    "Attractor": _attractor,
    "Attractors": _attractors,
    "Basins": _basins,
    "BasinFractions": _fractions,
    "Branch": _branch,
    "Beyond": _beyond,
    "BifurcationCurve": _curve,
    "CurvePoint": _curve_point,
    "BranchTree": _branch_tree,
    "Candidate": _candidate,
    "Special": _special,
    "Derivatives": _derivatives,
    "Fit": _fit,
}
