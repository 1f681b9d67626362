"""The text of the page on error against run time: its rules, its tables, its list of leaders."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from statistics import median

from ..page import table, version
from .condition import Condition
from .contestants import NEEDS, contestant, entrant
from .front import LEVELS, OWN, Lead, is_ahead_at_worst, label
from .measure import BASE, BUDGET, FELL, LEAST_ROUNDS, LOST, ROUNDS, SLOW, Plan, Point
from .problems import COUNT, Compliant, Ensemble, Problem
from .reference import Reference
from .trial import LEAST

FORGOTTEN = 1e-30  # a factor that is zero, to the digits of the references: contact that lasts forgets the start
ROUNDED = 2.0**-53  # relative error of one rounding

INTRODUCTION = """Who is the fastest at a given error? Each problem below has a reference of many digits. The library and what a
user would pick instead follow it at relative tolerances from {loosest:.0e} to {finest:.0e}; the absolute tolerance is a tenth of
the relative one, in the largest position of the motion."""

RULES = """## Rules

- *Error of the final state*: the largest component of its difference from the reference, positions in units of the largest
  position of the motion, velocities in units of its largest velocity. *Error of the impact times*: the largest difference by
  index, in units of largest position over largest velocity. An answer reaches a level if both errors do.
- *A wrong answer has no error*: a number of impacts other than the reference's is a cross in the grey strip of the figures; a
  final position deeper than {fell:g} of the motion's size in a stop, or a final state off by more than {lost:g} of it, a mark of
  three legs. Where the impacts accumulate, and their number is infinite, the first ones are asked for, and the state at the end.
- *Time*: one core; each contestant in a process of its own, one of them at work at a time; call by call in turn, medians of
  {least} rounds, and up to {rounds} within {budget:g} s of calls (of calls longer than {slow:g} s the first is taken); a round
  of a fast call is as many of them as take {least_ms:g} ms. Every
  run starts from the problem's first state and gives the final state and every impact time. Times are ratios to {package}
  {method} at rtol {rtol:g} in the same run; where that one was stopped, to the bound. Compilation and first calls are apart,
  in a table of their own. {scatter}
- *Many starts*: the error is the largest over {sample} of the trajectories, which have a reference; a wrong number of impacts
  in any of these is a wrong answer. SciPy follows {few} of them, and its time is counted for all: the bound of a call is that of
  {few} trajectories for it, of {all} for the others. Times of impact are not asked for.
- *Stops that give way*: times are those at which contacts begin, their number is that of the contacts, and a final position in
  a stop is no fault. Peers have a terminal event at each beginning and end of a contact, or follow the motion without.
- *Stopped*: a call that takes longer than {bound:g} s, a triangle at the right edge; finer tolerances are not tried then. An
  exception is a plus at the left edge.
- *Leader* of a level: the fastest of those that reach it, nothing interpolated. A peer has its fastest point there; the library
  the loosest tolerance of each method, so that of its like runs none is picked by chance. The ratio is the fastest peer's time
  over the library's: above 1 the library is the faster. The reading that favours peers most is counted apart: a peer has every
  tolerance between two neighbouring right ones too (by the line between them, both axes logarithmic).
- *Chosen with first runs in sight*: the problems, their spans (conditions of the final state and of the times by the start are
  below 1e4), the bound of a call and the limits of a wrong answer. Implicit methods of packages with others are tried on
  stiff scenes alone. Solvers that look for a change of sign from step to step are given no largest step: how short the shortest
  visit behind a stop would be is not known before."""

CONDITIONS = """*Conditions* come from motions in many digits, repeated with one number changed by 2^-40 of itself or of the
motion's scale: the largest factor by which such a change grows from an entry of the start to the final state, and to a time
of impact; and from the entries of the matrices, all changed by the same part of themselves in the worst direction, to the final
state. Of many starts it is the largest of the sample."""

ROUNDING = """## What rounding leaves

