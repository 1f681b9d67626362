"""Copies of the crate below the build directory, each with its changes, and the bench built of each."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path

from report.cost.bare.change import Change, texts

ROOT = Path(__file__).parents[4]
COPIES = ROOT / "target" / "bare"
BENCH = "scene_cost"
EXECUTABLE = re.compile(r"Executable .*\((?P<path>.*)\)")
# A copy is built for its bench alone, and may leave things unused.
FRAME = (
    Change("Cargo.toml", 'crate-type = ["cdylib", "rlib"]', 'crate-type = ["rlib"]'),
    Change("Cargo.toml", "[dev-dependencies]", "", "[[bench]]"),
    Change("src/lib.rs", '#![doc = include_str!("../README.md")]', "#![allow(warnings)]"),
)


def named(key: str) -> Change:
    """A version of its own, by which cargo tells the copies apart in the directory that they build in."""
    return Change("Cargo.toml", '\nversion = "', f'\nversion = "0.0.0+{key}', '"\nedition')


def is_possible() -> bool:
    """Whether this is a clone of the repository and cargo is installed."""
    return (ROOT / "benches" / f"{BENCH}.rs").exists() and shutil.which("cargo") is not None


def sources() -> list[str]:
    """The files that a copy needs."""
    folders = (path for folder in ("src", "benches") for path in sorted((ROOT / folder).rglob("*.rs")))
    return ["Cargo.toml", "Cargo.lock", *(str(path.relative_to(ROOT)) for path in folders)]


def write_copy(directory: Path, changes: Sequence[Change]) -> None:
    """Bring a copy up to date; files that have not changed are not touched, so that they are not compiled again."""
    wanted = texts(changes, ROOT, sources())
    for path in [path for path in directory.rglob("*") if path.is_file()]:
        if str(path.relative_to(directory)) not in wanted:
            path.unlink()
    for name, text in wanted.items():
        path = directory / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def built(key: str, changes: Iterable[Change]) -> Path | None:
    """The bench of a copy with these changes; None where it cannot be built."""
    directory = COPIES / key
    write_copy(directory, (named(key), *FRAME, *changes))
    command = ["cargo", "bench", "--bench", BENCH, "--no-run", "--target-dir", str(COPIES / "build")]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, check=False)
    found = EXECUTABLE.search(done.stderr)
    if done.returncode or not found:
        print(f"the copy `{key}` could not be built:\n{done.stderr[-3000:]}")
        return None
    return directory / found["path"]
