"""Every search answers Ctrl-C."""

import subprocess
import sys

import pytest

LONG = {
    "one_instant": "vi.periodic_orbits(slow, [0])",
    "longest_period": "vi.periodic_orbits(slow.replace(frequency=1.0001e-12), [0])",
    "longest_map": "vi.existence_map(slow, [0], ('frequency', [1.0001e-12]), ('clearance', [0.5]), workers=1)",
    "longest_map_on_threads": "vi.existence_map(slow, [0], ('frequency', np.linspace(1.1e-12, 2e-12, 600)), ('phase', [0]))",
    "is_admissible": "vi.periodic_orbits(slow, [0], phase=0.3)[0].is_admissible",
    "violation": "vi.periodic_orbits(slow, [0], phase=0.3)[0].violation",
    "multipliers": "vi.periodic_orbits(slow, [0], phase=0.3)[0].floquet_multipliers",
    "repr": "repr(vi.periodic_orbits(slow, [0], phase=0.3))",
    "two_instants": "vi.periodic_orbits(wide.replace(damping_scale=1e-3), [0, 1], 1000)",
    "free": "vi.periodic_orbits(wide, [(0, 1)], free='frequency', between=(0.1, 10.0))",
    "existence_map": "vi.existence_map(lambda x, y: slow.replace(clearance=x), [0], [0.5], [0.5], workers=1)",
    "ramp": "vi.simulate(wavering, [0.0], [0.0], (0, 4e5), keep='final', ramp=vi.Ramp('frequency', 2.0, over=4e5))",
    "signal": "vi.Signal.from_function(np.sin, (0.0, 2e6))",
    "tile": "vi.existence_map(slow, [0], ('frequency', np.linspace(1.1e-12, 2e-12, 6)), ('phase', [0]), workers=map)",
}

# What is long in itself: eigenproblems, and answers for many times.
HEAVY = {
    "modes": "vi.modes(coupled(500))",
    "real modes": "vi.modes(coupled(1500, proportional=True))",
    "complex orbits": "vi.periodic_orbits(vi.Scene(coupled(400), vi.Harmonic(np.ones(400), 1.5), stops), [0])",
    "lasting contact": "vi.simulate(pressed(400), np.zeros(400), np.zeros(400), (0, 10))",
    "t_eval": "vi.simulate(free, q, q, (0, 10), t_eval=np.linspace(0, 10, 300_000))",
    "position": "kept.position(np.linspace(0, 10, 300_000))",
    "velocity": "kept.velocity(np.linspace(0, 10, 300_000))",
    "orbit": "orbit.position(np.linspace(0, 10, 3_000_000))",
    "q": "bounces.q",
    "t": "[bounces.t for _ in range(1000)]",
    "energy": "bounces.energy",
    "along": "orbit.along(0, np.linspace(0, 10, 3_000_000), 2)",
    "acceleration": "kept.acceleration(np.linspace(0, 10, 300_000))",
    "contact force": "held.contact_force(0, np.linspace(0, 10, 1_000_000))",
    "impulse": "[held.impulse(0) for _ in range(1_000_000)]",
    "long orbits": "vi.find_orbit(chaotic, wandering, n_periods=600)",
    "functions": "vi.simulate_many(functions, many, 0 * many, (0, 1000))",
}

CHILD = """
import os, signal, time
import numpy as np
import vibroimpact as vi

# 1e9 natural periods in one of the forcing: every search walks over all of them.
slow = vi.Scene(
    vi.LinearSystem([[1.0]], [[1e-12]], [[1.0]]), vi.Harmonic([1.0], 1e-9), [vi.Stop(0, 0.5, 0.8)]
)
n = 100
damping = 0.02 * np.eye(n) + 0.01 * np.diag(np.arange(n) % 3)
stiffness = 4.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
stops = [vi.Stop(i, 0.1, 0.8) for i in (0, 50)]
wavering = vi.Scene(vi.LinearSystem(1.0, 0.1, 2.0), vi.Harmonic([1.0], 1.3), vi.Stop(0, 0.2, 0.5))
wide = vi.Scene(vi.LinearSystem(np.eye(n), damping, stiffness), vi.Harmonic(np.ones(n), 1.5), stops)

{setup}


def interrupted(signum, frame):
    global asked
    asked = time.perf_counter()
    raise KeyboardInterrupt


signal.signal(signal.SIGALRM, interrupted)
signal.setitimer(signal.ITIMER_REAL, 0.1)
try:
    {call}
except KeyboardInterrupt:
    print(time.perf_counter() - asked, end="", flush=True)
os._exit(0)  # and not wait for what was left to itself
"""

SETUP = """
def coupled(n, proportional=False):
    stiffness = 4.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    dampers = 0.0 if proportional else 0.01 * np.diag(np.arange(n) % 3)
    return vi.LinearSystem(np.eye(n), 0.02 * stiffness + dampers, stiffness, load=np.ones(n))


def pressed(n):
    stiffness = 4.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    system = vi.LinearSystem(np.ones(n), 0.02 * np.ones(n), np.linspace(1.0, 2.0, n), load=np.ones(n))
    return vi.Scene(system, None, vi.Stop(np.ones(n), 0.0, 0.0))


free = vi.Scene(vi.LinearSystem(np.ones(20), 0.1 * np.ones(20), np.ones(20)))
q = np.ones(20)
kept = vi.simulate(free, q, q, (0, 10))
orbit = vi.periodic_orbits(vi.paper_scene(3), [1], 2)[0]
held = vi.simulate(vi.Scene(free.system, None, vi.Stop(0, 1.0, 0.0)), q, 0 * q, (0, 10))
shuttle = [vi.Stop(0, 1.0, 1.0), vi.Stop(0, 1.0, 1.0, side="lower")]
bounces = vi.simulate(vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0), None, shuttle), 0.0, 2.0, (0, 600_000))
chaotic = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([8.5], 2.4), vi.Stop(0, 0.2, 0.7))
wandering = vi.simulate(chaotic, 0.0, 1.0, (0, 700 * chaotic.period))
functions = vi.Scene(vi.NonlinearSystem(1, lambda t, q, v: -q, mass=1.0), None, vi.Stop(0, 0.5, 0.9))
many = np.linspace(0.0, 0.4, 100)
"""

PROMPT = 0.2  # [s] in which an interruption is answered
LOADED = 2.0  # times as long on a machine that has other things to do


def check(call, setup):
    child = [sys.executable, "-c", CHILD.format(call=call, setup=setup)]
    answer = subprocess.run(child, capture_output=True, text=True, timeout=60, check=False)
    assert answer.stdout, answer.stderr or "it was done before it was interrupted"
    assert float(answer.stdout) < LOADED * PROMPT


@pytest.mark.parametrize("call", LONG.values(), ids=LONG.keys())
def test_every_search_answers_an_interruption(call):
    """In a process of its own, which is ended where it is deaf: left alone, each of these calls goes on for minutes."""
    check(call, "")


@pytest.mark.parametrize("call", HEAVY.values(), ids=HEAVY.keys())
def test_heavy_calls_answer_an_interruption(call):
    check(call, SETUP)
