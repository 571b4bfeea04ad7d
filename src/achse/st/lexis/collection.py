"""Pause of Python's search for garbage while many objects are made that all stay."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

_MANY = 50_000
"""New objects from which on they are made old before the next search for garbage."""


@contextmanager
def collection_paused() -> Iterator[None]:
    """Meanwhile Python looks for no cycles of garbage: with 100,000 variables in the making, all
    of them kept, that search takes as long as the rest. Afterwards they count as old, so that the
    next search does not begin with them."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        # Counting what is frozen walks over all of it: only where the search would cost more.
        if gc.get_count()[0] > _MANY and not gc.get_freeze_count():
            gc.freeze()
            gc.unfreeze()
        gc.enable()
