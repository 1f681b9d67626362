"""Files of the package import those of lower layers, and none in a circle; results declare what follows from their fields."""

import ast
import graphlib
import importlib
import typing
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import vibroimpact as vi
from vibroimpact.results.record import RESULTS, Record, array, items

PACKAGE = Path(vi.__file__).parent
FILES = {
    ".".join(("vibroimpact", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}

#: From the lowest to the highest: a layer imports those before it, and its own. `plot` takes what it draws by its attributes.
LAYERS = ("_core", "errors", "_validation", "_call_errors", "results", "run", "fe", "analysis", "_former", "")

#: The one import that is made in a method, not on import: `save` of every record.
LATE = {("vibroimpact.results.record", "vibroimpact.results.archive")}


def imports(name, path):
    """The files of the package that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (one.name for one in node.names if one.name.split(".")[0] == "vibroimpact")
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name} has a relative import"
            if str(node.module).split(".")[0] == "vibroimpact":
                for one in node.names:
                    whole = f"{node.module}.{one.name}"
                    yield whole if whole in FILES or whole == "vibroimpact._core" else node.module


def layer(name):
    """The layer of a file: its first name under the package."""
    return name.split(".")[1] if "." in name else ""


ARROWS = {(name, other) for name, path in FILES.items() for other in imports(name, path)} - LATE


def test_no_file_imports_one_of_a_higher_layer():
    assert {layer(name) for name in FILES} <= {*LAYERS, "plot"}
    own = [(name, other) for name, other in ARROWS if "plot" not in (layer(name), layer(other))]
    upward = [f"{name} imports {other}" for name, other in own if LAYERS.index(layer(other)) > LAYERS.index(layer(name))]
    assert upward == []


def test_plots_import_no_other_file():
    others = [f"{name} imports {other}" for name, other in ARROWS if layer(name) == "plot" and layer(other) != "plot"]
    assert others == []
    assert {name for name, other in ARROWS if layer(other) == "plot" and layer(name) != "plot"} <= {"vibroimpact"}


def test_no_files_import_each_other():
    graph = {name: {other for one, other in ARROWS if one == name and other != name} for name in FILES}
    graph["vibroimpact"] = {other for other in graph["vibroimpact"] if layer(other) != "plot"}
    list(graphlib.TopologicalSorter(graph).static_order())


def test_public_classes_are_those_of_the_package():
    classes = [one for one in map(vi.__dict__.get, vi.__all__) if isinstance(one, type) and one is not vi.ConvergenceError]
    assert [one for one in classes if one.__module__ != "vibroimpact"] == []
    for one in classes:
        if issubclass(one, Record):
            typing.get_type_hints(one)


@pytest.mark.parametrize("name", ["branch", "attractors", "basin_plane", "reduction", "damping", "verdict"])
def test_modules_of_former_versions_are_found(name):
    assert importlib.import_module(f"vibroimpact.{name}").continuation is vi.continuation


def test_docstrings_say_the_shapes_and_units_that_are_declared():
    """Each array of a result stands in its docstring with as many dimensions as it has in one of its forms, and its unit."""
    for one in RESULTS.values():
        entries = documented(one.__doc__)
        assert set(one._fields) <= set(entries), one
        for name, own in one._fields.items():
            kind, text = entries[name]
            if own.kind is not None and "shape" in kind:
                shapes = kind.partition("shape")[2].split("(")[1:]
                counts = {len([size for size in shape.split(")")[0].split(",") if size.strip()]) for shape in shapes}
                assert {len(form) for form in own.given.forms} <= counts, (one, name)
            assert f"{own.given.unit}" in text, (one, name)


def documented(text):
    """The attributes of a docstring: what stands behind the colon, and below."""
    found, names = {}, ()
    for line in text.partition("Attributes\n    ----------\n")[2].splitlines():
        if line.startswith("    ") and not line.startswith("     ") and " : " in line:
            head, _, kind = line.strip().partition(" : ")
            names = [one.strip() for one in head.split(",")]
            found |= {name: (kind, "") for name in names}
        else:
            found |= {name: (found[name][0], f"{found[name][1]} {line.strip()}") for name in names}
    return found


class Counted(Record):
    """A result of this test: counts of things along a line."""

    x: NDArray[np.float64] = array("x", unit="m", coordinate="x")
    counts: NDArray[np.int64] = array("x")
    names: tuple[str, ...] = items("x", as_text=True)
    title: str


class TestDeclaration:
    GOOD = Counted(np.array([0.5, 1.5]), np.array([3, 4]), ["a", "b"], "some")

    def test_all_follows_from_it(self):
        assert list(self.GOOD.to_arrays()) == ["x", "counts", "names"]
        assert self.GOOD.names == ("a", "b")
        assert "counts" in repr(self.GOOD)
        assert "x: 2" in self.GOOD._repr_html_()
        make, arguments = self.GOOD.__reduce__()
        assert make(*arguments).title == "some"

    def test_labelled_arrays_have_dimensions_and_units(self):
        pytest.importorskip("xarray")
        data = self.GOOD.to_xarray()
        assert data.counts.dims == ("x",)
        assert data.x.attrs == {"units": "m"}
        assert data.attrs["title"] == "some"

    @pytest.mark.parametrize(
        ("place", "bad", "said"),
        [
            (0, [0.5, 1.5], "x has shape"),
            (1, np.array([3.0, 4.0]), "counts has dtype float64, but one of kind 'i' is needed"),
            (1, np.array([3]), r"counts has shape \(1,\), but an array of shape \(2,\) is needed"),
            (1, None, "counts has shape"),
            (2, ["a"], "names has 1 entries, but 2 are needed"),
            (2, ["a", 1], "names is .*, but a sequence of str is needed"),
            (3, 1, "title is 1, but it must be of type"),
        ],
    )
    def test_what_does_not_fit_is_refused_by_name(self, place, bad, said):
        arguments = list(self.GOOD.__reduce__()[1])
        arguments[place] = bad
        with pytest.raises((TypeError, ValueError), match=said):
            Counted(*arguments)

    def test_a_class_of_a_user_is_none_of_the_library(self):
        class Basins(vi.Basins):
            """Of the same name."""

        assert RESULTS["Basins"] is vi.Basins
        assert list(Basins._fields) == list(vi.Basins._fields)
        assert Basins.__repr__ is vi.Basins.__repr__
