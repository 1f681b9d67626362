"""Results in files and as labelled arrays: what goes out comes back, to the bit, and nothing else comes in."""

import contextlib
import io
import json
import math
import pickle
import sys
import zipfile

import numpy as np
import pytest
from test_saved import OBJECTS, pieces

import vibroimpact as vi

RESULTS = {name: thing for name, thing in OBJECTS.items() if hasattr(thing, "save") and name != "Trajectory, functions"}
RUN = OBJECTS["Trajectory, exact"]


def same(one, other):
    """Equal to the bit, with the same types, all the way down."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, float):
        return (one == other and math.copysign(1, one) == math.copysign(1, other)) or (math.isnan(one) and math.isnan(other))
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return same(list(one.items()), list(other.items()))
    if one is None or isinstance(one, (str, int)):
        return one == other
    return same(pieces(one)[1], pieces(other)[1])


def saved(tmp_path, thing=RUN):
    path = tmp_path / "result.npz"
    thing.save(path)
    return path


def entries(path):
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    return json.loads(str(arrays.pop("header"))), arrays


def rewritten(path, header, arrays):
    with path.open("wb") as file:
        np.savez(file, header=np.array(json.dumps(header)), **arrays)
    return path


class TestSaveAndLoad:
    @pytest.mark.parametrize("name", RESULTS)
    def test_what_was_saved_comes_back_to_the_bit(self, name, tmp_path):
        thing = RESULTS[name]
        path = saved(tmp_path, thing)
        again = vi.load(path)
        assert same(thing, again)
        assert repr(again) == repr(thing)
        assert list(tmp_path.iterdir()) == [path]
        if hasattr(thing, "to_arrays"):
            assert same(thing.to_arrays(), again.to_arrays())

    def test_a_motion_is_as_it_was_between_its_rows_too(self, tmp_path):
        for name in ("exact", "held", "series", "steps", "long steps", "implicit steps"):
            run = OBJECTS[f"Trajectory, {name}"]
            again = vi.load(saved(tmp_path, run))
            t = np.linspace(0, 12, 97)
            assert same(run.velocity(t), again.velocity(t))
            assert same(run.acceleration(t), again.acceleration(t))
            assert run.impulse(0) == again.impulse(0)
            assert again.scene == run.scene

    def test_every_kind_of_scene_comes_back(self, tmp_path):
        ring = vi.Fourier([[1.0 + 2.0j], [0.1]], 1.3, 0.2, mean=[0.4])
        chain = vi.PendulumChain([1.0, 0.5], [0.5, 0.3], damping=0.02)
        tones = [vi.Harmonic([1.0], 1.5), vi.Fourier([[0.2], [0.1j]], 1.5 * math.sqrt(2.0), mean=[0.1])]
        record = [vi.Load(0, ([0.0, 0.7, 3.0], [0.0, 1 / 3, 0.2])), vi.Load([1.0], vi.Signal.from_function(np.sin, (0.0, 3.0)))]
        moving = [
            vi.Stop(0, 0.3, 0.5, motion=vi.Harmonic([0.1 + 0.02j], 1.3)),
            vi.Stop(0, 0.2, 0.5, side="lower", motion=vi.Fourier([0.01, 0.02j], 1.3, 0.1)),
            vi.Stop(0, 0.6, 0.5, motion=vi.Signal.from_function(lambda t: 0.01 * np.sin(t), (0.0, 3.0))),
        ]
        shaken = vi.LinearSystem(1.0, 0.1, 1.0, influence=[1.0])
        dense = vi.LinearSystem([[2.0, 0.5], [0.5, 1.0]], 0.1 * np.eye(2), np.eye(2), load=[0.1, -0.0], influence=[1.0, 1.0])
        for scene in (
            vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), ring, vi.Stop(0, 0.3, 0.5)),
            vi.Scene(
                chain, vi.BaseMotion(0.03, 5.0), [vi.Wall(1, 0.12, 0.7), vi.Stop([1.0, 0.5], 0.4, 0.2, reaction=[1.0, 0.3])]
            ),
            vi.Scene(dense, vi.BaseMotion(0.1, 1 / 3), vi.Stop([0.1, 0.7], 0.05, 0.9, side="lower", reaction="coordinate")),
            vi.Scene(vi.DoublePendulum(1.0, 3.2, (0.1, 0.2)), vi.Harmonic([0.1, 0.2j], 0.7)),
            vi.Scene(dense),
            vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), tones, vi.Stop(0, 0.3, 0.5)),
            vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), record, moving),
            vi.Scene(shaken, vi.BaseMotion([0.1, 0.02j], 1.1), vi.Stop(0, 0.3, 0.5)),
            vi.Scene(shaken, [vi.BaseAcceleration(([0.0, 1.0, 2.0], [0.1, 0.2, 0.0])), vi.Harmonic([1.0], 2.0)]),
            vi.Scene(chain, vi.BaseMotion(0.03, 5.0), vi.Wall(1, 0.12, 0.7, motion=vi.Harmonic([0.01], 5.0))),
        ):
            n = scene.n_dof
            run = vi.simulate(scene, np.full(n, -1e-3 / 3), np.full(n, 0.01), (0.1, 1.7))
            again = vi.load(saved(tmp_path, run))
            assert again.scene == scene
            assert same(scene, again.scene)
            assert same(run, again)

    def test_the_header_says_what_it_is(self, tmp_path):
        header, arrays = entries(saved(tmp_path))
        assert (header["format"], header["version"], header["type"]) == (1, vi.__version__, "Trajectory")
        assert header["scene"]["type"] == "Scene"
        assert all(array.dtype.kind in "biufcU" for array in arrays.values())
        with zipfile.ZipFile(saved(tmp_path)) as archive:
            assert b"pickle" not in b"".join(archive.read(name) for name in archive.namelist())
        # Numbers of the motion are arrays: the header of a long run is short.
        long = vi.simulate(RUN.scene, [0, 0], [0, 0.1], (0, 2000), keep="impacts")
        header, arrays = entries(saved(tmp_path, long))
        assert len(json.dumps(header)) < 5000
        assert sum(array.size for array in arrays.values()) > 6 * len(long.impacts)

    def test_the_file_has_the_name_that_it_is_given(self, tmp_path):
        RUN.save(str(tmp_path / "a run"))
        assert same(RUN, vi.load(str(tmp_path / "a run")))
        RUN.save(tmp_path / "a run")  # once more
        assert [path.name for path in tmp_path.iterdir()] == ["a run"]

    def test_a_file_is_written_whole_or_not_at_all(self, tmp_path, monkeypatch):
        path = saved(tmp_path)

        def full(file, **arrays):
            file.write(b"PK")
            raise OSError("no space left")

        monkeypatch.setattr(np, "savez", full)
        with pytest.raises(OSError, match="no space left"):
            OBJECTS["Trajectory, held"].save(path)
        monkeypatch.undo()
        assert list(tmp_path.iterdir()) == [path]
        assert same(RUN, vi.load(path))

    def test_numbers_that_json_does_not_have_come_back(self, tmp_path):
        found = vi.existence_map(OBJECTS["Scene"], [1], ("frequency", [1.5]), ("clearance", [0.15, 10.0]), 2)
        assert np.isnan(found.multiplier).any()
        assert same(found, vi.load(saved(tmp_path, found)))
        run = vi.simulate(OBJECTS["Scene"].replace(forcing=None), [0.1, 0], [0, 0.1], (0, 3))
        assert same(run, vi.load(saved(tmp_path, run)))

    def test_a_run_goes_on_from_a_file(self, tmp_path):
        first = vi.load(saved(tmp_path))
        ends = [vi.simulate(run.scene, *run.final, (run.t_end, 20)).final for run in (first, RUN)]
        assert same(ends[0], ends[1])


class TestRefusals:
    def test_functions_are_refused_and_nothing_is_written(self, tmp_path):
        for name, what in (("Trajectory, functions", "a NonlinearSystem, which is given by functions"),):
            with pytest.raises(ValueError, match=rf"scene.* has {what}: a file cannot hold it"):
                OBJECTS[name].save(tmp_path / "run.npz")
        assert not list(tmp_path.iterdir())
        pendulum = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), None, OBJECTS["NonlinearStop"])
        with pytest.raises(ValueError, match="scene, Scene has a NonlinearStop, which is given by functions"):
            vi.simulate(pendulum, 0.0, 0.1, (0, 1)).save(tmp_path / "run.npz")

    def test_a_newer_format_is_refused_by_both_numbers(self, tmp_path):
        path = saved(tmp_path)
        header, arrays = entries(path)
        rewritten(path, header | {"format": 3, "version": "9.1.0"}, arrays)
        rule = r"path is '.*', but its format 3 is newer than 2, the newest that this version reads: take vibroimpact 9.1.0"
        with pytest.raises(ValueError, match=rule):
            vi.load(path)

    def test_other_files_are_refused(self, tmp_path):
        path = tmp_path / "other.npz"
        contents = [b"", b"not a file of arrays", pickle.dumps(RUN), b"PK\x03\x04 cut"]
        buffer = io.BytesIO()
        np.save(buffer, np.eye(2))
        contents.append(buffer.getvalue())
        for arrays in ({"a": np.eye(2)}, {"header": np.eye(2)}, {"header": np.array("no json")}, {"header": np.array("[1]")}):
            buffer = io.BytesIO()
            np.savez(buffer, **arrays)
            contents.append(buffer.getvalue())
        buffer = io.BytesIO()
        np.savez(buffer, header=np.array([{"format": 1}], dtype=object))
        contents += [buffer.getvalue(), saved(tmp_path).read_bytes()[:-100]]
        for content in contents:
            path.write_bytes(content)
            with pytest.raises(ValueError, match=r"path is '.*other.npz', but it is no result of vibroimpact"):
                vi.load(path)

    def test_a_file_that_is_not_there(self, tmp_path):
        with pytest.raises(FileNotFoundError):
            vi.load(tmp_path / "nothing.npz")
        with pytest.raises(FileNotFoundError):
            RUN.save(tmp_path / "no" / "folder.npz")

    @pytest.mark.parametrize("name", ["Trajectory, exact", "Orbit", "ExistenceMap", "Orbits"])
    def test_no_change_of_a_header_brings_anything_else_in(self, name, tmp_path):
        path = saved(tmp_path, RESULTS[name])
        header, arrays = entries(path)
        strange = [None, [], {}, "no such", 7, 1e300, {"type": "simulate"}, {"type": "__doc__", "arguments": [], "keywords": {}}]
        strange += [{"array": "nowhere"}, {"list": {"rows": "dict", "columns": []}}, {"float": "x"}, {"dict": [[[], 1]]}]

        def changes(value):
            yield from strange
            items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
            for key, item in list(items)[:4]:
                for other in changes(item):
                    copy = value.copy()
                    copy[key] = other
                    yield copy

        n_refused = 0
        for part in ("type", "scene", "arguments", "keywords"):
            for other in changes(header[part]):
                rewritten(path, header | {part: other}, arrays)
                try:
                    vi.load(path)
                except ValueError as error:
                    n_refused += "it was changed" in str(error)
        assert n_refused > 30
        rewritten(path, {key: value for key, value in header.items() if key != "arguments"}, arrays)
        with pytest.raises(ValueError, match="it was changed"):
            vi.load(path)
        rewritten(path, header, {})
        with pytest.raises(ValueError, match="it was changed"):
            vi.load(path)


class TestXarray:
    def test_a_trajectory_has_named_dimensions(self):
        run = OBJECTS["Trajectory, held"]
        data = run.to_xarray()
        assert dict(data.sizes) == {
            "time": len(run.t),
            "dof": 1,
            "impact": len(run.impacts),
            "graze": len(run.grazes),
            "segment": len(run.segments),
        }
        assert data.q.dims == data.v.dims == ("time", "dof")
        for name, values in (("q", run.q), ("v", run.v), ("final_q", run.final[0]), ("time", run.t)):
            assert same(data[name].values, values)
        for column in run.impacts.dtype.names:
            assert same(data[f"impact_{column}"].values, np.ascontiguousarray(run.impacts[column]))
        assert same(data.segment_impulse.values, np.ascontiguousarray(run.segments["impulse"]))
        assert data.attrs == {"t_end": 12.0, "status": run.status, "message": run.message, "vibroimpact": vi.__version__}

    def test_what_was_not_kept_is_not_there(self):
        data = OBJECTS["Trajectory, samples"].to_xarray()
        assert data.sizes["time"] == 2
        assert "segment_kind" not in data
        data = OBJECTS["Trajectory, impacts"].to_xarray()
        assert "q" not in data
        assert data.final_q.dims == ("dof",)
        assert data.sizes["impact"] == len(OBJECTS["Trajectory, impacts"].impacts)

    def test_an_orbit_a_map_and_an_ensemble(self):
        orbit = OBJECTS["Orbit"]
        data = orbit.to_xarray()
        assert same(data.q0.values, orbit.q0)
        assert same(data.floquet_multipliers.values, orbit.floquet_multipliers)
        assert data.attrs["period"] == orbit.period
        assert data.attrs["is_stable"] == "True"
        found = OBJECTS["ExistenceMap"]
        data = found.to_xarray()
        assert data.n_orbits.dims == ("y", "x")
        assert same(data.multiplier.values, found.multiplier)
        assert data.sel(x=1.5, y=0.2).n_orbits == found.n_orbits[1, 1]
        assert data.attrs["x_name"] == "frequency"
        ends = OBJECTS["Ensemble"]
        data = ends.to_xarray()
        assert data.q.dims == ("run", "dof")
        assert same(data.q.values, ends.q)
        assert data.status.values.tolist() == ends.status.tolist()

    def test_without_xarray_the_remedy_is_told(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "xarray", None)
        for name in ("Trajectory, exact", "Orbit", "ExistenceMap", "Ensemble"):
            with pytest.raises(ImportError, match=r'to_xarray needs xarray: pip install "vibroimpact\[xarray\]"'):
                RESULTS[name].to_xarray()


class TestBytes:
    """Bytes that are not those that were written: a result that is the same, or ValueError."""

    @pytest.mark.parametrize("name", RESULTS)
    def test_flipped_bits_and_cuts_are_refused(self, name, tmp_path):
        thing = RESULTS[name]
        path = saved(tmp_path, thing)
        whole = path.read_bytes()
        rng = np.random.default_rng(len(whole))
        for k in range(24):
            changed = bytearray(whole)
            if k % 4 == 3:
                del changed[int(rng.integers(len(whole))) :]
            else:
                for place in rng.integers(len(whole), size=1 + k % 3):
                    changed[place] ^= 1 << int(rng.integers(8))
            path.write_bytes(changed)
            try:
                again = vi.load(path)
            except ValueError as error:
                assert "path is" in str(error)  # noqa: PT017
            else:
                assert same(thing, again)

    def test_every_bit_of_the_first_entries_and_of_the_directory(self, tmp_path):
        """Headers of the archive and of NumPy: their readers raise errors of every kind."""
        path = saved(tmp_path, OBJECTS.get("Ensemble, final", RUN))
        thing, whole = vi.load(path), path.read_bytes()
        places = [*range(0, 260), *range(len(whole) - 160, len(whole))]
        for place in places:
            for bit in (1, 4, 32, 128):
                changed = bytearray(whole)
                changed[place] ^= bit
                path.write_bytes(changed)
                with contextlib.suppress(ValueError):
                    assert same(thing, vi.load(path))

    def test_headers_that_numpy_cannot_read(self, tmp_path):
        """The header of an array is Python's own syntax, which its reader parses."""
        path = saved(tmp_path)
        with zipfile.ZipFile(path) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        for text in (
            b"{'descr': '<f8', 'fortran_order': False, 'shape': (1,",
            b"\x00{",
            b"(" * 90,
            b"{'a'",
            b"'",
            b"1 +",
            b"\n \n  a",
        ):
            for name in members:
                if name != "header.npy":
                    own = b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text
                    with zipfile.ZipFile(path, "w") as archive:
                        for other, content in members.items():
                            archive.writestr(other, own if other == name else content)
                    with pytest.raises(ValueError, match="no result of vibroimpact, or was changed or cut"):
                        vi.load(path)


