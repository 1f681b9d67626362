"""Computations that return results: thin functions over the core."""
