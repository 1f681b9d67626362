"""Compare the run times of two builds of the package, contest by contest.

Run by hand, ``python benches/two_builds.py BEFORE NOW [--rounds N] [--only WORD ...]``, where BEFORE and NOW are the Python
interpreters of two virtual environments, each with a release build of the package (and NumPy) installed. The library's own
methods follow the problems of ``examples/error_vs_runtime.py`` that are one run, at the tolerances of that report. Each build
has a process that stays alive, and is asked in turn: a slow moment of the machine falls on both. What is printed is the ratio
of the least times, now to before, of each contest, method and tolerance, and the median of all.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from statistics import median

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
TOLERANCES = [1e-3, 1e-6, 1e-9, 1e-12]
ROUNDS = 15
LEAST = 2e-3  # [s] of calls in a row that one time is taken from


def contests(words):
    """Return what each contest runs, by its problem, method and tolerance; those whose name has one of the words, if any."""
    from report.contest.contestants import own
    from report.contest.measure import tolerances
    from report.contest.problems import Ensemble, problems
    from report.contest.reference import load

    runs = {}
    for problem in problems():
        if isinstance(problem, Ensemble):
            continue
        reference = load(problem)
        for method in own.methods(problem):
            for rtol in TOLERANCES:
                name = f"{problem.name} {method} {rtol:.0e}"
                if not words or any(word in name for word in words):
                    runs[name] = own.prepare(problem, method, tolerances(rtol, reference))
    return runs


def is_answered(run):
    """Whether a build has an answer at all."""
    try:
        run()
    except RuntimeError:
        return False
    return True


def serve(words):
    """Print the contests that this build answers; then, for each name read, the time of one of several calls in a row."""
    from report.timing import repeats_for, seconds

    runs = {name: run for name, run in contests(words).items() if is_answered(run)}
    repeats = {name: repeats_for(run, LEAST) for name, run in runs.items()}
    print(*runs, sep="\t", flush=True)
    for line in sys.stdin:
        name = line.strip()
        print(seconds(runs[name], repeats[name]), flush=True)


class Build:
    """A build's process."""

    def __init__(self, python, words):
        """Start it."""
        command = [python, __file__, "--serve", *(["--only", *words] if words else [])]
        path = os.pathsep.join([str(EXAMPLES), os.environ.get("PYTHONPATH", "")])
        environment = {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}
        self.process = subprocess.Popen(command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def answer(self):
        """Return the next line that it prints."""
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{self.process.args[0]} ended")
        return line.strip()

    def seconds(self, name):
        """Return the time of a contest."""
        print(name, file=self.process.stdin, flush=True)
        return float(self.answer())

    def end(self):
        """Let it go."""
        self.process.stdin.close()
        self.process.wait()


def compare(before, now, words, rounds):
    """Print the ratio of each contest and the median."""
    builds = [Build(python, words) for python in (before, now)]
    old, new = (build.answer().split("\t") for build in builds)
    for name in sorted(set(old) ^ set(new)):
        print(f"{name}: not answered {'now' if name in old else 'before'}")
    common = [name for name in old if name in new]
    least = {name: [float("inf")] * 2 for name in common}
    for _ in range(rounds):
        for name in common:
            least[name] = [min(known, build.seconds(name)) for known, build in zip(least[name], builds, strict=True)]
    for build in builds:
        build.end()
    ratios = {name: now / before for name, (before, now) in least.items()}
    print(f"{'contest':32} {'before':>12} {'now':>12}  ratio")
    for name, (first, second) in least.items():
        print(f"{name:32} {first * 1e6:9.1f} us {second * 1e6:9.1f} us  {ratios[name]:.3f}")
    print(f"median of {len(ratios)}: {median(ratios.values()):.3f}; largest: {max(ratios.values()):.3f}")


def main():
    """Measure and print, or be one of the processes that are asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pythons", nargs="*", metavar="PYTHON", help="before and now")
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD", help="contests whose names have one of these")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    job = parser.parse_args()
    if job.serve:
        serve(job.only)
    elif len(job.pythons) == 2:
        compare(*job.pythons, job.only, job.rounds)
    else:
        parser.error("the interpreters of two builds are wanted")


if __name__ == "__main__":
    main()
