"""Stores: what was broken off is gone on with, to the same bits; another call, a full disk, a store that vanishes are told."""

import errno
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import vibroimpact as vi
from vibroimpact.analysis import basins
from vibroimpact.run import store as stores
from vibroimpact.run import stored_arguments

zarr = pytest.importorskip("zarr")

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
PLANE = {"q": (-3.0, 1.5, 24), "v": (-5.0, 5.0, 18), "box": [(-3.0, 1.5), (-5.0, 5.0)], "max_periods": 400}
PAPER = vi.paper_scene(3)
MAP = (PAPER, [1], ("frequency", np.linspace(1.0, 2.0, 13)), ("clearance", np.linspace(0.05, 0.3, 11)), 2)


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    """Chunks of a few cells, as large planes have many of many."""
    monkeypatch.setattr(stores, "_CELLS", 60)


@pytest.fixture(scope="module")
def whole():
    return vi.basins(SCENE, **PLANE)


def equal(one, other):
    """Whether two results have the same bits."""
    names = one.to_arrays()
    return type(one) is type(other) and all(np.array_equal(names[k], other.to_arrays()[k], equal_nan=True) for k in names)


def chunks(path, name="labels"):
    return sorted(file for file in (Path(path) / name / "c").rglob("*") if file.is_file())


def test_a_store_holds_what_the_call_returns(whole, tmp_path):
    path = tmp_path / "basins.zarr"
    made = vi.basins(SCENE, **PLANE, store=path)
    assert equal(made, whole)
    again = vi.load(path)
    assert equal(again, whole)
    assert (again.x_name, again.y_name) == (whole.x_name, whole.y_name)
    assert again.attractors.scene == SCENE
    for kept, one in zip(again.attractors, whole.attractors, strict=True):
        assert np.array_equal(kept.points, one.points)
        assert np.array_equal(kept.orbit.q0, one.orbit.q0)
        assert (kept.kind, kept.pattern, kept.fraction) == (one.kind, one.pattern, one.fraction)
    assert len(chunks(path)) > 3


def test_other_programs_read_a_store(whole, tmp_path):
    path = tmp_path / "basins.zarr"
    vi.basins(SCENE, **PLANE, store=str(path))
    xarray = pytest.importorskip("xarray")
    with xarray.open_zarr(path, consolidated=False) as data:
        assert data["labels"].dims == ("y", "x")
        assert np.array_equal(data["labels"], whole.labels)
        assert np.array_equal(data["x"], whole.x)


def test_a_map_is_kept_too(tmp_path):
    path = tmp_path / "map.zarr"
    plain = vi.existence_map(*MAP)
    with ThreadPoolExecutor(3) as pool:
        assert equal(vi.existence_map(*MAP, store=path, workers=pool), plain)
    assert equal(vi.load(path), plain)
    assert (vi.load(path).x_name, vi.load(path).y_name) == ("frequency", "clearance")


def test_what_is_missing_is_worked_out_and_nothing_else(whole, tmp_path, monkeypatch):
    path = tmp_path / "basins.zarr"
    vi.basins(SCENE, **PLANE, store=path)
    gone = chunks(path)[1:3]
    for file in gone:
        file.unlink()
    part = vi.load(path)
    assert (part.labels == -3).sum() == 2 * 48
    assert "96 not worked out yet" in repr(part)
    assert part.fractions.sum() == pytest.approx(1.0)
    kept = {file: file.stat().st_mtime_ns for file in chunks(path)}

    def refused(*arguments, **options):
        raise AssertionError("the attractors are in the store")

    monkeypatch.setattr(basins, "find_attractors", refused)
    assert equal(vi.basins(SCENE, **PLANE, store=path), whole)
    assert all(file.stat().st_mtime_ns == time for file, time in kept.items())


