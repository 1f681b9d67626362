"""A referee of what branches meet at boundaries: orbits gone through by mechanics written down anew, runs on both sides."""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import expm

import vibroimpact as vi

#: A motion comes to the last orbit if a hundredth of the distance from the boundary brings it nearer by this factor, and is
#: elsewhere if it stays by that.
NEARER, STAYS = 0.3, 0.5
#: What the kick of rounding and slow decay leave of a distance.
NOTHING = 2e-5


@dataclass
class Stop:
    """A plane h = clearance + amplitude cos(w t + phase) - normal q >= 0, its restitution."""

    normal: np.ndarray
    clearance: float
    restitution: float
    amplitude: float = 0.0
    phase: float = 0.0


@dataclass
class Twin:
    """A linear system under a harmonic force F cos(w t) and its stops."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray
    frequency: float
    stops: list[Stop] = field(default_factory=list)

    def scene(self):
        """Return the scene that the library is given."""
        w = self.frequency
        stops = []
        for own in self.stops:
            motion = vi.Harmonic([own.amplitude], w, own.phase) if own.amplitude else None
            stops.append(vi.Stop(own.normal, own.clearance, own.restitution, motion=motion))
        system = vi.LinearSystem(self.mass, self.damping, self.stiffness)
        return vi.Scene(system, vi.Harmonic(self.force, w), stops)

    def with_value(self, name, value):
        """Return the same with another value of a number."""
        stops = [Stop(**vars(own)) for own in self.stops]
        other = Twin(self.mass, self.damping, self.stiffness, self.force, self.frequency, stops)
        if name == "frequency":
            other.frequency = value
        elif name == "forcing_scale":
            other.force = self.force * value
        else:
            what, stop = name[:-1].split("[")
            setattr(stops[int(stop)], what, value)
        return other

    def field(self, held):
        """Return the matrix of y' = A y, y = (q, v, cos w t, sin w t), with some stops held by forces along M^-1 n."""
        n, w = len(self.force), self.frequency
        inverse = np.linalg.inv(self.mass)
        matrix = np.zeros((2 * n + 2, 2 * n + 2))
        matrix[:n, n : 2 * n] = np.eye(n)
        matrix[n : 2 * n, :n] = -inverse @ self.stiffness
        matrix[n : 2 * n, n : 2 * n] = -inverse @ self.damping
        matrix[n : 2 * n, 2 * n] = inverse @ self.force
        matrix[2 * n, 2 * n + 1], matrix[2 * n + 1, 2 * n] = -w, w
        if held:
            normals = np.array([self.stops[k].normal for k in held])
            along = inverse @ normals.T
            # The gap's own acceleration is -w^2 times its motion.
            own = np.zeros((len(held), 2 * n + 2))
            for i, k in enumerate(held):
                a, phase = self.stops[k].amplitude, self.stops[k].phase
                own[i, 2 * n :] = -(w**2) * a * np.array([np.cos(phase), -np.sin(phase)])
            pressed = normals @ matrix[n : 2 * n] - own
            matrix[n : 2 * n] -= along @ np.linalg.solve(normals @ along, pressed)
        return matrix

    def moved(self, held, q, v, angle, span):
        """Return position and velocity some time after a state at an angle of the forcing."""
        n = len(q)
        y = expm(self.field(held) * span) @ np.concatenate([q, v, [np.cos(angle), np.sin(angle)]])
        return y[:n], y[n : 2 * n]

    def opening(self, stop, v, angle):
        """Return the speed at which a gap opens."""
        own = self.stops[stop]
        return -own.amplitude * self.frequency * np.sin(angle + own.phase) - own.normal @ v

    def gap(self, stop, q, angle):
        """Return a gap."""
        own = self.stops[stop]
        return own.clearance + own.amplitude * np.cos(angle + own.phase) - own.normal @ q

    def reaction(self, stop):
        """Return the direction in which an impulse pushes."""
        return np.linalg.solve(self.mass, self.stops[stop].normal)


