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
}

CHILD = """
import signal
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
wide = vi.Scene(vi.LinearSystem(np.eye(n), damping, stiffness), vi.Harmonic(np.ones(n), 1.5), stops)

signal.signal(signal.SIGALRM, signal.default_int_handler)
signal.setitimer(signal.ITIMER_REAL, 0.3)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", end="")
"""


@pytest.mark.parametrize("call", LONG.values(), ids=LONG.keys())
def test_every_search_answers_an_interruption(call):
    """In a process of its own, which is ended where it is deaf: left alone, each of these calls goes on for minutes."""
    child = [sys.executable, "-c", CHILD.format(call=call)]
    answer = subprocess.run(child, capture_output=True, text=True, timeout=20, check=False)
    assert answer.stdout == "interrupted", answer.stderr
