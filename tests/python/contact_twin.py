"""Exact runs with compliant and rigid stops: the laws written down anew, flown exactly regime by regime.

A scene is linear, M q'' + C q' + K q = Re(F e^{i w t}), before plane stops. The approach into a stop is
p = n.q - c - c(t), positive inside. A compliant stop has the force f = k p + c_d p' + F0 while it is pressed:

    law "gap"       pressed while p > 0; the dashpot may pull
    law "clipped"   max(0, f) where p > 0; idle where f would pull
    law "force"     ends where f = 0; its point r comes back by c_d r' + k r + F0 = 0 and is met again where p = r

A rigid stop turns the approach speed, p'+ = -e p'-; one with e = 0 may be held by a force L >= 0 until that falls
through zero. A compliant stop with a preload F0 may be seated, p = p' = 0, by a force L between 0 and F0. In each
regime the motion is X' = A X, X = (q, v, r; 1, cos w t, sin w t). It is sampled in cells short beside the fastest rate
of A; in each cell every guard is its Taylor polynomial, exact to rounding, whose first zero is found.
"""

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

#: Cells of a flight are this long, in units of one over the fastest rate of their regime; their Taylor polynomials have
#: this degree, whose remainder is 0.4^17/17! of the largest term.
CELL, DEGREE = 0.4, 16
#: Cells that are sampled at once.
CELLS = 64
#: Places in a cell at which guards are looked at, and powers of them and of the slope.
PLACES = np.linspace(0.0, 1.0, 5)
VALUES = PLACES[None, :] ** np.arange(DEGREE + 1)[:, None]
SLOPES = np.vstack([np.zeros((1, 5)), VALUES[:-1] * np.arange(1, DEGREE + 1)[:, None]])
#: Integrals over the unit cell of s^i s^j.
HILBERT = 1.0 / (np.arange(DEGREE + 1)[:, None] + np.arange(DEGREE + 1)[None, :] + 1.0)

#: Two transitions closer than this are not told apart, nor are touches of guards closer than that to zero.
COINCIDENT, TOUCH = 1e-9, 1e-11
#: A start within this of a stop is on it.
ON = 1e-14
#: Guards that fall slower than this are grazed; rigid stops hit slower than that chatter, preloaded ones are seated.
SLOW, SLOW_IMPACT, SLOW_BOUNCE = 1e-6, 3e-5, 1e-3
#: A rigid stop that was hit so often in ever shorter flights, the last shorter than this, chatters.
CHATTER, SHORT = 8, 1e-3
#: A run with more transitions than this is not looked at.
MOST = 600
#: A relaxing point is at its seat after so many times c_d/k.
RELAXED = 42.0

#: The transitions of each law and state: the guard that falls through zero, and the state behind it. Those of PRELOADED
#: guards are there with a preload only.
TABLE = {
    ("gap", "free"): {"enter": "pressed"},
    ("gap", "pressed"): {"leave": "free"},
    ("clipped", "free"): {"enter": "pressed"},
    ("clipped", "pressed"): {"force ends": "idle", "leave": "free"},
    ("clipped", "idle"): {"leave": "free", "force returns": "pressed"},
    ("force", "free"): {"enter": "pressed"},
    ("force", "pressed"): {"force ends": "relaxing", "leave": "free"},
    ("force", "relaxing"): {"meet": "pressed", "seat": "free"},
    ("rigid", "free"): {"enter": "hit"},
    ("rigid", "held"): {"release": "free"},
    **{(law, "seated"): {"release": "free", "yield": "pressed"} for law in ("gap", "clipped", "force")},
}
PRELOADED = {("clipped", "pressed", "leave"), ("force", "pressed", "leave"), ("force", "relaxing", "seat")}
#: Orders of the zeros that guards of a stop have right behind its transition; all others are positive there.
ORDERS = {
    ("enter", "pressed"): {"leave": 1},
    ("leave", "free"): {"enter": 1},
    ("force ends", "relaxing"): {"meet": 2},
    ("force ends", "idle"): {"force returns": 1},
    ("force returns", "pressed"): {"force ends": 1},
    ("release", "free"): {"enter": 3},
    ("yield", "pressed"): {"leave": 3},
    ("judged", "free"): {"enter": 2},
    ("judged", "pressed"): {"leave": 2},
    ("waited", "free"): {"enter": 2},
    ("waited", "pressed"): {"leave": 2, "force ends": 1},
}


