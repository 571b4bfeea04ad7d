"""Defines of conditional pragmas: declared variables, types and units of a project, by name."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from achse.st.lexis.pragmas import ProjectDefines
from achse.st.syntax.parser import Parsed
from achse.st.syntax.printer import print_expression, print_type
from achse.st.syntax.tree import Declaration, Expression, Note
from achse.st.syntax.units import (
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Namespace,
    Program,
    Property,
    TypeDeclaration,
    Unit,
)


class SourceDefines(ProjectDefines):
    """Defines for the conditions in one source: its own variables, variables of lists, all types
    and units.

    A variable counts for the whole file it is declared in: the unit that a pragma is in shows
    only when the text is read.
    """

    def __init__(self, defines: Mapping[str, str], own: Parsed, sources: Iterable[Parsed]) -> None:
        self._defines = dict(defines)
        self._variables: dict[str, Declaration] = {}
        self._notes: dict[str, dict[str, Note]] = {"variable": {}, "type": {}, "pou": {}}
        for parsed in sources:
            for unit in _flat(parsed.units):
                self._take(unit)
                if isinstance(unit, GlobalList):
                    self._take_variables(unit)
        for unit in _flat(own.units):
            self._take_variables(unit)

    @property
    def defines(self) -> Mapping[str, str]:
        return self._defines

    def _take(self, unit: Unit) -> None:
        kind = "type" if isinstance(unit, TypeDeclaration) else "pou"
        if not isinstance(unit, Namespace):
            self._notes[kind][unit.name.lower()] = unit.note
        if isinstance(unit, FunctionBlock | Interface):
            self._notes["type"][unit.name.lower()] = unit.note
        for part in getattr(unit, "parts", ()):
            self._notes["pou"][f"{unit.name}.{part.name}".lower()] = part.note

    def _take_variables(self, unit: Unit) -> None:
        owners: list[Any] = [unit]
        if isinstance(unit, FunctionBlock | Program):
            for part in unit.parts:
                if isinstance(part, Method):
                    owners.append(part)
                elif isinstance(part, Property):
                    owners += [item for item in (part.get, part.set) if item is not None]
        for owner in owners:
            for block in getattr(owner, "blocks", ()):
                for declaration in block.variables:
                    for name in declaration.names:
                        self._variables[name.name.lower()] = declaration
                        self._notes["variable"][name.name.lower()] = declaration.note

    def is_declared(self, kind: str, name: str) -> bool:
        return name.lower() in self._notes.get(kind, {})

    def attribute(self, kind: str, name: str, attribute: str) -> str | None:
        note = self._notes.get(kind, {}).get(name.lower())
        for key, value in () if note is None else note.attributes:
            if key.lower() == attribute.lower():
                return value
        return None

    def type_name(self, variable: str) -> str:
        declaration = self._variables.get(variable.lower())
        return "" if declaration is None else print_type(declaration.type)

    def constant(self, name: str) -> str | None:
        declaration = self._variables.get(name.lower())
        if declaration is None or not isinstance(declaration.initial, Expression):
            return None
        return print_expression(declaration.initial)


def _flat(units: Iterable[Unit]) -> Iterator[Unit]:
    """Units, those in name spaces too."""
    for unit in units:
        yield unit
        if isinstance(unit, Namespace):
            yield from _flat(unit.units)
