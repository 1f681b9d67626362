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

from vibroimpact._calls import answered as _answered
from vibroimpact._calls import no_name as _no_name
from vibroimpact._core import (
    BaseAcceleration,
    BaseMotion,
    Coefficients,
    DoublePendulum,
    Energy,
    Family,
    Fourier,
    Harmonic,
    LinearSystem,
    Load,
    Modes,
    NonlinearStop,
    NonlinearSystem,
    Orbit,
    Orbits,
    PendulumChain,
    Ramp,
    RecoveryAudit,
    Scene,
    Signal,
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
from vibroimpact._files import load
from vibroimpact.attractors import Attractor, Attractors, find_attractors
from vibroimpact.basin_plane import Basins, Fit, basins
from vibroimpact.basin_samples import BasinFractions, basin_fractions
from vibroimpact.branch import Branch, continuation
from vibroimpact.curve import BifurcationCurve, CurvePoint, bifurcation_curve
from vibroimpact.damping import rayleigh_damping
from vibroimpact.derivative import Derivatives
from vibroimpact.diagram import BifurcationDiagram, PoincarePoints, bifurcation_diagram, poincare_points
from vibroimpact.ensemble import Ensemble, simulate_many
from vibroimpact.errors import ConvergenceError
from vibroimpact.existence import ExistenceMap, existence_map
from vibroimpact.exponents import LyapunovExponents, lyapunov_exponents
from vibroimpact.objective import objective
from vibroimpact.reduction import Reduction, reduce
from vibroimpact.special import Candidate, Special
from vibroimpact.tree import BranchTree, branch_tree
from vibroimpact.verdict import Beyond

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
    "LinearSystem",
    "Load",
    "LyapunovExponents",
    "Modes",
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
    if isinstance(_function := globals().get(_name), types.FunctionType | types.BuiltinFunctionType):
        globals()[_name] = _answered(_function)


def __getattr__(name: str) -> Any:
    """Import ``plot``, and with it matplotlib, when it is first used."""
    if name == "plot":
        return importlib.import_module("vibroimpact.plot")
    raise _no_name(__name__, name, __all__)


def __dir__() -> list[str]:
    return sorted(__all__)