def test_another_call_is_refused_unless_it_may_replace(tmp_path):
    path = tmp_path / "basins.zarr"
    vi.basins(SCENE, **PLANE, store=path)
    with pytest.raises(
        ValueError, match=r"basins.zarr.*another max_periods, 400, not 401 \(max_periods=400 goes on with it\): overwrite=True"
    ):
        vi.basins(SCENE, **{**PLANE, "max_periods": 401}, store=path)
    with pytest.raises(ValueError, match="another scene"):
        vi.basins(SCENE.replace(restitution=0.7), **PLANE, store=path)
    with pytest.raises(ValueError, match="another plane"):
        vi.basins(SCENE, **{**PLANE, "v": (-5.0, 4.0, 18)}, store=path)
    with pytest.raises(ValueError, match="its type is 'Basins', not 'ExistenceMap'"):
        vi.existence_map(*MAP, store=path)
    assert equal(vi.existence_map(*MAP, store=path, overwrite=True), vi.load(path))
    # The same call goes on, whatever it may replace.
    kept = {file: file.stat().st_mtime_ns for file in chunks(path, "n_orbits")}
    vi.existence_map(*MAP, store=path, overwrite=True)
    assert {file: file.stat().st_mtime_ns for file in chunks(path, "n_orbits")} == kept


def test_what_is_no_store_is_left_alone(tmp_path):
    file = tmp_path / "file.zarr"
    file.write_text("mine")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "mine.txt").write_text("mine")
    zarr.create_group(tmp_path / "group.zarr", attributes={"mine": 1})
    for path, reason in [
        (file, "is a file: a folder is needed"),
        (folder, "has something else"),
        (tmp_path / "group.zarr", "group of zarr"),
    ]:
        for overwrite in (False, True):
            with pytest.raises(ValueError, match=reason):
                vi.existence_map(*MAP, store=path, overwrite=overwrite)
    assert (file.read_text(), (folder / "mine.txt").read_text()) == ("mine", "mine")
    with pytest.raises(ValueError, match="no result of vibroimpact"):
        vi.load(folder)
    with pytest.raises(ValueError, match="no result of vibroimpact"):
        vi.load(tmp_path / "group.zarr")


