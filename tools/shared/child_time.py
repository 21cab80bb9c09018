"""How long a child process has worked: seconds of the processor, which no load stretches.

For the tools that end children which hang."""

from __future__ import annotations

import os
import time
from pathlib import Path


class ChildClock:
    """Seconds that a child process works, from now on."""

    def __init__(self, pid: int | None) -> None:
        self.pid, self.since = pid, time.monotonic()
        self.before = self._work_time()

    def work_time(self) -> float:
        """Seconds of the processor that the child and what it waited for have taken."""
        return self._work_time() - self.before

    def wait_time(self) -> float:
        """Seconds on the wall."""
        return time.monotonic() - self.since

    def _work_time(self) -> float:
        try:
            stat = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:  # not on Linux, or ended
            return time.monotonic()
        # utime, stime, and those of children that were waited for: fields 14 to 17 of proc(5)
        return sum(map(int, stat[11:15])) / os.sysconf("SC_CLK_TCK")
