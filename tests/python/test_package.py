"""What the packages take along."""

import tomllib
from pathlib import Path


def test_the_crate_takes_files_of_its_own_alone():
    """A pattern of `include` without a leading slash is looked for in every folder, such as an environment's."""
    manifest = tomllib.loads((Path(__file__).parents[2] / "Cargo.toml").read_text())
    assert all(pattern.startswith(("/", "!")) for pattern in manifest["package"]["include"])
