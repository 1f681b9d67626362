"""A page of a report: where it goes, its tables and values, and what made it."""

from __future__ import annotations

import argparse
import csv
import datetime
import importlib.metadata
import platform
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

ALWAYS = ("vibroimpact", "numpy", "scipy", "matplotlib", "mpmath")
ROOT = Path(__file__).parents[2]
DEFAULT = ROOT / "docs" / "report"


@dataclass(frozen=True)
class Job:
    """What a script is asked for: the whole report or a quick one, and the directory it is written to."""

    quick: bool
    output: Path


def job(description: str, arguments: Sequence[str] | None = None) -> Job:
    """Read the command line; a quick report goes into a directory beside the whole one."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--quick", action="store_true", help="under two minutes, written to OUTPUT/quick")
    parser.add_argument("--output", type=Path, default=DEFAULT, help="directory of the report")
    found = parser.parse_args(arguments)
    output: Path = found.output / "quick" if found.quick else found.output
    output.mkdir(parents=True, exist_ok=True)
    return Job(found.quick, output)


def version(package: str) -> str | None:
    """Version of an installed package; without metadata, what the package says once it is imported; None where there is none."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        said = getattr(sys.modules.get(package), "version", None)
        return said if isinstance(said, str) else None


def processor() -> str:
    """Name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.processor())


def sources() -> str:
    """The library's sources as git names them, so that a reader can tell whether they are those at hand; empty without git."""

    def git(*arguments: str) -> str:
        done = subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True, check=True)
        return done.stdout.strip()

    try:
        tree, changed = git("rev-parse", "--short", "HEAD:src"), git("status", "--porcelain", "--", "src")
    except (OSError, subprocess.CalledProcessError):
        return ""
    return f"; src is git's tree {tree}{', changed' if changed else ''}"


def provenance(packages: Iterable[str] = ()) -> str:
    """One line: the day, the processor, the versions of what took part, the sources."""
    names = dict.fromkeys((*ALWAYS, *packages))
    found = [f"{name} {version(name)}" for name in names if version(name)]
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    machine = f"Python {platform.python_version()} on {platform.system()}, {processor()}"
    return f"Made on {today} by {machine}; {', '.join(found)}{sources()}."


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table; the first column is text, the others are numbers."""
    rule = ["---", *["---:"] * (len(header) - 1)]
    lines = [header, rule, *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines)


def write_csv(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write rows under the names of the first one's values."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read_csv(path: Path) -> list[dict[str, str]]:
    """The rows of a table; none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def write_page(path: Path, title: str, parts: Iterable[str], packages: Iterable[str] = ()) -> None:
    """Write a page: its title, its parts, and at the end what made it."""
    path.write_text("\n\n".join([f"# {title}", *parts, provenance(packages)]) + "\n")


def put_in_readme(name: str, text: str) -> None:
    """Write a text between its marks in the README; one without them is left alone."""
    readme = ROOT / "README.md"
    start, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    whole = readme.read_text()
    if start in whole and end in whole:
        before, rest = whole.split(start, 1)
        readme.write_text(before + start + text + end + rest.split(end, 1)[1])
