"""Signals in tests."""

import signal


def hears_ctrl_c() -> None:
    """For a process that is to hear Ctrl-C, though these tests may run where it is ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