def test_a_wrong_call_leaves_no_store(tmp_path):
    path = tmp_path / "basins.zarr"
    for wrong in ({"max_periods": -1}, {"method": "none"}, {"rtol": -1.0}, {"hits": 0}, {"box": [(0, 1)]}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            vi.basins(SCENE, **(PLANE | wrong), store=path)
    with pytest.raises(ValueError, match="frequency"):
        vi.existence_map(PAPER, [1], ("frequency", [1.0, -1.0]), ("clearance", [0.1]), 2, store=path)
    assert not path.exists()


def test_a_store_from_the_future_is_refused(tmp_path):
    path = tmp_path / "map.zarr"
    vi.existence_map(*MAP, store=path)
    header = json.loads((path / "zarr.json").read_text())
    header["attributes"]["vibroimpact"]["format"] = 99
    (path / "zarr.json").write_text(json.dumps(header))
    with pytest.raises(ValueError, match="its format is 99"):
        vi.existence_map(*MAP, store=path)
    header["attributes"]["vibroimpact"] |= {"format": 1, "version": "99"}
    (path / "zarr.json").write_text(json.dumps(header))
    with pytest.raises(ValueError, match="its version is '99'"):
        vi.existence_map(*MAP, store=path)
    header["attributes"]["vibroimpact"]["format"] = 99
    (path / "zarr.json").write_text(json.dumps(header))
    with pytest.raises(ValueError, match="format 99 is newer"):
        vi.load(path)


class Counted:
    """Makes scenes, and may fail at one."""

    def __init__(self, fails_at=0):
        self.count, self.fails_at = 0, fails_at

    def __call__(self, x, y):
        self.count += 1
        if self.count == self.fails_at:
            raise ZeroDivisionError
        return PAPER.replace(frequency=x, clearance=y)

    def __reduce__(self):
        return Counted, ()


def test_what_was_done_before_a_failure_is_kept(tmp_path):
    path = tmp_path / "map.zarr"
    axes = MAP[2][1], MAP[3][1]
    with pytest.raises(ZeroDivisionError):
        vi.existence_map(Counted(fails_at=100), [1], *axes, 2, store=path)
    part = vi.load(path)
    assert part.x_name is None
    assert 0 < (part.n_orbits >= 0).sum() < 100
    rest = Counted()
    made = vi.existence_map(rest, [1], *axes, 2, store=path)
    assert rest.count == (part.n_orbits < 0).sum()
    assert equal(made, vi.existence_map(Counted(), [1], *axes, 2))


def test_scenes_of_functions_are_told_apart_by_their_code(tmp_path):
    path = tmp_path / "basins.zarr"

    def scene(scale):
        def scaled(t, q, v):
            return scale * q - q**3 - 0.25 * v

        return vi.Scene(vi.NonlinearSystem(1, scaled, mass=1.0), vi.Harmonic([0.05], 1.0), vi.Stop(0, 3.0, 0.8))

    call = {"q": (-1.5, 1.5, 4), "v": (-1.0, 1.0, 3), "max_periods": 3, "attractors": (), "store": path}
    made = vi.basins(scene(1.0), **call)
    assert equal(vi.basins(scene(1.0), **call), made)
    with pytest.raises(ValueError, match="another scene"):
        vi.basins(scene(1.5), **call)
    with pytest.raises(ValueError, match=r"made of functions.*the same call of basins opens it"):
        vi.load(path)


MADE_BY = """
import functools
import vibroimpact as vi
E = 0.8
def helper(x, y):
    return vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([x], 2.4), vi.Stop(0, y, E))
class Make:
    def __call__(self, x, y):
        return helper(x, y)
made = Make()
partial = functools.partial(Make())
def plain(x, y):
    return helper(x, y)
@functools.lru_cache(None)
def cached(x, y):
    return helper(x, y)
"""


def edited(**values):
    """A module whose callables make scenes, with other values in its text."""
    module = ModuleType("made_by")
    sys.modules["made_by"] = module
    text = MADE_BY
    for name, value in values.items():
        text = text.replace(f"{name} = 0.8", f"{name} = {value}")
    exec(text, vars(module))
    return module


AXES = [0], np.linspace(4.0, 9.0, 3), np.linspace(0.5, 1.5, 3)


@pytest.mark.parametrize("name", ["made", "partial", "plain", "cached"])
def test_cells_are_of_one_code(name, tmp_path):
    path = tmp_path / "map.zarr"
    first = vi.existence_map(getattr(edited(), name), *AXES, store=path)
    assert equal(vi.existence_map(getattr(edited(), name), *AXES, store=path), first)
    with pytest.raises(ValueError, match=r"another scene: made_by.E changed"):
        vi.existence_map(getattr(edited(E=0.3), name), *AXES, store=path)
    other = vi.existence_map(getattr(edited(E=0.3), name), *AXES, store=path, overwrite=True)
    assert equal(other, vi.existence_map(getattr(edited(E=0.3), name), *AXES))
    assert not equal(other, first)


def as_of_0_2_0(path, arguments):
    """Let a store know its callables by their own code alone, as those of version 0.2.0 do."""
    told = {name: stored_arguments.encode(name, value, stored_arguments.OwnCode()) for name, value in arguments.items()}
    header = json.loads((path / "zarr.json").read_text())
    header["attributes"]["vibroimpact"] = stores._made("ExistenceMap", told)
    (path / "zarr.json").write_text(json.dumps(header))


@pytest.mark.parametrize("name", ["made", "partial", "plain", "cached"])
def test_stores_of_0_2_0_go_on_where_they_knew_the_code(name, tmp_path):
    path = tmp_path / "map.zarr"
    pattern, x, y = AXES
    make = getattr(edited(), name)
    whole = vi.existence_map(make, *AXES, store=path)
    as_of_0_2_0(path, {"scene": make, "pattern": pattern, "x": (None, x), "y": (None, y), "n_periods": 1})
    if name != "plain":
        with pytest.raises(ValueError, match="did not look through all code: that of scene is another, or it did not see it"):
            vi.existence_map(make, *AXES, store=path)
        return
    with pytest.raises(ValueError, match="did not look through all code"):
        vi.existence_map(lambda x, y: make(x, y), *AXES, store=path)
    with pytest.warns(UserWarning, match="told functions by their own code alone"):
        assert equal(vi.existence_map(make, *AXES, store=path), whole)
    # From now on it knows the rest too.
    assert equal(vi.existence_map(make, *AXES, store=path), whole)
    with pytest.raises(ValueError, match=r"another scene: made_by.E changed"):
        vi.existence_map(edited(E=0.3).plain, *AXES, store=path)


def test_stores_of_0_2_0_go_on_in_later_versions(tmp_path, monkeypatch):
    path = tmp_path / "basins.zarr"
    whole = vi.basins(SCENE, **PLANE, store=path)
    header = json.loads((path / "zarr.json").read_text())
    header["attributes"]["vibroimpact"]["version"] = "0.2.0"
    (path / "zarr.json").write_text(json.dumps(header))
    monkeypatch.setattr(stores._core, "__version__", "0.3.0")
    chunks(path)[0].unlink()
    assert equal(vi.basins(SCENE, **PLANE, store=path), whole)


def test_stores_of_the_default_of_0_2_0_name_it_and_go_on_with_it(tmp_path):
    """Cells of 1e-12 and of a part of how far the motion goes are not the same: one is asked for by its number."""
    path = tmp_path / "basins.zarr"
    made = vi.basins(SCENE, **PLANE, atol=1e-12, store=path)
    named = r"another atol, 1e-12, not None \(1e-12 was the default of atol up to version 0.2.0.*; atol=1e-12 goes on with it\)"
    with pytest.raises(ValueError, match=named):
        vi.basins(SCENE, **PLANE, store=path)
    with pytest.raises(
        ValueError, match=r"another max_periods, 400, not 401, another atol, 1e-12, not None .*max_periods=400, atol=1e-12"
    ):
        vi.basins(SCENE, **{**PLANE, "max_periods": 401}, store=path)
    with pytest.raises(ValueError, match=r"another atol, 1e-12, not 1e-09 \(atol=1e-12 goes on with it\)"):
        vi.basins(SCENE, **PLANE, atol=1e-9, store=path)
    chunks(path)[0].unlink()
    assert equal(vi.basins(SCENE, **PLANE, atol=1e-12, store=path), made)


def restoring(t, q, v):
    return -q - 0.1 * v


def test_stores_of_0_2_0_of_functions_name_the_default_too(tmp_path):
    """The code is the same and so told then: what differs is the number, not the scene."""
    path = tmp_path / "basins.zarr"
    scene = vi.Scene(vi.NonlinearSystem(1, restoring, mass=1.0), vi.Harmonic([0.05], 1.0), vi.Stop(0, 3.0, 0.8))
    call = {"q": (-1.5, 1.5, 4), "v": (-1.0, 1.0, 3), "max_periods": 3, "attractors": (), "store": path}
    made = vi.basins(scene, **call, atol=1e-12)
    header = json.loads((path / "zarr.json").read_text())
    arguments = header["attributes"]["vibroimpact"]["arguments"]
    arguments["scene"] = stored_arguments.encode("scene", scene, stored_arguments.OwnCode())
    header["attributes"]["vibroimpact"] = stores._made("Basins", arguments)
    (path / "zarr.json").write_text(json.dumps(header))
    with pytest.raises(ValueError, match=r"another atol, 1e-12, not None \(1e-12 was the default .*atol=1e-12 goes on with it"):
        vi.basins(scene, **call)
    with pytest.warns(UserWarning, match="told functions by their own code alone"):
        assert equal(vi.basins(scene, **call, atol=1e-12), made)


def test_a_key_stands_for_code_that_cannot_be_looked_through(tmp_path):
    path = tmp_path / "map.zarr"
    lock = threading.Lock()

    def make(x, y):
        with lock:
            return edited().plain(x, y)

    with pytest.raises(ValueError, match=r"scene: .*make: .*lock.* cannot be told from others.*key="):
        vi.existence_map(make, *AXES, store=path)
    assert not path.exists()
    made = vi.existence_map(make, *AXES, store=path, key="mine, 1")
    assert equal(vi.existence_map(make, *AXES, store=path, key="mine, 1"), made)
    with pytest.raises(ValueError, match="another key"):
        vi.existence_map(make, *AXES, store=path, key="mine, 2")
    with pytest.raises(TypeError, match="key is 3, but a text is needed"):
        vi.existence_map(make, *AXES, store=path, key=3)
    scene = vi.Scene(
        vi.NonlinearSystem(1, lambda t, q, v, lock=lock: -q, mass=1.0), vi.Harmonic([0.05], 1.0), vi.Stop(0, 3.0, 0.8)
    )
    call = {"q": (-1.5, 1.5, 4), "v": (-1.0, 1.0, 3), "max_periods": 3, "attractors": (), "store": tmp_path / "basins.zarr"}
    with pytest.raises(ValueError, match=r"scene, .*lock.* cannot be told from others.*key="):
        vi.basins(scene, **call)
    assert equal(vi.basins(scene, **call, key="one"), vi.basins(scene, **call, key="one"))
    with pytest.raises(ValueError, match="another key"):
        vi.basins(scene, **call, key="two")


KILLED = """
import sys
import vibroimpact as vi
from vibroimpact.run import store

store._CELLS = 60
scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
plane = {"q": (-3.0, 1.5, 240), "v": (-5.0, 5.0, 18), "box": [(-3.0, 1.5), (-5.0, 5.0)], "max_periods": 400}
vi.basins(scene, **plane, store=sys.argv[1], rtol=1e-9, workers=1)
"""


def test_a_run_that_is_killed_is_gone_on_with(tmp_path):
    path, script = tmp_path / "basins.zarr", tmp_path / "killed.py"
    script.write_text(KILLED)
    plain = vi.basins(SCENE, **{**PLANE, "q": (-3.0, 1.5, 240)})
    rng = np.random.default_rng(7)
    kills = 0
    before = 0
    while kills < 10:
        process = subprocess.Popen([sys.executable, script, path])
        until = time.monotonic() + 60
        while process.poll() is None and time.monotonic() < until and len(chunks(path)) <= before:
            time.sleep(0.001)
        time.sleep(rng.uniform(0, 0.05))
        process.send_signal(signal.SIGKILL)
        process.wait()
        kills += 1
        done = len(chunks(path))
        # A file that was being written may lie beside the 72.
        assert done > before or done >= 72
        part = vi.load(path)
        known = part.labels != -3
        assert np.array_equal(part.labels[known], plain.labels[known])
        assert np.array_equal(part.iterations[known], plain.iterations[known])
        before = done
    assert subprocess.run([sys.executable, script, path]).returncode == 0
    assert equal(vi.load(path), plain)


class Interrupted(Counted):
    """Makes scenes, and is broken off at the 70th as by Ctrl-C."""

    def __init__(self, workers):
        super().__init__()
        self.workers = workers

    def __call__(self, x, y):
        made = super().__call__(x, y)
        if self.count == 70:
            signal.raise_signal(signal.SIGINT) if self.workers == "threads" else os.kill(os.getpid(), signal.SIGINT)
        return made

    def __reduce__(self):
        return Interrupted, (self.workers,)


@pytest.mark.parametrize("workers", ["threads", "pool"])
def test_an_interruption_leaves_a_store_to_go_on_with(workers, tmp_path):
    path = tmp_path / "map.zarr"
    axes = MAP[2][1], MAP[3][1]
    make = Interrupted(workers)
    with ThreadPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt):
        vi.existence_map(make, [1], *axes, 2, store=path, workers=pool if workers == "pool" else 1)
    assert (vi.load(path).n_orbits < 0).any()
    made = vi.existence_map(make, [1], *axes, 2, store=path)
    assert equal(made, vi.existence_map(make, [1], *axes, 2))


