"""Random linear scenes with compliant and rigid stops, and starts for them."""

import math

import numpy as np
from contact_twin import Rows, Stop, Twin


def draw(rng):
    """Return a random scene, a start and a span of time."""
    while True:
        twin = some_twin(rng)
        start = some_start(rng, twin)
        if start is not None:
            return twin, *start, float(rng.uniform(12.0, 30.0))


def some_matrix(rng, n, low, high):
    """Return a random symmetric positive definite matrix with eigenvalues in a range."""
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    made = turn @ np.diag(rng.uniform(low, high, n)) @ turn.T
    return 0.5 * (made + made.T)


def chain(springs, n):
    """Return the matrix of a chain of n masses with n + 1 springs, the outer ones to the ground."""
    made = np.diag(springs[:-1] + springs[1:])
    return made - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1) if n > 1 else made


def some_system(rng):
    """Return random mass, damping and stiffness, with exact zeros among them."""
    n = int(rng.choice([1, 1, 2, 2, 3, 4, 5]))
    mass = [np.eye(n), np.diag(rng.uniform(0.5, 2.0, n)), some_matrix(rng, n, 0.5, 1.6)][rng.integers(3)]
    kind = rng.random()
    if kind < 0.5:
        springs = rng.uniform(0.5, 4.0, n + 1)
        if rng.random() < 0.5:
            springs[-1] = 0.0
        if rng.random() < 0.2:
            # A rigid body.
            springs[0] = springs[-1] = 0.0
        stiffness = chain(springs, n)
    elif kind < 0.65:
        stiffness = np.diag(rng.uniform(0.5, 6.0, n))
    else:
        stiffness = some_matrix(rng, n, 0.5, 8.0)
    kind = rng.random()
    if kind < 0.25:
        damping = np.zeros((n, n))
    elif kind < 0.6:
        damping = rng.uniform(0.0, 0.15) * mass + rng.uniform(0.0, 0.05) * stiffness
    elif kind < 0.8:
        damping = np.diag(rng.uniform(0.0, 0.3, n) * (rng.random(n) < 0.6))
    else:
        damping = some_matrix(rng, n, 0.01, 0.4)
    return mass, damping, stiffness


def some_normal(rng, n):
    """Return a coordinate, a difference of neighbours, or any direction."""
    kind = rng.random()
    if kind < 0.6 or n == 1:
        return np.eye(n)[rng.integers(n)]
    if kind < 0.8:
        i = int(rng.integers(n - 1))
        return np.eye(n)[i] - np.eye(n)[i + 1]
    return np.round(rng.normal(size=n), 2)


def some_spring(rng, twin, stop):
    """Give a stop a random spring and dashpot."""
    typical = max(np.trace(twin.stiffness) / len(twin.stiffness), 0.5)
    stop.stiffness = float(typical * 10.0 ** rng.uniform(-1.0, 4.0 if rng.random() < 0.4 else 2.0))
    stop.release = str(rng.choice(["gap", "force", "force", "clipped"]))
    b = np.linalg.solve(twin.mass, stop.normal) if stop.reaction == "inertia" else stop.normal
    critical = 2.0 * math.sqrt(stop.stiffness / float(stop.normal @ b))
    kind = rng.random()
    if kind < 0.2:
        stop.damping = 0.0
    elif kind < 0.7:
        stop.damping = float(rng.uniform(0.02, 0.9)) * critical
    elif kind < 0.8:
        stop.damping = critical
    else:
        stop.damping = float(rng.uniform(1.1, 5.0)) * critical
    if rng.random() < 0.3:
        stop.preload = float(typical * rng.uniform(0.02, 0.6))


