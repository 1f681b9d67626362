"""Vibro-impact dynamics: structures that vibrate and hit stops.

Periodic impact motions in closed form by recovery matrices, their admissibility and stability, and simulation with
impacts located to a stated guarantee. ``import vibroimpact`` needs NumPy alone; ``vibroimpact.plot`` needs matplotlib,
the extra ``plot``, and ``vibroimpact.reduce`` SciPy, the extra ``fe``.
"""

from __future__ import annotations

import importlib
import types
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vibroimpact import _former
from vibroimpact._call_errors import answered as _answered
from vibroimpact._call_errors import no_name as _no_name
from vibroimpact._core import (
    BaseAcceleration,
    BaseMotion,
    Coefficients,
    DoublePendulum,
    Energy,
    Family,
    Fourier,
    Harmonic,
    Hertz,
    LinearSystem,
    Load,
    Modes,
    MotionState,
    Newton,
    NonlinearStop,
    NonlinearSystem,
    Orbit,
    Orbits,
    PendulumChain,
    Ramp,
    RecoveryAudit,
    Scene,
    Signal,
    Spring,
    Stability,
    Stats,
    Stop,
    Trajectory,
    Violation,
    Wall,
    __version__,
    audit_recovery,
    find_orbit,
    modes,
    paper_scene,
    paper_system,
    periodic_orbits,
    recovery_matrix,
    simulate,
)
from vibroimpact.analysis.basin_fractions import basin_fractions
from vibroimpact.analysis.basins import basins
from vibroimpact.analysis.bifurcation_curve import bifurcation_curve
from vibroimpact.analysis.bifurcation_diagram import bifurcation_diagram, poincare_points
from vibroimpact.analysis.branch_tree import branch_tree
from vibroimpact.analysis.continuation import continuation
from vibroimpact.analysis.existence_map import existence_map
from vibroimpact.analysis.find_attractors import find_attractors
from vibroimpact.analysis.lyapunov_exponents import lyapunov_exponents
from vibroimpact.analysis.objective import objective
from vibroimpact.analysis.simulate_many import simulate_many
from vibroimpact.errors import ConvergenceError
from vibroimpact.fe.damping import rayleigh_damping
from vibroimpact.fe.reduction import Reduction, reduce
from vibroimpact.results.attractors import Attractor, Attractors
from vibroimpact.results.basin_fractions import BasinFractions
from vibroimpact.results.basins import Basins
from vibroimpact.results.boundary import Fit
from vibroimpact.results.branch import Branch
from vibroimpact.results.branch_tree import BranchTree
from vibroimpact.results.curve import BifurcationCurve, CurvePoint
from vibroimpact.results.derivatives import Derivatives
from vibroimpact.results.diagram import BifurcationDiagram, PoincarePoints
from vibroimpact.results.ensemble import Ensemble
from vibroimpact.results.existence_map import ExistenceMap
from vibroimpact.results.exponents import LyapunovExponents
from vibroimpact.results.special import Beyond, Candidate, Special
from vibroimpact.run.load import load

if TYPE_CHECKING:
    from vibroimpact import plot

Sequence.register(Orbits)

#: Table 1 of the source paper as patterns: the stops hit in one period, a tuple at one instant.
KINDS: dict[int, list[int | tuple[int, ...]]] = {1: [(0, 1)], 2: [0], 3: [1], 4: []}

__all__ = [
    "KINDS",
    "Attractor",
    "Attractors",
    "BaseAcceleration",
    "BaseMotion",
    "BasinFractions",
    "Basins",
    "Beyond",
    "BifurcationCurve",
    "BifurcationDiagram",
    "Branch",
    "BranchTree",
    "Candidate",
    "Coefficients",
    "ConvergenceError",
    "CurvePoint",
    "Derivatives",
    "DoublePendulum",
    "Energy",
    "Ensemble",
    "ExistenceMap",
    "Family",
    "Fit",
    "Fourier",
    "Harmonic",
    "Hertz",
    "LinearSystem",
    "Load",
    "LyapunovExponents",
    "Modes",
    "MotionState",
    "Newton",
    "NonlinearStop",
    "NonlinearSystem",
    "Orbit",
    "Orbits",
    "PendulumChain",
    "PoincarePoints",
    "Ramp",
    "RecoveryAudit",
    "Reduction",
    "Scene",
    "Signal",
    "Special",
    "Spring",
    "Stability",
    "Stats",
    "Stop",
    "Trajectory",
    "Violation",
    "Wall",
    "__version__",
    "audit_recovery",
    "basin_fractions",
    "basins",
    "bifurcation_curve",
    "bifurcation_diagram",
    "branch_tree",
    "continuation",
    "existence_map",
    "find_attractors",
    "find_orbit",
    "load",
    "lyapunov_exponents",
    "modes",
    "objective",
    "paper_scene",
    "paper_system",
    "periodic_orbits",
    "plot",
    "poincare_points",
    "rayleigh_damping",
    "recovery_matrix",
    "reduce",
    "simulate",
    "simulate_many",
]

for _name in __all__:
    _thing = globals().get(_name)
    if isinstance(_thing, types.FunctionType | types.BuiltinFunctionType):
        globals()[_name] = _answered(_thing)
    elif isinstance(_thing, type) and _thing.__module__ != __name__:
        _thing.__module__ = __name__  # where pickle finds it, whichever file it is in

_former.keep()


def __getattr__(name: str) -> Any:
    """Import ``plot``, and with it matplotlib, when it is first used."""
    if name == "plot":
        return importlib.import_module("vibroimpact.plot")
    raise _no_name(__name__, name, __all__)


def __dir__() -> list[str]:
    return sorted(__all__)
