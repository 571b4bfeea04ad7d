"""Touched units: what the check of a changed declaration may find otherwise.

Whatever a routine or a declaration looks up is a word in its text. So a unit is touched if its
declarations have the name of a touched unit, or that of a variable, value or property of one that
needs no prefix. A touched unit is declared again; a routine, of such a unit or of another, is
checked again if its text has a changed name. Words that mean something else there cost time and
change nothing.
"""

import re
from bisect import bisect_right
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from achse.st.check.signatures import Signature
from achse.st.check.warm import WarmChecking
from achse.st.declared.scopes import DeclaredUnit
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.source import Diagnostic, Source
from achse.st.syntax.parser import Parsed
from achse.st.syntax.units import GlobalList, Namespace, Unit
from achse.st.typed.project import RoutineKind
from achse.st.workspace.changed import (
    UnitMembers,
    differing,
    members_of,
    names_of,
    words_in,
)
from achse.st.workspace.cursor import first_offset

_WITHOUT_UNIT = ("", "interfaces")
"""Nodes that are checked again after each edit."""
_WORD = re.compile(r"\w+")
_BY_ITSELF = re.compile(r"\w+\b(?!\s*\^?\s*\.(?!\.))")
_INTO = re.compile(r"\w+\b(?=\s*\^?\s*\.(?!\.))")
"""Names before a dot, that of a pointer too; a range is none."""


class Touched(NamedTuple):
    """Reach of an edit: all names in lower case."""

    units: set[str]
    """Keys of the units to declare again."""
    words: set[str]
    """Their names, and those of their contents that need no prefix."""
    wholes: set[str]
    """Keys of those of which everything may be other."""


class WordIndex:
    """Words of files and of declarations, kept while their texts and trees are."""

    def __init__(self) -> None:
        self._files: dict[Source, tuple[str, frozenset[str]]] = {}
        self._declared: dict[DeclaredUnit, tuple[Unit, frozenset[str]]] = {}
        self._routines: dict[Source, tuple[str, dict[str, frozenset[str]]]] = {}
        self._members: dict[int, tuple[Unit, UnitMembers]] = {}

    def of_file(self, source: Source, units: Iterable[Unit] = ()) -> frozenset[str]:
        """Return the words in a file, its drawn bodies included."""
        known = self._files.get(source)
        if known is None or known[0] is not source.text:
            words = set(_WORD.findall(source.text.lower()))
            if source.drawings:
                for text in _drawn(units):
                    words.update(_WORD.findall(text.lower()))
            known = self._files[source] = (source.text, frozenset(words))
        return known[1]

    def declared(self, entry: DeclaredUnit) -> frozenset[str]:
        """Return the words in the declarations of a unit, its parts included."""
        tree = entry.tree
        known = self._declared.get(entry)
        if known is None or known[0] is not tree:
            known = self._declared[entry] = (tree, frozenset(words_in(tree)))
        return known[1]

    def members(self, tree: Unit) -> UnitMembers:
        """Return what the declarations of a unit say of its members."""
        known = self._members.get(id(tree))
        if known is None or known[0] is not tree:
            known = self._members[id(tree)] = (tree, members_of(tree))
        return known[1]

    def forget(self, entry: DeclaredUnit) -> None:
        """Forget the words in the declarations of a unit."""
        self._declared.pop(entry, None)
        self._members.pop(id(entry.tree), None)

    def of_routines(
        self, source: Source, routines: Iterable[Signature]
    ) -> Mapping[str, frozenset[str]]:
        """Return the words in the text of each routine of a file, by its key, `name.` for one in
        front of a dot; what is drawn or has no text is not among them. `routines` are all that the
        file has."""
        known = self._routines.get(source)
        if known is None or known[0] is not source.text:
            words = dict(_words_of_routines(source, list(routines)))
            known = self._routines[source] = (source.text, words)
        return known[1]

    def keep(self, sources: Iterable[Parsed], entries: Iterable[DeclaredUnit]) -> None:
        """Forget the words of all other files and units."""
        files, units = {parsed.source for parsed in sources}, set(entries)
        self._files = {key: words for key, words in self._files.items() if key in files}
        self._routines = {key: words for key, words in self._routines.items() if key in files}
        self._declared = {key: words for key, words in self._declared.items() if key in units}
        trees = {id(entry.tree) for entry in units}
        self._members = {key: known for key, known in self._members.items() if key in trees}

    def touched(
        self,
        sources: Iterable[Parsed],
        entries: Iterable[DeclaredUnit],
        first: Touched,
        sound: Container[str] = (),
    ) -> Touched:
        """Return all that an edit touches, of which it touches `first` itself.

        `entries` are the units of `sources`; of lists that are `sound`, keys, variables count one
        by one.
        """
        units, words = set(first.units), set(first.words)
        trees = {parsed.source: parsed.units for parsed in sources}
        waiting = [one for one in entries if one.name.lower() not in units]
        lists: list[DeclaredUnit] = []
        grows = True
        while grows:
            further = [
                entry
                for entry in waiting
                if not words.isdisjoint(self.of_file(entry.source, trees[entry.source]))
                and not words.isdisjoint(self.declared(entry))
            ]
            before = len(words)
            for entry in further:
                units.add(entry.name.lower())
                if isinstance(entry.tree, GlobalList) and entry.name.lower() in sound:
                    words.add(entry.tree.name.lower())
                    lists.append(entry)
                else:
                    words.update(names_of(entry.tree))
            for entry in lists:
                for member in self.members(entry.tree).members:
                    if not words.isdisjoint(member.words):
                        words.update(member.names)
            waiting = [one for one in waiting if one.name.lower() not in units]
            grows = bool(further) or len(words) > before
        return Touched(units, words, first.wholes)


