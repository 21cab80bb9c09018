"""Build the documentation site: ``python tools/build.py site`` (needs the extra ``docs``).

The pages under ``docs`` and the reference, made from the docstrings, go to ``build/site/source``,
and Sphinx makes ``build/site/html`` of them.  A warning, an error in a notebook or a link that
leads nowhere ends with status 1.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from html.parser import HTMLParser
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import voronec
from pages import audit, gallery
from voronec.motion.viewer.gallery import write_gallery
from voronec.motion.viewer.page import Page

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PLACE = ROOT / "build" / "site"

ROOMS = {
    "declaration": "Defining a system",
    "kinematics": "Rotations, surfaces and rolling",
    "equations": "Equations of motion",
    "motion": "Motions",
    "closed": "Motions in closed form",
    "proof": "Claims, relations and searches",
    "dynamics": "Steady motions, periodic orbits, exponents",
    "sweeps": "Sweeps over many motions",
    "audit": "Teaching",
    "algebra": "Symbols and verdicts",
    "accuracy": "Hard cases",
    "errors": "Errors",
    "testing": "Tests for your own systems",
}
"""The rooms of the package that have public names, in the order of use, and what they are for."""


OUTSIDE = re.compile(r"\[([^\]]*)\]\(\.\./[^)]*\)")
SYSTEMS = "\n```{toctree}\n:hidden:\n:glob:\n\n*\n```\n"
"""All pages beside the list of systems, for the column on the left."""
SITE_PAGES = "lists them; the site\ncarries them, too.\n"
"""Where the pages of motions are told of."""
MOTION = "\n## Motions\n"
"""Where a page of a system tells of its motions."""
BOTH = "are made with the site, which carries both.\n"
"""Where the page and the article of the audit are told of."""
CLASSES = "are made with the site, which shows them.\n"
"""Where the pictures of the classes of traces are told of."""
TIME = "The time, the symbol ``t``; also the argument of SymPy's ``dynamicsymbols``."


def reference_pages() -> dict[str, str]:
    """The pages of the reference by their names: every public name, with its docstring."""
    names: dict[str, list[str]] = {room: [] for room in ROOMS}
    for name in voronec.__all__:
        if name != "kinematics":
            names[voronec._HOME[name].split(".")[1]].append(f"voronec.{name}")
    for room in ("kinematics", "testing"):
        module = import_module(f"voronec.{room}")
        names[room] = [f"voronec.{room}.{name}" for name in module.__all__]
    return {room: _reference_page(title, names[room]) for room, title in ROOMS.items()}


def _reference_page(title: str, names: list[str]) -> str:
    lines = [title, "=" * len(title), ""]
    for name in names:
        home, _, last = name.rpartition(".")
        value = getattr(import_module(home), last)
        if value is voronec.time:  # its docstring is that of SymPy's symbols
            lines += [last, "-" * len(last), "", f".. data:: {name}", "", f"   {TIME}", ""]
            continue
        kind = "class" if isinstance(value, type) else "function" if callable(value) else "data"
        if kind == "class" and issubclass(value, Exception):
            kind = "exception"
        lines += [last, "-" * len(last), "", f".. auto{kind}:: {name}"]
        options = ["   :members:"] if kind in ("class", "exception") else []
        if kind == "class":  # what is derived, and what is inverted, is their base's
            options.append("   :inherited-members: object, tuple")
        lines += [*options, ""]
    return "\n".join(lines)


def write_source(source: Path) -> None:
    """The pages as Sphinx reads them."""
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    for page in source.rglob("*.md"):  # what lies outside of the documentation is named, not linked
        text = page.read_text("utf-8")
        page.write_text(OUTSIDE.sub(r"\1", text) if page.parent == source else text, "utf-8")
    _add_sketches(source / "systems")
    _add_audit(source / "audit.md")
    _add_classes(source / "closed-form.md")
    _add_notebooks(source / "notebooks")
    index = source / "systems" / "README.md"
    index.write_text(index.read_text("utf-8") + SYSTEMS, "utf-8")
    reference = source / "reference"
    reference.mkdir(exist_ok=True)
    for room, text in reference_pages().items():
        (reference / f"{room}.rst").write_text(text, "utf-8")
    _list_others(source / "index.md", "*.md", "special-motions")
    _list_others(source / "index.md", "reference/*.rst", "reference/testing")
    _list_others(source / "how-to" / "index.md", "*.md", "formula")
    _list_others(source / "notebooks" / "index.md", "*.md", "search-and-prove")


CELL = re.compile(r"^```\{code-cell\}.*?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
"""A cell of code in a notebook that is kept as a text."""


def notebook_of(text: str) -> dict[str, Any]:
    """A notebook, as Jupyter keeps it, of one that is kept as a text: words and code in turn."""
    body = re.sub(r"\A---\n.*?\n---\n", "", text, flags=re.DOTALL)
    cells = []
    for number, part in enumerate(CELL.split(body)):
        lines = part.strip().splitlines(keepends=True)
        kind = "code" if number % 2 else "markdown"
        more: dict[str, Any] = {"outputs": [], "execution_count": None} if number % 2 else {}
        if lines:
            own: dict[str, Any] = {
                "cell_type": kind,
                "id": f"cell-{number}",
                "metadata": {},
                "source": lines,
            }
            cells.append(own | more)
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


def _add_notebooks(folder: Path) -> None:
    """Write each notebook for Jupyter, and offer it at the head of its page."""
    downloads = folder.parent / "downloads"
    downloads.mkdir(exist_ok=True)
    for page in folder.glob("*.md"):
        text = page.read_text("utf-8")
        if not CELL.search(text):
            continue
        file = downloads / f"{page.stem}.ipynb"
        file.write_text(json.dumps(notebook_of(text), indent=1), "utf-8")
        offer = f"{{download}}`Download this notebook <../downloads/{file.name}>` for Jupyter."
        page.write_text(re.sub(r"^(# .*)$", rf"\1\n\n{offer}", text, count=1, flags=re.MULTILINE))


def _add_audit(page: Path) -> None:
    """Write the page and the article of the audit, and link them on the page that tells of them."""
    folder = page.parent / "audit" / audit.PAPER
    audit.write_pages(folder)
    place = folder.relative_to(page.parent).as_posix()
    links = f"Here are [the page]({place}/report.html) and [the article]({place}/report.tex).\n"
    _add_behind(BOTH, links, page)


def _add_classes(page: Path) -> None:
    """Draw a motion of each class of traces, and link the pictures on their page."""
    pictures = gallery.pictures(voronec.load("demchenko"))
    folder = page.parent / "closed-form"
    for name in gallery.CLASSES:
        gallery.write_picture(pictures[name](), folder / f"{name}.svg")
    shown = [f"[{label}]({folder.name}/{name}.svg)" for name, label in gallery.CLASSES.items()]
    _add_behind(CLASSES, f"Here they are: {', '.join(shown)}.\n", page)


def _add_behind(words: str, more: str, page: Path) -> None:
    """Go on behind the words of a page that tell of what the site adds."""
    text = page.read_text("utf-8")
    assert words in text, f"{page.name} does not say: {words}"
    page.write_text(text.replace(words, words + more, 1), "utf-8")


def add_motions(page: Path, folder: Path, of_all: bool = True) -> None:
    """Write the pages of motions, and show the first where these are told of, and on the page of
    each system its default scene; without ``of_all`` where the gallery has it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    listed, first, *_ = write_gallery(folder)
    place = f"../{folder.name}"
    shown = f"""
```{{raw}} html
<p><a href="{place}/{listed.name}">The pages of a dozen motions</a>; here is the first:</p>
<iframe src="{place}/{first.name}" style="width: 100%; height: 52rem; border: 0"></iframe>
```
"""
    _add_behind(SITE_PAGES, shown, page)
    systems = sorted((page.parents[1] / "systems").glob("[!R]*.md"))
    targets = [folder / f"{own.stem}-default.html" for own in systems]
    there = [target.exists() for target in targets]
    if of_all:
        with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
            there = [*pool.map(write_motion, targets)]
    for own, target, shows in zip(systems, targets, there, strict=True):
        frame = f'<iframe src="{place}/{target.name}" loading="lazy" title="default" '
        style = 'style="width: 100%; height: 46rem; border: 0"></iframe>'
        if shows:
            _add_behind(MOTION, f"\n```{{raw}} html\n{frame}{style}\n```\n", own)


