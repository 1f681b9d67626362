"""Count the shallow contacts that are missed, by SciPy's events and here.

Run by hand, ``python benches/shallow_contacts.py``. A resonant oscillator (c/2m = 0.05) at rest, a wall at 26 depths from
1e-6 to 1e-1 below each of its first 8 peaks: 208 contacts. One is missed if the run up to the trough behind that peak finds
no contact at all; a touch inside the margin that is listed as a graze is found, and counted apart. ``tests/simulate/stepping.rs``
holds the package to the same set.
"""

import numpy as np
from scipy.integrate import solve_ivp

import vibroimpact as vi

W = np.sqrt(1 - 0.05**2)
METHODS = ("rk45", "dop853", "radau")


def scene(wall):
    """Return the oscillator with its wall."""
    return vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic(1, W), vi.Stop(0, wall, 0.8))


def peaks():
    """Return times and heights of the first 8 peaks without a wall."""
    t = np.linspace(0, 60, 600_001)
    q = vi.simulate(scene(100.0), 0, 0, (0, 60), t_eval=t).q[:, 0]
    at = np.flatnonzero((q[1:-1] > q[:-2]) & (q[1:-1] >= q[2:])) + 1
    return [(t[i], q[i]) for i in at[:8]]


def finds_scipy(wall, end, rtol):
    """Whether a terminal event sees the wall."""

    def gap(t, x):
        return wall - x[0]

    gap.terminal, gap.direction = True, -1
    run = solve_ivp(
        lambda t, x: [x[1], np.cos(W * t) - 0.1 * x[1] - x[0]], (0, end), [0, 0], rtol=rtol, atol=1e-3 * rtol, events=gap
    )
    return len(run.t_events[0]) > 0


def found_here(wall, end, rtol, method):
    """Return what is found at the wall: "impact", "graze" or "nothing"."""
    run = vi.simulate(scene(wall), 0, 0, (0, end), method=method, rtol=rtol, atol=1e-3 * rtol, max_impacts=1)
    return "impact" if len(run.impacts) else "graze" if len(run.grazes) else "nothing"


def main():
    """Print the counts."""
    print("rtol   missed by SciPy RK45", *(f"  missed by {method}   its grazes" for method in METHODS))
    contacts = [(height - depth, time + np.pi) for time, height in peaks() for depth in 10 ** np.arange(-6, -0.9, 0.2)]
    for exponent in range(3, 13):
        rtol = 10.0**-exponent
        missed = sum(not finds_scipy(wall, end, rtol) for wall, end in contacts)
        print(f"{rtol:.0e} {missed:19}", end="")
        for method in METHODS:
            found = [found_here(wall, end, rtol, method) for wall, end in contacts]
            print(f"{found.count('nothing'):18} {found.count('graze'):12}", end="")
        print(flush=True)


if __name__ == "__main__":
    main()
