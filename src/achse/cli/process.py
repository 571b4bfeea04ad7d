"""Settings of a process that serves stations: file limit and event loop."""

import asyncio
import contextlib
import sys
from collections.abc import Callable


def raise_file_limit() -> None:
    """Open as many files as the system lets us: each connection is one, and usual are 1024."""
    if sys.platform == "win32":
        return
    import resource

    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


def loop_factory() -> Callable[[], asyncio.AbstractEventLoop] | None:
    """uvloop's loop where achse[fast] is installed, else asyncio's own."""
    try:
        import uvloop
    except ImportError:
        return None
    return uvloop.new_event_loop