def write_motion(target: Path) -> bool:
    """Write the page of a default scene if it is not there, and say whether there is one."""
    if target.exists():
        return True
    system = voronec.load(target.stem.removesuffix("-default"))
    if not system.shapes or "default" not in system.scenes:
        return False
    motion = voronec.integrate(system, outputs=(*system.coordinates, *system.velocities))
    target.write_text(Page(motion, system.scenes["default"].caption).text, "utf-8")
    return True


def _list_others(index: Path, pages: str, last: str) -> None:
    """Name the pages of a pattern that an index does not, after its entry ``last``."""
    folder, text = index.parent, index.read_text("utf-8")
    there = {str(p.relative_to(folder).with_suffix("")) for p in folder.glob(pages)}
    others = sorted(there - {*text.splitlines(), index.stem})
    entry = f"\n{last}\n"
    index.write_text(text.replace(entry, entry + "\n".join([*others, ""]), 1), "utf-8")


def _add_sketches(folder: Path) -> None:
    """Draw the sketch of each system, and show it above its equations."""
    for page in folder.glob("*.md"):
        sketch = None if page.stem == "README" else voronec.load(page.stem).sketch
        if sketch is None:
            continue
        page.with_suffix(".svg").write_text(sketch.svg(), "utf-8")
        text = page.read_text("utf-8")
        shown = f"![The mechanism, {sketch.view}]({page.stem}.svg)\n\n## Equations of motion"
        page.write_text(text.replace("## Equations of motion", shown, 1), "utf-8")