def first_touched(
    checking: WarmChecking,
    known: Parsed,
    edited: Parsed,
    declared: Iterable[Diagnostic],
    *,
    is_whole: bool = False,
) -> Touched | None:
    """Return what two versions of a file declare, and units with findings that may depend on all
    names; None if everything is to be checked.

    `declared` are the faults of declarations. With `is_whole` everything in the file may be other.
    """
    scopes = checking.names.scopes
    before, after = dict(units_of(known)), dict(units_of(edited))
    for key in before.keys() ^ after.keys():
        if scopes.is_of_library(key) or scopes.is_of_library(key.rpartition(".")[2]):
            return None
    units, words = {*before, *after}, set[str]()
    faulty = {one.origin.source if one.origin is not None else None for one in declared}
    if None in faulty:
        return None
    is_whole |= known.source in faulty
    for key in before.keys() | after.keys():
        versions = [one[key] for one in (before, after) if key in one]
        words.update(_given_names(versions, is_whole=is_whole))
    quoted = f"{known.source.path}:"  # a place there may have moved
    for node in checking.nodes.values():
        if any(quoted in one.message for one in node.warnings):
            return None
    tainted = [one for one in scopes.entries.values() if one.source in faulty]
    for key, node in checking.nodes.items():
        if node.faults and checking.routines.entry(key) is None:
            owner = scopes.entries.get(checking.unit_of(key))
            if owner is not None:
                tainted.append(owner)
            elif key not in _WITHOUT_UNIT:
                return None
    wholes = {*before, *after} if is_whole else set()
    for entry in tainted:
        wholes.add(entry.name.lower())
        if entry.source is not known.source:
            units.add(entry.name.lower())
            words.update(names_of(entry.tree))
    return Touched(units, words, wholes)


def _given_names(versions: Sequence[Unit], *, is_whole: bool) -> Iterable[str]:
    """Return the names of a unit, and those of its contents that need no prefix; of a list those
    alone that differ between two versions, unless it `is_whole`."""
    if not is_whole and len(versions) == 2 and isinstance(versions[0], GlobalList):
        different = differing(*versions)
        if different is not None:
            return (versions[0].name.lower(), *different)
    return {name for unit in versions for name in names_of(unit)}


def _words_of_routines(
    source: Source, routines: Sequence[Signature]
) -> Iterator[tuple[str, frozenset[str]]]:
    """Yield the words in the text of each routine: from its declarations, and from its body, to
    where those of another begin."""
    places = {routine.key: tuple(_places_of(routine)) for routine in routines}
    ends = sorted({place for own in places.values() for place in own})
    pieces = [piece.start for piece in source.pieces]
    for routine in routines:
        if routine.kind is RoutineKind.LIFE or isinstance(routine.body, GraphicalBody):
            continue
        words: set[str] = set()
        for place in places[routine.key]:
            piece = bisect_right(pieces, place)
            begin = max(pieces[piece - 1] if piece else 0, source.text.rfind("\n", 0, place) + 1)
            following = bisect_right(ends, place)
            end = ends[following] if following < len(ends) else len(source.text)
            text = source.text[begin:end].lower()
            words.update(_BY_ITSELF.findall(text))
            words.update(f"{name}." for name in _INTO.findall(text))
        yield routine.key, frozenset(words)


def _places_of(routine: Signature) -> Iterator[int]:
    """Yield the offsets of the declarations and of the first statement of a routine."""
    yield routine.tree.at
    if isinstance(routine.body, tuple) and routine.body:
        yield first_offset(routine.body[0])


def units_of(parsed: Parsed) -> Iterator[tuple[str, Unit]]:
    """Yield the units of a file with their keys; those in name spaces too."""
    waiting: list[tuple[str, Unit]] = [("", unit) for unit in parsed.units]
    while waiting:
        space, unit = waiting.pop()
        name = f"{space}{unit.name.lower()}"
        if isinstance(unit, Namespace):
            waiting += [(f"{name}.", inner) for inner in unit.units]
        else:
            yield name, unit


def _drawn(units: Iterable[Unit]) -> Iterator[str]:
    """Texts of the drawn bodies in some units."""
    waiting: list[Any] = list(units)
    while waiting:
        tree = waiting.pop()
        for name in ("units", "parts"):
            waiting += getattr(tree, name, ())
        waiting += [one for one in (getattr(tree, "get", None), getattr(tree, "set", None)) if one]
        body = getattr(tree, "body", None)
        if isinstance(body, GraphicalBody):
            yield body.text