def contacts(orbit):
    """Return the parts of an orbit: start, end, kind and the stops held, of those that take time or are chatter."""
    parts = {}
    for row in orbit.segments:
        key = (float(row["start"]), float(row["end"]), str(row["kind"]))
        parts.setdefault(key, []).append(int(row["stop"]))
    ordered = sorted(parts.items())
    return [(start, end, kind, sorted(stops) if kind == "stick" else []) for (start, end, kind), stops in ordered]


def misses(twin, orbit):
    """Return by how much an orbit misses its laws, in parts of its size, and where: flights, gaps, impacts, what is held."""
    w = twin.frequency
    parts = contacts(orbit)
    t = np.linspace(0.0, orbit.period, 200)
    size = np.abs(orbit.position(t)).max()
    speed = max(np.abs(orbit.velocity(t)).max(), size * w)
    found = []

    def note(miss, what):
        found.append((float(miss), what))

    def angle(time):
        return orbit.phase + w * time

    for k, (start, end, kind, held) in enumerate(parts):
        q, v = orbit.position(start), orbit.velocity(start)
        _, _, before_kind, before_held = parts[k - 1]
        here = [row for row in orbit.impacts if abs(row["time"] - start) <= 1e-13 * orbit.period]
        # What is left of a chatter is over in no time, and known to what is left of its speeds.
        if here and kind != "chatter" and before_kind != "chatter":
            q_before, v_before = orbit.position(start), orbit.velocity(start if start > 0.0 else orbit.period, side="before")
            after = np.array(v_before)
            for row in here:
                after = after - twin.reaction(int(row["stop"])) * row["impulse"]
                note(-row["impulse"] / abs(row["impulse"]) if row["impulse"] < 0.0 else 0.0, "an impulse pulls")
            note(np.abs(after - v).max() / speed, f"v+ = v- + B p at t = {start:.6f}")
            hit = [int(row["stop"]) for row in here]
            for stop in sorted({*hit, *before_held}):
                reach = np.linalg.norm(twin.stops[stop].normal)
                opens = twin.opening(stop, after, angle(start)) / (reach * speed)
                note(max(-opens, 0.0), f"stop {stop} is passed behind t = {start:.6f}")
                if stop in held:
                    note(abs(opens), f"stop {stop} is held and left at t = {start:.6f}")
                if stop in hit and stop not in before_held:
                    back = -twin.stops[stop].restitution * twin.opening(stop, v_before, angle(start)) / (reach * speed)
                    # Others that are hit with it may make it leave faster.
                    miss = abs(opens - back) if len(hit) == 1 else max(back - opens, 0.0)
                    note(miss, f"the restitution of stop {stop} at t = {start:.6f}")
                    note(abs(twin.gap(stop, q_before, angle(start))) / (reach * size), f"the gap of stop {stop} at its impact")
        if end > start and kind != "chatter":
            q_end, v_end = twin.moved(held, q, v, angle(start), end - start)
            note(np.abs(q_end - orbit.position(end)).max() / size, f"the flight to t = {end:.6f}")
            note(np.abs(v_end - orbit.velocity(end, side="before")).max() / speed, f"the speed at t = {end:.6f}")
    first, last = orbit.position(0.0), orbit.position(orbit.period)
    note(np.abs(first - last).max() / size, "closing")
    return max(found)


def are_one(one, other):
    """Whether two orbits are the same motion, from whichever impact they are counted."""
    a, b = one.impacts, other.impacts
    if len(a) != len(b) or one.n_periods != other.n_periods:
        return False
    t = np.linspace(0.0, 1.0, 97)
    size = np.abs(one.position(t * one.period)).max()
    for k in range(one.n_periods):
        late = (one.phase - other.phase) / (2.0 * np.pi) + k
        there = other.position((t + late / one.n_periods) % 1.0 * other.period)
        if np.abs(one.position(t * one.period) - there).max() < 1e-7 * size:
            return True
    return False


