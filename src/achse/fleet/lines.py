"""Line numbers of keys in a TOML document, which the parser of Python's library does not report."""

import tomllib
from collections.abc import Sequence
from typing import Any


def line_of(text: str, place: Sequence[str | int]) -> int:
    """Return the line, 1 and up, where the key at `place` begins; 0 if it is not there.

    `("station", 1, "name")` is `name` of the second `[[station]]`. What is above a line is a
    document too, unless it ends within a value: a key begins below the last one without it.
    """
    lines = text.splitlines(keepends=True)
    without, with_it = 0, len(lines)
    if not _has(_above(lines, with_it)[1], place):
        return 0
    while with_it - without > 1:
        middle = (without + with_it) // 2
        if _has(_above(lines, middle)[1], place):
            with_it = middle
        else:
            without = middle
    return _above(lines, with_it - 1)[0] + 1


def _above(lines: Sequence[str], count: int) -> tuple[int, Any]:
    """The longest document in the first `count` lines: how many lines it has, and its content."""
    for length in range(count, 0, -1):
        try:
            return length, tomllib.loads("".join(lines[:length]))
        except (ValueError, RecursionError):
            continue
    return 0, {}


def _has(document: Any, place: Sequence[str | int]) -> bool:
    for part in place:
        if isinstance(part, int):
            if not isinstance(document, list) or len(document) <= part:
                return False
        elif not isinstance(document, dict) or part not in document:
            return False
        document = document[part]
    return True
