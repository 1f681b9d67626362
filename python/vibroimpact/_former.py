"""Modules by the names that they had up to version 0.2.0, which its pickles have."""

import sys

#: What had public classes and functions: the package itself has them.
_PUBLIC = (
    *("_boundary", "attractors", "basin_plane", "basin_samples", "branch", "curve", "damping", "derivative", "diagram"),
    *("ensemble", "existence", "exponents", "objective", "reduction", "special", "tree", "verdict"),
)


def keep() -> None:
    """Let imports find them, and with them pickle."""
    for name in _PUBLIC:
        sys.modules[f"vibroimpact.{name}"] = sys.modules["vibroimpact"]
