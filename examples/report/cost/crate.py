"""The same scenes run from Rust by `benches/scene_cost.rs`: a build without Python, threads and looks at Ctrl-C."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

LINE = re.compile(r"^(?P<name>\S.*?)\s{2,}(?P<ns>\d+)\s+(?P<instructions>\d+|-)\s+(?P<call>\d+)\s+(?P<fixed>-?\d+|-)$")
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
    "taylor: no wall": "taylor: no wall",
    "taylor: base motion": "taylor: base motion",
    "taylor: joint dampers": "taylor: joint dampers",
    "taylor: a wall": "taylor: 1 wall",
    "taylor: a wall and a second one": "taylor: 2 walls",
    "taylor: three walls": "taylor: 3 walls",
    'taylor: keep="motion"': "taylor: motion kept",
}


@dataclass(frozen=True)
class Measured:
    """Nanoseconds and instructions of a unit from Rust, microseconds of a call with one, and its instructions beside that."""

    nanoseconds: float
    instructions: float | None
    call: float
    fixed: float | None


def read(printed: str) -> dict[str, Measured]:
    """The lines of the bench by the names of the catalogue."""
    found = (LINE.match(line) for line in printed.splitlines())
    lines = {match["name"]: match for match in found if match}

    def measured(match: re.Match[str]) -> Measured:
        count, fixed = (None if match[name] == "-" else float(match[name]) for name in ("instructions", "fixed"))
        return Measured(float(match["ns"]), count, float(match["call"]) / 1000.0, fixed)

    return {name: measured(lines[line]) for name, line in SAME.items() if line in lines}


def measured(bench: Path | None) -> dict[str, Measured]:
    """What the bench prints; nothing where there is none."""
    if bench is None:
        return {}
    return read(subprocess.run([bench], capture_output=True, text=True, check=True).stdout)
