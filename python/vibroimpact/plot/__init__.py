"""Figures of motions, modes, stability and existence, with matplotlib alone.

Every function takes the data first, draws on `ax` (on a new figure if it is None) and returns the Axes (`animate` the
animation); what is left of its keywords goes to the artist it draws.  Nothing here computes mechanics, and a velocity is
never joined across the jump of an impact unless the jump itself is meant.
"""

try:
    import matplotlib as _matplotlib  # noqa: F401  asked for first, so that its absence is met with the remedy
except ImportError as _error:
    raise ImportError('vibroimpact.plot needs matplotlib: pip install "vibroimpact[plot]"') from _error

import difflib as _difflib
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Never as _Never

from vibroimpact.plot.animation import animate
from vibroimpact.plot.basins import basins
from vibroimpact.plot.branch import branch
from vibroimpact.plot.contact_force import contact_force
from vibroimpact.plot.curves import bifurcation_curves
from vibroimpact.plot.diagram import bifurcation_diagram
from vibroimpact.plot.existence import existence_map
from vibroimpact.plot.exponents import lyapunov
from vibroimpact.plot.gap import gap
from vibroimpact.plot.impacts import impact_speeds
from vibroimpact.plot.ledger import energy
from vibroimpact.plot.modes import mode_shapes
from vibroimpact.plot.motion import phase_portrait, time_history
from vibroimpact.plot.paths import multiplier_paths
from vibroimpact.plot.section import poincare_section
from vibroimpact.plot.spectrum import spectrum
from vibroimpact.plot.stability import multipliers
from vibroimpact.plot.sweep import sweep

__all__ = [
    "animate",
    "basins",
    "bifurcation_curves",
    "bifurcation_diagram",
    "branch",
    "contact_force",
    "energy",
    "existence_map",
    "gap",
    "impact_speeds",
    "lyapunov",
    "mode_shapes",
    "multiplier_paths",
    "multipliers",
    "phase_portrait",
    "poincare_section",
    "spectrum",
    "sweep",
    "time_history",
]


if not _TYPE_CHECKING:  # to which an unknown name is an error

    def __getattr__(name: str) -> _Never:
        """Answer with the names that are near."""
        near = [own for own in __all__ if name in own or own in name] or _difflib.get_close_matches(name, __all__, 3, 0.5)
        meant = f"; is {' or '.join(near[:3])} meant?" if near else ""
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{meant}", name=name)
