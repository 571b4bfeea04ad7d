"""stubs of a project for names of libraries that are not here, and edits that leave them as
they are.

What a stub has follows from all uses of a name, so only a check of everything makes them. An
edit leaves them if it changes no use of what they reach, and if nothing else becomes unknown.
"""

import re
from collections import Counter
from collections.abc import Collection, Iterable

from achse.st.check.warm import WarmChecking
from achse.st.lexis.codes import Code
from achse.st.missing.libraries import OF_DEVICES, name_pattern
from achse.st.project import ProjectFiles
from achse.st.syntax.parser import Parsed
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
    return bool(files.found.missing) or predefined.has_shells or bool(_unknown_in(checking))


class ProjectStubs:
    """The stubs that a check of everything made, perhaps none."""

    def __init__(
        self, files: ProjectFiles, sources: tuple[Parsed, ...], checking: WarmChecking
    ) -> None:
        self.sources = sources
        """The stubs, which count as sources of libraries."""
        self._patterns = [name_pattern(one) for one in (*files.found.here, OF_DEVICES)]
        self._is_missing = bool(files.found.missing)
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
        paths = {path for path, _, _ in unknown - self._unknown}
        places = [one.source for one in (*files.sources, *files.libraries)]
        texts = [one.text for one in places if one.path in paths or "" in paths]
        words = {word for text in texts for word in _WORD.findall(text)}
        return not any(
            pattern.fullmatch(word) and names.scopes.find(word) is None
            for word in words
            for pattern in self._patterns
        )

    def _reached_words(self, sources: Iterable[Parsed], index: WordIndex) -> frozenset[str]:
        """The names by which code reaches a stub, or what has its type."""
        if self._reached is None:
            scopes = self._checking.names.scopes
            every = (*sources, *self.sources)
            readable = {one.source for one in every}
            entries = [one for one in scopes.entries.values() if one.source in readable]
            made = {one.source for one in self.sources}
            own = {one.name.lower() for one in entries if one.source in made}
            words = {name for key in own for name in index.members(scopes.entries[key].tree).names}
            touched = index.touched(every, entries, Touched(own, words, own))
            trees = {key: scopes.entries[key].tree for key in touched.units}
            lists = {tree.name.lower() for tree in trees.values() if isinstance(tree, GlobalList)}
            members = {key: index.members(tree) for key, tree in trees.items()}
            self._reached = frozenset(changed_names({}, {}, own, members).words - lists)
        return self._reached


def _unknown_in(checking: WarmChecking) -> _Unknown:
    """The faults of names that mean nothing."""
    found: _Unknown = Counter()
    nodes = checking.nodes.values()
    for faults in (checking.names.scopes.faults, *(node.faults for node in nodes)):
        for one in faults:
            if one.code in _UNKNOWN:
                found[one.location.path, one.message, one.code] += 1
    return found
