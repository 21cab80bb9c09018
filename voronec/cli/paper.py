"""``voronec audit``: any paper as its file stands, beside a system; a paper of the catalogue by its
name, as ``voronec regenerate`` does it.

The exit status is 1 where a formula is refuted.
"""

from __future__ import annotations

import re
from argparse import Namespace
from pathlib import Path

from voronec.cli import regeneration
from voronec.cli.files import create, deliver, wanted_folder
from voronec.cli.output import answer, progress, progress_line
from voronec.cli.subject import is_file, resolve
from voronec.declaration.catalogue import papers


def execute(arguments: Namespace) -> int:
    """Print the summary for a referee; a page, where a folder is given; without a system, a draft
    of its file."""
    path = Path(arguments.paper)
    if arguments.system is None and not is_file(arguments.paper) and arguments.paper in papers():
        options = {**vars(arguments), "label": None, "details": False, "fresh": False}
        return regeneration.execute(Namespace(**options))
    if arguments.system is None:
        return _draft(path, arguments.json)
    from voronec.audit.file_audit import audit_paper
    from voronec.audit.letters import letters_table
    from voronec.audit.page.referee import referee_markdown
    from voronec.audit.page.report import write_audit

    folder = None if arguments.out is None else wanted_folder(arguments.out)
    table = None if arguments.dictionary is None else Path(arguments.dictionary)
    known = table if table is not None and table.exists() else None
    with progress_line(f"{path.name}: deriving the equations ..."):
        system, _ = resolve(arguments.system)
        review = audit_paper(path, system, known, lambda at, verdict: progress(f"{at}: {verdict}"))
    lines = review.lines()
    if arguments.format == "md":
        lines = [referee_markdown(review.audit, review.letters, system.name).rstrip()]
    if folder is not None:
        files = deliver(folder, lambda to: write_audit(review.audit, to))
        lines += ["wrote " + ", ".join(map(str, files))]
    if table is not None and known is None and not review.letters:
        lines += [f"no letter is left to be explained; {table} is not needed"]
    elif table is not None and known is None:
        create(table, letters_table(review.letters))
        lines += [f"wrote {table}: say there what the letters are, and repeat the command"]
    elif review.letters and known is None:
        lines += ["--dictionary FILE.toml writes a table of these letters, to be filled in"]
    answer(arguments.json, review.as_dict, lines)
    return 1 if review.errata else 0


def _draft(path: Path, as_json: bool) -> int:
    """Print a system file drafted from the paper."""
    from voronec.audit.draft import draft_system
    from voronec.audit.latex.document import read_document

    name = re.sub(r"[^a-z0-9]+", "-", path.stem.lower()).strip("-") or "paper"
    text = draft_system(read_document(path), name)
    answer(as_json, lambda: {"system": text}, [text.rstrip()])
    return 0
