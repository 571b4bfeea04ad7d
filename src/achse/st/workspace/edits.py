"""Edits: what a new version of a file changes in syntax trees that are kept.

If declarations are the same apart from their places and from local variables, the kept trees get
the places, locals and bodies of the new version, and only routines with others are to be checked
again.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from achse.st.files.files import content_of, project_file
from achse.st.lexis.source import Diagnostic, Source
from achse.st.syntax.parser import Parsed
from achse.st.syntax.tree import ArrayOf, NamedType, StringOf, TypeSpec, VarBlock
from achse.st.syntax.units import Accessor, Function, Method
from achse.st.workspace.changed import words_in

_NAMED_FILES = re.compile(rb"<(Compile|Folder)\b[^>]*?(?:/>|>.*?</\1>)", re.DOTALL)
"""Files and folders in a `.plcproj`."""

_PARTS = ("parts", "units")
_ACCESSORS = ("get", "set")
_LOCALS = ("VAR", "VAR_TEMP")


@dataclass(frozen=True, slots=True)
class BodyEdit:
    """An edit of bodies and of local variables alone, not yet made in the kept trees."""

    cached: Source
    edited: Source
    pairs: tuple[tuple[Any, Any], ...]
    """Units, parts and accessors of the kept file and of the new version."""
    start: int
    """The text from here to `end` was replaced."""
    end: int
    delta: int
    """Characters that the text became longer."""
    declaring: tuple[Function | Method | Accessor, ...] = ()
    """Kept routines that get other local variables."""

    def moved(self, offset: int) -> int | None:
        """Return the offset of a place after the edit; None inside of what was replaced."""
        if offset < self.start:
            return offset
        return offset + self.delta if offset >= self.end else None

    def follow(self, finding: Diagnostic) -> Diagnostic | None:
        """Return a finding of a body that is the same, at its place after the edit; None if the
        place is inside of what was replaced."""
        origin = finding.origin
        if origin is None or origin.source is not self.cached:
            return finding
        at = self.moved(origin.at)
        last = None if origin.end is None else self.moved(max(origin.end - 1, 0))
        if at is None or (last is None) != (origin.end is None):
            return None
        return self.cached.fault(
            at, origin.message, finding.code, None if last is None else last + 1
        )

    def words(self) -> set[str]:
        """Return the words of the bodies and variables that change, before and after, in lower
        case."""
        words: set[str] = set()
        for pair in self.pairs:
            for name in ("body", "blocks"):
                before, after = (getattr(one, name, None) for one in pair)
                if before != after:
                    words.update(words_in((before, after), is_code=True))
        return words

    def make(self) -> list[Any]:
        """Put places, local variables and bodies into the kept trees; return the routines with
        others."""
        changed = []
        declaring = set(map(id, self.declaring))
        for cached, edited in self.pairs:
            is_declaring = id(cached) in declaring
            for name in _field_names(cached):
                if name == "blocks" and is_declaring:
                    cached.blocks = edited.blocks
                else:
                    _place(getattr(cached, name), getattr(edited, name))
            cached.at = edited.at
            if hasattr(cached, "body"):
                if is_declaring or cached.body != edited.body:
                    changed.append(cached)
                cached.body = edited.body
        self.cached.adopt(self.edited)
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


def body_edit(cached: Parsed, edited: Parsed) -> BodyEdit | None:
    """Return the edit between two versions of a file; None if declarations differ that others may
    see, or if a body is drawn."""
    if cached.source.drawings or edited.source.drawings:
        return None
    pairs: list[tuple[Any, Any]] = []
    declaring: tuple[Any, ...] = ()
    try:
        if not _same(cached.units, edited.units, pairs):
            return None
        _ = [one.body == other.body for one, other in pairs if hasattr(one, "body")]
        declaring = tuple(
            one for one, other in pairs if isinstance(one, _ROUTINES) and one.blocks != other.blocks
        )
    except RecursionError:  # nodes are compared in depth
        return None
    before, after = cached.source.text, edited.source.text
    start = _common(before, after)
    most = min(len(before), len(after)) - start
    tail = _common_end(before, after, most)
    end = len(before) - tail
    delta = len(after) - len(before)
    return BodyEdit(cached.source, edited.source, tuple(pairs), start, end, delta, declaring)


def _same(cached: tuple[Any, ...], edited: tuple[Any, ...], pairs: list[tuple[Any, Any]]) -> bool:
    """Return True if units or parts are the same apart from bodies, locals and places."""
    if len(cached) != len(edited):
        return False
    for one, other in zip(cached, edited, strict=True):
        if one.__class__ is not other.__class__:
            return False
        for name in _field_names(one):
            before, after = getattr(one, name), getattr(other, name)
            if before == after:
                continue
            if name != "blocks" or not isinstance(one, _ROUTINES):
                return False
            if _shared_blocks(before) != _shared_blocks(after):
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


_ROUTINES = (Function, Method, Accessor)


def _shared_blocks(blocks: Iterable[VarBlock]) -> list[VarBlock]:
    """Return the variables of a routine that others may see, or whose types have no name."""
    return [
        block
        for block in blocks
        if block.section not in _LOCALS
        or "CONSTANT" in block.qualifiers
        or not all(_has_name(declaration.type) for declaration in block.variables)
    ]


def _has_name(spec: TypeSpec) -> bool:
    """Return True if a type is a named one, a string, or an array of those."""
    while isinstance(spec, ArrayOf):
        spec = spec.element
    return isinstance(spec, NamedType | StringOf)


def _field_names(node: Any) -> Iterator[str]:
    """Fields of a unit, part or accessor besides its place, its body and what is inside of it."""
    names: tuple[str, ...] = node.__match_args__
    return (n for n in names if n not in ("at", "body", *_PARTS, *_ACCESSORS))


def _place(cached: Any, edited: Any) -> None:
    """Give nodes of a declaration the places of others that are equal."""
    waiting = [(cached, edited)]
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
