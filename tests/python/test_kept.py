"""Files and pickles that version 0.2.0 wrote, kept beside this file, come back as they were (made by `kept/make.py`)."""

import importlib.util
import json
import pickle
from pathlib import Path

import pytest

import vibroimpact as vi

KEPT = Path(__file__).parent / "kept"
FOLDER = KEPT / "0.2.0"
EXPECTED = json.loads((FOLDER / "expected.json").read_text())
FILES = sorted(path.stem for path in FOLDER.glob("*.npz"))

_spec = importlib.util.spec_from_file_location("kept_make", KEPT / "make.py")
make = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(make)


def unlike(thing, expected):
    """The places in which a thing is not as it was described; what a field of a later version says is nothing of an older one."""
    if isinstance(thing, dict) and isinstance(expected, dict):
        missing = [name for name in expected if name not in thing]
        return missing + [f"{name}.{more}" for name in expected if name in thing for more in unlike(thing[name], expected[name])]
    if isinstance(thing, list) and isinstance(expected, list) and len(thing) == len(expected):
        return [f"{k}.{more}" for k, pair in enumerate(zip(thing, expected, strict=True)) for more in unlike(*pair)]
    return [] if thing == expected else [f"{thing!r}, not {expected!r}"]


@pytest.mark.parametrize("name", EXPECTED)
def test_a_pickle_is_what_it_was(name):
    thing = pickle.loads((FOLDER / f"{name}.pickle").read_bytes())
    assert unlike(make.described(thing), EXPECTED[name]) == []


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_what_it_was(name):
    assert unlike(make.described(vi.load(FOLDER / f"{name}.npz")), EXPECTED[name]) == []


@pytest.mark.parametrize("name", FILES)
def test_what_was_kept_is_written_as_it_was(name, tmp_path):
    thing = vi.load(FOLDER / f"{name}.npz")
    thing.save(tmp_path / "again.npz")
    assert unlike(make.described(vi.load(tmp_path / "again.npz")), EXPECTED[name]) == []
    assert unlike(make.described(pickle.loads(pickle.dumps(thing))), EXPECTED[name]) == []


def test_a_changed_number_is_seen():
    described = json.loads(json.dumps(EXPECTED["Branch"]))
    described["fields"]["parameter"]["digest"] = "0" * 16
    assert unlike(described, EXPECTED["Branch"])