class Skipped(Exception):
    """A run that comes too close to a border between two motions, or needs what is not modelled here."""


@dataclass
class Stop:
    """A plane at a clearance, which may move by amplitude cos(w t + phase): restitution, or spring and dashpot."""

    normal: np.ndarray
    clearance: float
    restitution: float | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    release: str = "gap"
    preload: float = 0.0
    side: str = "upper"
    amplitude: float = 0.0
    phase: float = 0.0
    reaction: str = "inertia"

    @property
    def is_rigid(self):
        """Whether it has a restitution."""
        return self.restitution is not None

    @property
    def law(self):
        """Return the law of its table; without a dashpot all of compliant stops are one."""
        if self.is_rigid:
            return "rigid"
        return self.release if self.damping > 0.0 else "gap"

    @property
    def toward(self):
        """Return the normal that points into the stop."""
        return np.asarray(self.normal, float) * (1.0 if self.side == "upper" else -1.0)

    def stored(self, p):
        """Return the energy in the spring at an approach."""
        return 0.5 * self.stiffness * p**2 + self.preload * p


@dataclass
class Twin:
    """A linear system under the force Re(F e^{i w t}), or none, and its stops; w is that of moving stops too."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray | None
    frequency: float
    stops: list[Stop] = field(default_factory=list)

    @property
    def phase(self):
        """Return the phase at the start: of the force or else of the first stop that moves; nan without both."""
        if self.force is not None:
            return 0.0
        return next((stop.phase for stop in self.stops if stop.amplitude), math.nan)

    def scene(self):
        """Return the scene that the library is given."""
        import vibroimpact as vi

        stops = []
        for own in self.stops:
            motion = vi.Harmonic([own.amplitude], self.frequency, own.phase) if own.amplitude else None
            beside = {"side": own.side, "reaction": own.reaction, "motion": motion}
            if own.is_rigid:
                stops.append(vi.Stop(own.normal, own.clearance, own.restitution, **beside))
                continue
            spring = vi.Spring(own.stiffness, own.damping, release=own.release, preload=own.preload)
            stops.append(vi.Stop(own.normal, own.clearance, contact=spring, **beside))
        forcing = None if self.force is None else vi.Harmonic(self.force, self.frequency)
        return vi.Scene(vi.LinearSystem(self.mass, self.damping, self.stiffness), forcing, stops)


@dataclass
class Contact:
    """What is known of one contact, as the library's table has it.

    `is_lasting` of a stop that was held or seated. `other_loss` is what the motion gives by M b in place of n: the same
    but for reactions that are not M^-1 n. `unsure` names what may be meant otherwise and is not compared.
    """

    stop: int
    start: float
    end: float = math.nan
    speed_before: float = math.nan
    speed_after: float = math.nan
    impulse: float = 0.0
    peak_force: float = -math.inf
    peak_approach: float = -math.inf
    loss: float = 0.0
    other_loss: float = 0.0
    dashpot: float = 0.0
    is_lasting: bool = False
    unsure: set = field(default_factory=set)


@dataclass
class Run:
    """The contacts in the order of their starts, the transitions (time, stop, state entered) and the final state."""

    contacts: list[Contact]
    events: list[tuple]
    states: list[tuple]
    q: np.ndarray
    v: np.ndarray


class Rows:
    """Rows on X = (q, v, r of each stop of law "force"; 1, cos, sin) of the quantities of each stop."""

    def __init__(self, twin):
        """Write down approaches, their rates, forces and reactions."""
        self.twin = twin
        n = len(twin.mass)
        relaxing = [i for i, stop in enumerate(twin.stops) if stop.law == "force"]
        self.place = {i: 2 * n + j for j, i in enumerate(relaxing)}
        self.n, self.one = n, 2 * n + len(relaxing)
        self.size = self.one + 3
        self.inverse = np.linalg.inv(twin.mass)
        self.p, self.rate, self.force, self.motion, self.taking = [], [], [], [], []
        self.reaction, self.share = [], []
        for i, stop in enumerate(twin.stops):
            self.add(i, stop)

    def add(self, i, stop):
        """Add the rows of one stop."""
        n, one, w = self.n, self.one, self.twin.frequency
        p, rate, motion, unit = np.zeros((4, self.size))
        cos, sin = stop.amplitude * np.cos(stop.phase), stop.amplitude * np.sin(stop.phase)
        # The motion of the clearance is cos(phase) cos(w t) - sin(phase) sin(w t) times its amplitude.
        p[:n], p[one], p[one + 1], p[one + 2] = stop.toward, -stop.clearance, -cos, sin
        rate[n : 2 * n], rate[one + 1], rate[one + 2] = stop.toward, w * sin, w * cos
        motion[one + 1], motion[one + 2] = -(w**2) * cos, w**2 * sin
        unit[one] = 1.0
        self.p.append(p)
        self.rate.append(rate)
        self.motion.append(motion)
        self.force.append(stop.stiffness * p + stop.damping * rate + stop.preload * unit)
        b = self.inverse @ stop.toward if stop.reaction == "inertia" else stop.toward
        self.reaction.append(b)
        self.share.append(float(stop.toward @ b))
        # Times the force: the power that it takes, less that of the stop's own motion.
        self.taking.append(rate.copy())
        self.taking[-1][n : 2 * n] = self.twin.mass @ b

    def state(self, q, v, t, r):
        """Return X at a time."""
        x = np.zeros(self.size)
        x[: self.n], x[self.n : 2 * self.n], x[2 * self.n : self.one] = q, v, r
        x[self.one :] = 1.0, np.cos(self.twin.frequency * t), np.sin(self.twin.frequency * t)
        return x

    def point(self, i):
        """Return the row of the point of a stop of law "force"."""
        row = np.zeros(self.size)
        row[self.place[i]] = 1.0
        return row

    def free_field(self, states):
        """Return A of X' = A X with all pressed stops in these states and no stop held."""
        n, one, w, twin = self.n, self.one, self.twin.frequency, self.twin
        matrix = np.zeros((self.size, self.size))
        matrix[:n, n : 2 * n] = np.eye(n)
        matrix[n : 2 * n, :n] = -self.inverse @ twin.stiffness
        matrix[n : 2 * n, n : 2 * n] = -self.inverse @ twin.damping
        if twin.force is not None:
            push = self.inverse @ np.asarray(twin.force, complex)
            matrix[n : 2 * n, one + 1], matrix[n : 2 * n, one + 2] = push.real, -push.imag
        matrix[one + 1, one + 2], matrix[one + 2, one + 1] = -w, w
        for i, state in enumerate(states):
            stop = twin.stops[i]
            if state == "pressed":
                matrix[n : 2 * n] -= np.outer(self.reaction[i], self.force[i])
            if state == "relaxing":
                matrix[self.place[i], self.place[i]] = -stop.stiffness / stop.damping
                matrix[self.place[i], one] = -stop.preload / stop.damping
        return matrix

    def holding(self, states, held):
        """Return the rows of the forces that hold some stops, in a regime where the others are as they are."""
        free = self.free_field(states)[self.n : 2 * self.n]
        normals = np.array([self.twin.stops[i].toward for i in held])
        along = np.array([self.reaction[i] for i in held]).T
        wanted = normals @ free - np.array([self.motion[i] for i in held])
        return np.linalg.solve(normals @ along, wanted), along

    def guard(self, i, name, holding):
        """Return the row of a guard, positive inside the state."""
        if name == "enter":
            return -self.p[i]
        if name == "leave":
            return self.p[i]
        if name == "force ends":
            return self.force[i]
        if name == "force returns":
            return -self.force[i]
        if name == "meet":
            return self.point(i) - self.p[i]
        if name == "seat":
            return self.point(i)
        if name == "yield":
            row = -holding[i]
            row[self.one] += self.twin.stops[i].preload
            return row
        return holding[i]


