"""Examples run as they stand: in every public docstring, and the six lines that the project promises."""

import doctest
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

import matplotlib.pyplot as plt

import vibroimpact as vi

SIX_LINES = """
import vibroimpact as vi
scene = vi.paper_scene(kind=3)                                 # the paper's third case: pendulum, base motion, two stops
orbits = vi.periodic_orbits(scene, pattern=[1], n_periods=2)   # the lower pendulum hits once in two forcing periods
print(orbits[0])                                               # phase, contact state, admissible?, stable?, multipliers
ax = vi.plot.phase_portrait(orbits[0])
ax.figure.savefig("orbit.png")
"""

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = (README, ROOT / "docs" / "features.md")
BLOCKS = [block for page in PAGES for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)]

PLAIN = {"KINDS", "__version__", "plot"}  # data and a module: no docstring of their own


def public_objects():
    """Every public object, its methods and properties, by name."""
    found = {}
    for module, name_of_module in ((vi, "vi"), (vi.plot, "vi.plot")):
        for name in module.__all__:
            value = getattr(module, name)
            if name in PLAIN:
                continue
            found[f"{name_of_module}.{name}"] = value
            if isinstance(value, type):
                for member, entry in vars(value).items():
                    if not member.startswith("_"):
                        found[f"{name_of_module}.{name}.{member}"] = entry
    return found


OBJECTS = public_objects()
EXAMPLES = {name: value for name, value in OBJECTS.items() if ">>>" in (value.__doc__ or "")}
if not hasattr(vi, "existence_map"):  # its picture needs it
    EXAMPLES.pop("vi.plot.existence_map")


@pytest.mark.parametrize("name", OBJECTS)
def test_has_a_docstring(name):
    text = OBJECTS[name].__doc__
    assert text
    assert text.strip().splitlines()[0].endswith((".", ":", "?")) or name.count(".") > 1, "the first line is a sentence"


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_of_docstrings(name):
    text = textwrap.dedent("    " + OBJECTS[name].__doc__) if OBJECTS[name].__doc__.startswith(" ") else OBJECTS[name].__doc__
    test = doctest.DocTestParser().get_doctest(text, {}, name, name, 0)
    report = []
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE, verbose=False)
    with np.printoptions(legacy=False):
        runner.run(test, out=report.append)
    plt.close("all")
    assert runner.tries > 0
    assert runner.failures == 0, "".join(report)


@pytest.mark.parametrize("name", [name for name in OBJECTS if not name.startswith("vi.plot.")])
def test_sections_are_those_of_numpydoc(name):
    """Names, types and exceptions stand bare; code in the text has two backticks."""
    text = OBJECTS[name].__doc__
    assert "`" not in re.sub(r"``[^`]+``|\[\d+\]_", "", text)


def test_the_important_functions_have_examples():
    for name in (
        "LinearSystem",
        "Scene",
        "Stop",
        "modes",
        "recovery_matrix",
        "audit_recovery",
        "periodic_orbits",
        "simulate",
    ):
        assert f"vi.{name}" in EXAMPLES


def test_the_six_lines(tmp_path):
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", SIX_LINES],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    for word in ("phase", "contact state", "admissible", "stable", "multipliers"):
        assert word in run.stdout
    assert (tmp_path / "orbit.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("code", BLOCKS, ids=range(1, len(BLOCKS) + 1))
def test_the_readme_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    plt.close("all")


def test_numpy_alone_is_enough_to_import(tmp_path):
    code = (
        "import sys, vibroimpact as vi\n"
        "vi.periodic_orbits(vi.paper_scene(kind=3), [1], 2)\n"
        "assert not {'matplotlib', 'scipy', 'tqdm'} & set(sys.modules), 'too much imported'\n"
        "assert 'plot' in dir(vi)\n"
        "vi.plot\n"
        "assert 'matplotlib' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], cwd=tmp_path, timeout=60, check=True)


def test_all_names_exist():
    assert sorted(vi.__all__) == sorted(set(vi.__all__))
    for name in vi.__all__:
        assert hasattr(vi, name)
        assert name in dir(vi)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        vi.nothing  # noqa: B018
    assert vi.__version__.count(".") == 2


def test_classes_say_where_they_live():
    for name, value in OBJECTS.items():
        if isinstance(value, type):
            assert value.__module__.startswith("vibroimpact")
            assert getattr(vi, value.__name__) is value, name
