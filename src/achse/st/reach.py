"""Reached units: what the programs of tasks name, and what that names in turn.

A project is built from its reached units: a fault in another unit is a warning. Attributes and
names by which the runtime finds a unit count as mentions by a task, and so does a name in a unit
that is reached, whatever the name means there.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import PurePosixPath
from typing import NamedTuple

from achse.st.declared.resolve import Resolver, generics_of
from achse.st.declared.scopes import DeclaredUnit
from achse.st.files.forms import Content, has_content
from achse.st.lexis.source import Diagnostic, Source
from achse.st.mentions import Mentions, mentions_of
from achse.st.syntax.parser import Parsed
from achse.st.syntax.tree import NO_NOTE
from achse.st.syntax.unit_parts import attributes_of
from achse.st.syntax.units import Function, GlobalList, Program

_WITH_UNITS = (Content.TEXT, Content.ENVELOPE, Content.EXPORT, Content.PLCOPEN)

_CALLED_BY_RUNTIME = frozenset(
    ("linkalways", "call_after_global_init_slot", "call_after_online_change_slot")
)
"""Attributes that reach a unit without a mention."""

_IMPLICIT_CHECKS = frozenset(
    {
        "checkbounds",
        "checkdivdint",
        "checkdivlint",
        "checkdivreal",
        "checkdivlreal",
        "checkrangesigned",
        "checkrangeunsigned",
        "checklrangesigned",
        "checklrangeunsigned",
        "checkpointer",
    }
)

_HEAD = re.compile(
    r"\b(?:FUNCTION_BLOCK|FUNCTION|PROGRAM|INTERFACE)\s+"
    r"(?:(?:PUBLIC|PRIVATE|PROTECTED|INTERNAL|ABSTRACT|FINAL)\s+)*([A-Za-z_]\w*)",
    re.IGNORECASE,
)
_WORD = re.compile(r"[A-Za-z_]\w*")


class Findings(NamedTuple):
    """Faults of a project by what they mean for its build."""

    errors: list[Diagnostic]
    unreached: list[Diagnostic]
    """Faults in units that no program of a task reaches."""


class Reach:
    """Units of a project that the programs of its tasks reach.

    `programs` are the names of programs that tasks call. If none of them is declared, every unit
    is reached. `sources` are those of the project and of its libraries, `mentions` those of units
    that did not change since.
    """

    def __init__(
        self,
        names: Resolver,
        sources: Iterable[Parsed],
        programs: Iterable[str] = (),
        mentions: dict[DeclaredUnit, Mentions] | None = None,
    ) -> None:
        self._names = names
        self._scopes = names.scopes
        self._sources = tuple(sources)
        self._programs = tuple(name.lower() for name in programs)
        self._own_sources = {parsed.source for parsed in self._sources}
        self._mentions = {} if mentions is None else mentions
        self.has_errors = False
        """True once `findings` had an error."""

    def findings(self, faults: Iterable[Diagnostic]) -> Findings:
        """Return faults as errors and as faults of unreached units.

        If a reached unit could not be declared and no error says why, all faults are errors.
        """
        faults = list(faults)
        findings = Findings([], [])
        if not self._is_partial:
            findings.errors.extend(faults)
        else:
            for fault in faults:
                findings[not self._is_error(fault)].append(fault)
        self.has_errors |= bool(findings.errors)
        if findings.unreached and not self.has_errors and any(map(self._is_undeclared, self.units)):
            return Findings(faults, [])
        return findings

    def dependent_on(self, faults: Iterable[Diagnostic]) -> frozenset[str]:
        """Return the unreached units that have one of these faults, and those that name such a
        unit, directly or not, as keys in lower case."""
        faults = list(faults)
        if not faults:
            return frozenset()
        rest = [entry for entry in self._walkable if entry not in self.units]
        tainted = {entry for fault in faults for entry in self._owners(fault)} - self.units
        grows = True
        while grows:
            further = {
                entry
                for entry in rest
                if entry not in tainted and not tainted.isdisjoint(self._mentions_of(entry).units)
            }
            tainted |= further
            grows = bool(further)
        return frozenset(entry.name.lower() for entry in tainted)

    @property
    def _is_partial(self) -> bool:
        """True if tasks call a program that is declared."""
        return any(name in self._scopes.entries for name in self._programs)

    # units -----------------------------------------------------------------------------------

    @cached_property
    def units(self) -> frozenset[DeclaredUnit]:
        """The reached units, those of the user's libraries included."""
        waiting = [entry for entry in self._walkable if self._is_root(entry)]
        reached = set(waiting)
        while waiting:
            for entry in self._mentions_of(waiting.pop()).units - reached:
                reached.add(entry)
                if entry.source in self._own_sources:
                    waiting.append(entry)
        return frozenset(reached)

    @property
    def _walkable(self) -> Iterator[DeclaredUnit]:
        """Units of the project and of the user's libraries."""
        entries = self._scopes.entries.values()
        return (entry for entry in entries if entry.source in self._own_sources)

    def _is_shipped(self, entry: DeclaredUnit) -> bool:
        """Return True for a unit of a library that comes with achse."""
        return entry.source not in self._own_sources

    def _mentions_of(self, entry: DeclaredUnit) -> Mentions:
        if entry not in self._mentions:
            self._mentions[entry] = mentions_of(entry, self._scopes)
        return self._mentions[entry]

    def _is_root(self, entry: DeclaredUnit) -> bool:
        if entry.is_library:
            return False
        name = entry.name.lower()
        if name in (_IMPLICIT_CHECKS if isinstance(entry.tree, Function) else self._programs):
            return True
        tree = entry.tree
        if isinstance(tree, GlobalList) and any(b.section == "VAR_CONFIG" for b in tree.blocks):
            return True
        parts = getattr(tree, "parts", ()) if isinstance(tree, Program) else ()
        return any(
            not _CALLED_BY_RUNTIME.isdisjoint(
                key.lower() for key in attributes_of(getattr(item, "note", NO_NOTE))
            )
            for item in (tree, *parts)
        )

    def _is_undeclared(self, entry: DeclaredUnit) -> bool:
        """Return True if a unit of the project could not be declared."""
        if entry.is_library or generics_of(entry):
            return False
        if isinstance(entry.tree, GlobalList | Program):
            return entry.name.lower() not in self._names.units
        return entry.failed

    # faults ----------------------------------------------------------------------------------

    def _is_error(self, fault: Diagnostic) -> bool:
        if not has_content(PurePosixPath(fault.location.path), *_WITH_UNITS):
            return True
        owners = self._owners(fault)
        if not self.units.isdisjoint(owners) or any(map(self._is_shipped, owners)):
            return True
        if owners and fault not in self._syntax_faults:
            return False
        return not self._mentioned.isdisjoint(self._names_in(fault.location.path))

    @cached_property
    def _by_path(self) -> Mapping[str, Sequence[DeclaredUnit]]:
        """Units by the file they are in, in the order of their places."""
        by_path: dict[str, list[DeclaredUnit]] = {}
        for entry in self._scopes.entries.values():
            by_path.setdefault(entry.source.path, []).append(entry)
        for entries in by_path.values():
            entries.sort(key=lambda entry: entry.at)
        return by_path

    @cached_property
    def _syntax_faults(self) -> frozenset[Diagnostic]:
        return frozenset(fault for parsed in self._sources for fault in parsed.faults)

    def _owners(self, fault: Diagnostic) -> set[DeclaredUnit]:
        """Return the unit that a fault is in; of a fault of the syntax all units of the file."""
        entries = self._by_path.get(fault.location.path, ())
        if len(entries) < 2 or fault in self._syntax_faults:
            return set(entries)
        owners: dict[Source, DeclaredUnit] = {}
        for entry in entries:  # a file of the project and one of a library may have one name
            known = owners.setdefault(entry.source, entry)
            if entry.source.locate(entry.at) <= fault.location or known is entry:
                owners[entry.source] = entry
        return set(owners.values())

    @cached_property
    def _mentioned(self) -> frozenset[str]:
        """Names that reached units mention and nothing declares, and names of reached units."""
        names = {*self._programs, *(unit.name.lower() for unit in self.units)}
        for entry in self.units:
            if entry.source in self._own_sources:
                names |= self._mentions_of(entry).unknown
        return frozenset(names)

    def _names_in(self, path: str) -> set[str]:
        """Return the names that a file with a fault of the syntax would declare."""
        names = {PurePosixPath(path).stem.lower()}
        for parsed in self._sources:
            if parsed.source.path == path:
                text = parsed.source.text
                heads = _HEAD.findall(text)  # without one, it declares variables or values
                names.update(name.lower() for name in heads or _WORD.findall(text))
        return names
