"""Modules by the names that they had up to version 0.2.0, which its pickles have."""

import importlib
import sys

#: What had public classes and functions: the package itself has them.
_PUBLIC = (
    *("_boundary", "attractors", "basin_plane", "basin_samples", "branch", "curve", "damping", "derivative", "diagram"),
    *("ensemble", "existence", "exponents", "objective", "reduction", "special", "tree", "verdict"),
)

#: What a core that was built before asks for: to be left out with the next build of it.
_ASKED_FOR = {"_files": "results.archive", "_xarray": "results.labelled", "_html": "results.html"}


def keep() -> None:
    """Let imports find them, and with them pickle."""
    for name in _PUBLIC:
        sys.modules[f"vibroimpact.{name}"] = sys.modules["vibroimpact"]
    for name, now in _ASKED_FOR.items():
        sys.modules[f"vibroimpact.{name}"] = importlib.import_module(f"vibroimpact.{now}")