def some_twin(rng):
    """Return a random scene."""
    mass, damping, stiffness = some_system(rng)
    n = len(mass)
    kind = rng.random()
    if kind < 0.12:
        force = None
    elif kind < 0.7:
        force = np.round(rng.normal(size=n) * rng.uniform(0.4, 2.0), 3)
    else:
        force = np.round((rng.normal(size=n) + 1j * rng.normal(size=n)) * rng.uniform(0.3, 1.5), 3)
    if force is not None and n > 1 and rng.random() < 0.3:
        force[rng.integers(n)] = 0.0
    twin = Twin(mass, damping, stiffness, force, float(rng.uniform(0.4, 3.0)))
    # Scenes of many stops that may be held, and of the others.
    rests = rng.random() < 0.2
    for _ in range(int(rng.choice([1, 2, 2, 3, 4])) + int(rests and n > 1)):
        stop = Stop(some_normal(rng, n), float(rng.uniform(0.02, 0.6) * rng.choice([1.0, 1.0, 0.3])))
        if rng.random() < 0.05:
            stop.clearance *= -0.5
        stop.side = str(rng.choice(["upper", "lower"]))
        if twin.stops and rng.random() < 0.2:
            # A second stop behind another.
            other = twin.stops[-1]
            stop.normal, stop.side = other.normal, other.side
            stop.clearance = other.clearance + float(rng.uniform(0.05, 0.4))
        if rng.random() < 0.1:
            stop.reaction = "coordinate"
        if rng.random() < 0.2:
            stop.amplitude, stop.phase = float(rng.uniform(0.02, 0.2)), float(rng.uniform(-3.0, 3.0))
        if rng.random() < (0.6 if rests else 0.3):
            bounces = [0.0, 1.0, rng.uniform(0.3, 1.0), rng.uniform(0.3, 1.0)]
            stop.restitution = 0.0 if rests else float(rng.choice(bounces))
        else:
            some_spring(rng, twin, stop)
        twin.stops.append(stop)
    return twin


def some_start(rng, twin):
    """Return a random start outside all rigid stops, seldom inside compliant ones; none where none is found."""
    rows = Rows(twin)
    may_be_inside = rng.random() < 0.25
    n = len(twin.mass)
    plain = [i for i, stop in enumerate(twin.stops) if not stop.amplitude and np.count_nonzero(stop.normal) == 1]
    plain = [i for i in plain if twin.stops[i].preload > 0.0] or plain
    at_rest = int(rng.choice(plain)) if plain and rng.random() < 0.2 else None
    if at_rest is not None and twin.stops[at_rest].preload > 0.0 and rng.random() < 0.8:
        # Beyond the middle the springs push against the stop.
        twin.stops[at_rest].clearance = -abs(twin.stops[at_rest].clearance)
        rows = Rows(twin)
    for attempt in range(40):
        spread = rng.choice([0.0, 0.3, 1.0]) if attempt else 0.0
        q, v = rng.normal(size=n) * spread, rng.normal(size=n) * rng.choice([0.0, 0.5, 1.0])
        if twin.force is None:
            v = v + rng.normal(size=n)
        if at_rest is not None:
            put_on(twin.stops[at_rest], q, v)
        x = rows.state(q, v, 0.0, 0.0)
        deep = [float(row @ x) for row in rows.p]
        if may_be_inside and not any(p > 0.0 for p in deep) and attempt < 20:
            continue
        bounds = [-0.01 if stop.is_rigid or not may_be_inside else 0.7 for stop in twin.stops]
        if all(p < bound or i == at_rest for i, (p, bound) in enumerate(zip(deep, bounds, strict=True))):
            if at_rest is not None and twin.stops[at_rest].preload > 0.0:
                bear(rng, twin, rows, at_rest, x)
            return q, v
    return None


def bear(rng, twin, rows, i, x):
    """Give a preloaded stop mostly a preload that bears the force on it at the start, so that it is seated."""
    free = rows.free_field(["free"] * len(twin.stops))
    force = float((rows.rate[i] @ free) @ x) / rows.share[i]
    if force > 0.01:
        twin.stops[i].preload = force * float(rng.uniform(0.7, 3.0))


def put_on(stop, q, v):
    """Put the coordinate of a stop at rest on it."""
    i = int(np.flatnonzero(stop.normal)[0])
    q[i], v[i] = stop.clearance / stop.toward[i], 0.0
