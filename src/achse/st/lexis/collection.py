"""Pause of Python's search for garbage while many objects are made that all stay."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

_MANY = 50_000
"""New objects from which on they are made old before the next search for garbage."""

_MOST_UNSEARCHED = 400_000
"""Objects made old without a search, from which on the next pause ends with one."""


class _OldObjects:
    """Count of the objects that were made old without a search.

    Python counts those that its own searches made old, and searches all when they are many. What a
    process makes and drops again and again, as a language server does, would stay for ever.
    """

    def __init__(self) -> None:
        self._unsearched = 0
        self._survivors = 0

    def add(self, count: int) -> None:
        """Make new objects old, or search for garbage among all."""
        self._unsearched += count
        if self._unsearched > max(_MOST_UNSEARCHED, self._survivors):
            gc.collect()
            self._unsearched = 0
        gc.freeze()
        if not self._unsearched:
            self._survivors = gc.get_freeze_count()
        gc.unfreeze()


_old = _OldObjects()


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
        count = gc.get_count()[0]
        if count > _MANY and not gc.get_freeze_count():
            _old.add(count)
        gc.enable()
