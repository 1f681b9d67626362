"""Error against run time: the library's methods and what a user would pick instead, on many problems, front to front.

Each problem has a reference of many digits (examples/report/contest/recipe.py). Every contestant follows it at tolerances from
1e-3 to 1e-13; you will see, in figures and as a list, who is the fastest at each level of error, who misses impacts, who falls
through the stop and who never ends.

Run: python examples/error_vs_runtime.py [--quick] [--output DIRECTORY]
"""

# sphinx_gallery_thumbnail_path = "report/figures/error_vs_runtime.png"
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict

from report import page
from report.contest import figures, prose
from report.contest.condition import conditions
from report.contest.contestants import available, contestant
from report.contest.front import Lead, front
from report.contest.measure import Plan, Point, measured
from report.contest.problems import Problem, problems
from report.contest.readme import block, read
from report.contest.reference import Reference, load
from report.contest.trial import Contestant

WHOLE = Plan([10.0**-k for k in range(3, 14)], 2.0, {})
QUICK = Plan([1e-3, 1e-6, 1e-9], 0.5, {"scipy": ["RK45", "DOP853", "DOP853 without restarts"]})
QUICK_CONTESTANTS = ("own", "scipy")


def measure(job: page.Job, wanted: Mapping[Problem, Reference]) -> list[Point]:
    """Measure every problem, with a process for each contestant."""
    names = available(QUICK_CONTESTANTS) if job.quick else available()
    processes = {name: Contestant(name) for name in names}
    points: list[Point] = []
    for problem, reference in wanted.items():
        found = measured(problem, reference, processes, QUICK if job.quick else WHOLE)
        points += found
        print(f"{problem.name}: {sum(p.verdict == 'right' for p in found)} right of {len(found)}", flush=True)
    for process in processes.values():
        process.end()
    return points


def write(job: page.Job, points: list[Point], leads: list[Lead], wanted: Mapping[Problem, Reference]) -> None:
    """Write the table, the figures and the page."""
    titles = {problem.name: problem.title for problem in wanted}
    folder = job.output / "figures"
    folder.mkdir(exist_ok=True)
    page.write_csv(job.output / "error_vs_runtime.csv", [asdict(point) for point in points])
    figures.sheet(points, titles, folder / "error_vs_runtime")
    for name, title in titles.items():
        figures.of_problem([p for p in points if p.problem == name], title, folder / f"error_vs_runtime_{name}")
    packages = [contestant(name).DISTRIBUTION for name in dict.fromkeys(point.package for point in points)]
    parts = prose.parts(QUICK if job.quick else WHOLE, points, leads, wanted, conditions(list(wanted)))
    page.write_page(job.output / "error_vs_runtime.md", "Error against run time", parts, packages)


def main() -> None:
    """Measure, write, and print who leads."""
    job = page.job(__doc__.partition("\n")[0])
    wanted = {problem: load(problem) for problem in problems()}
    points = measure(job, wanted)
    leads = front(points)
    write(job, points, leads, wanted)
    print(*(prose.sentence(lead) for lead in leads), sep="\n")
    print(prose.verdict(leads))
    if job.output == page.DEFAULT:
        page.put_in_readme("report", block(read(job.output / "error_vs_runtime.csv")))
    print(f"report in {job.output}/")


if __name__ == "__main__":
    main()
