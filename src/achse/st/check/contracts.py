"""Contracts of blocks: requirements of interfaces, abstract bases and overridden methods."""

from collections.abc import Callable, Iterator
from typing import Any

from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Section
from achse.st.check.blocks import Blocks
from achse.st.check.kinds import same_shape
from achse.st.check.life import element_of
from achse.st.check.signatures import Routines, Signature
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Failed
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.units import (
    Action,
    FunctionBlock,
    GlobalList,
    Method,
    Part,
    Program,
    Property,
)
from achse.st.typed.places import flat

Tell = Callable[[Source, int, str, Code], None]

_OF_THEIR_OWN = ("fb_init", "fb_exit", "fb_reinit")
"""Methods that each block has and that no table calls: a derived block may take more parameters."""


class Contracts:
    """Checks blocks against what they extend and implement."""

    def __init__(self, names: Resolver, blocks: Blocks, routines: Routines, fault: Tell) -> None:
        self._names = names
        self._blocks = blocks
        self._routines = routines
        self._fault = fault

    def check(self, entry: DeclaredUnit) -> None:
        """Report missing parts of a block, methods that do not match the overridden ones, and
        variables that are not allowed."""
        tree = entry.tree
        if isinstance(tree, FunctionBlock | Program | GlobalList):
            self._check_variables(entry, tree)
        if not isinstance(tree, FunctionBlock):
            return
        for part in tree.parts:
            if isinstance(part, Method) and part.name.lower() not in _OF_THEIR_OWN:
                self._check_override(entry, part)
        if "ABSTRACT" in tree.modifiers:
            return
        for name in self._missing(entry):
            self._fault(entry.source, tree.at, name, Code.PART_MISSING)

    def _check_variables(
        self, entry: DeclaredUnit, tree: FunctionBlock | Program | GlobalList
    ) -> None:
        """Report instances of abstract blocks."""
        try:
            if isinstance(tree, FunctionBlock):
                type = self._names.entry_type(entry, tree.at)
            else:
                type = self._names.unit(entry).__iec__
        except (Failed, Unexpected):
            return
        abstract = {
            member.name.lower(): inner.name
            for member in (type.own_members if isinstance(type, StructType) else ())
            if member.section is not Section.IN_OUT
            and (inner := element_of(member.type)) is not None
            and self._is_abstract_block(inner)
        }
        for block in tree.blocks if abstract else ():
            for name in (name for item in block.variables for name in item.names):
                block_name = abstract.get(name.name.lower())
                if block_name is not None:
                    message = f"{block_name} is abstract: there is no instance of it"
                    self._fault(entry.source, name.at, message, Code.ABSTRACT_INSTANCE)

    def _is_abstract_block(self, type: StructType[Any]) -> bool:
        entry = self._names.entry_of(type)
        tree = None if entry is None else entry.tree
        return isinstance(tree, FunctionBlock) and "ABSTRACT" in tree.modifiers

    def _missing(self, entry: DeclaredUnit) -> Iterator[str]:
        """Return a message for each missing part of interfaces and abstract bases."""
        is_known = not self._blocks.has_unknown_base(entry)
        for interface in self._interfaces(entry):
            for name, part in self._blocks.own_parts(interface).items():
                if name in _OF_THEIR_OWN:
                    continue
                if is_known and self._blocks.part(entry, name) is None:
                    yield f"{entry.name} implements {interface.name} without its {part.name}"
        for base in self._blocks.chain(entry)[1:]:
            for name, part in self._blocks.own_parts(base).items():
                own = self._blocks.part(entry, name)
                if own is not None and own.part is part and _is_abstract(part):
                    yield f"{entry.name} leaves {base.name}.{part.name} abstract"

    def _interfaces(self, entry: DeclaredUnit) -> list[DeclaredUnit]:
        keys = sorted(self._blocks.interfaces(entry))
        entries = self._names.scopes.entries
        return [entries[key] for key in keys if key in entries]

    def _check_override(self, entry: DeclaredUnit, part: Method) -> None:
        """Check that a method has the parameters and result of the one it overrides."""
        key = part.name.lower()
        for owner in (*self._blocks.chain(entry)[1:], *self._interfaces(entry)):
            other = self._blocks.own_parts(owner).get(key)
            if not isinstance(other, Method):
                continue
            if "FINAL" in other.modifiers and isinstance(owner.tree, FunctionBlock):
                self._fault(
                    entry.source,
                    part.at,
                    f"{owner.name}.{other.name} is FINAL",
                    Code.OVERRIDE_OF_FINAL,
                )
            try:
                own = self._routines.of_method(entry, part)
                wanted = self._routines.of_method(owner, other)
            except (Failed, Unexpected):
                continue
            difference = _difference(own, wanted)
            if difference:
                message = f"{own.name} overrides {wanted.name}, but {difference}"
                self._fault(entry.source, part.at, message, Code.OVERRIDE_DIFFERS)
                return


def _difference(own: Signature, wanted: Signature) -> str:
    """Return the difference between the parameters of two methods; empty if there is none."""
    if len(own.parameters) != len(wanted.parameters):
        return f"takes {len(own.parameters)} parameters instead of {len(wanted.parameters)}"
    for mine, theirs in zip(own.parameters, wanted.parameters, strict=True):
        name = mine.variable.name
        if mine.section != theirs.section:
            return f"its {name} is a {mine.section} instead of a {theirs.section}"
        if not _alike(mine.variable.type, theirs.variable.type):
            return f"its {name} is a {mine.type.name} instead of a {theirs.type.name}"
    mine_type = None if own.result is None else own.result.type
    their_type = None if wanted.result is None else wanted.result.type
    if mine_type is None or their_type is None:
        if mine_type is not their_type:
            return f"gives {_named(mine_type)} instead of {_named(their_type)}"
    elif not _alike(mine_type, their_type):
        return f"gives a {mine_type.name} instead of a {their_type.name}"
    return ""


def _alike(mine: IecType[Any], theirs: IecType[Any]) -> bool:
    return same_shape(flat(mine), flat(theirs))


def _named(type: IecType[Any] | None) -> str:
    return "nothing" if type is None else f"a {type.name}"


def _is_abstract(part: Part) -> bool:
    return isinstance(part, Method | Property | Action) and "ABSTRACT" in getattr(
        part, "modifiers", ()
    )
