"""The motion of one degree of freedom in closed form, at any damping, through resonance."""

from __future__ import annotations

from mpmath import mp, mpc, mpf

from report.extremes.condition import Parts

APART = mpf(10) ** -60  # between roots that are equal: with twice the digits, far below the fiftieth


def driven(root: mpc, rate: mpc, time: mpf) -> mpc:
    """The solution from rest of x' = root x + e^(rate t)."""
    if root == rate:
        return time * mp.exp(root * time)
    return (mp.exp(rate * time) - mp.exp(root * time)) / (rate - root)


def oscillator(
    damping: mpf,
    stiffness: mpf,
    load: mpf,
    force: mpf,
    frequency: mpf,
    phase: mpf,
    q: mpf,
    v: mpf,
    start: mpf,
    length: mpf,
) -> Parts:
    """Position and velocity of q'' + damping q' + stiffness q = load + force cos(frequency t + phase) after some time."""
    with mp.workdps(160):
        apart = mp.sqrt(mpc(damping**2 / 4 - stiffness)) or APART
        first, second = apart - damping / 2, -apart - damping / 2
        turned = force * mp.exp(1j * (frequency * start + phase))
        x = y = mpc(0)
        for root, other in ((first, second), (second, first)):
            state = (v - other * q) * mp.exp(root * length) + load * driven(root, mpc(0), length)
            forced = mp.re(turned * driven(root, 1j * frequency, length) / (root - other)) if force else mpf(0)
            forced_rate = mp.re(turned * root * driven(root, 1j * frequency, length) / (root - other)) if force else mpf(0)
            x += state / (root - other) + forced
            y += root * state / (root - other) + forced_rate
        values = mp.re(x), mp.re(y)
    return [[+values[0]], [+values[1]]]
