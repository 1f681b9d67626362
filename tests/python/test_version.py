"""One version, Cargo.toml's; what has to repeat it agrees."""

import re
import tomllib
from pathlib import Path

import vibroimpact as vi

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["package"]["version"]


def test_the_module_has_the_version_of_the_crate():
    assert vi.__version__ == VERSION


def test_the_newest_section_of_the_changelog_and_the_citation_are_of_the_version():
    version, day = re.search(
        r"^## (\d[\d.]*) - ([\d-]+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE
    ).groups()
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert version == VERSION
    assert re.search(rf"^version: {re.escape(VERSION)}$", citation, re.MULTILINE)
    assert re.search(rf"^date-released: {day}$", citation, re.MULTILINE)
