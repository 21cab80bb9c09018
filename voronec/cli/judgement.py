"""``voronec judge``: an equation that somebody wrote, proved or refuted."""

from __future__ import annotations

from argparse import Namespace

from voronec.cli.output import answer
from voronec.cli.subject import resolve


def execute(arguments: Namespace) -> int:
    """Print what was read, what was done and what came out; 1 unless it is proved."""
    from voronec.audit.lessons.judgement import judge

    system, _ = resolve(arguments.system)
    judgement = judge(system, arguments.equation)
    answer(arguments.json, judgement.as_dict, [judgement])
    return 0 if judgement.proved else 1
