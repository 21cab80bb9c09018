"""A system whose author made a mistake."""

raise RuntimeError("this module\nfails")
