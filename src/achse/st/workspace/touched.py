"""Touched units: what the check of a changed declaration may find otherwise.

Whatever a routine or a declaration looks up is a word in its text. So a unit is touched if its
declarations have the name of a touched unit, or that of a variable, value or property of one that
needs no prefix; a routine is checked again if its text has such a name. Words that mean something
else there cost time and change nothing.
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
from achse.st.syntax.outlines import outline_of
from achse.st.syntax.parser import Parsed
from achse.st.syntax.tree import Note
from achse.st.syntax.units import Namespace, Unit
from achse.st.typed.project import RoutineKind
from achse.st.workspace.cursor import first_offset

_WITHOUT_UNIT = ("", "interfaces")
"""Nodes that are checked again after each edit."""
_WORD = re.compile(r"\w+")


class Touched(NamedTuple):
    """Reach of an edit: all names in lower case."""

    units: set[str]
    """Keys of the units to declare again."""
    words: set[str]
    """Their names, and those of their contents that need no prefix."""


class WordIndex:
    """Words of files and of declarations, kept while their texts and trees are."""

    def __init__(self) -> None:
        self._files: dict[Source, tuple[str, frozenset[str]]] = {}
        self._declared: dict[DeclaredUnit, tuple[Unit, frozenset[str]]] = {}
        self._routines: dict[Source, tuple[str, dict[str, frozenset[str]]]] = {}

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
            known = self._declared[entry] = (tree, frozenset(_words_in(tree)))
        return known[1]

    def forget(self, entry: DeclaredUnit) -> None:
        """Forget the words in the declarations of a unit."""
        self._declared.pop(entry, None)

    def of_routines(
        self, source: Source, routines: Iterable[Signature]
    ) -> Mapping[str, frozenset[str]]:
        """Return the words in the text of each routine of a file, by its key; what is drawn or has
        no text is not among them. `routines` are all that the file has."""
        known = self._routines.get(source)
        if known is None or known[0] is not source.text:
            found = dict(_words_of_routines(source, list(routines)))
            known = self._routines[source] = (source.text, found)
        return known[1]

    def keep(self, sources: Iterable[Parsed], entries: Iterable[DeclaredUnit]) -> None:
        """Forget the words of all other files and units."""
        files, units = {parsed.source for parsed in sources}, set(entries)
        self._files = {key: words for key, words in self._files.items() if key in files}
        self._routines = {key: words for key, words in self._routines.items() if key in files}
        self._declared = {key: words for key, words in self._declared.items() if key in units}

    def touched(
        self,
        sources: Iterable[Parsed],
        entries: Iterable[DeclaredUnit],
        first: Touched,
    ) -> Touched:
        """Return all that an edit touches, of which it touches `first` itself.

        `entries` are the units of `sources`.
        """
        units, words = set(first.units), set(first.words)
        trees = {parsed.source: parsed.units for parsed in sources}
        waiting = [one for one in entries if one.name.lower() not in units]
        grows = True
        while grows:
            further = [
                entry
                for entry in waiting
                if not words.isdisjoint(self.of_file(entry.source, trees[entry.source]))
                and not words.isdisjoint(self.declared(entry))
            ]
            for entry in further:
                units.add(entry.name.lower())
                words.update(_names_of(entry.tree))
            waiting = [one for one in waiting if one.name.lower() not in units]
            grows = bool(further)
        return Touched(units, words)


def first_touched(
    checking: WarmChecking, known: Parsed, edited: Parsed, declared: Iterable[Diagnostic]
) -> Touched | None:
    """Return what two versions of a file declare, and units with findings that may depend on all
    names; None if everything is to be checked. `declared` are the faults of declarations."""
    scopes = checking.names.scopes
    before, after = dict(_units_of(known)), dict(_units_of(edited))
    for key in before.keys() ^ after.keys():
        if scopes.is_of_library(key) or scopes.is_of_library(key.rpartition(".")[2]):
            return None
    units, words = {*before, *after}, set[str]()
    for unit in (*before.values(), *after.values()):
        words.update(_names_of(unit))
    faulty = {one.origin.source if one.origin is not None else None for one in declared}
    if None in faulty:
        return None
    quoted = f"{known.source.path}:"  # a place there may have moved
    for node in checking.nodes.values():
        if any(quoted in one.message for one in node.warnings):
            return None
    tainted = [one for one in scopes.entries.values() if one.source in faulty]
    for key, node in checking.nodes.items():
        if node.faults and checking.routines.known(key) is None:
            owner = scopes.entries.get(checking.unit_of(key))
            if owner is not None:
                tainted.append(owner)
            elif key not in _WITHOUT_UNIT:
                return None
    for entry in tainted:
        if entry.source is not known.source:
            units.add(entry.name.lower())
            words.update(_names_of(entry.tree))
    return Touched(units, words)


def routines_again(
    checking: WarmChecking, touched: Touched, named: Container[Source], index: WordIndex
) -> list[Signature]:
    """Return the routines to check again in units that are not declared again.

    `named` are the files that have a touched name. Faults say what has a similar name, anywhere.
    """
    by_source: dict[Source, list[Signature]] = {}
    for routine in checking.routines.made:
        by_source.setdefault(routine.source, []).append(routine)
    found = []
    for source, routines in by_source.items():
        words = index.of_routines(source, routines) if source in named else None
        for routine in routines:
            node = checking.nodes.get(routine.key)
            if node is None or checking.unit_of(routine.key) in touched.units:
                continue
            own = None if words is None else words.get(routine.key)
            is_named = words is not None and (own is None or not touched.words.isdisjoint(own))
            if node.faults or is_named:
                found.append(routine)
    return found


def _words_of_routines(
    source: Source, routines: Sequence[Signature]
) -> Iterator[tuple[str, frozenset[str]]]:
    """The words in the text of each routine: from its declarations, and from its body, to where
    those of another begin."""
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
            words.update(_WORD.findall(source.text[begin:end].lower()))
        yield routine.key, frozenset(words)


def _places_of(routine: Signature) -> Iterator[int]:
    """The offsets of the declarations and of the first statement of a routine."""
    yield routine.tree.at
    if isinstance(routine.body, tuple) and routine.body:
        yield first_offset(routine.body[0])


def _names_of(unit: Unit) -> Iterator[str]:
    """The names by which others reach a unit and its contents, in lower case."""
    outline = outline_of(unit)
    yield outline.name.lower()
    yield from outline.variables
    yield from outline.properties
    yield from outline.values


def _units_of(parsed: Parsed) -> Iterator[tuple[str, Unit]]:
    """The units of a file with their keys; those in name spaces too."""
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


def _words_in(unit: Unit) -> Iterator[str]:
    """Words of a syntax tree, without bodies and comments."""
    waiting: list[Any] = [unit]
    while waiting:
        tree = waiting.pop()
        if isinstance(tree, str):
            yield from _WORD.findall(tree.lower())
        elif isinstance(tree, Note):
            waiting.append(tree.attributes)
        elif isinstance(tree, tuple):
            waiting += tree
        elif hasattr(tree, "__match_args__"):
            waiting += [getattr(tree, name) for name in tree.__match_args__ if name != "body"]
