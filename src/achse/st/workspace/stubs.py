"""stubs of a project for names of libraries that are not here, and edits that leave them as
they are.

What a stub has follows from all uses of a name, so only a check of everything makes them. An
edit leaves them if it changes no use of what they reach, and if nothing else becomes unknown.
"""

import re
from collections import Counter
from collections.abc import Collection, Container, Iterable, Iterator
from typing import Any

from achse.st.check.warm import WarmChecking
from achse.st.declared.scopes import with_bases
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic
from achse.st.missing.libraries import OF_DEVICES, name_pattern
from achse.st.project import ProjectFiles
from achse.st.syntax.parser import Parsed
from achse.st.syntax.tree import Argument, Member
from achse.st.syntax.units import GlobalList
from achse.st.workspace.changed import changed_names
from achse.st.workspace.touched import Touched, WordIndex

_UNKNOWN = frozenset(
    (
        *(Code.UNKNOWN_TYPE, Code.UNKNOWN_NAME, Code.UNKNOWN_MEMBER, Code.UNKNOWN_ENUM_VALUE),
        *(Code.UNKNOWN_CALL, Code.UNKNOWN_PARAMETER, Code.SOURCE_MISSING),
    )
)
_WORD = re.compile(r"\w+")

_Unknown = Counter[tuple[str, str, Code | None]]
"""Faults of names that mean nothing, by file, message and code."""


def may_need_stubs(files: ProjectFiles, checking: WarmChecking) -> bool:
    """Return True if a project, checked without stubs, may get some."""
    predefined = checking.names.predefined
    return bool(files.gathered.missing) or predefined.has_shells or bool(_unknown_in(checking))


