"""Time ``vi.reduce`` of 20 000 unknowns to 40 modes, and measure the memory it takes.

Run by hand, ``python benches/reduction.py``, with SciPy. An Euler-Bernoulli beam of 10 000 elements and a solid bar of 5000
bricks, each clamped at one end and free, with the direction of a stop at its other end. Each runs in a process of its own,
whose peak is printed, beside what Python, NumPy and the matrices took before.
"""

import itertools
import multiprocessing
import resource
import time

import numpy as np
import scipy.sparse as sp

import vibroimpact as vi


def assemble(block, unknowns):
    """Sum equal element matrices at their unknowns, shape (e, k)."""
    k = unknowns.shape[1]
    rows, columns = np.repeat(unknowns, k, axis=1), np.tile(unknowns, (1, k))
    n = int(unknowns.max()) + 1
    return sp.csc_array(sp.coo_array((np.tile(block.ravel(), len(unknowns)), (rows.ravel(), columns.ravel())), shape=(n, n)))


def beam(n_elements=10_000):
    """Return mass and stiffness of a free Euler-Bernoulli beam, and the number of unknowns at its end."""
    h = 1.0 / n_elements
    mass = np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]])
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
    unknowns = 2 * np.arange(n_elements)[:, np.newaxis] + np.arange(4)
    blocks = (h / 420.0 * mass, stiffness / h**3)
    return *(assemble(block + np.triu(block, 1).T, unknowns) for block in blocks), 2


def brick(poisson=0.3):
    """Return mass and stiffness of a brick of unit edges with eight nodes, (x, y, z) each, by Gauss points."""
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    shear = 0.5 / (1.0 + poisson)
    law = np.diag([2.0 * shear] * 3 + [shear] * 3)
    law[:3, :3] += poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    mass, stiffness = np.zeros((24, 24)), np.zeros((24, 24))
    for point in itertools.product((-(3.0**-0.5), 3.0**-0.5), repeat=3):
        factors = 1.0 + corners * point
        values = np.kron(factors.prod(axis=1) / 8.0, np.eye(3))
        slopes = [corners[:, d] * np.delete(factors, d, axis=1).prod(axis=1) / 4.0 for d in range(3)]
        strains = np.zeros((6, 24))
        for d in range(3):
            strains[d, d::3] = slopes[d]
        for row, (a, b) in enumerate(((0, 1), (1, 2), (0, 2)), start=3):
            strains[row, a::3], strains[row, b::3] = slopes[b], slopes[a]
        mass += values.T @ values / 8.0
        stiffness += strains.T @ law @ strains / 8.0
    return mass, stiffness


def solid(long=136, wide=6):
    """Return mass and stiffness of a free bar of bricks, and the number of unknowns at its end."""
    nodes = np.arange((long + 1) * (wide + 1) ** 2).reshape(long + 1, wide + 1, wide + 1)
    corners = [nodes[i : long + i, j : wide + j, k : wide + k].ravel() for i, j, k in itertools.product((0, 1), repeat=3)]
    unknowns = (3 * np.array(corners).T[:, :, np.newaxis] + np.arange(3)).reshape(-1, 24)
    return *(assemble(block, unknowns) for block in brick()), 3 * (wide + 1) ** 2


def measure(name, make, is_clamped, answers):
    """Reduce one structure and hand back what is printed of it."""
    mass, stiffness, at_end = make()
    if is_clamped:
        mass, stiffness = mass[at_end:, at_end:], stiffness[at_end:, at_end:]
    unit = 1024  # of Linux
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
    start, start_cpu = time.perf_counter(), time.process_time()
    reduction = vi.reduce(mass, 0.01, stiffness, n_modes=40, directions=[mass.shape[0] - at_end + 1])
    seconds, cpu = time.perf_counter() - start, time.process_time() - start_cpu
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
    spent = f"{seconds:6.2f} s ({cpu:.2f} s of processors)   peak {peak / 1e6:6.0f} MB, before {before / 1e6:4.0f} MB"
    answers.put(f"{name:14} {spent}\n    {reduction!r}")


def main():
    """Measure each structure in a process of its own."""
    context = multiprocessing.get_context("spawn")
    for name, make in (("beam", beam), ("solid", solid)):
        for is_clamped in (True, False):
            answers = context.Queue()
            arguments = (f"{'clamped' if is_clamped else 'free'} {name}", make, is_clamped, answers)
            process = context.Process(target=measure, args=arguments)
            process.start()
            print(answers.get(), flush=True)
            process.join()


if __name__ == "__main__":
    main()
