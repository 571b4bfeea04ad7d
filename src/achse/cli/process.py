"""What a process that serves stations asks of Python and of the system."""

import asyncio
import contextlib
import gc
import sys
from collections.abc import Callable, Iterator

__all__ = ["loop_factory", "raise_file_limit", "seldom_collected"]

_YOUNG = 700
"""New objects until Python looks for garbage among them, its own default: short and often."""

_SELDOM = 100
"""Collections of younger objects before one of all."""


def raise_file_limit() -> None:
    """Open as many files as the system lets us: each connection is one, and usual are 1024."""
    if sys.platform == "win32":
        return
    import resource

    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


@contextlib.contextmanager
def seldom_collected() -> Iterator[None]:
    """Meanwhile Python looks through all objects seldom, and not at those that are there now.

    With tens of thousands of subscriptions that takes longer than a client should wait. Most of
    what ends is freed without it; the rest waits for a hundred collections of younger objects.
    """
    before = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(_YOUNG, before[1], _SELDOM)
    try:
        yield
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


def loop_factory() -> Callable[[], asyncio.AbstractEventLoop] | None:
    """uvloop's loop where achse[fast] is installed, else asyncio's own."""
    try:
        import uvloop
    except ImportError:
        return None
    return uvloop.new_event_loop
