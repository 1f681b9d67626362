"""Finite-element models with closed-form answers: beams, bars and trusses of unit length, stiffness and mass."""

import numpy as np
import scipy.sparse as sp

#: Roots of cos b cosh b = -1 (clamped and free) and cos b cosh b = 1 (both ends free): w = b^2.
CANTILEVER = np.array([1.8751040687119611, 4.694091132974175, 7.854757438237613, 10.995540734875467])
FREE_BEAM = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671, 14.137165491257464])


def assemble(blocks, unknowns, n):
    """Sum equal or different blocks (e, k, k) at their unknowns (e, k)."""
    k = unknowns.shape[1]
    rows, columns = np.repeat(unknowns, k, axis=1), np.tile(unknowns, (1, k))
    blocks = np.broadcast_to(blocks, (len(unknowns), k, k))
    return sp.csc_array(sp.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n)))


def beam(n_elements, clamped=True):
    """Euler-Bernoulli beam: mass and stiffness; unknowns are deflection and slope of each node but a clamped one."""
    h = 1.0 / n_elements
    mass = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]])
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
    unknowns = 2 * np.arange(n_elements)[:, np.newaxis] + np.arange(4)
    n = 2 * (n_elements + 1)
    first = 2 if clamped else 0
    whole = (h / 420.0 * (mass + np.triu(mass, 1).T), (stiffness + np.triu(stiffness, 1).T) / h**3)
    return tuple(assemble(block, unknowns, n)[first:, first:] for block in whole)


def cantilever_compliance(x, y):
    """Deflection at x of a unit load at y on a clamped beam."""
    low, high = min(x, y), max(x, y)
    return low**2 * (3.0 * high - low) / 6.0


def bar(n_elements):
    """A free bar with its mass at the nodes, half of an element's at each of its ends."""
    h = 1.0 / n_elements
    unknowns = np.arange(n_elements)[:, np.newaxis] + np.arange(2)
    stiffness = assemble(np.array([[1.0, -1.0], [-1.0, 1.0]]) / h, unknowns, n_elements + 1)
    mass = np.full(n_elements + 1, h)
    mass[[0, -1]] *= 0.5
    return mass, stiffness


def bar_frequencies(n_elements):
    """Natural frequencies of that bar, the rigid-body mode first: 2 n sin(j pi / (2 n)), exactly."""
    return 2.0 * n_elements * np.sin(np.arange(n_elements + 1) * np.pi / (2.0 * n_elements))


def truss(points, pairs, stiffnesses=1.0):
    """Unit masses at points (p, d), and bars between pairs of them (b, 2)."""
    points, pairs = np.asarray(points), np.asarray(pairs)
    p, d = points.shape
    along = points[pairs[:, 1]] - points[pairs[:, 0]]
    along /= np.linalg.norm(along, axis=1)[:, np.newaxis]
    rows = np.concatenate([-along, along], axis=1)
    blocks = np.broadcast_to(stiffnesses, len(pairs))[:, np.newaxis, np.newaxis] * rows[:, :, np.newaxis] * rows[:, np.newaxis]
    unknowns = (d * pairs[:, :, np.newaxis] + np.arange(d)).reshape(len(pairs), 2 * d)
    return np.ones(p * d), assemble(blocks, unknowns, p * d)
