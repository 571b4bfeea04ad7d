"""Uses: the variables of each unit of a project, and what reads and writes them.

The walk knows names, not types. When in doubt a variable counts as read and written: as an
argument of a call, behind ADR and REF=, in a drawn body, and wherever a member has its name.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntFlag
from typing import Any, TypeAlias

from achse.st.declared.scopes import DeclaredUnit, Scopes, with_bases
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.source import Source
from achse.st.syntax.nodes import field_names
from achse.st.syntax.tree import (
    Assign,
    Call,
    Declaration,
    Dereference,
    Expression,
    For,
    Index,
    Member,
    Name,
    NamedType,
    Note,
    PartOf,
    Try,
    TypeOperand,
    VarBlock,
)
from achse.st.syntax.unit_parts import attributes_of
from achse.st.syntax.units import (
    Accessor,
    Action,
    Function,
    FunctionBlock,
    GlobalList,
    Method,
    Program,
    Property,
)
from achse.st.values.functions import is_standard

_WORD = re.compile(r"[A-Za-z_]\w*")
_PATHS = (Name, Member, Index, Dereference, PartOf)

Owner: TypeAlias = Function | FunctionBlock | Program | GlobalList | Method | Accessor


class UseKind(IntFlag):
    """Way in which a name is used."""

    NONE = 0
    READ = 1
    WRITE = 2
    BOTH = 3


@dataclass(slots=True, eq=False)
class TrackedVariable:
    """A declared variable and its uses so far."""

    name: Name
    block: VarBlock
    declaration: Declaration
    owner: Owner
    entry: DeclaredUnit
    use: UseKind = UseKind.NONE

    @property
    def source(self) -> Source:
        """Source that declares it."""
        return self.entry.source


TrackedVariables: TypeAlias = dict[str, TrackedVariable]
"""TrackedVariables by their names in lower case."""


@dataclass(slots=True, eq=False)
class TrackedUnit:
    """A unit with its routines: each body, and the variables that it sees, the nearest first."""

    entry: DeclaredUnit
    variables: TrackedVariables
    """Variables of the unit itself."""
    parts: list[tuple[Owner | Action, TrackedVariables]] = field(default_factory=list)
    """Methods, accessors and actions, with variables of their own."""


def tracked_units(entries: Iterable[DeclaredUnit]) -> list[TrackedUnit]:
    """Return the units that have variables and bodies."""
    units = []
    for entry in entries:
        tree = entry.tree
        if isinstance(tree, Function | FunctionBlock | Program | GlobalList):
            unit = TrackedUnit(entry, _declared(tree, entry))
            for part in getattr(tree, "parts", ()):
                for owner in (part.get, part.set) if isinstance(part, Property) else (part,):
                    if owner is not None:
                        own = {} if isinstance(owner, Action) else _declared(owner, entry)
                        unit.parts.append((owner, own))
            units.append(unit)
    return units


def _declared(owner: Owner, entry: DeclaredUnit) -> TrackedVariables:
    return {
        name.name.lower(): TrackedVariable(name, block, declaration, owner, entry)
        for block in owner.blocks
        if block.section != "VAR_EXTERNAL"
        for declaration in block.variables
        for name in declaration.names
    }


def uses_of(units: Sequence[TrackedUnit], scopes: Scopes) -> None:
    """Walk through all bodies and declarations, and note the uses of the variables."""
    walk = _Walk()
    for unit, chain in with_chains(units, scopes):
        walk.unit(unit, chain)
    for unit in units:
        for variables in (unit.variables, *(own for _, own in unit.parts)):
            for key, variable in variables.items():
                variable.use |= walk.members[key]


def with_chains(
    units: Sequence[TrackedUnit], scopes: Scopes
) -> Iterator[tuple[TrackedUnit, list[TrackedVariables]]]:
    """Yield units with the variables that their bodies see: their own, then those of bases."""
    by_name = {unit.entry.name.lower(): unit.variables for unit in units}
    for unit in units:
        owners = [scope.owner.lower() for scope in with_bases(scopes.scope(unit.entry))]
        yield unit, [by_name[owner] for owner in owners if owner in by_name]


class _Walk:
    """Walk through syntax trees."""

    def __init__(self) -> None:
        self.members: dict[str, UseKind] = defaultdict(lambda: UseKind.NONE)
        """Uses of names behind a dot, wherever they are."""
        self._chain: Sequence[Mapping[str, TrackedVariable]] = ()

    def unit(self, unit: TrackedUnit, chain: list[TrackedVariables]) -> None:
        """Walk through the bodies of a unit that sees these variables."""
        tree = unit.entry.tree
        assert isinstance(tree, Function | FunctionBlock | Program | GlobalList)
        self._chain = chain
        self._owner(tree, unit)
        for owner, own in unit.parts:
            self._chain = [own, *chain]
            self._owner(owner, unit)

    def _owner(self, owner: Owner | Action, unit: TrackedUnit) -> None:
        for block in getattr(owner, "blocks", ()):
            for declaration in block.variables:
                self._declaration(declaration)
        body = () if isinstance(owner, GlobalList) else owner.body
        has_abstract_body = "ABSTRACT" in getattr(owner, "modifiers", ())
        if isinstance(body, GraphicalBody):
            for word in set(_WORD.findall(body.text)):
                self._mark(word, UseKind.BOTH)
                self.members[word.lower()] |= UseKind.BOTH
        elif (body is None and not has_abstract_body) or _is_builtin(owner, unit):
            for variable in self._chain[0].values():
                variable.use = UseKind.BOTH
        elif body:
            self._visit(body, UseKind.READ)

    def _declaration(self, declaration: Declaration) -> None:
        self._visit(declaration.type, UseKind.READ)
        self._visit(declaration.arguments, UseKind.BOTH)
        how = UseKind.BOTH if declaration.is_reference else UseKind.READ
        self._visit(declaration.initial, how)

    def _mark(self, name: str, use: UseKind) -> None:
        key = name.lower()
        for variables in self._chain:
            variable = variables.get(key)
            if variable is not None:
                variable.use |= use
                return

    def _visit(self, root: Any, use: UseKind) -> None:
        stack: list[tuple[Any, UseKind]] = [(root, use)]
        while stack:
            tree, how = stack.pop()
            kind = tree.__class__
            if kind is Name:
                self._mark(tree.name, how)
            elif kind is tuple:
                stack += [(item, _of_statement(item, how)) for item in tree]
            elif kind is Member:
                self.members[tree.name.lower()] |= how
                stack.append((tree.of, how))
            elif kind is PartOf:
                stack.append((tree.of, how))
            elif kind is Index:
                stack += [(tree.of, how), *((item, UseKind.READ) for item in tree.indices)]
            elif kind is Dereference:
                stack.append((tree.of, UseKind.READ))
            elif kind is Assign:
                bound = UseKind.BOTH if tree.operator == "REF=" else UseKind.READ
                stack += [(tree.target, UseKind.WRITE), (tree.value, bound)]
            elif kind is Call:
                stack += self._call(tree)
            elif kind is For:
                stack += [(tree.variable, UseKind.BOTH), (tree.body, UseKind.READ)]
                stack += [(item, UseKind.READ) for item in (tree.first, tree.last, tree.step)]
            elif kind is Try:
                stack += [(tree.exception, UseKind.BOTH)]  # it takes a variable, read or not
                stack += [(item, UseKind.READ) for item in (tree.body, tree.handler, tree.final)]
            elif kind is TypeOperand and isinstance(tree.type, NamedType):
                self._mark(tree.type.name.partition(".")[0], UseKind.BOTH)
            elif hasattr(tree, "__dataclass_fields__") and kind is not Note:
                stack += [(getattr(tree, name), how) for name in field_names(kind)]

    def _call(self, tree: Call) -> Iterator[tuple[Any, UseKind]]:
        """Yield what a call uses: functions of the language read their arguments, others may
        write them."""
        is_pure = isinstance(tree.of, Name) and is_standard(tree.of.name.upper())
        if not is_pure:
            yield tree.of, UseKind.BOTH
        for argument in tree.arguments:
            value: Expression | None = argument.value
            if argument.is_output:
                yield value, UseKind.WRITE
            elif isinstance(value, _PATHS) and not is_pure:
                yield value, UseKind.BOTH
            else:
                yield value, UseKind.READ


def _of_statement(tree: Any, how: UseKind) -> UseKind:
    """Return the use of an item of a list: a bare path in a list of statements is a call."""
    return UseKind.BOTH if isinstance(tree, _PATHS) else how


def _is_builtin(owner: Owner | Action, unit: TrackedUnit) -> bool:
    return any(
        "builtin" in attributes_of(note)
        for note in (owner.note, getattr(unit.entry.tree, "note", None))
        if note is not None
    )
