"""What a campaign of random trials is asked for: a seed, how many trials, how long, which kind."""

from __future__ import annotations

import argparse
import os
import random
from collections.abc import Iterable


def campaign_parser(about: str | None, kinds: Iterable[str]) -> argparse.ArgumentParser:
    """The options that all campaigns have; the first line of ``about`` describes it."""
    parser = argparse.ArgumentParser(description=(about or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=None)
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--kind", choices=[*kinds], default=None)
    parser.add_argument("--only", type=int, default=None)
    return parser


def read_campaign(parser: argparse.ArgumentParser) -> argparse.Namespace:
    """What the command line says, with a seed drawn where it names none."""
    chosen = parser.parse_args()
    if chosen.seed is None:
        chosen.seed = random.SystemRandom().randrange(10**6)
    return chosen
