"""Finite-element models: damping and reduction, with SciPy."""
