"""A referee of runs with stops that give way and rigid ones: random scenes, flown by an exact twin and by the library."""

import dataclasses
import itertools
import math
from dataclasses import dataclass

import numpy as np
from contact_scenes import draw
from contact_twin import ON, Rows, Run, Skipped, Twin, run

#: What times may differ by, in parts of the span; other numbers, in parts of their size; and by how many roundings, as
#: often as the run amplifies them. Beyond that amplification a run is not compared.
TIMES, NUMBERS, ROUNDINGS, CHAOTIC = 1e-8, 1e-6, 1e3 * np.finfo(float).eps, 1e6


def columns(own, name):
    """Return one number of all contacts."""
    return np.array([getattr(contact, name) for contact in own.contacts])


def amplification(twin, q0, v0, end, own, rows, regimes):
    """Return by how much a run grows what its start is off by; refuses a run that becomes another."""
    kick = 1e-9
    n = len(q0)
    direction = np.cos(np.arange(1, 2 * n + 1) * 1.7)
    x = rows.state(q0, v0, 0.0, 0.0)
    for i, stop in enumerate(twin.stops):
        if abs(rows.p[i] @ x) <= ON:
            # What begins on a stop stays on it.
            direction[np.tile(stop.normal != 0.0, 2)] = 0.0
    if direction.any():
        other = run(twin, q0 + kick * direction[:n], v0 + kick * direction[n:], end, rows, regimes)
    else:
        other = run(dataclasses.replace(twin, stiffness=twin.stiffness * (1.0 + kick)), q0, v0, end)
    if [event[1:] for event in other.events] != [event[1:] for event in own.events]:
        raise Skipped("a run too close to another")
    apart = [np.abs(own.q - other.q).max(), np.abs(own.v - other.v).max()]
    for name in ("start", "end", "speed_before", "speed_after"):
        off = np.abs(columns(own, name) - columns(other, name))
        apart.append(np.nanmax(off, initial=0.0))
    return max(apart) / kick


def judged(twin, q0, v0, end):
    """Return the twin's run and what it amplifies differences by; refuses runs that cannot be compared."""
    rows, regimes = Rows(twin), {}
    own = run(twin, q0, v0, end, rows, regimes)
    grows = amplification(twin, q0, v0, end, own, rows, regimes)
    if grows > CHAOTIC:
        raise Skipped("a chaotic run")
    return own, grows


def disagreement(twin, q0, v0, end):
    """Return what the library's run has otherwise than the twin's; none where both agree."""
    import vibroimpact as vi

    own, grows = judged(twin, q0, v0, end)
    try:
        trajectory = vi.simulate(twin.scene(), q0, v0, (0.0, end))
    except Exception as error:
        return f"the library raises {type(error).__name__}: {error}"
    return difference(twin, own, trajectory, end, grows)


def difference(twin, own, trajectory, end, grows=1.0):
    """Return the first thing that a trajectory has otherwise than the twin's run; none where both agree."""
    if trajectory.status != "finished":
        return f"status {trajectory.status!r}: {trajectory.message}"
    found = different_contacts(twin, own, trajectory.contacts, end, grows)
    if found is None and getattr(trajectory, "regimes", None) is not None:
        found = different_regimes(twin, own, trajectory.regimes, end, grows)
    if found is None:
        found = different_end(own, trajectory.final, grows)
    return found


def names(stops):
    """Return a list of stops, shortened."""
    text = " ".join(str(int(stop)) for stop in stops[:12])
    return text + (" ..." if len(stops) > 12 else "")


def different_contacts(twin, own, table, end, grows):
    """Return the first difference of the tables of contacts."""
    sat = {i for _, states in own.states for i, state in enumerate(states) if state == "seated"}
    contacts = [contact for contact in own.contacts if contact.stop not in sat]
    table = table[~np.isin(table["stop"], list(sat))]
    contacts, table = by_instants(contacts, TIMES * end), [table[k] for k in instants(table, TIMES * end)]
    stops = [contact.stop for contact in contacts]
    given = [int(row["stop"]) for row in table]
    same = next((k for k, (a, b) in enumerate(zip(stops, given, strict=False)) if a != b), None)
    if len(table) != len(stops) or same is not None:
        k = min(len(table), len(stops)) if same is None else same
        at = [f"{float(t):.9g}" for t in (contacts[k].start if k < len(stops) else math.nan,)]
        at += [f"{float(table[k]['start']):.9g}"] if k < len(table) else ["-"]
        return (
            f"{len(table)} contacts, not {len(stops)}: first other is row {k}, "
            f"twin {names(stops[k:])} from t = {at[0]}, library {names(given[k:])} from t = {at[1]}"
        )
    late = TIMES * end + ROUNDINGS * grows
    off = NUMBERS + ROUNDINGS * grows
    speed = max([abs(x) for c in contacts for x in (c.speed_before, c.speed_after) if math.isfinite(x)], default=1.0)
    for k, contact in enumerate(contacts):
        row = table[k]
        stop = twin.stops[contact.stop]
        peak = contact.peak_force if math.isfinite(contact.peak_force) else 0.0
        length = max(contact.end - contact.start, 0.0) if math.isfinite(contact.end) else end
        force = max(abs(peak), stop.stiffness * max(contact.peak_approach, 0.0), stop.damping * speed * off)
        wanted = [
            ("start", contact.start, late),
            ("end", contact.end, late),
            ("speed_before", contact.speed_before, off * speed),
            ("speed_after", contact.speed_after, off * speed),
            ("impulse", contact.impulse, off * max(abs(contact.impulse), force * length, speed / share(twin, stop))),
            ("loss", contact.loss, off * max(abs(contact.loss), 0.5 * speed**2 / share(twin, stop))),
        ]
        if not stop.is_rigid:
            wanted.append(("peak_force", contact.peak_force, off * max(force, stop.damping * speed)))
            wanted.append(("peak_approach", contact.peak_approach, off * max(contact.peak_approach, 1e-3)))
        elif not contact.is_lasting:
            wanted.append(("peak_force", math.inf, 0.0))
            wanted.append(("peak_approach", 0.0, 0.0))
        for name, value, margin in wanted:
            if name in contact.unsure:
                continue
            if name == "loss" and is_other(contact, stop, float(row[name]), margin):
                continue
            if not is_close(float(row[name]), value, margin):
                return (
                    f"contact {k} of stop {contact.stop} at t = {contact.start:.9g}: {name} {float(row[name])!r}, "
                    f"not {float(value)!r} (margin {margin:.1e}, amplification {grows:.1e})"
                )
        if math.isfinite(twin.phase):
            turned = float(row["phase"]) - twin.frequency * contact.start - twin.phase
            turned = (turned + math.pi) % (2.0 * math.pi) - math.pi
            if not abs(turned) <= twin.frequency * late + 1e-12 * end:
                return f"contact {k} of stop {contact.stop} at t = {contact.start:.9g}: phase {float(row['phase'])!r}"
    return None