def distance(twin, last, value, name, periods):
    """Return how far a run from the last orbit comes to be from it at a value, in parts of its size; none without a run."""
    w = 2.0 * np.pi * last.n_periods / last.period
    flights = [part for part in contacts(last) if part[2] == "flight"]
    if not flights:
        return None
    start, end = max(((a, b) for a, b, *_ in flights), key=lambda span: span[1] - span[0])
    begin = start + 0.37 * (end - start)
    there = twin.with_value(name, value)
    phase = (last.phase + w * begin) % (2.0 * np.pi)
    scene = there.scene().replace(phase=phase)
    try:
        run = vi.simulate(scene, last.position(begin), last.velocity(begin), (0.0, periods * scene.period), keep="final")
        run = vi.simulate(scene, *run.final, (0.0, 24 * scene.period))
    except ValueError:
        return None
    if run.status != "finished":
        return None
    k = np.arange(24 * 40)
    then = (begin + (periods + k / 40) * last.period / last.n_periods) % last.period
    off = np.abs(run.position(k / 40 * scene.period) - last.position(then)).max()
    return float(off / np.abs(last.max_displacement).max())


def stands(candidate):
    """Whether a run that begins on an orbit stays on it."""
    orbit = candidate.orbit
    begin = 0.5 * (orbit.segments["end"].max() + orbit.segments["start"].max())
    phase = (orbit.phase + 2.0 * np.pi * orbit.n_periods * begin / orbit.period) % (2.0 * np.pi)
    run = vi.simulate(
        orbit.scene.replace(phase=phase), orbit.position(begin), orbit.velocity(begin), (0.0, 300 * orbit.period), keep="final"
    )
    return bool(np.abs(run.final[0] - orbit.position(begin)).max() < 1e-8 * np.abs(orbit.max_displacement).max())


def seen(twin, special, side, delta, periods=900):
    """Return "goes on", "elsewhere" or "unclear" of runs beyond a boundary on one side, and their distances."""
    apart = []
    for off in (delta, 0.1 * delta, 0.01 * delta):
        if off < 30.0 * special.error:
            break
        own = distance(twin, special.orbit, special.parameter + side * off, special.parameter_name, periods)
        if own is None:
            return "unclear", apart
        apart.append(own)
    if len(apart) < 3:
        return "unclear", apart
    if apart[2] <= max(NEARER * apart[0], NOTHING):
        return "goes on", apart
    if min(apart) >= max(STAYS * max(apart), 10.0 * NOTHING):
        return "elsewhere", apart
    return "unclear", apart


def some_twin(rng):
    """Return a random system before one to three stops, a number of it and the range of that."""
    n = int(rng.integers(1, 3))

    def definite(low, high):
        turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
        return turn @ np.diag(rng.uniform(low, high, n)) @ turn.T

    mass, stiffness = definite(0.5, 1.5), definite(0.8, 8.0)
    damping = rng.uniform(0.02, 0.12) * mass + rng.uniform(0.0, 0.02) * stiffness
    w = float(rng.uniform(0.4, 3.0))
    twin = Twin(mass, damping, stiffness, rng.normal(size=n) + np.sign(rng.normal()) * 0.7, w)
    for _ in range(int(rng.integers(1, 4))):
        normal = rng.normal(size=n)
        if rng.random() < 0.5:
            normal = np.eye(n)[int(rng.integers(n))] * rng.choice([-1.0, 1.0])
        restitution = float(rng.choice([0.0, 0.0, rng.uniform(0.1, 0.9)]))
        own = Stop(normal, float(rng.uniform(0.02, 0.4)), restitution)
        if rng.random() < 0.4:
            own.amplitude, own.phase = float(rng.uniform(0.02, 0.2)), float(rng.uniform(-3.0, 3.0))
        twin.stops.append(own)
    stop = int(rng.integers(len(twin.stops)))
    ranges = {
        "frequency": (0.7 * w, 1.4 * w),
        f"clearance[{stop}]": (0.5 * twin.stops[stop].clearance, 1.6 * twin.stops[stop].clearance),
    }
    if not any(own.amplitude for own in twin.stops):
        ranges["forcing_scale"] = (0.6, 1.6)
    name = str(rng.choice(list(ranges)))
    return twin, name, ranges[name]
