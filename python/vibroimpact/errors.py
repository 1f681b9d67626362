"""Exceptions of vibroimpact; bad input is a plain ``ValueError``."""

__all__ = ["ConvergenceError"]


class ConvergenceError(RuntimeError):
    """A computation that ended without a result; the message says where and how far it got."""
