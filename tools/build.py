"""What is built from the package.

python tools/build.py KIND [--help] ...

pages        the pages of the systems: docs/systems
audit        the audit that the documentation carries: docs/audit
hard-cases   the page of the hard cases: docs/hard-cases.md
gallery      the pictures of docs/closed-form.md
pictures     the pictures of the README
site         the documentation site
derivations  stored derivations: tests/derivations
"""

import sys

from shared.kinds import run

KINDS = {
    "pages": "pages.systems",
    "audit": "pages.audit",
    "hard-cases": "pages.hard_cases",
    "gallery": "pages.gallery",
    "pictures": "pages.pictures",
    "site": "pages.site",
    "derivations": "pages.derivations",
}
"""Kind -> the module that does it."""

if __name__ == "__main__":
    sys.exit(run(__doc__, KINDS))