class ProjectStubs:
    """The stubs that a check of everything made, perhaps none."""

    def __init__(
        self, files: ProjectFiles, sources: tuple[Parsed, ...], checking: WarmChecking
    ) -> None:
        self.sources = sources
        """The stubs, which count as sources of libraries."""
        self._patterns = [name_pattern(one) for one in (*files.gathered.here, OF_DEVICES)]
        self._spaces = {
            space.lower()
            for folders in files.gathered.own.values()
            for spaces in folders.values()
            for space in spaces
        }
        self._is_missing = bool(files.gathered.missing)
        self._declared = frozenset(checking.names.scopes.entries)
        self._texts = {one.source.path: one.source.text for one in files.sources}
        """Texts of the files, and units, when everything was checked."""
        self._checking = checking
        self._has_shells = checking.names.predefined.has_shells
        self._unknown = _unknown_in(self._checking)
        self._reached: frozenset[str] | None = None

    def leaves(self, words: Collection[str], sources: Iterable[Parsed], index: WordIndex) -> bool:
        """Return True if words, in lower case, name nothing that stubs reach."""
        return not self.sources or self._reached_words(sources, index).isdisjoint(words)

    def leaves_texts(
        self, versions: Iterable[Parsed], sources: Iterable[Parsed], index: WordIndex
    ) -> bool:
        """Return True if versions of a file name nothing that stubs reach."""
        if not self.sources:
            return True
        texts = (set(_WORD.findall(one.source.text.lower())) for one in versions)
        return all(self.leaves(words, sources, index) for words in texts)

    def leaves_units(self, touched: Touched, sources: Collection[Parsed], index: WordIndex) -> bool:
        """Return True if nothing that names touched units names what stubs reach."""
        if not self.sources:
            return True
        reached = self._reached_words(sources, index)
        texts = (index.of_file(one.source, one.units) for one in (*sources, *self.sources))
        return not any(
            not text.isdisjoint(touched.words) and not text.isdisjoint(reached) for text in texts
        )

    def hold(self, files: ProjectFiles) -> bool:
        """Return True if a check of everything would make the same ones, after an edit that leaves
        them."""
        names = self._checking.names
        if names.predefined.has_shells != self._has_shells:
            return False
        unknown = _unknown_in(self._checking)
        if unknown == self._unknown:
            return True
        if self._is_missing or self._has_shells or self.sources:
            return False
        return not any(
            names.scopes.find(word) is None and any(one.fullmatch(word) for one in self._patterns)
            for path, word in self._words_beside(unknown - self._unknown, files)
            if not self._was_judged(path, word)
        )

    def _was_judged(self, path: str, word: str) -> bool:
        """Return True if a file had a word that meant nothing, and that got no stub."""
        if word in self._declared or path not in self._texts:
            return False
        return re.search(rf"\b{re.escape(word)}\b", self._texts[path], re.IGNORECASE) is not None

    def _words_beside(self, unknown: _Unknown, files: ProjectFiles) -> Iterator[tuple[str, str]]:
        """Yield the words of code with these faults, which may have other undeclared names, each
        with its file: of a body those that are not variables of its own; of declarations those of
        the file."""
        checking = self._checking
        for key, node in checking.nodes.items():
            if not any(_key_of(one) in unknown for one in node.faults):
                continue
            routine = checking.routines.known(key)
            if routine is None:
                paths = {one.location.path for one in node.faults}
                yield from _words_of(files, paths)
                continue
            own = {name for scope in with_bases(routine.scope) for name in scope.variables}
            text, path = routine.source.text.lower(), routine.source.path
            for word in _names_in((routine.tree.body, getattr(routine.tree, "blocks", ()))):
                if word in self._spaces or checking.names.scopes.library_named(word):
                    behind = re.findall(rf"\b{re.escape(word)}\s*\.\s*(\w+)", text)
                    yield from ((path, one) for one in behind)
                elif word not in own:
                    yield path, word
        declared = [one for one in checking.names.scopes.faults if _key_of(one) in unknown]
        yield from _words_of(files, {one.location.path for one in declared})

    def _reached_words(self, sources: Iterable[Parsed], index: WordIndex) -> frozenset[str]:
        """Return the names by which code reaches a stub, or what has its type."""
        if self._reached is None:
            scopes = self._checking.names.scopes
            every = (*sources, *self.sources)
            readable = {one.source for one in every}
            entries = [one for one in scopes.entries.values() if one.source in readable]
            stub_sources = {one.source for one in self.sources}
            own = {one.name.lower() for one in entries if one.source in stub_sources}
            words = {name for key in own for name in index.members(scopes.entries[key].tree).names}
            touched = index.touched(every, entries, Touched(own, words, own))
            trees = {key: scopes.entries[key].tree for key in touched.units}
            lists = {tree.name.lower() for tree in trees.values() if isinstance(tree, GlobalList)}
            members = {key: index.members(tree) for key, tree in trees.items()}
            self._reached = frozenset(changed_names({}, {}, own, members).words - lists)
        return self._reached


def _unknown_in(checking: WarmChecking) -> _Unknown:
    """Return the faults of names that mean nothing."""
    unknown: _Unknown = Counter()
    nodes = checking.nodes.values()
    for faults in (checking.names.scopes.faults, *(node.faults for node in nodes)):
        for one in faults:
            if one.code in _UNKNOWN:
                unknown[_key_of(one)] += 1
    return unknown


def _names_in(tree: Any) -> Iterator[str]:
    """Yield the names in some code that stand for something by themselves, in lower case: no
    members and no parameters."""
    waiting: list[Any] = [tree]
    while waiting:
        tree = waiting.pop()
        if isinstance(tree, str):
            yield from _WORD.findall(tree.lower())
        elif isinstance(tree, tuple):
            waiting += tree
        elif hasattr(tree, "__match_args__"):
            is_named = not isinstance(tree, Member | Argument)
            names = (name for name in tree.__match_args__ if is_named or name != "name")
            waiting += [getattr(tree, name) for name in names]


def _key_of(fault: Diagnostic) -> tuple[str, str, Code | None]:
    return fault.location.path, fault.message, fault.code


def _words_of(files: ProjectFiles, paths: Container[str]) -> Iterator[tuple[str, str]]:
    for one in (*files.sources, *files.libraries):
        if one.source.path in paths:
            words = set(_WORD.findall(one.source.text.lower()))
            yield from ((one.source.path, word) for word in words)
