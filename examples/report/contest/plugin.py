"""Formulas as functions of a C library, compiled here and loaded: what a simulator calls that takes functions of C alone."""

from __future__ import annotations

import ctypes
import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from .formulas import Traced


@dataclass(frozen=True)
class Plugin:
    """A loaded library: its path without the suffix; the file is gone, the loader knows it by that name."""

    path: str
    library: ctypes.CDLL


def number(value: object) -> str:
    """A number as C writes it."""
    return repr(float(value))


def function(head: str, formula: Traced, places: Mapping[str, str], target: str) -> str:
    """A C function: its head, a formula of values at places (those without a place are in the head), its results in an array."""
    values = [f"const double {name} = {places[name]};" for name in formula.arguments if name in places]
    lines = [f"const double {line.name} = {line.text(number)};" for line in formula.lines]
    results = [each if isinstance(each, str) else number(each) for each in formula.results]
    body = [*values, *lines, *(f"{target}[{i}] = {each};" for i, each in enumerate(results))]
    return "\n".join([f"void {head} {{", *(f"  {line}" for line in body), "}"])


def loaded(functions: Sequence[str]) -> Plugin:
    """Compile functions and load the library; whoever stops this process leaves no file behind."""
    with TemporaryDirectory() as folder:
        source, library = Path(folder, "plugin.c"), Path(folder, "plugin.so")
        source.write_text("\n\n".join(["#include <math.h>", *functions]) + "\n")
        compiler = os.environ.get("CC", "cc")
        subprocess.run([compiler, "-O2", "-fPIC", "-shared", source, "-o", library, "-lm"], check=True)
        return Plugin(str(library.with_suffix("")), ctypes.CDLL(str(library)))
