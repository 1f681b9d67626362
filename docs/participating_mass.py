"""Draw docs/figures/participating_mass.png: the mass that takes part in an impact, over the number of modes kept (theory 13).

Run by hand, ``python docs/participating_mass.py``, with the package installed with its extras ``fe`` and ``plot``. A clamped
beam and a free bar are reduced to k modes, without a residual vector and with one for the end that is hit; k modes of the
continuous beam leave 1/(4 k) of its mass at the tip, k modes of the bar, one of them its rigid-body mode, 1/(2 k - 1).
"""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import scipy.sparse as sp

import vibroimpact as vi

N_ELEMENTS = 600
COUNTS = (1, 2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64)


def assemble(block):
    """Sum equal element matrices along a line of nodes."""
    per_node = len(block) // 2
    unknowns = per_node * np.arange(N_ELEMENTS)[:, np.newaxis] + np.arange(len(block))
    rows, columns = np.repeat(unknowns, len(block), axis=1), np.tile(unknowns, (1, len(block)))
    n = per_node * (N_ELEMENTS + 1)
    return sp.csc_array(sp.coo_array((np.tile(block.ravel(), N_ELEMENTS), (rows.ravel(), columns.ravel())), shape=(n, n)))


def clamped_beam():
    """Return mass and stiffness of an Euler-Bernoulli beam of unit mass, and the unknown of its tip."""
    h = 1.0 / N_ELEMENTS
    mass = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]])
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
    m, k = (assemble(a + np.triu(a, 1).T)[2:, 2:] for a in (h / 420.0 * mass, stiffness / h**3))
    return m, k, m.shape[0] - 2


def free_bar():
    """Return mass and stiffness of a bar of unit mass that moves along itself, and the unknown of its end."""
    h = 1.0 / N_ELEMENTS
    m, k = assemble(h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])), assemble(np.array([[1.0, -1.0], [-1.0, 1.0]]) / h)
    return m, k, N_ELEMENTS


def masses(structure, residual):
    """Return the mass that takes part, for each number of modes."""
    mass, stiffness, end = structure
    options = {"directions": [end], "residual": residual}
    return [vi.reduce(mass, None, stiffness, n_modes=count, **options).participating_mass(end) for count in COUNTS]


def main():
    """Check both structures against the continuous ones, and draw."""
    counts = np.array(COUNTS)
    fig, ax = plt.subplots(figsize=(7, 4.5), layout="constrained")
    laws = (
        ("tip of a clamped beam", clamped_beam(), 1.0 / (4.0 * counts)),
        ("end of a free bar", free_bar(), 1.0 / (2.0 * counts - 1.0)),
    )
    for color, (name, structure, law) in enumerate(laws):
        plain = np.array(masses(structure, residual=False))
        assert np.allclose(plain, law, rtol=2e-2)
        ax.loglog(counts, law, color="0.7", linewidth=4, label="continuous" if color == 0 else None)
        ax.loglog(counts, plain, "o", color=f"C{color}", label=f"{name}, k modes")
        ax.loglog(counts, masses(structure, residual=True), "x", color=f"C{color}", label=f"{name}, with a residual vector")
    ax.set(
        xlabel="modes kept, k",
        ylabel="1/(n.M⁻¹n) / mass of the structure",
        title="Mass that takes part in the instant of an impact",
    )
    ax.grid(which="both", color="0.9")
    ax.legend()
    fig.savefig(Path(__file__).parent / "figures" / "participating_mass.png", dpi=120)


if __name__ == "__main__":
    main()