def guards_of(stop, state):
    """Return the names of the guards of a stop in a state."""
    names = TABLE[stop.law, state]
    return [name for name in names if stop.preload > 0.0 or (stop.law, state, name) not in PRELOADED]


class Regime:
    """The states of all stops, the field of the motion in them, and Taylor polynomials of all that is looked at."""

    def __init__(self, rows, states):
        """Make the propagators and polynomials of one regime."""
        self.states = states
        twin = rows.twin
        matrix = self.matrix = rows.free_field(states)
        held = [i for i, state in enumerate(states) if state in ("held", "seated")]
        holding = {}
        if held:
            forces, along = rows.holding(states, held)
            matrix[rows.n : 2 * rows.n] -= along @ forces
            holding = dict(zip(held, forces, strict=True))
        rate = np.abs(np.linalg.eigvals(matrix)).max()
        self.step = CELL / rate
        self.guards = [(i, name) for i, state in enumerate(states) for name in guards_of(twin.stops[i], state)]
        guards = [rows.guard(i, name, holding) for i, name in self.guards]
        self.pressed = [i for i, state in enumerate(states) if state == "pressed"]
        self.held = held
        looked_at = [own for i in self.pressed for own in (rows.p[i], rows.force[i], rows.taking[i])]
        looked_at += [own for i in held for own in (holding[i], rows.taking[i])]
        #: A guard as large as this is no longer small: forces by what makes them from lengths of one.
        stiff = {"force ends", "force returns"}
        sizes = [stop.stiffness + stop.damping * rate for stop in twin.stops]
        self.scale = np.array([sizes[i] if name in stiff else 1.0 for i, name in self.guards])
        self.taylor = taylor_terms(matrix, self.step)
        self.powers = powers(self.taylor.sum(axis=0), CELLS + 1)
        polynomials = np.einsum("gi,jik->gjk", np.array(guards + looked_at), self.taylor)
        flat = polynomials.reshape(-1, rows.size) @ self.powers[:CELLS]
        self.polynomials = flat.reshape(-1, rows.size)
        self.shape = (CELLS, len(guards) + len(looked_at), DEGREE + 1)

    def series(self, x):
        """Return the coefficients of guards and of what is looked at, in the cells from a state on."""
        return (self.polynomials @ x).reshape(self.shape)

    def state_in_cell(self, x, cell, place):
        """Return the state at a place of a cell."""
        return np.tensordot(place ** np.arange(DEGREE + 1), self.taylor, 1) @ (self.powers[cell] @ x)


