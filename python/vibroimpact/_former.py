"""Modules by the names that they had up to version 0.2.0, which its pickles have."""

import importlib
import sys

#: What had public classes: these are in the package now.
_OF_CLASSES = (
    *("_boundary", "attractors", "basin_plane", "basin_samples", "branch", "curve", "derivative", "diagram", "ensemble"),
    *("existence", "exponents", "reduction", "special", "tree", "verdict"),
)

#: What the core asks for.
_OF_FUNCTIONS = {"_files": "results.archive", "_xarray": "results.labelled", "_html": "results.html"}


def keep() -> None:
    """Let imports find them, and with them pickle."""
    for name in _OF_CLASSES:
        sys.modules[f"vibroimpact.{name}"] = sys.modules["vibroimpact"]
    for name, now in _OF_FUNCTIONS.items():
        sys.modules[f"vibroimpact.{name}"] = importlib.import_module(f"vibroimpact.{now}")
