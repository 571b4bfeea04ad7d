"""Garbage collection around the parts of a station: when Python searches for cycles, and when not.

A station is one large cycle of objects: only the search for cycles frees what a restart leaves.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

_YOUNG = 700
"""New objects until Python searches the young ones for garbage, its own default."""

_SELDOM = 100
"""Searches of younger objects before one of all."""

_seldom = False


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Meanwhile Python looks through all objects seldom, and not at those that are there now.

    With tens of thousands of subscriptions that takes longer than a client should wait. Most of
    what ends is freed without it; the rest waits for a hundred collections of younger objects, or
    for `collect_remains`.
    """
    global _seldom
    before = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(_YOUNG, before[1], _SELDOM)
    _seldom = True
    try:
        yield
    finally:
        _seldom = False
        gc.set_threshold(*before)
        gc.unfreeze()


def collect_remains() -> None:
    """Free the parts that a station has left, where Python would do so seldom.

    It takes some 0.1 s for 200,000 objects: for a moment in which the station does nothing else.
    """
    if _seldom:
        gc.unfreeze()
        gc.collect()
        gc.freeze()