def taylor_terms(matrix, step):
    """Return (A h)^j/j! for the orders of a cell."""
    terms = [np.eye(len(matrix))]
    for j in range(1, DEGREE + 1):
        terms.append(terms[-1] @ matrix * (step / j))
    return np.array(terms)


def powers(matrix, count):
    """Return the powers 0 to count - 1 of a matrix."""
    found = np.eye(len(matrix))[None]
    while len(found) < count:
        found = np.concatenate([found, found @ (found[-1] @ matrix)])
    return found[:count]


def horner(coefficients, s):
    """Return a polynomial and its slope."""
    value = slope = 0.0
    for c in reversed(coefficients):
        slope = slope * s + value
        value = value * s + c
    return value, slope


def bracketed_root(coefficients, low, high):
    """Return the zero of a polynomial that falls through zero between two places, by Newton's steps in a bracket."""
    s = 0.5 * (low + high)
    for _ in range(80):
        value, slope = horner(coefficients, s)
        if value > 0.0:
            low = s
        else:
            high = s
        new = s - value / slope if slope < 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - s) <= 2e-16 or high - low <= 2e-16:
            return new
        s = new
    return s


def derivative(coefficients):
    """Return the coefficients of the slope."""
    return [j * c for j, c in enumerate(coefficients)][1:]


def least(coefficients, low, high):
    """Return the place of the minimum of a polynomial whose slope rises through zero between two places."""
    return bracketed_root([-c for c in derivative(coefficients)], low, high)