Where a stiff spring and soft ones stand in the same entries of a matrix, what the soft ones do is a small difference of large
numbers: one rounding of each entry, 2^-53 of itself, may move the answer by the third column. Reference and contestants have the
same doubles, so nothing forbids a smaller error; but no method that rounds these entries or their products with the positions
can promise it. Listed are the problems in which this is above the finest level, {finest:.0e}."""


def scatter(points: Sequence[Point]) -> str:
    """How far times taken in different rounds of calls lie apart."""
    spreads = sorted(p.spread for p in points if p.spread is not None)
    if not spreads:
        return ""
    typical, most = median(spreads), spreads[int(0.9 * (len(spreads) - 1))]
    return (
        f"The middle half of a point's rounds spans {typical:.0%} of their median (median over points; nine in ten: at most "
        f"{most:.0%})."
    )


def doubtful(leads: Sequence[Lead], points: Sequence[Point]) -> str:
    """How often the library leads by the reading that favours peers most."""
    reached = [lead for lead in leads if lead.is_reached]
    ahead = sum(is_ahead_at_worst(lead, points) for lead in reached)
    return f"By the reading that favours peers most (see the rules) it leads {ahead} of the {len(reached)}."


def sentence(lead: Lead) -> str:
    """One line of the list of leaders."""
    ratio = f"{lead.ratio:.2f}" if lead.ratio is not None else "-"
    return f"{lead.problem:16} {lead.level:.0e}  {ratio:>9}  {lead.leader}"


def verdict(leads: Sequence[Lead]) -> str:
    """How often the library leads, and where it does not."""
    reached, lost = [lead for lead in leads if lead.is_reached], [lead for lead in leads if lead.is_lost]
    text = f"Of {len(leads)} pairs of problem and level, {len(reached)} are reached by anybody; the library leads {{}} of them."
    text = text.format(len(reached) - len(lost))
    if not lost:
        return text
    places = "; ".join(f"{x.problem} at {x.level:.0e} ({x.leader}, {behind(x)})" for x in lost)
    return f"{text} It does not at: {places}."


def behind(lead: Lead) -> str:
    """How far behind the library is."""
    return "which alone reaches it" if lead.ratio is None else f"ratio {lead.ratio:.2f}"


def standing(leads: Sequence[Lead]) -> str:
    """Where the library stands on one problem: at how many levels it leads, by how much there, by how much not elsewhere."""
    reached = [lead for lead in leads if lead.is_reached]
    led = [lead for lead in reached if not lead.is_lost]
    beside = [lead for lead in led if lead.ratio is not None]
    behind_in = [lead for lead in reached if lead.is_lost and lead.ratio is not None]
    text = f"The library leads at {len(led)} of {len(reached)} levels"
    if led and not beside:
        text += ", where no peer gets"
    if beside:
        text += f", where the fastest peer that gets there takes {span(beside)} times as long"
    if behind_in:
        names = ", ".join(dict.fromkeys(lead.leader for lead in behind_in))
        text += f"; where it does not, the fastest peer ({names}) takes {span(behind_in)} of its time"
    return f"{text}."


def span(leads: Sequence[Lead]) -> str:
    """Smallest and largest ratio of some leads."""
    ratios = [lead.ratio for lead in leads if lead.ratio is not None]
    return " to ".join(dict.fromkeys(f"{float(f'{each:.3g}'):g}" for each in (min(ratios), max(ratios))))


def leaders(leads: Sequence[Lead], titles: Mapping[str, str]) -> str:
    """The list of leaders as a table: a row for each problem and level."""
    rows = [
        (
            titles[lead.problem],
            f"{lead.level:.0e}",
            lead.leader,
            "-" if lead.own is None else f"{lead.own.method} at {lead.own.rtol:.0e}",
            "-" if lead.peer is None else f"{label(lead.peer)} at {lead.peer.rtol:.0e}",
            "-" if lead.ratio is None else f"{lead.ratio:.3g}",
        )
        for lead in leads
    ]
    return table(["problem", "level", "leader", "fastest here", "fastest peer", "peer's time / ours"], rows)


def at_a_glance(leads: Sequence[Lead], titles: Mapping[str, str]) -> str:
    """Ratios of peers' times to the library's, a column for each level."""
    rows = []
    for name, title in titles.items():
        mine = {lead.level: lead for lead in leads if lead.problem == name}
        rows.append((title, *(cell(mine[level]) for level in LEVELS)))
    return table(["peer's time / ours", *(f"{level:.0e}" for level in LEVELS)], rows)


def cell(lead: Lead) -> str:
    """A ratio, or who alone reaches the level."""
    if lead.ratio is not None:
        return f"**{lead.ratio:.3g}**" if lead.is_lost else f"{lead.ratio:.3g}"
    if lead.own is not None:
        return "no peer"
    return "**peer alone**" if lead.peer is not None else "nobody"


def described(wanted: Mapping[Problem, Reference], conditions: Mapping[str, Condition]) -> str:
    """What the problems are: spans, impacts, condition, reference."""
    rows = [
        (
            problem.title,
            f"{problem.end:g}",
            impacts(problem, reference),
            *condition_cells(conditions[problem.name]),
            reference.recipe,
        )
        for problem, reference in wanted.items()
    ]
    names = ["condition: start to end", "start to times", "matrices to end"]
    return table(["problem", "span", "impacts", *names, "reference"], rows)


def condition_cells(condition: Condition) -> list[str]:
    """The three numbers."""
    values = (condition.state, condition.times, condition.entries)
    return ["-" if value is None else f"{value if value > FORGOTTEN else 0.0:.2g}" for value in values]


def rounding(points: Sequence[Point], titles: Mapping[str, str], conditions: Mapping[str, Condition]) -> str:
    """Problems whose matrices, rounded, do not define the finest level, and the smallest errors there."""
    rows = []
    for name, title in titles.items():
        entries = conditions[name].entries
        if entries is not None and entries * ROUNDED > min(LEVELS):
            here = [p for p in points if p.problem == name]
            rows.append(
                (title, f"{entries:.2g}", f"{entries * ROUNDED:.1e}", *(smallest(here, is_own) for is_own in (True, False)))
            )
    header = [
        "problem",
        "condition, matrices to end",
        "one rounding of each entry",
        "smallest error here",
        "smallest error of a peer",
    ]
    return f"{ROUNDING.format(finest=min(LEVELS))}\n\n{table(header, rows)}"


def smallest(points: Sequence[Point], is_own: bool) -> str:
    """The smallest error of the library or of its peers, and whose it is."""
    best = min((p for p in points if (p.package == OWN) is is_own), key=lambda p: p.error, default=None)
    return "-" if best is None or best.error == float("inf") else f"{best.error:.1e} ({label(best)} at {best.rtol:.0e})"


def worst_of_many(points: Sequence[Point]) -> str:
    """How far the largest error of many trajectories is above the median one; nothing for one trajectory."""
    factors = [p.state_error / p.median_error for p in points if p.verdict == "right" and p.median_error]
    if not factors:
        return ""
    return (
        f"The largest error of the sample is {median(factors):.2g} times the median one (median over {len(factors)} right "
        f"points; at most {max(factors):.2g})."
    )


def contestants(points: Sequence[Point], wanted: Iterable[Problem]) -> str:
    """Who took part: version, and how each was driven, as its file says; who did not."""
    lines = []
    present = list(dict.fromkeys(point.package for point in points))
    for name in present:
        module = contestant(name)
        methods = ", ".join(dict.fromkeys(p.method for p in points if p.package == name))
        lines.append(f"- *{module.DISTRIBUTION}* {version(module.DISTRIBUTION)} ({methods}). {' '.join(module.__doc__.split())}")
        for kind, words in ((Ensemble, "Many starts"), (Compliant, "Stops that give way")):
            other = next((entrant(name, each) for each in wanted if isinstance(each, kind)), None)
            lines[-1] += f" {words}: {' '.join(other.__doc__.split())}" if other else ""
    absent = [name for name in NEEDS if name not in present]
    if absent:
        lines.append(f"\nNot installed, or not asked for, where this was made: {', '.join(absent)}.")
    return "\n".join(lines)


def impacts(problem: Problem, reference: Reference) -> str:
    """How many impacts a problem has."""
    if len(reference.counts):
        return f"{reference.counts.sum()} in {len(reference.counts)} of {COUNT[0] * COUNT[1]} trajectories"
    return f"{len(reference.times)}{' of infinitely many' if problem.first else ''}"


def trouble(points: Sequence[Point]) -> str:
    """What went wrong, method by method: verdicts and the tolerances at which they fell."""
    rows = []
    for name in dict.fromkeys(point.name for point in points):
        wrong = [p for p in points if p.name == name and p.verdict != "right"]
        kinds = dict.fromkeys(p.verdict for p in wrong)
        rows += [(name.replace("own ", "this library, "), kind, at([p for p in wrong if p.verdict == kind])) for kind in kinds]
    return table(["contestant", "what happened", "at rtol"], rows) if rows else "Every contestant was right at every tolerance."


def at(points: Sequence[Point]) -> str:
    """Tolerances of points, as ranges of decades where they are neighbours."""
    powers = [round(math.log10(p.rtol)) for p in points]
    runs: list[list[int]] = []
    for power in powers:
        if runs and runs[-1][-1] == power + 1:
            runs[-1].append(power)
        else:
            runs.append([power])
    ends = [(run[0], run[-1]) if len(run) > 1 else (run[0],) for run in runs]
    return ", ".join(" to ".join(f"{10.0**power:.0e}" for power in end) for end in ends)


def preparations(points: Sequence[Point]) -> str:
    """Times of compilation and of the first call, contestant by contestant.

    Of each problem the largest: what is compiled for one tolerance is often there for the next.
    """
    rows = []
    for name in dict.fromkeys(p.name for p in points):
        ready = [p for p in points if p.name == name and p.preparation is not None]
        each = [[p for p in ready if p.problem == problem] for problem in dict.fromkeys(p.problem for p in ready)]
        made = [max(p.preparation for p in here) for here in each]
        more = [max(p.first_call - p.seconds for p in timed) for here in each if (timed := [p for p in here if p.seconds])]
        if made and more:
            cells = [f"{of(times):.2g}" for times in (made, more) for of in (median, max)]
            rows.append((name.replace("own ", "this library, "), *cells))
    return table(["contestant", "preparation [s], median", "most", "first call more than later ones [s], median", "most"], rows)


def scores(points: Sequence[Point]) -> str:
    """How many of its points each contestant got right."""
    tried, right = Counter(p.name for p in points), Counter(p.name for p in points if p.verdict == "right")
    rows = [(name.replace("own ", "this library, "), right[name], tried[name]) for name in tried]
    return table(["contestant", "right", "of"], rows)


def parts(
    plan: Plan,
    points: Sequence[Point],
    leads: Sequence[Lead],
    wanted: Mapping[Problem, Reference],
    conditions: Mapping[str, Condition],
) -> list[str]:
    """The parts of the page."""
    titles = {problem.name: problem.title for problem in wanted}
    package, method, rtol = BASE
    sample = max(len(reference.counts) for reference in wanted.values())
    few = max((round(p.share * COUNT[0] * COUNT[1]) for p in points if p.share < 1.0), default=0)
    rules = RULES.format(
        sample=sample,
        few=few,
        fell=FELL,
        lost=LOST,
        least=LEAST_ROUNDS,
        rounds=ROUNDS,
        budget=BUDGET,
        slow=SLOW,
        least_ms=1e3 * LEAST,
        all=COUNT[0] * COUNT[1],
        bound=plan.bound,
        package=package,
        method=method,
        rtol=rtol,
        scatter=scatter(points),
    )
    sections = []
    for problem in wanted:
        here = [p for p in points if p.problem == problem.name]
        picture = f"![{problem.title}](figures/error_vs_runtime_{problem.name}.png)"
        own = [lead for lead in leads if lead.problem == problem.name]
        why = f" Why: {problem.behind}" if problem.behind and any(lead.is_lost for lead in own) else ""
        stands = standing(own) + why
        pieces = [f"## {problem.title}", f"{problem.scene.plan()}.", stands, picture, worst_of_many(here), trouble(here)]
        sections.append("\n\n".join(piece for piece in pieces if piece))
    return [
        INTRODUCTION.format(loosest=max(plan.tolerances), finest=min(plan.tolerances)),
        "![Error of the final state against run time, every problem](figures/error_vs_runtime.png)",
        f"## Who leads\n\n{verdict(leads)} {doubtful(leads, points)} Bold: a peer is the faster.\n\n{at_a_glance(leads, titles)}",
        rules,
        f"## Contestants\n\n{contestants(points, wanted)}",
        f"## Problems\n\n{CONDITIONS}\n\n{described(wanted, conditions)}",
        rounding(points, titles, conditions),
        *sections,
        f"## Every leader\n\n{leaders(leads, titles)}",
        f"## Right answers\n\n{scores(points)}",
        f"## Compilation and first calls\n\nOf each problem the largest over the tolerances.\n\n{preparations(points)}",
    ]
