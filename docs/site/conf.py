"""How Sphinx builds the site: ``python tools/build.py site`` calls it."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import voronec

project = "Voronec"
author = "The Voronec developers"
copyright = author
version = release = voronec.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "sphinx.ext.viewcode"]
exclude_patterns = ["site", "downloads", "**/.ipynb_checkpoints"]
html_theme = "furo"
html_title = "Voronec"
html_copy_source = False
html_show_sphinx = False
html_static_path = ["site.css"]
html_css_files = ["site.css"]

# Formulas are drawn by one file that is copied into the site: a reader needs no network.
MATHJAX = "tex-svg-full.js"
mathjax_path = MATHJAX
myst_enable_extensions = ["amsmath", "attrs_block", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
myst_fence_as_directive = ["math"]
myst_dmath_double_inline = True

# Notebooks are run anew for every site, and an error in one of them is an error of the site.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

autodoc_typehints = "signature"
# Every public name has its heading: entries for members, too, would be copied into each page.
toc_object_entries = False
autodoc_member_order = "bysource"
python_use_unqualified_type_names = True
viewcode_line_numbers = True


def _plain_formulas(*event: Any) -> None:
    """In docstrings |a| is a length, in reStructuredText a substitution: escape what is no code."""
    lines = event[-1]
    for i, line in enumerate(lines):
        parts = line.split("``")
        lines[i] = "``".join(p if k % 2 else p.replace("|", r"\|") for k, p in enumerate(parts))


def _copy_mathjax(app: Sphinx, error: Exception | None) -> None:
    package = importlib.util.find_spec("sphinx-mathjax-offline")
    if error is None and package is not None and package.origin is not None:
        source = Path(package.origin).parent / "static" / "mathjax" / MATHJAX
        shutil.copyfile(source, Path(app.outdir) / "_static" / MATHJAX)


def _list_own_branch(*event: Any) -> None:
    """Beside a page only the branch of the contents that leads to it: all pages beside each of them
    are a third of the work, and a site that is built to be checked is read by nobody."""
    context = event[3]
    if "toctree" in context:
        contents = context["toctree"]
        context["toctree"] = lambda **given: contents(**{**given, "collapse": True})


def setup(app: Sphinx) -> None:
    """What Sphinx calls first."""
    if "still" in app.tags:
        app.connect("html-page-context", _list_own_branch, priority=400)  # before the theme's
    app.connect("autodoc-process-docstring", _plain_formulas)
    app.connect("build-finished", _copy_mathjax)