def instants(table, late):
    """Return the order of rows by their instants, those of one by their stops."""
    order, first = [], 0
    starts = [float(row["start"]) for row in table]
    for k in range(1, len(starts) + 1):
        if k == len(starts) or starts[k] - starts[k - 1] > late:
            order += sorted(range(first, k), key=lambda row: (int(table[row]["stop"]), starts[row]))
            first = k
    return order


def by_instants(contacts, late):
    """Return contacts by their instants, those of one by their stops."""
    rows = [{"start": contact.start, "stop": contact.stop} for contact in contacts]
    return [contacts[k] for k in instants(rows, late)]


def is_other(contact, stop, loss, margin):
    """Whether a loss is that of a reaction which is not that of inertia: what such a stop has stored is told by no energy."""
    if stop.reaction == "inertia":
        return False
    at_edge = not (math.isfinite(contact.speed_before) and math.isfinite(contact.end))
    return at_edge or is_close(loss, contact.other_loss, margin)


def share(twin, stop):
    """Return n.b of a stop."""
    b = np.linalg.solve(twin.mass, stop.toward) if stop.reaction == "inertia" else stop.toward
    return float(stop.toward @ b)


def is_close(value, wanted, margin):
    """Whether two numbers are the same within a margin; what is not finite, exactly."""
    if not (math.isfinite(wanted) and math.isfinite(value)):
        return value == wanted or (math.isnan(value) and math.isnan(wanted))
    return abs(value - wanted) <= margin


def shown(twin, states):
    """Return states in which a point that comes to its seat without an event is not told from one at it."""
    made = []
    for stop, state in zip(twin.stops, states, strict=True):
        made.append("free" if str(state) == "relaxing" and stop.preload == 0.0 else str(state))
    return tuple(made)


def merged(twin, pieces):
    """Return (time, states) of a list of regimes, neighbours of the same states as one."""
    made = []
    for start, states in pieces:
        states = shown(twin, states)
        if not made or made[-1][1] != states:
            made.append((float(start), states))
    return made


def different_regimes(twin, own, table, end, grows):
    """Return the first difference of the lists of regimes."""
    wanted = merged(twin, own.states)
    given = merged(twin, [(row["start"], np.atleast_1d(row["state"])[: len(twin.stops)]) for row in table])
    late = TIMES * end + ROUNDINGS * grows
    for k, (one, other) in enumerate(itertools.zip_longest(given, wanted)):
        if one is None or other is None or one[1] != other[1] or abs(one[0] - other[0]) > late:
            return f"regime {k}: {one}, not {other}"
    return None


def different_end(own, final, grows):
    """Return how the final states differ."""
    off = NUMBERS + ROUNDINGS * grows
    for name, value, wanted in zip("qv", final, (own.q, own.v), strict=True):
        size = max(np.abs(wanted).max(), 1.0)
        miss = np.abs(np.asarray(value) - wanted).max()
        if not miss <= off * size:
            return f"final {name} is off by {miss:.2e}: {np.asarray(value)}, not {wanted} (amplification {grows:.1e})"
    return None


def described(twin, q0, v0, end):
    """Return a scene and start as text that makes them again."""
    with np.printoptions(precision=17, floatmode="unique"):
        return f"{twin!r}\n    q0 = {q0!r}, v0 = {v0!r}, end = {end!r}".replace("array(", "np.array(")


@dataclass
class Case:
    """One random scene that can be compared, and the reasons of those that could not and were drawn before."""

    twin: Twin
    q0: np.ndarray
    v0: np.ndarray
    end: float
    run: Run
    amplification: float
    skipped: list[str]


def some_case(seed, number, wanted=lambda twin: True):
    """Return a scene of a number that can be compared, of those that are wanted."""
    rng = np.random.default_rng([seed, number])
    skipped = []
    while True:
        twin, q0, v0, end = draw(rng)
        if not wanted(twin):
            continue
        try:
            own, grows = judged(twin, q0, v0, end)
        except Skipped as reason:
            skipped.append(str(reason))
            continue
        return Case(twin, q0, v0, end, own, grows, skipped)
