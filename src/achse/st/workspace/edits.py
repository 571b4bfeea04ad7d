"""Edits: what a new version of a file changes in syntax trees that are kept.

If declarations are the same apart from their places, the kept trees get the places and bodies of
the new version, and only routines with other bodies are to be checked again.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from achse.st.files.files import content_of, project_file
from achse.st.lexis.source import Diagnostic, Source
from achse.st.syntax.parser import Parsed

_NAMED_FILES = re.compile(rb"<(Compile|Folder)\b[^>]*?(?:/>|>.*?</\1>)", re.DOTALL)
"""Files and folders in a `.plcproj`."""

_PARTS = ("parts", "units")
_ACCESSORS = ("get", "set")


@dataclass(frozen=True, slots=True)
class BodyEdit:
    """An edit of bodies alone, not yet made in the kept trees."""

    kept: Source
    edited: Source
    pairs: tuple[tuple[Any, Any], ...]
    """Units, parts and accessors of the kept file and of the new version."""
    start: int
    """The text from here to `end` was replaced."""
    end: int
    delta: int
    """Characters that the text became longer."""

    def moved(self, offset: int) -> int | None:
        """Return the offset of a place after the edit; None inside of what was replaced."""
        if offset < self.start:
            return offset
        return offset + self.delta if offset >= self.end else None

    def follow(self, finding: Diagnostic) -> Diagnostic | None:
        """Return a finding of a body that is the same, at its place after the edit; None if the
        place is inside of what was replaced."""
        origin = finding.origin
        if origin is None or origin.source is not self.kept:
            return finding
        at = self.moved(origin.at)
        last = None if origin.end is None else self.moved(max(origin.end - 1, 0))
        if at is None or (last is None) != (origin.end is None):
            return None
        return self.kept.fault(at, origin.message, finding.code, None if last is None else last + 1)

    def make(self) -> list[Any]:
        """Put places and bodies into the kept trees; return the routines with other bodies."""
        changed = []
        for kept, edited in self.pairs:
            for name in _field_names(kept):
                _place(getattr(kept, name), getattr(edited, name))
            kept.at = edited.at
            if hasattr(kept, "body"):
                if kept.body != edited.body:
                    changed.append(kept)
                kept.body = edited.body
        self.kept.adopt(self.edited)
        return changed


def emptied(parsed: Parsed) -> Parsed:
    """Return a file without code in the place of one that came or went."""
    source = Source("", parsed.source.path)
    source.file = parsed.source.file
    return Parsed(source, (), ())


def project_options(path: Path) -> bytes:
    """Return the content of a `.plcproj` apart from files and blanks; nothing without one."""
    project = project_file(path)
    if project is None:
        return b""
    return b"".join(_NAMED_FILES.sub(b"", content_of(project, project.name)).split())


def is_on_disk(file: Path, content: bytes) -> bool:
    """Return True if a file on disk has this content."""
    return file.is_file() and file.stat().st_size == len(content) and file.read_bytes() == content


def body_edit(kept: Parsed, edited: Parsed) -> BodyEdit | None:
    """Return the edit between two versions of a file; None if declarations differ, or if a body is
    drawn."""
    if kept.source.drawings or edited.source.drawings:
        return None
    pairs: list[tuple[Any, Any]] = []
    try:
        if not _same(kept.units, edited.units, pairs):
            return None
        _ = [one.body == other.body for one, other in pairs if hasattr(one, "body")]
    except RecursionError:  # nodes are compared in depth
        return None
    before, after = kept.source.text, edited.source.text
    start = _common(before, after)
    most = min(len(before), len(after)) - start
    tail = _common_end(before, after, most)
    end = len(before) - tail
    return BodyEdit(kept.source, edited.source, tuple(pairs), start, end, len(after) - len(before))


def _same(kept: tuple[Any, ...], edited: tuple[Any, ...], pairs: list[tuple[Any, Any]]) -> bool:
    """Return True if units or parts are the same apart from bodies and places."""
    if len(kept) != len(edited):
        return False
    for one, other in zip(kept, edited, strict=True):
        if one.__class__ is not other.__class__:
            return False
        if any(getattr(one, name) != getattr(other, name) for name in _field_names(one)):
            return False
        pairs.append((one, other))
        for name in _PARTS:
            if not _same(getattr(one, name, ()), getattr(other, name, ()), pairs):
                return False
        for name in _ACCESSORS:
            mine, theirs = getattr(one, name, None), getattr(other, name, None)
            if (mine is None) != (theirs is None):
                return False
            if mine is not None and not _same((mine,), (theirs,), pairs):
                return False
    return True


def _field_names(node: Any) -> Iterator[str]:
    """Fields of a unit, part or accessor besides its place, its body and what is inside of it."""
    names: tuple[str, ...] = node.__match_args__
    return (n for n in names if n not in ("at", "body", *_PARTS, *_ACCESSORS))


def _place(kept: Any, edited: Any) -> None:
    """Give nodes of a declaration the places of others that are equal."""
    waiting = [(kept, edited)]
    while waiting:
        one, other = waiting.pop()
        if isinstance(one, tuple):
            waiting += zip(one, other, strict=True)
        elif hasattr(one, "__match_args__") and one is not other:
            for name in one.__match_args__:
                if name == "at":
                    one.at = other.at
                else:
                    waiting.append((getattr(one, name), getattr(other, name)))


def _common(one: str, other: str) -> int:
    """Return the length of the common beginning."""
    low, high = 0, min(len(one), len(other))
    while low < high:
        middle = (low + high + 1) // 2
        if one[low:middle] == other[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _common_end(one: str, other: str, most: int) -> int:
    """Return the length of the common end, `most` at most."""
    low, high = 0, most
    while low < high:
        middle = (low + high + 1) // 2
        if one[len(one) - middle : len(one) - low] == other[len(other) - middle : len(other) - low]:
            low = middle
        else:
            high = middle - 1
    return low
