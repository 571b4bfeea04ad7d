"""Symbols: what names mean, by their declarations, and the symbols that a source declares.

A meaning comes from the checker; here it is followed to the declaration that it was made of.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from achse.iec.derived import InterfaceType, resolved
from achse.iec.enums import EnumType
from achse.iec.structs import StructType
from achse.st.check.blocks import FoundPart
from achse.st.check.checking import Checking, NameUse
from achse.st.check.meanings import (
    BaseInstance,
    BuiltinName,
    Callee,
    Meaning,
    PropertyUse,
    TypeName,
    UnitName,
)
from achse.st.check.operands import TypedOperand
from achse.st.check.signatures import Signature
from achse.st.declared.scopes import Declared, DeclaredUnit, Scope
from achse.st.lexis.source import Source
from achse.st.syntax.tree import Argument, Declaration, EnumOf, Literal, Member, VarBlock
from achse.st.syntax.unit_parts import blocks_of
from achse.st.syntax.units import (
    Accessor,
    Action,
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Program,
    Property,
    TypeDeclaration,
)


class SymbolKind(Enum):
    """Kinds of symbols."""

    VARIABLE = "variable"
    CONSTANT = "constant"
    MEMBER = "member"
    ENUM_VALUE = "enumeration value"
    TYPE = "type"
    STRUCTURE = "structure"
    ENUMERATION = "enumeration"
    BLOCK = "function block"
    INTERFACE = "interface"
    PROGRAM = "program"
    FUNCTION = "function"
    LIST = "variable list"
    METHOD = "method"
    ACTION = "action"
    PROPERTY = "property"
    BUILTIN = "function of the language"


_PARTS = {Method: SymbolKind.METHOD, Action: SymbolKind.ACTION, Property: SymbolKind.PROPERTY}
_UNITS = {
    FunctionBlock: SymbolKind.BLOCK,
    Interface: SymbolKind.INTERFACE,
    Program: SymbolKind.PROGRAM,
    Function: SymbolKind.FUNCTION,
    GlobalList: SymbolKind.LIST,
}


@dataclass(frozen=True, slots=True)
class DeclaredSymbol:
    """A declared name. `node` is its name, value, part or unit in the syntax tree: one for each
    declaration, whose place follows edits."""

    name: str
    kind: SymbolKind
    source: Source | None = field(compare=False)
    """None of a function of the language."""
    node: Any = field(compare=False)
    container: str = field(default="", compare=False)
    declared: Declared | None = field(default=None, compare=False)
    """Block and declaration of a variable."""
    entry: DeclaredUnit | None = field(default=None, compare=False)
    """The unit that it is, or is in."""
    identity: int = 0

    @property
    def at(self) -> int | None:
        """Offset of its name in the source; None if the name is not in the code: that of an
        action or a list is in its file alone."""
        if self.source is None or self.node is None:
            return None
        at: int = self.node.at
        written = self.source.text[at : at + len(self.name)]
        return at if written.lower() == self.name.lower() else None

    @property
    def place(self) -> int:
        """Offset of its name, or of the code that belongs to it."""
        at = self.at
        return at if at is not None else getattr(self.node, "at", 0)


def _symbol(name: str, kind: SymbolKind, source: Source, node: Any, **more: Any) -> DeclaredSymbol:
    return DeclaredSymbol(name, kind, source, node, identity=id(node), **more)


def symbol_of_unit(entry: DeclaredUnit) -> DeclaredSymbol:
    """Return the symbol of a unit."""
    tree = entry.tree
    name = entry.name.partition("<")[0].rpartition(".")[2]
    return _symbol(name, _kind_of_unit(tree), entry.source, tree, entry=entry)


def _kind_of_unit(tree: Any) -> SymbolKind:
    if isinstance(tree, TypeDeclaration):
        if isinstance(tree.type, EnumOf):
            return SymbolKind.ENUMERATION
        return SymbolKind.STRUCTURE if blocks_of(tree) else SymbolKind.TYPE
    return _UNITS.get(tree.__class__, SymbolKind.TYPE)


def _of_variable(
    key: str, declared: Declared, source: Source, container: str, entry: DeclaredUnit | None
) -> DeclaredSymbol | None:
    block, declaration = declared
    kind = SymbolKind.CONSTANT if "CONSTANT" in block.qualifiers else SymbolKind.VARIABLE
    if entry is not None and isinstance(entry.tree, TypeDeclaration):
        kind = SymbolKind.MEMBER
    for item in declaration.names:
        if item.name.lower() == key:
            return _symbol(
                item.name, kind, source, item, container=container, declared=declared, entry=entry
            )
    return None


def _of_part(entry: DeclaredUnit, part: Any) -> DeclaredSymbol:
    kind = _PARTS[part.__class__]
    return _symbol(part.name, kind, entry.source, part, container=entry.name, entry=entry)


def of_enum_value(entry: DeclaredUnit, key: str) -> DeclaredSymbol | None:
    """Return the symbol of a value of an enumeration; None if it has no such value."""
    tree = entry.tree
    if isinstance(tree, TypeDeclaration) and isinstance(tree.type, EnumOf):
        for value in tree.type.values:
            if value.name.lower() == key:
                return _symbol(
                    value.name,
                    SymbolKind.ENUM_VALUE,
                    entry.source,
                    value,
                    container=entry.name,
                    entry=entry,
                )
    return None


# meanings ---------------------------------------------------------------------------------------


def symbol_of(use: NameUse) -> DeclaredSymbol | None:
    """Return the symbol that a name in a body means; None if it means nothing that is declared."""
    checking, tree = use.body.checking, use.tree
    if isinstance(tree, Argument):
        assert isinstance(use.whole, Signature)
        return _parameter(checking, use.whole, tree.name.lower())
    if isinstance(tree, Literal):
        prefix, _, value = tree.text.partition("#")
        entry = checking.names.scopes.find(prefix, use.body.scope.space)
        return None if entry is None else of_enum_value(entry, value.lower())
    if isinstance(tree, Member):
        assert not isinstance(use.whole, Signature)
        return _of_member(checking, tree.name.lower(), use.whole, use.meaning)
    return _of_name(use.body, tree.name.lower(), use.meaning)


def _parameter(checking: Checking, signature: Signature, key: str) -> DeclaredSymbol | None:
    scopes = checking.names.scopes
    declared = scopes.own(key, signature.scope)
    if declared is None:
        return None
    return of_scope(checking, key, *declared)


def of_scope(
    checking: Checking, key: str, scope: Scope, declared: Declared
) -> DeclaredSymbol | None:
    """Return the symbol of a variable that a scope declares."""
    entry = checking.names.scopes.entries.get(scope.owner.partition("<")[0].lower())
    return _of_variable(key, declared, scope.source, scope.owner, entry)


def _of_routine(signature: Signature) -> DeclaredSymbol:
    tree = signature.accessor_of or signature.tree
    if tree.__class__ in _PARTS:
        return _of_part(signature.entry, tree)
    return symbol_of_unit(signature.entry)


def _of_meaning(meaning: Meaning | None) -> DeclaredSymbol | None:
    match meaning:
        case Callee(signature):
            return _of_routine(signature)
        case PropertyUse(entry, tree):
            return _of_part(entry, tree)
        case TypeName(entry=entry) | UnitName(entry=entry) if entry is not None:
            return symbol_of_unit(entry)
        case BuiltinName(name):
            return DeclaredSymbol(name, SymbolKind.BUILTIN, None, None)
    return None


def _of_name(body: Any, key: str, meaning: Meaning | None) -> DeclaredSymbol | None:
    if not isinstance(meaning, TypedOperand):
        return _of_meaning(meaning)
    checking: Checking = body.checking
    scopes = checking.names.scopes
    if body.frame.find(key) is not None and key not in body.scope.variables:
        return _of_routine(body.signature)  # its result
    own = scopes.own(key, body.scope)
    if own is not None and own[1][0].section not in ("VAR_EXTERNAL", "VAR_CONFIG"):
        return of_scope(checking, key, *own)
    for scope, declared in scopes.global_variables(key, body.scope.space)[:1]:
        return of_scope(checking, key, scope, declared)
    for entry in scopes.values_of_enumerations(key, body.scope.space)[:1]:
        return of_enum_value(entry, key)
    return None


def _of_member(
    checking: Checking, key: str, whole: Meaning | None, meaning: Meaning | None
) -> DeclaredSymbol | None:
    if not isinstance(meaning, TypedOperand):
        return _of_meaning(meaning)
    names = checking.names
    match whole:
        case PropertyUse() | Callee():
            return None
        case TypedOperand():
            enum = resolved(whole.type)
            if isinstance(enum, EnumType):
                entry = names.scopes.find(enum.name)
                return None if entry is None else of_enum_value(entry, key)
            return _of_record(checking, whole.flat, key)
        case TypeName(type, entry):
            if entry is not None and (value := of_enum_value(entry, key)) is not None:
                return value
            return _of_record(checking, type, key)
        case UnitName(entry=entry) | BaseInstance(entry=entry) if entry is not None:
            declared = names.scopes.own(key, names.scopes.scope(entry))
            return None if declared is None else of_scope(checking, key, *declared)
    return None


def _of_record(checking: Checking, type: object, key: str) -> DeclaredSymbol | None:
    if not isinstance(type, StructType):
        return None
    entry = checking.names.entry_of(type)
    if entry is None:
        return None
    declared = checking.names.scopes.own(key, checking.names.scopes.scope(entry))
    return None if declared is None else of_scope(checking, key, *declared)


# members ----------------------------------------------------------------------------------------


def members_of(checking: Checking, whole: Meaning) -> Iterator[DeclaredSymbol]:
    """Return what can follow a dot behind a meaning."""
    names = checking.names
    match whole:
        case TypedOperand():
            type = whole.flat
            if isinstance(type, StructType | InterfaceType):
                entry = names.entry_of(type)
                if entry is not None:
                    yield from _inside(checking, entry, from_outside=True)
            return
        case PropertyUse() | Callee():
            return
        case TypeName(entry=entry) | UnitName(entry=entry) | BaseInstance(entry=entry):
            if entry is not None:
                yield from _inside(checking, entry, from_outside=isinstance(whole, UnitName))


def parameters_of(checking: Checking, signature: Signature) -> Iterator[DeclaredSymbol]:
    """Return the parameters of a routine in the order of the declaration."""
    for key in signature.by_name:
        parameter = _parameter(checking, signature, key)
        if parameter is not None:
            yield parameter


def visible_in(checking: Checking, signature: Signature) -> Iterator[DeclaredSymbol]:
    """Return what a routine can name without a dot: its variables, parts, globals and units."""
    scopes = checking.names.scopes
    scope: Scope | None = signature.scope
    seen: set[int] = set()
    while scope is not None and id(scope) not in seen:
        seen.add(id(scope))
        for key, declared in scope.variables.items():
            symbol = of_scope(checking, key, scope, declared)
            if symbol is not None:
                yield symbol
        scope = scope.base
    for owner, part in _all_parts(checking, signature.entry):
        yield _of_part(owner, part)
    for key, lists in scopes.globals.items():
        if not lists[0].is_library:
            inside = scopes.scope(lists[0])
            symbol = of_scope(checking, key, inside, inside.variables[key])
            if symbol is not None:
                yield symbol
    for key, enumerations in scopes.loose_values.items():
        if not enumerations[0].is_library:
            value = of_enum_value(enumerations[0], key)
            if value is not None:
                yield value
    for entry in scopes.entries.values():
        if not entry.is_library:
            yield symbol_of_unit(entry)


_INNER = ("VAR_TEMP", "VAR_EXTERNAL", "VAR_CONFIG", "VAR_GENERIC", "VAR_STAT")


def _inside(
    checking: Checking, entry: DeclaredUnit, *, from_outside: bool
) -> Iterator[DeclaredSymbol]:
    tree = entry.tree
    if isinstance(tree, TypeDeclaration) and isinstance(tree.type, EnumOf):
        for value in tree.type.values:
            symbol = of_enum_value(entry, value.name.lower())
            if symbol is not None:
                yield symbol
        return
    scope: Scope | None = checking.names.scopes.scope(entry)
    seen: set[str] = set()
    while scope is not None and scope.owner not in seen:
        seen.add(scope.owner)
        for key, declared in scope.variables.items():
            if not (from_outside and declared[0].section in _INNER):
                variable = of_scope(checking, key, scope, declared)
                if variable is not None:
                    yield variable
        scope = scope.base
    for owner, part in _all_parts(checking, entry):
        if "PRIVATE" not in getattr(part, "modifiers", ()):
            yield _of_part(owner, part)


def _all_parts(checking: Checking, entry: DeclaredUnit) -> list[FoundPart]:
    keys: dict[str, None] = {}
    units = [*checking.blocks.chain(entry), *checking.blocks.bases_of_interface(entry)]
    for unit in units:
        keys |= dict.fromkeys(checking.blocks.own_parts(unit))
    parts = [checking.blocks.part(entry, key) for key in keys]
    return [one for one in parts if one is not None]


# what a source declares ---------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Outline:
    """A symbol, and those declared inside of it."""

    symbol: DeclaredSymbol
    children: "tuple[Outline, ...]" = ()


def symbols_in(entries: Iterator[DeclaredUnit]) -> Iterator[Outline]:
    """Return the symbols that units declare, as a tree."""
    for entry in entries:
        tree = entry.tree
        children = [*_variables(entry, blocks_of(tree), entry.name)]
        if isinstance(tree, TypeDeclaration) and isinstance(tree.type, EnumOf):
            values = (of_enum_value(entry, value.name.lower()) for value in tree.type.values)
            children += [Outline(value) for value in values if value is not None]
        for part in getattr(tree, "parts", ()):
            owner = f"{entry.name}.{part.name}"
            accessors = (getattr(part, "get", None), getattr(part, "set", None))
            inner: list[Outline] = []
            for one in (part, *accessors):
                if isinstance(one, Method | Accessor):
                    inner += _variables(entry, one.blocks, owner)
            children.append(Outline(_of_part(entry, part), tuple(inner)))
        yield Outline(symbol_of_unit(entry), tuple(children))


def _variables(
    entry: DeclaredUnit, blocks: "tuple[VarBlock, ...] | Any", owner: str
) -> Iterator[Outline]:
    for block in blocks:
        for declaration in block.variables:
            declared: tuple[VarBlock, Declaration] = (block, declaration)
            for item in declaration.names:
                symbol = _of_variable(item.name.lower(), declared, entry.source, owner, entry)
                if symbol is not None:
                    yield Outline(symbol)