def test_two_processes_fill_one_store(tmp_path):
    path, script = tmp_path / "basins.zarr", tmp_path / "killed.py"
    script.write_text(KILLED)
    both = [subprocess.Popen([sys.executable, script, path]) for _ in range(2)]
    assert [process.wait() for process in both] == [0, 0]
    assert equal(vi.load(path), vi.basins(SCENE, **{**PLANE, "q": (-3.0, 1.5, 240)}))


def test_a_full_disk_is_told(tmp_path):
    path = tmp_path / "map.zarr"
    vi.existence_map(*MAP, store=path)
    first, *others = chunks(path, "n_orbits")
    for file in others:
        file.unlink()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1, hard))
    try:
        with pytest.raises(OSError, match=r"store .*map.zarr.*what it had before is kept") as told:
            vi.existence_map(*MAP, store=path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert told.value.errno == errno.EFBIG
    assert chunks(path, "n_orbits") == [first]
    assert equal(vi.existence_map(*MAP, store=path), vi.existence_map(*MAP))


def test_a_store_that_vanishes_is_told(tmp_path):
    path = tmp_path / "map.zarr"

    def make(x, y):
        if make.count == 80:
            shutil.rmtree(path)
        make.count += 1
        return PAPER.replace(frequency=x, clearance=y)

    make.count = 0
    with pytest.raises(OSError, match=r"store .*map.zarr.*not there any more"):
        vi.existence_map(make, [1], MAP[2][1], MAP[3][1], 2, store=path)
    assert not (path / "n_orbits").exists()


def test_a_store_of_zarr_is_taken(tmp_path):
    store = zarr.storage.MemoryStore()
    plain = vi.existence_map(*MAP)
    assert equal(vi.existence_map(*MAP, store=store), plain)
    assert equal(vi.existence_map(*MAP, store=store), plain)


def test_an_install_without_zarr_says_what_it_needs(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(ImportError, match=r"vibroimpact\[store\]"):
        vi.existence_map(*MAP, store=tmp_path / "map.zarr")


def test_the_library_imports_no_engine():
    code = "import sys, vibroimpact; print([m for m in ('zarr', 'dask', 'distributed', 'mpi4py', 'joblib') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"


def bytes_changed(rng, whole, k):
    """Bytes with some bits flipped, every fourth time cut."""
    changed = bytearray(whole)
    if k % 4 == 3:
        del changed[int(rng.integers(len(whole))) :]
    else:
        for place in rng.integers(len(whole), size=1 + k % 2):
            changed[place] ^= 1 << int(rng.integers(8))
    return bytes(changed)


@pytest.mark.parametrize("kind", ["Basins", "ExistenceMap"])
def test_bytes_that_are_not_those_that_were_written(kind, whole, tmp_path):
    """What a store holds is read as it was, but for cells that are not there any more, or refused; the same call goes on."""
    path = tmp_path / "store.zarr"

    def call():
        return vi.basins(SCENE, **PLANE, store=path) if kind == "Basins" else vi.existence_map(*MAP, store=path)

    made = call()
    last, is_open = ("labels", -3) if kind == "Basins" else ("n_orbits", -1)
    rng = np.random.default_rng(3)
    refused = 0
    files = sorted(file for file in path.rglob("*") if file.is_file())
    for file in files:
        kept = file.read_bytes()
        for k in range(24 if file.name == "zarr.json" else 8):
            file.write_bytes(bytes_changed(rng, kept, k))
            try:
                found = vi.load(path)
            except ValueError as error:
                refused += 1
                assert "path is" in str(error)  # noqa: PT017
            else:
                there = getattr(found, last) != is_open
                for name, array in found.to_arrays().items():
                    own = np.ones(array.shape, bool) if array.ndim == 1 else there
                    assert np.array_equal(array[own], made.to_arrays()[name][own], equal_nan=True)
            file.write_bytes(kept)
    assert refused > len(files)


@pytest.mark.parametrize("kind", ["Basins", "ExistenceMap"])
def test_chunks_that_were_cut_are_worked_out_again(kind, tmp_path):
    path = tmp_path / "store.zarr"

    def call():
        return vi.basins(SCENE, **PLANE, store=path) if kind == "Basins" else vi.existence_map(*MAP, store=path)

    made = call()
    for name in made.to_arrays():
        for k, file in enumerate(chunks(path, name)[1:4] if name not in ("x", "y") else []):
            kept = file.read_bytes()
            flipped = bytearray(kept)
            flipped[len(kept) // 2] ^= 4
            file.write_bytes(kept[: len(kept) // 2] if k % 2 else flipped)
            with pytest.raises(ValueError, match="it was changed or cut"):
                vi.load(path)
            assert equal(call(), made)
            assert equal(vi.load(path), made)


def test_attractors_in_a_store_that_were_changed_are_refused(tmp_path):
    path = tmp_path / "basins.zarr"
    vi.basins(SCENE, **PLANE, store=path)
    header = json.loads((path / "zarr.json").read_text())
    text = json.dumps(header["attributes"]["attractors"]["value"])
    assert '"periodic"' in text
    header["attributes"]["attractors"]["value"] = json.loads(text.replace('"periodic"', '"chaotic"'))
    (path / "zarr.json").write_text(json.dumps(header))
    with pytest.raises(ValueError, match="it was changed"):
        vi.load(path)
    with pytest.raises(ValueError, match="its attractors were changed or cut"):
        vi.basins(SCENE, **PLANE, store=path)
