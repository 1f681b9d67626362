"""Print the speed of Taylor series as a ratio to heyoka, which compiles Taylor series of any equations.

Run by hand, ``python benches/against_heyoka.py [rounds]``, with heyoka and a release build of the package installed (``maturin
develop --release``). Both follow the paper's third case with large motions: the same equations, a terminal event for each stop,
the impact in its callback, integrators compiled beforehand. Call by call they take turns; the error is that of the final
state against the series at the finest tolerance. For each level of error the fastest setting of either that reaches it is
compared.
"""

import sys
import time
from statistics import median

import heyoka as hy
import numpy as np

import vibroimpact as vi

ROUNDS = 30
SPAN = 400.0
START = (0.02, -0.1), (0.0, 0.3)
LEVELS = [10.0**-k for k in range(4, 13)]
TOLERANCES = [10.0**-k for k in range(3, 15)]


def equations(scene):
    """Return the equations of motion (3), solved for the accelerations, in heyoka's variables."""
    system, base = scene.system, scene.forcing
    gravity = 1 / (1 + system.mass_ratio)
    alpha = system.mass_ratio * gravity / system.length_ratio
    second = alpha / system.length_ratio
    (c00, c01), (c10, c11) = system.damping.tolist()
    p, q, u, v = hy.make_vars("p", "q", "u", "v")
    push = base.amplitude * base.frequency**2 * hy.cos(base.frequency * hy.time + base.phase)
    sine, cosine = hy.sin(p - q), alpha * hy.cos(p - q)
    f = push * hy.cos(p) - gravity * hy.sin(p) - alpha * sine * v * v - c00 * u - c01 * v
    g = alpha * (push * hy.cos(q) - gravity * hy.sin(q) + sine * u * u) - c10 * u - c11 * v
    det = second - cosine * cosine
    return [(p, u), (q, v), (u, (second * f - cosine * g) / det), (v, (g - cosine * f) / det)]


class Impact:
    """The impact on a stop, counted."""

    def __init__(self, stop):
        """Remember the coordinate and the restitution."""
        self.entry, self.restitution, self.count = 2 + stop.normal, stop.restitution, 0

    def __call__(self, integrator, _sign):
        """Turn the velocity and go on."""
        integrator.state[self.entry] *= -self.restitution
        self.count += 1
        return True


def heyoka_run(scene, tolerance):
    """Return a function that runs the scene and gives the final state and the number of impacts."""
    rates = equations(scene)
    impacts = [Impact(stop) for stop in scene.stops]
    events = [
        hy.t_event(stop.clearance - rates[stop.normal][0], callback=impact, direction=hy.event_direction.negative)
        for stop, impact in zip(scene.stops, impacts, strict=True)
    ]
    start = [*START[0], *START[1]]
    integrator = hy.taylor_adaptive(rates, start, tol=tolerance, t_events=events)

    def run():
        for event in integrator.t_events:
            event.callback.count = 0
        integrator.time = 0.0
        integrator.state[:] = start
        integrator.reset_cooldowns()
        integrator.propagate_until(SPAN)
        return integrator.state.copy(), sum(event.callback.count for event in integrator.t_events)

    return run


def batch_of_pendulums(scene, starts, span, tolerance=1e-9):
    """Follow starts at rest over a time, as many abreast as the processor has room for; return how many that are."""
    rates = equations(scene)
    size = hy.recommended_simd_size()

    def turned(stop):
        def callback(integrator, _sign, lane):
            integrator.state[2 + stop.normal, lane] *= -stop.restitution
            return True

        return callback

    events = [
        hy.t_event_batch(stop.clearance - rates[stop.normal][0], callback=turned(stop), direction=hy.event_direction.negative)
        for stop in scene.stops
    ]
    integrator = hy.taylor_adaptive_batch(rates, np.zeros((4, size)), tol=tolerance, t_events=events)
    for first in range(0, len(starts), size):
        rows = np.resize(starts[first : first + size], (size, 2))
        integrator.set_time(0.0)
        integrator.state[:] = np.vstack([rows.T, np.zeros((2, size))])
        integrator.reset_cooldowns()
        integrator.propagate_until([span] * size)
    return size


def own_run(scene, rtol):
    """Return the same for the package."""

    def run():
        motion = vi.simulate(scene, *START, (0.0, SPAN), method="taylor", rtol=rtol, atol=0.1 * rtol, keep="final")
        return np.concatenate(motion.final), motion.stats.n_impacts

    return run


def main():
    """Measure and print."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    scene = vi.paper_scene(kind=3, linear=False)
    truth, count = own_run(scene, 1e-15)()
    runs = {(name, tol): make(scene, tol) for name, make in (("heyoka", heyoka_run), ("own", own_run)) for tol in TOLERANCES}
    errors, times = {}, {key: [] for key in runs}
    for key, run in runs.items():
        state, found = run()
        assert found == count, key
        errors[key] = np.abs(state - truth).max()
    for _ in range(rounds):
        for key, run in runs.items():
            start = time.perf_counter()
            run()
            times[key].append((time.perf_counter() - start) / count * 1e6)
    print(f"heyoka {hy.__version__}; microseconds per impact, {count} impacts, median of {rounds}")
    for level in LEVELS:
        best = {}
        for name in ("heyoka", "own"):
            reached = [median(times[key]) for key in runs if key[0] == name and errors[key] <= level]
            best[name] = min(reached, default=float("nan"))
        print(
            f"error {level:.0e}: heyoka {best['heyoka']:6.2f}, own {best['own']:6.2f}, ratio {best['heyoka'] / best['own']:5.2f}"
        )


if __name__ == "__main__":
    main()
