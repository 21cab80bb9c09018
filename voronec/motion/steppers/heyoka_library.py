"""heyoka, with what it compiles kept in a folder that stays small.

On its first use in a process heyoka sums up the sizes of all programs that it keeps on disk, which
takes 0.4 s where they are 1.2 GB (2500 programs); by default it lets them grow to 20 GB.
"""

from __future__ import annotations

import sys
from typing import Any

from voronec.declaration.whole_files import user_cache

__all__ = ["heyoka"]

ROOM = 64 * 2**20
"""So many bytes of compiled programs stay on disk, those of some 130 models; what nobody used for
longest gives way."""


def heyoka() -> Any:
    """The module; ``ImportError`` where it is not installed.

    Who loads heyoka before has it keep its programs where and as long as that one likes.
    """
    is_ours = "heyoka" not in sys.modules
    import heyoka as hy

    if is_ours:
        folder, state = user_cache("heyoka"), hy.llvm_state
        try:
            folder.mkdir(parents=True, exist_ok=True)
            state.set_diskcache_path(folder)
            state.set_diskcache_limit(ROOM)
        except (OSError, RuntimeError):  # nobody can write there
            state.set_diskcache_enabled(False)
    return hy
