"""diffrax: a compiled loop over solves that end at an event; one condition, the smallest gap, by bisection.

Each new solve starts a little in front of the stop, at a gap far below every tolerance.
"""

from __future__ import annotations

from functools import lru_cache

import diffrax as dx
import jax
import numpy as np
import optimistix as optx
from jax import numpy as jnp

from ..equations import equations
from ..opening import opening
from ..problems import Problem
from . import Outcome, Run, Tolerances

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_cpu_enable_async_dispatch", False)  # a run that is stopped does not go on behind the next

DISTRIBUTION = "diffrax"
MOST = 20_000  # impacts kept
STEPS = 10**7
ROOT = 1e-13  # of the bisection, in time and gap: closer, it does not end
SOLVERS = {"Tsit5": dx.Tsit5, "Dopri8": dx.Dopri8, "Kvaerno5": dx.Kvaerno5}


def methods(problem: Problem) -> list[str]:
    """Two explicit pairs; for stiff scenes an implicit one too."""
    return list(SOLVERS) if problem.is_stiff else ["Tsit5", "Dopri8"]


def pieces(problem: Problem):
    """Rate, gaps and impacts as functions of jax's arrays."""
    formulas = equations(problem.scene)
    n, functions = formulas.n_dof, {"sin": jnp.sin, "cos": jnp.cos}
    acceleration = formulas.acceleration.function(functions)
    gaps, impacts = ([each.function(functions) for each in some] for some in (formulas.gaps, formulas.impacts))

    def rate(t, x, _):
        return jnp.concatenate([x[n:], jnp.stack([jnp.asarray(a, x.dtype) for a in acceleration(t, *x)])])

    def distances(t, x):
        return jnp.stack([gap(t, *x[:n])[0] for gap in gaps])

    openings = [opening(problem, k) for k in range(len(impacts))]
    leading = jnp.array([i for i, _ in openings])
    changes = [change.function(functions) for _, change in openings]

    def turned(k, t, x):
        q = x[:n].at[leading[k]].add(jnp.stack([change(t, *x[:n])[0] for change in changes])[k])
        return jnp.concatenate([q, jnp.stack([jnp.stack(impact(t, *x)) for impact in impacts])[k]])

    return rate, distances, turned


def loop(problem: Problem, method: str, most: int = MOST):
    """The motion as a function of start and tolerances, to be compiled; it keeps so many times of impact."""
    rate, distances, turned = pieces(problem)
    term, end = dx.ODETerm(rate), problem.end
    event = dx.Event(
        lambda t, y, args, **_: jnp.min(distances(t, y)),
        root_finder=optx.Bisection(rtol=ROOT, atol=ROOT, flip=True),  # the gap falls
        direction=False,
    )
    options = {"event": event, "max_steps": STEPS, "saveat": dx.SaveAt(t1=True), "throw": False}

    def motion(start, rtol, atol):
        controller = dx.PIDController(rtol=rtol, atol=atol)

        def flight(carry):
            t, x, times, count = carry
            start = jnp.minimum(t, end * (1.0 - 1e-12))  # many at once: those that are done go on for nothing
            found = dx.diffeqsolve(term, SOLVERS[method](), start, end, None, x, **options, stepsize_controller=controller)
            t, x = found.ts[0], found.ys[0]
            is_hit = found.result == dx.RESULTS.event_occurred
            after = turned(jnp.argmin(distances(t, x)), t, x)
            times = times.at[count].set(jnp.where(is_hit, t, times[count]), mode="drop")
            done = jnp.where(is_hit | dx.is_okay(found.result), t, jnp.nan)
            return done, jnp.where(is_hit, after, x), times, count + is_hit

        return jax.lax.while_loop(lambda carry: carry[0] < end, flight, (0.0, start, jnp.zeros(most), 0))

    return motion


@lru_cache(maxsize=4)
def compiled(problem: Problem, method: str):
    """The motion, compiled."""
    start = jnp.asarray(problem.start)
    return jax.jit(loop(problem, method)).lower(start, 1.0, 1.0).compile()


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """One call of the compiled loop."""
    motion, start = compiled(problem, method), jnp.asarray(problem.start)
    rtol, atol = jnp.asarray(tolerances.relative), jnp.asarray(tolerances.absolute)

    def run() -> Outcome:
        t, x, times, count = motion(start, rtol, atol)
        if not np.isfinite(float(t)):
            raise RuntimeError("a solve failed")
        return Outcome(np.asarray(x), np.asarray(times[: int(count)]))

    return run