def suspects(values, slopes, scale):
    """Return where guards (cells, guards, places) are negative, or may have a minimum below zero between two places."""
    ahead = PLACES[1] - PLACES[0]
    left, right, fall, rise = values[..., :-1], values[..., 1:], slopes[..., :-1], slopes[..., 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        meeting = (right - left - rise * ahead) / (fall - rise)
        deepest = left + fall * meeting
    dips = (fall < 0.0) & (rise > 0.0) & (deepest < TOUCH * scale[None, :, None])
    return (right <= 0.0) | dips


def first_zero(coefficients, values, slopes, scale, doubtful):
    """Return the place of the first zero of one guard in one cell; none where it has none."""
    for k in np.flatnonzero(doubtful):
        low, high = PLACES[k], PLACES[k + 1]
        if values[k + 1] <= 0.0:
            return bracketed_root(coefficients, low, high)
        s = least(coefficients, low, high)
        depth = horner(coefficients, s)[0]
        if depth < -TOUCH * scale:
            return bracketed_root(coefficients, low, s)
        if depth < TOUCH * scale:
            raise Skipped("a guard is touched")
    return None


def first_event(series, n_guards, scale):
    """Return (cell, place, guard) of the first zero of any guard in these cells; none where there is none."""
    own = series[:, :n_guards]
    values, slopes = own @ VALUES, own @ SLOPES
    doubtful = suspects(values, slopes, scale)
    for cell in np.flatnonzero(doubtful.any(axis=(1, 2))):
        found = []
        for g in np.flatnonzero(doubtful[cell].any(axis=1)):
            at = (own[cell, g].tolist(), values[cell, g], slopes[cell, g], scale[g], doubtful[cell, g])
            place = first_zero(*at)
            if place is not None:
                found.append((place, int(g)))
        if found:
            return int(cell), *min(found)
    return None


def deflated(series, orders):
    """Return the series with the known zeros of guards at the start divided out of the first cell."""
    if not orders:
        return series
    series = series.copy()
    for guard, order in orders.items():
        series[0, guard, : DEGREE + 1 - order] = series[0, guard, order:]
        series[0, guard, DEGREE + 1 - order :] = 0.0
    return series


def check_start(series, n_guards):
    """Refuse a start at which a guard is not positive right behind it."""
    if n_guards and not (series[0, :n_guards, 0] > 0.0).all():
        raise Skipped("two transitions at one instant")


def check_event(polynomials, place, guard, step, scale):
    """Refuse a guard that falls too slowly, and others that fall at the same instant."""
    powers_of_place = place ** np.arange(DEGREE + 1)
    values = polynomials @ powers_of_place
    slopes = polynomials[:, 1:] @ (powers_of_place[:-1] * np.arange(1, DEGREE + 1)) / step
    if -slopes[guard] < SLOW * scale[guard]:
        raise Skipped("a guard is grazed")
    near = (np.abs(values) < COINCIDENT * np.abs(slopes)) & (np.arange(len(values)) != guard)
    if near.any():
        raise Skipped("two transitions at one instant")


def integral(coefficients, steps):
    """Return the integral of polynomials (cells, orders) over unit cells of these lengths."""
    return float(steps @ (coefficients @ (1.0 / np.arange(1, DEGREE + 2))))


def integral_of_product(one, other, steps):
    """Return the integral of the product of two such polynomials."""
    return float(steps @ ((one @ HILBERT) * other).sum(axis=1))


def slopes_of(coefficients, steps):
    """Return the derivatives by time of such polynomials."""
    made = np.zeros_like(coefficients)
    made[:, :-1] = coefficients[:, 1:] * np.arange(1, DEGREE + 1) / steps[:, None]
    return made


def largest(coefficients):
    """Return the largest value of polynomials (cells, orders) in unit cells, ends included."""
    found = float((coefficients @ VALUES).max())
    slopes = coefficients @ SLOPES
    for cell, k in zip(*np.nonzero((slopes[:, :-1] > 0.0) & (slopes[:, 1:] < 0.0)), strict=True):
        own = coefficients[cell].tolist()
        found = max(found, horner(own, bracketed_root(derivative(own), PLACES[k], PLACES[k + 1]))[0])
    return found


class Motion:
    """One run: the state, the states of the stops, and what was written down."""

    def __init__(self, twin, q0, v0, rows=None, regimes=None):
        """Begin at time zero."""
        self.twin = twin
        self.rows = rows or Rows(twin)
        self.regimes = {} if regimes is None else regimes
        self.time = 0.0
        self.x = self.rows.state(np.asarray(q0, float), np.asarray(v0, float), 0.0, 0.0)
        self.open, self.contacts, self.events = {}, [], []
        self.hits = {}
        self.orders = {}
        self.states = ("free",) * len(twin.stops)
        self.start()
        self.history = [(0.0, self.states)]

    def regime(self):
        """Return the present regime, made when first met."""
        if self.states not in self.regimes:
            self.regimes[self.states] = Regime(self.rows, self.states)
        return self.regimes[self.states]

    def approach(self, i):
        """Return the approach of a stop."""
        return float(self.rows.p[i] @ self.x)

    def speed(self, i):
        """Return the approach speed of a stop."""
        return float(self.rows.rate[i] @ self.x)

    def start(self):
        """Find the states at the start: by p, then by p', then by forces and accelerations."""
        resting, waiting = [], []
        for i, stop in enumerate(self.twin.stops):
            p, speed = self.approach(i), self.speed(i)
            if ON < abs(p) < COINCIDENT or (abs(p) <= ON < abs(speed)):
                raise Skipped("a start too near to a stop")
            if p > ON and stop.is_rigid:
                raise Skipped("a start inside a rigid stop")
            if p > ON:
                self.start_inside(i, stop, p)
            elif abs(p) <= ON:
                (resting if stop.is_rigid or stop.preload > 0.0 else waiting).append(i)
        if resting:
            self.judge_holds(resting)
        field = self.regime().matrix if waiting else None
        for i in waiting:
            acceleration = float((self.rows.rate[i] @ field) @ self.x)
            if abs(acceleration) < COINCIDENT:
                raise Skipped("a start at rest on a stop")
            self.enter(i, "pressed" if acceleration > 0.0 else "free", "waited")
        self.events = []
        for contact in self.contacts:
            contact.speed_before = math.nan
            if self.approach(contact.stop) <= ON:
                contact.unsure.add("speed_before")

    def start_inside(self, i, stop, p):
        """Put a compliant stop that is met inside in its state."""
        force = float(self.rows.force[i] @ self.x)
        if stop.law == "gap" or force > 0.0:
            self.enter(i, "pressed", "start")
            self.open[i].loss = 0.0
            self.open[i].other_loss = stop.stored(p)
        elif stop.law == "clipped":
            self.enter(i, "idle", "start")
        else:
            self.enter(i, "relaxing", "start")
            self.orders[i] = {"meet": 1}

    def enter(self, i, state, name):
        """Put a stop in a state by the transition of a guard."""
        before = self.states[i]
        self.states = (*self.states[:i], state, *self.states[i + 1 :])
        self.events.append((self.time, i, state))
        self.orders[i] = ORDERS.get((name, state), {})
        touching = ("pressed", "held", "seated")
        if before in touching and state not in touching:
            self.close(i)
        if state in touching and i not in self.open:
            self.begin(i)
        if state in ("held", "seated"):
            self.open[i].is_lasting = True
        if i in self.rows.place:
            self.x[self.rows.place[i]] = self.approach(i) if state == "relaxing" else 0.0

    def begin(self, i):
        """Open the row of a contact."""
        contact = Contact(i, self.time, speed_before=self.speed(i))
        # What the stop was left with at the end of its last contact was booked there as lost.
        contact.loss = -self.stored(i)
        self.open[i] = contact
        self.contacts.append(contact)

    def stored(self, i):
        """Return the energy in the spring of a stop."""
        stop = self.twin.stops[i]
        return 0.0 if stop.is_rigid else stop.stored(max(self.approach(i), 0.0))

    def close(self, i):
        """Close the row of a contact."""
        contact = self.open.pop(i)
        contact.end, contact.speed_after = self.time, -self.speed(i)
        contact.loss += self.stored(i)

    def watch(self, regime, series, steps):
        """Add what a flight brings to the contacts that are open."""
        coefficients = series[:, len(regime.guards) :]
        for j, i in enumerate(regime.pressed):
            p, force, taking = coefficients[:, 3 * j], coefficients[:, 3 * j + 1], coefficients[:, 3 * j + 2]
            own = self.open[i]
            own.impulse += integral(force, steps)
            own.peak_force = max(own.peak_force, largest(force))
            own.peak_approach = max(own.peak_approach, largest(p))
            rate = slopes_of(p, steps)
            work = self.twin.stops[i].damping * integral_of_product(rate, rate, steps)
            own.dashpot += work
            own.loss += work
            own.other_loss += integral_of_product(force, taking, steps)
        first = 3 * len(regime.pressed)
        for j, i in enumerate(regime.held):
            force, taking = coefficients[:, first + 2 * j], coefficients[:, first + 2 * j + 1]
            self.open[i].impulse += integral(force, steps)
            self.open[i].other_loss += integral_of_product(force, taking, steps)

    def relaxed_after(self):
        """Return the time after which a point without preload is at its seat, and the stop."""
        spans = []
        for i, state in enumerate(self.states):
            stop = self.twin.stops[i]
            if state == "relaxing" and stop.preload == 0.0:
                r = max(self.x[self.rows.place[i]], 1e-300)
                spans.append((max(RELAXED + math.log(r), 0.0) * stop.damping / stop.stiffness, i))
        return min(spans, default=(math.inf, None))

    def fly(self, end):
        """Fly to the next transition and return (stop, guard); guard "relaxed" or "end" where there was none."""
        regime = self.regime()
        span, relaxed = self.relaxed_after()
        left, last = (span, (relaxed, "relaxed")) if span < end - self.time else (end - self.time, (None, "end"))
        n_guards, step = len(regime.guards), regime.step
        orders = {
            g: self.orders[i][name] for g, (i, name) in enumerate(regime.guards) if self.orders.get(i) and name in self.orders[i]
        }
        self.orders = {}
        start = self.time
        while True:
            series = regime.series(self.x)
            searched = deflated(series, orders)
            if self.time == start:
                check_start(searched, n_guards)
            event = first_event(searched, n_guards, regime.scale) if n_guards else None
            if event and (event[0] + event[1]) * step < left:
                cell, place, guard = event
                check_event(series[cell, :n_guards], place, guard, step, regime.scale)
                what = regime.guards[guard]
                break
            if left <= CELLS * step:
                cell = min(int(left / step), CELLS - 1)
                place, what = left / step - cell, last
                break
            self.watch(regime, series, np.full(CELLS, step))
            self.x = regime.powers[CELLS] @ self.x
            self.time += CELLS * step
            left -= CELLS * step
            orders = {}
        used = series[: cell + 1].copy()
        used[cell] *= place ** np.arange(DEGREE + 1)
        steps = np.full(cell + 1, step)
        steps[cell] *= max(place, 1e-300)
        self.watch(regime, used, steps)
        self.arrive(regime.state_in_cell(self.x, cell, place), self.time + (cell + place) * step)
        if what[1] not in ("end", "relaxed") and self.time - start < COINCIDENT:
            raise Skipped("two transitions at one instant")
        return what

    def arrive(self, x, t):
        """Take over a state, its phase anew from the time."""
        self.time = t
        n = self.rows.n
        self.x = self.rows.state(x[:n], x[n : 2 * n], t, x[2 * n : self.rows.one])

    def make(self, i, name):
        """Make the transition of a guard."""
        stop = self.twin.stops[i]
        if stop.preload > 0.0 and name in ("enter", "leave") and abs(self.speed(i)) < SLOW_BOUNCE:
            raise Skipped("a low bounce on a preloaded stop")
        state = "free" if name == "relaxed" else TABLE[stop.law, self.states[i]][name]
        if state == "hit":
            self.hit(i)
            return
        self.enter(i, state, name)
        if name in ("enter", "leave", "meet"):
            self.judge_holds()

    def hit(self, i):
        """Resolve an impact on a rigid stop, together with those that are held."""
        stops, rows = self.twin.stops, self.rows
        speed = self.speed(i)
        if speed < SLOW_IMPACT:
            raise Skipped("a slow impact")
        self.note_chatter(i)
        part = [i] + [j for j, state in enumerate(self.states) if state == "held"]
        normals = np.array([stops[j].toward for j in part])
        along = np.array([rows.reaction[j] for j in part]).T
        speeds = np.zeros(len(part))
        speeds[0] = speed * (1.0 + stops[i].restitution)
        impulses = boxed(normals @ along, speeds, np.full(len(part), math.inf))
        before = self.x[rows.n : 2 * rows.n].copy()
        after = before - along @ impulses
        self.x[rows.n : 2 * rows.n] = after
        self.events.append((self.time, i, "hit"))
        mean = self.x.copy()
        mean[rows.n : 2 * rows.n] = 0.5 * (before + after)
        taken = float(impulses[0] * (rows.taking[i] @ mean))
        contact = Contact(i, self.time, self.time, speed, -self.speed(i), impulses[0], math.inf, 0.0, taken, taken)
        self.contacts.append(contact)
        self.orders[i] = {"enter": 1}
        for j, impulse in zip(part[1:], impulses[1:], strict=True):
            self.open[j].impulse += impulse
            self.open[j].other_loss += float(impulse * (rows.taking[j] @ mean))
            if -self.speed(j) > 1e-12 * speed:
                self.enter(j, "free", "leave")
        self.judge_springs(speed)
        stays = stops[i].restitution == 0.0 and -self.speed(i) <= 1e-12 * speed
        self.judge_holds([i] if stays else [], contact)

    def note_chatter(self, i):
        """Refuse impacts of one stop that follow each other ever faster."""
        hits = self.hits.setdefault(i, [])
        hits.append(self.time)
        flights = np.diff(hits[-CHATTER:])
        if len(flights) >= CHATTER - 1 and flights[-1] < SHORT and (np.diff(flights) < 0.0).all():
            raise Skipped("chatter")

    def judge_springs(self, speed):
        """Judge compliant stops by their forces and speeds again, behind an impact."""
        for i, state in enumerate(self.states):
            stop = self.twin.stops[i]
            if state == "seated" and abs(self.speed(i)) > 1e-12 * speed:
                self.enter(i, "pressed" if self.speed(i) > 0.0 else "free", "impact")
                self.orders[i] = {"leave": 1} if self.speed(i) > 0.0 else {"enter": 1}
            if stop.law not in ("force", "clipped") or state not in ("pressed", "idle"):
                continue
            force = float(self.rows.force[i] @ self.x)
            if abs(force) < COINCIDENT * (stop.stiffness + stop.damping):
                raise Skipped("two transitions at one instant")
            if state == "pressed" and force < 0.0:
                self.open[i].unsure.add("speed_after")
                self.enter(i, "relaxing" if stop.law == "force" else "idle", "impact")
                self.orders[i] = {"meet": 1} if stop.law == "force" else {}
            elif state == "idle" and force > 0.0:
                self.enter(i, "pressed", "impact")
                self.open[i].unsure.add("speed_before")

    def judge_holds(self, more=(), contact=None):
        """Find which stops at rest are held or seated where accelerations jumped; `more` have just come to rest."""
        part = [i for i, state in enumerate(self.states) if state in ("held", "seated")] + list(more)
        if not part:
            return
        stops, rows = self.twin.stops, self.rows
        accelerations = rows.free_field(self.states)[rows.n : 2 * rows.n] @ self.x
        motions = np.array([rows.motion[i] @ self.x for i in part])
        normals = np.array([stops[i].toward for i in part])
        along = np.array([rows.reaction[i] for i in part]).T
        limits = np.array([math.inf if stops[i].is_rigid else stops[i].preload for i in part])
        forces = boxed(normals @ along, normals @ accelerations - motions, limits, ties=True)
        for i, force, limit in zip(part, forces, limits, strict=True):
            if force == 0.0:
                state = "free"
            elif force == limit:
                state = "pressed"
            else:
                state = "held" if stops[i].is_rigid else "seated"
            if i in more and state == "free":
                self.orders[i] = ORDERS["judged", "free"]
            elif i in more and contact is not None:
                # The impact is the beginning of a lasting contact.
                self.open[i] = contact
                contact.end = contact.speed_after = math.nan
                self.enter(i, state, "judged")
            elif state != self.states[i]:
                self.enter(i, state, "judged")


def boxed(delassus, wanted, limits, ties=False):
    """Return p in [0, limits], with D p - w >= 0 where p = 0, <= 0 at the limit and = 0 between, by trying all sets."""
    count = len(wanted)
    delassus = np.where(np.abs(delassus) < 1e-14 * np.abs(delassus).max(), 0.0, delassus)
    margin = 1e-13 * max(np.abs(wanted).max(), 1e-300)
    choices = [("between", "zero") if math.isinf(limit) else ("between", "zero", "limit") for limit in limits]
    for chosen in itertools.product(*choices):
        own = [j for j in range(count) if chosen[j] == "between"]
        zero = [j for j in range(count) if chosen[j] == "zero"]
        full = [j for j in range(count) if chosen[j] == "limit"]
        found = np.zeros(count)
        found[full] = limits[full]
        if own:
            try:
                found[own] = np.linalg.solve(delassus[np.ix_(own, own)], wanted[own] - delassus[own] @ found)
            except np.linalg.LinAlgError as error:
                raise Skipped("dependent stops are held") from error
        opening = delassus @ found - wanted
        above, below = found[own] * np.diag(delassus)[own], (limits[own] - found[own]) * np.diag(delassus)[own]
        inside, outside = [*above, *below], [*opening[zero], *-opening[full]]
        if min(inside, default=math.inf) <= margin or min(outside, default=0.0) < -margin:
            continue
        if ties and min(inside + outside) < COINCIDENT:
            raise Skipped("a held stop without force")
        return found
    raise Skipped("a jam")


def run(twin, q0, v0, end, rows=None, regimes=None):
    """Return the exact run of a scene from a start to a time."""
    motion = Motion(twin, q0, v0, rows, regimes)
    while True:
        stop, name = motion.fly(end)
        if name == "end":
            break
        before = motion.states
        motion.make(stop, name)
        if motion.states != before:
            motion.history.append((motion.time, motion.states))
        if name != "relaxed" and end - motion.time < 1e-6:
            raise Skipped("a transition at the end")
        if len(motion.events) > MOST:
            raise Skipped("too many transitions")
    for i, contact in motion.open.items():
        contact.other_loss -= motion.stored(i)
    n = motion.rows.n
    return Run(motion.contacts, motion.events, motion.history, motion.x[:n].copy(), motion.x[n : 2 * n].copy())
