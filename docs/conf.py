"""The site: ``bash .ci/run site`` builds it into ``target/site``; building the gallery runs the Python examples."""

import os
from importlib.metadata import metadata
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from sphinx_gallery.scrapers import figure_rst

import vibroimpact

#: Addresses of the project, where it has any: [project.urls] of pyproject.toml is the one place for them.
URLS = dict(entry.split(", ", 1) for entry in metadata("vibroimpact").get_all("Project-URL") or [])
ROOT = Path(__file__).parent.parent
FIGURES = ROOT / "target" / "figures"

# Notebooks show their pictures by themselves only where no other backend is asked for.
os.environ.pop("MPLBACKEND", None)

project = "vibroimpact"
author = "the developers of vibroimpact"
project_copyright = author
version = release = vibroimpact.__version__

extensions = ["myst_nb", "numpydoc", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["report/figures", "gallery/*.ipynb", "gallery/*.py", "**sg_execution_times.rst", "jupyter_execute"]
default_role = "code"
templates_path = ["_templates"]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb"}

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
# A formula in backticks is text, and numbered lists begin where they begin.
suppress_warnings = ["myst.header", "config.cache"]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120

autosummary_generate = True
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

smartquotes = False  # --output is an option, not a dash
html_theme = "pydata_sphinx_theme"
html_title = "vibroimpact"
html_baseurl = URLS.get("Documentation", "")
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_favicon = html_logo = "_static/icon.svg"
html_context = {"default_mode": "auto"}
html_show_sourcelink = False
html_copy_source = False
html_sidebars = {name: [] for name in ("*", "howto/*", "report/*")}  # the width is for code and tables
html_theme_options = {
    "logo": {"text": "vibroimpact"},
    "navigation_with_keys": False,
    "show_prev_next": False,
    "header_links_before_dropdown": 5,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    **({"github_url": URLS["Repository"]} if "Repository" in URLS else {}),
}


def output_of(_gallery: object, script: dict[str, object]) -> list[str]:
    """Return the arguments of an example: where its figures go, a folder of its own."""
    source = Path(str(script["src_file"]))
    return ["--output", os.path.relpath(FIGURES / source.stem, source.parent)]


def saved_figures(_block: object, variables: dict[str, object], gallery: dict[str, object]) -> str:
    """Take the pictures that an example has saved."""
    places = []
    folder = FIGURES / Path(str(variables["src_file"])).stem
    for picture in sorted([*folder.glob("*.png"), *folder.glob("*.gif")], key=lambda path: path.suffix):
        place = Path(next(variables["image_path_iterator"])).with_suffix(picture.suffix)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(picture.read_bytes())
        places.append(str(place))
    return figure_rst(places, str(gallery["src_dir"]))


#: Reports take minutes and have pages of their own; cells on a cluster are shown, not run.
SHOWN = ("error_vs_runtime", "extreme_cases", "scene_cost", "basin_cluster")

sphinx_gallery_conf = {
    "examples_dirs": ["../examples"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": rf"/(?!({'|'.join(SHOWN)}))\w+\.py$",
    "ignore_pattern": r"/report/|__init__",
    "image_scrapers": (saved_figures,),
    "reset_argv": output_of,
    "reset_modules": (),
    "within_subsection_order": "FileNameSortKey",
    "default_thumb_file": str(Path(__file__).parent / "_static" / "icon.svg"),
    "remove_config_comments": True,
    "min_reported_time": 1e9,
    "show_memory": False,
    "show_signature": False,
    "download_all_examples": False,
    "abort_on_example_error": True,
}


def titled(_app: object, name: str, source: list[str]) -> None:
    """Make a heading of the first line of an example."""
    if not name.startswith("gallery/") or name.endswith(("index", "sg_execution_times")):
        return
    lines = source[0].split("\n")
    label = next(k for k, line in enumerate(lines) if line.startswith(".. _sphx_glr_gallery_"))
    first = next(k for k in range(label + 1, len(lines)) if lines[k].strip())
    lines[first] = lines[first].rstrip(".")
    lines.insert(first + 1, "=" * len(lines[first]))
    source[0] = "\n".join(lines)


def listing(title: str, module: str, names: list[str]) -> str:
    """Return a section that lists names of a module, a page each."""
    head = [
        title,
        "=" * len(title),
        "",
        f".. currentmodule:: {module}",
        "",
        ".. autosummary::",
        "   :toctree: .",
        "   :nosignatures:",
        "",
    ]
    return "\n".join([*head, *(f"   {name}" for name in sorted(names, key=str.lower)), ""])


# Every public name; written before the build, which makes their pages.
API = Path(__file__).parent / "api" / "index.rst"
API.parent.mkdir(exist_ok=True)
API.write_text(
    "API\n===\n\n"
    + listing("Scenes, motions, results", "vibroimpact", sorted(set(vibroimpact.__all__) - {"plot", "KINDS", "__version__"}))
    + "\n"
    + listing("Pictures", "vibroimpact.plot", list(vibroimpact.plot.__all__)),
    encoding="utf-8",
)


def formula(display: str):
    """Return how a formula is written: as MathML, which a browser draws without a script."""

    def visit(writer: object, node: nodes.math | nodes.math_block) -> None:
        writer.body.append(convert(node.astext(), display=display))  # type: ignore[attr-defined]
        raise nodes.SkipNode

    return visit, None


def setup(app: object) -> None:
    """Give Sphinx what is not an option."""
    app.connect("source-read", titled)  # type: ignore[attr-defined]
    app.add_html_math_renderer("mathml", formula("inline"), formula("block"))  # type: ignore[attr-defined]
