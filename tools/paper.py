"""A paper under its audit.

python tools/paper.py KIND [--help] ...

errors         errors put into it one at a time: does its audit notice them?
premises       premises of its systems changed: what is proved all the same?
transcription  its transcription against its LaTeX file
"""

import sys

from shared.kinds import run

KINDS = {
    "errors": "papers.errors",
    "premises": "papers.premises",
    "transcription": "papers.transcription",
}
"""Kind -> the module that does it."""

if __name__ == "__main__":
    sys.exit(run(__doc__, KINDS))
