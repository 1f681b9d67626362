"""The text of the page on error against run time: its rules, its tables, its list of leaders."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import median

from ..page import table, version
from .contestants import contestant
from .front import LEVELS, Lead, label
from .measure import BASE, BUDGET, FELL, LOST, ROUNDS, SLOW, Plan, Point
from .problems import COUNT, Problem
from .reference import Reference

INTRODUCTION = """Who is the fastest at a given error? Each problem below has a reference of many digits. The library and what a
user would pick instead follow it at relative tolerances from {loosest:.0e} to {finest:.0e}; the absolute tolerance is a tenth of
the relative one, in the largest position of the motion."""

RULES = """## Rules

- *Error of the final state*: the largest component of its difference from the reference, positions in units of the largest
  position of the motion, velocities in units of its largest velocity. *Error of the impact times*: the largest difference by
  index, in units of largest position over largest velocity. An answer reaches a level if both errors do.
- *A wrong answer has no error*: a number of impacts other than the reference's, a final position deeper than {fell:g} of the
  motion's size in a stop, or a final state off by more than {lost:g} of it, is a cross in the grey strip of the figures.
  Where the impacts accumulate, and their number is infinite, the first ones are asked for, and the state at the end.
- *Time*: one core; each contestant in a process of its own, one of them at work at a time; call by call in turn, medians of
  up to {rounds} rounds within {budget:g} s of calls (of calls longer than {slow:g} s the first is taken). Every run starts
  from the problem's first state and gives the final state and every impact time. Times are ratios to {package} {method} at
  rtol {rtol:g} in the same run; where that one was stopped, to the bound. Compilation and first calls are apart, in a table
  of their own.
- *Many starts*: the error is the median over {sample} of the trajectories, which have a reference; a wrong number of impacts
  in any of these is a wrong answer. SciPy follows {few} of them, and its time is counted for all.
- *Stopped*: a call that takes longer than {bound:g} s, a triangle at the right edge; finer tolerances are not tried then. An
  exception is a plus at the left edge.
- *Leader* of a level: the fastest point that reaches it. The ratio is the fastest peer's time over the library's: above 1 the
  library is the faster."""


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


def described(wanted: Mapping[Problem, Reference], conditions: Mapping[str, float]) -> str:
    """What the problems are: spans, impacts, condition, reference."""
    rows = [
        (
            problem.title,
            f"{problem.end:g}",
            impacts(problem, reference),
            f"{conditions[problem.name]:.2g}",
            reference.recipe,
        )
        for problem, reference in wanted.items()
    ]
    return table(["problem", "span", "impacts", "condition", "reference"], rows)


def contestants(points: Sequence[Point]) -> str:
    """Who took part: version, and how each was driven, as its file says."""
    lines = []
    for name in dict.fromkeys(point.package for point in points):
        module = contestant(name)
        methods = ", ".join(dict.fromkeys(p.method for p in points if p.package == name))
        lines.append(f"- *{module.DISTRIBUTION}* {version(module.DISTRIBUTION)} ({methods}). {' '.join(module.__doc__.split())}")
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
    """Tolerances of points, as a range if there are many."""
    values = [f"{p.rtol:.0e}" for p in points]
    return ", ".join(values) if len(values) < 3 else f"{values[0]} to {values[-1]} ({len(values)})"


def preparations(points: Sequence[Point]) -> str:
    """Median times of compilation and of the first call, contestant by contestant."""
    rows = []
    for name in dict.fromkeys(p.name for p in points):
        ready = [p for p in points if p.name == name and p.preparation is not None]
        if ready:
            extra = median(p.first_call - p.seconds for p in ready if p.seconds is not None)
            rows.append((name.replace("own ", "this library, "), f"{median(p.preparation for p in ready):.4f}", f"{extra:.4f}"))
    return table(["contestant", "preparation [s]", "first call more than later ones [s]"], rows)


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
    conditions: Mapping[str, float],
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
        rounds=ROUNDS,
        budget=BUDGET,
        slow=SLOW,
        bound=plan.bound,
        package=package,
        method=method,
        rtol=rtol,
    )
    sections = []
    for problem in wanted:
        here = [p for p in points if p.problem == problem.name]
        picture = f"![{problem.title}](figures/error_vs_runtime_{problem.name}.png)"
        sections.append(f"## {problem.title}\n\n{problem.scene.plan()}.\n\n{picture}\n\n{trouble(here)}")
    return [
        INTRODUCTION.format(loosest=max(plan.tolerances), finest=min(plan.tolerances)),
        "![Error of the final state against run time, every problem](figures/error_vs_runtime.png)",
        f"## Who leads\n\n{verdict(leads)} Bold: a peer is the faster.\n\n{at_a_glance(leads, titles)}",
        rules,
        f"## Contestants\n\n{contestants(points)}",
        f"## Problems\n\n{described(wanted, conditions)}",
        *sections,
        f"## Every leader\n\n{leaders(leads, titles)}",
        f"## Right answers\n\n{scores(points)}",
        f"## Compilation and first calls\n\nMedians over problems and tolerances.\n\n{preparations(points)}",
    ]
