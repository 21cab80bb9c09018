"""``python -m voronec``."""

from voronec.cli import main

raise SystemExit(main())
