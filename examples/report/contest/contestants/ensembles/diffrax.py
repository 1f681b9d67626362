"""diffrax: the compiled loop of one trajectory, mapped over all of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import jax
import numpy as np
from jax import numpy as jnp

from ...problems import Ensemble
from .. import Tolerances
from ..diffrax import loop
from . import Ends


def methods(_: Ensemble) -> list[str]:
    """Both explicit pairs."""
    return ["Tsit5", "Dopri8"]


@lru_cache(maxsize=4)
def compiled(problem: Ensemble, method: str):
    """The mapped motion, compiled."""
    motion = loop(problem, method, most=1)

    def ends(start, rtol, atol):
        t, x, _, count = motion(start, rtol, atol)
        return t, x, count

    return jax.jit(jax.vmap(ends, (0, None, None))).lower(jnp.asarray(problem.starts), 1.0, 1.0).compile()


def prepare(problem: Ensemble, method: str, tolerances: Tolerances) -> Callable[[], Ends]:
    """One compiled call."""
    motion, starts, rows = compiled(problem, method), jnp.asarray(problem.starts), np.arange(len(problem.starts))
    rtol, atol = jnp.asarray(tolerances.relative), jnp.asarray(tolerances.absolute)

    def run() -> Ends:
        t, states, counts = motion(starts, rtol, atol)
        if not np.all(np.isfinite(np.asarray(t))):
            raise RuntimeError("a solve failed")
        return Ends(rows, np.asarray(states), np.asarray(counts))

    return run
