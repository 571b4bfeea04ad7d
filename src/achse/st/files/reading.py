"""Reading with texts of an editor: what it has open counts instead of the file on disk."""

import os
from collections.abc import Iterator, Mapping, MutableMapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, NamedTuple


class _Reading(NamedTuple):
    contents: Mapping[str, bytes]
    trees: MutableMapping[tuple[object, ...], Any]


_current: ContextVar[_Reading | None] = ContextVar("reading", default=None)


@contextmanager
def reading(
    contents: Mapping[str, bytes], trees: MutableMapping[tuple[object, ...], Any]
) -> Iterator[None]:
    """Meanwhile files have these contents, by `file_key`, and `trees` keeps the syntax trees.

    Trees that a caller changes must not be those that others read.
    """
    token = _current.set(_Reading(contents, trees))
    try:
        yield
    finally:
        _current.reset(token)


def file_key(file: Path) -> str:
    """Return the key of a file: its absolute path, without `..` in it."""
    return os.path.normcase(os.path.abspath(file))


def open_content(file: Path) -> bytes | None:
    """Return the content that an editor has of a file; None if it is not open."""
    current = _current.get()
    if current is None or not current.contents:
        return None
    return current.contents.get(file_key(file))


def cached_trees(
    default: MutableMapping[tuple[object, ...], Any],
) -> MutableMapping[tuple[object, ...], Any]:
    """Return the syntax trees that are kept now, by content."""
    current = _current.get()
    return default if current is None else current.trees