class TestMechanics:
    """Files rewritten with valid checksums: a motion is one of its scene, or it is refused."""

    LINEAR = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 1.3), vi.Stop(0, 0.5, 0.5))
    CHAIN = vi.Scene(vi.PendulumChain([1.0, 0.5], [0.5, 0.3], damping=0.02), vi.BaseMotion(0.06, 5.0), vi.Wall(1, 0.05, 0.7))

    def changed(self, path, change):
        """Rewrite a file with another header or other arrays."""
        header, arrays = entries(path)
        change(header, arrays)
        return rewritten(path, header, arrays)

    @pytest.mark.parametrize("factor", [2.0, 0.5, -1.0, 1e300, 0.0])
    @pytest.mark.parametrize("kind", ["linear", "chain"])
    def test_numbers_of_the_scene_are_those_of_the_motion(self, kind, factor, tmp_path):
        scene = {"linear": self.LINEAR, "chain": self.CHAIN}[kind]
        n = scene.n_dof
        run = vi.simulate(scene, np.zeros(n), np.zeros(n), (0, 15))
        assert len(run.impacts) > 2
        _, arrays = entries(saved(tmp_path, run))
        for name, array in arrays.items():
            # What times have beyond their last bit is of no consequence.
            if array.dtype.kind == "f" and np.abs(array).max() > 1e-12:
                path = saved(tmp_path, run)
                self.changed(path, lambda _, arrays, name=name: arrays.update({name: arrays[name] * factor}))
                with pytest.raises(ValueError, match="it was changed"):
                    vi.load(path)

    def test_each_number_of_the_motion_is_one_of_it(self, tmp_path):
        """Every number in the header that is no count, a tenth more: another motion, or one number of no consequence."""
        run = vi.simulate(self.LINEAR, 0.0, 0.0, (0, 15))
        header, _ = entries(saved(tmp_path, run))

        def numbers(part, way=()):
            if isinstance(part, float) and part and way[0] in ("arguments", "scene"):
                yield way
            for key, inner in part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ():
                yield from numbers(inner, (*way, key))

        refused, taken = 0, []
        for way in numbers(header):
            path = saved(tmp_path, run)

            def change(header, _, way=way):
                for key in way[:-1]:
                    header = header[key]
                header[way[-1]] *= 1.1

            self.changed(path, change)
            try:
                again = vi.load(path)
                taken.append(way)
                assert again.energy.balance[-1] < np.inf
            except ValueError:
                refused += 1
        assert refused > 20
        # What rounding took from the times, and phases, which follow from the times.
        assert all(way[0] == "arguments" for way in taken), taken

    def test_orbits_are_of_their_scene(self, tmp_path):
        orbit = vi.periodic_orbits(vi.paper_scene(3), [1], n_periods=2)[0]
        for name in entries(saved(tmp_path, orbit))[1]:
            path = saved(tmp_path, orbit)
            self.changed(path, lambda _, arrays, name=name: arrays.update({name: arrays[name] * 2}))
            if same(*(entries(p)[1][name] for p in (path, saved(tmp_path, orbit)))):
                continue
            self.changed(path, lambda _, arrays, name=name: arrays.update({name: arrays[name] * 2}))
            with pytest.raises(ValueError, match="it was changed"):
                vi.load(path)

    @pytest.mark.parametrize("damping", [1e13, 1e17, 1e30])
    def test_orbits_are_not_of_rates_that_no_search_takes(self, damping, tmp_path):
        """Beside terms of such a size every jump is small, and a verdict on so many turns would not end."""
        scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
        for thing in (orbits := vi.periodic_orbits(scene, [0]), orbits[0]):
            path = saved(tmp_path, thing)
            damped = [name for name, array in entries(path)[1].items() if array.size == 1 and array.item() == 0.1]
            assert damped
            self.changed(path, lambda _, arrays, names=damped: arrays.update({name: np.array([damping]) for name in names}))
            with pytest.raises(ValueError, match="it was changed"):
                vi.load(path)

    def test_counts_are_counts(self, tmp_path):
        """Infinite, or so large that their product is none."""
        signal = vi.Load(0, ([0.0, 1.0, 2.0], [0.0, 1.0, 0.0]))
        run = vi.simulate(vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), signal, vi.Stop(0, 0.5, 0.5)), 0.0, 0.0, (0, 3))
        path = saved(tmp_path, run)
        self.changed(path, lambda header, _: header.update(format=math.inf))
        with pytest.raises(ValueError, match="its header has no format"):
            vi.load(path)
        text = json.dumps(entries(saved(tmp_path, run))[0]["scene"]["arguments"][1])
        for degree in (10**18, 2**63 - 1, 2**64 - 1):

            def change(header, _, degree=degree):
                load = header["scene"]["arguments"][1]
                own = load["arguments"][1]["arguments"]
                assert own[1] == 1, text
                own[1] = degree

            self.changed(path := saved(tmp_path, run), change)
            with pytest.raises(ValueError, match="it was changed"):
                vi.load(path)

    def test_orbits_that_are_not_admissible_come_back(self, tmp_path):
        orbits = vi.periodic_orbits(vi.paper_scene(3), [1], n_periods=2)
        found = [
            one
            for scale in (0.2, 1.0, 3.0)
            for one in vi.periodic_orbits(vi.paper_scene(3).replace(forcing_scale=scale), [1], n_periods=2)
        ]
        assert {one.is_admissible for one in [*orbits, *found]} == {True, False}
        for one in found:
            assert same(one, vi.load(saved(tmp_path, one)))

    def test_a_flight_that_turns_without_end_is_told(self):
        system = vi.LinearSystem(1.0, 0.0, 1e300)
        run = vi.simulate(vi.Scene(system, None, []), 1e-300, 0.0, (0, 1))
        with pytest.raises(vi.ConvergenceError, match="the quadrature of a flight"):
            run.energy  # noqa: B018


def test_orbits_of_moving_stops_come_back_to_the_bit(tmp_path):
    """Turning a scene to the phase of an orbit rounds the phases of its stops: the orbit is of the scene before."""
    rng = np.random.default_rng(5)
    compared = 0
    for _ in range(60):
        w = rng.uniform(0.6, 2.0)
        motion = vi.Harmonic([rng.uniform(0.02, 0.2) * np.exp(1j * rng.uniform(0, 6))], w, rng.uniform(0, 6))
        stop = vi.Stop(0, rng.uniform(0.05, 0.4), rng.uniform(0.3, 0.9), motion=motion)
        scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], w, rng.uniform(0, 6)), stop)
        for orbit in vi.periodic_orbits(scene, [0]):
            again = vi.load(saved(tmp_path, orbit))
            t = np.linspace(0.0, orbit.period, 23)
            assert same(orbit, again)
            assert orbit.scene == again.scene
            for one in (orbit, again):
                assert (one.violation is None) == one.is_admissible
            assert same(orbit.position(t), again.position(t))
            assert same(orbit.velocity(t), again.velocity(t))
            assert repr(orbit.violation) == repr(again.violation)
            assert same(orbit.floquet_multipliers, again.floquet_multipliers)
            compared += 1
    assert compared > 40
