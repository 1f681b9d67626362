"""The example that goes from files to files: its exact flights beside implicit steps."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import vibroimpact as vi

EXAMPLE = Path(__file__).parents[2] / "examples" / "measured_shaker.py"


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    spec = importlib.util.spec_from_file_location("measured_shaker", EXAMPLE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    folder = tmp_path_factory.mktemp("measured_shaker")
    example.write_inputs(folder)
    return example.read_scene(folder)[0]


def test_the_first_impacts_by_steps(scene):
    """The tolerances say when impacts that accumulate are completed: one pair of them for both, so that they count alike."""
    rest, options = np.zeros(scene.n_dof), {"rtol": 1e-10, "atol": 1e-13, "keep": "impacts"}
    exact = vi.simulate(scene, rest, rest, (0.0, 0.4), method="exact", **options)
    times = exact.impacts["time"][:20]
    assert times.size == 20
    steps = vi.simulate(scene, rest, rest, (0.0, 1.01 * times[-1]), method="radau", **options)
    np.testing.assert_array_equal(steps.impacts["stop"][:20], exact.impacts["stop"][:20])
    np.testing.assert_allclose(steps.impacts["time"][:20], times, rtol=0, atol=1e-7 * times[-1])
