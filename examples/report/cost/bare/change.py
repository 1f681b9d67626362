"""A change to the text of a source file: a stretch of it that must be found exactly once, and what stands in its place."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

# What stands where a scene would need what was taken out.
NEVER = "unreachable!()"


@dataclass(frozen=True)
class Change:
    """Replace what lies from `start`, which must occur once, up to the next `until`; without that, `start` alone."""

    path: str
    start: str
    by: str
    until: str = ""

    def fault(self, text: str) -> str | None:
        """Why the change does not apply to a text any more; None where it does."""
        count = text.count(self.start)
        first = self.start.strip().splitlines()[0]
        if count != 1:
            return f"{self.path}: `{first}` is there {count} times, not once"
        if self.until not in text[text.index(self.start) + len(self.start) :]:
            return f"{self.path}: the end of what begins with `{first}` is not there"
        return None

    def applied(self, text: str) -> str:
        """The text with the change."""
        begin = text.index(self.start)
        end = text.index(self.until, begin + len(self.start))
        return text[:begin] + self.by + text[end:]


def texts(changes: Iterable[Change], root: Path, paths: Iterable[str]) -> dict[str, str]:
    """The texts of files below a directory with the changes, which must apply."""
    found = {path: (root / path).read_text() for path in paths}
    for change in changes:
        found[change.path] = change.applied(found[change.path])
    return found


def faults(changes: Iterable[Change], root: Path) -> list[str]:
    """Why changes do not apply, one after the other, to the files below a directory."""
    found = []
    known: dict[str, str] = {}
    for change in changes:
        if change.path not in known:
            path = root / change.path
            known[change.path] = path.read_text() if path.exists() else ""
        fault = change.fault(known[change.path])
        if fault:
            found.append(fault)
        else:
            known[change.path] = change.applied(known[change.path])
    return found