class _Links(HTMLParser):
    """The links of a page, and the anchors that it has."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(page.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key in ("href", "src") and value:
                self.links.append(value)
            elif key in ("id", "name") and value:
                self.anchors.add(value)


def dead_links(site: Path) -> Iterator[str]:
    """Links of the site that lead to no file, to no anchor, or into the network for a picture."""
    pages = {page.resolve(): _Links(page) for page in sorted(site.rglob("*.html"))}
    for page, found in pages.items():
        for link in found.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            anchor = unquote(parts.fragment)
            there = target.exists() and not target.is_dir()
            if not there or (anchor and target in pages and anchor not in pages[target].anchors):
                yield f"{page.relative_to(site.resolve())}: {link}"


def main() -> int:
    """Write the source, build, look at every link."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "--still", action="store_true", help="run no notebooks and no motions but the gallery's"
    )
    still = parser.parse_args().still
    from sphinx.cmd.build import build_main

    source, site = PLACE / "source", PLACE / "html"
    write_source(source)
    add_motions(source / "how-to" / "view.md", site / "motions", of_all=not still)
    options = ["-W", "--keep-going", "-q", "-E", "-j", "auto", "-b", "html"]
    if still:  # then no kernel says in which language the cells are
        options += ["-D", "nb_execution_mode=off", "-D", "suppress_warnings=myst-nb.lexer"]
        options += ["-t", "still"]
    conf = ["-c", str(DOCS / "site"), "-d", str(PLACE / "doctrees")]
    status = build_main([*options, *conf, str(source), str(site)])
    dead = list(dead_links(site)) if status == 0 else []
    for line in dead:
        print(f"dead link: {line}")
    if status == 0 and not dead:
        print(f"the site is {site / 'index.html'}")
    return 1 if status or dead else 0
