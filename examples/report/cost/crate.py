"""The same scenes run from Rust by `benches/scene_cost.rs`: a build without Python, threads and looks at Ctrl-C."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
LINE = re.compile(r"^(?P<name>\S.*?)\s{2,}(?P<ns>\d+)\s+(?P<instructions>\d+|-)$")
# Lines of the bench by the cases of the catalogue that run the same scene.
SAME = {
    "exact: one stop": "exact: one stop",
    "exact: forcing": "exact: and forcing",
    "exact: proportional damping": "exact: and damping",
    "exact: non-proportional damping": "exact: and complex modes",
    "exact: non-proportional damping and forcing": "exact: complex, forcing",
    "exact: a second stop": "exact: 2 stops",
    "exact: a third stop": "exact: 3 stops",
    "exact: a fourth stop": "exact: 4 stops",
    'exact: keep="impacts"': "exact: impacts kept",
    'exact: keep="motion"': "exact: motion kept",
    "rk45: no stop": "rk45: no stop",
    "rk45: forcing": "rk45: and forcing",
    "rk45: damping": "rk45: and damping",
    "rk45: a stop": "rk45: 1 stop",
    "rk45: a stop and a second one": "rk45: 2 stops",
    "rk45: a stop, a second and a third one": "rk45: 3 stops",
    "rk45: four stops": "rk45: 4 stops",
    'rk45: keep="motion"': "rk45: motion kept",
}


@dataclass(frozen=True)
class Measured:
    """Nanoseconds and instructions of a unit, from Rust."""

    nanoseconds: float
    instructions: float | None


def is_possible() -> bool:
    """Whether this is a clone of the repository and cargo is installed."""
    return (ROOT / "benches" / "scene_cost.rs").exists() and shutil.which("cargo") is not None


def read(printed: str) -> dict[str, Measured]:
    """The lines of the bench by the names of the catalogue."""
    found = (LINE.match(line) for line in printed.splitlines())
    lines = {match["name"]: match for match in found if match}

    def measured(match: re.Match[str]) -> Measured:
        count = match["instructions"]
        return Measured(float(match["ns"]), None if count == "-" else float(count))

    return {name: measured(lines[line]) for name, line in SAME.items() if line in lines}


def measured() -> dict[str, Measured]:
    """What the bench prints; empty where it cannot be built."""
    if not is_possible():
        return {}
    command = ["cargo", "bench", "--quiet", "--bench", "scene_cost"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return read(done.stdout) if done.returncode == 0 else {}
