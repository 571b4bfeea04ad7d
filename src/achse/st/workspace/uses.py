"""Uses: each name in a source with the symbol that it means.

Names in bodies get their meaning from the checker, those in declarations from the scopes that the
declarations are made with.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from achse.st.check.signatures import Signature
from achse.st.check.warm import WarmChecking
from achse.st.declared.scopes import DeclaredUnit, Scope
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.source import Source
from achse.st.syntax.tree import Declaration, EnumOf, Expression, NamedType, Note
from achse.st.syntax.units import Accessor, Method, TypeDeclaration
from achse.st.values.constants import path_of
from achse.st.workspace.cursor import routine_at
from achse.st.workspace.drawn_uses import drawn_names
from achse.st.workspace.symbols import (
    DeclaredSymbol,
    Outline,
    of_enum_value,
    of_scope,
    symbol_of,
    symbol_of_unit,
    symbols_in,
)


@dataclass(frozen=True, slots=True)
class SymbolUse:
    """A name in a source, from `at` to `end`, and its symbol."""

    at: int
    end: int
    symbol: DeclaredSymbol
    is_declaration: bool = False


def entries_in(checking: WarmChecking, source: Source) -> list[DeclaredUnit]:
    """Return the units that a source declares, in order."""
    entries = checking.names.scopes.entries.values()
    return sorted((one for one in entries if one.source is source), key=lambda one: one.at)


def outline_in(checking: WarmChecking, source: Source) -> list[Outline]:
    """Return the symbols that a source declares."""
    return list(symbols_in(iter(entries_in(checking, source))))


def uses_in(checking: WarmChecking, source: Source) -> list[SymbolUse]:
    """Return all names of a source that mean something, in order."""
    routines = [
        one
        for one in checking.routines.created
        if one.source is source and checking.checked(one.key) is not None
    ]
    return _uses(checking, source, routines)


def use_at(checking: WarmChecking, source: Source, offset: int) -> SymbolUse | None:
    """Return the name at an offset, also that which ends there, as `uses_in` has it.

    Only the routine there is looked at, unless bodies of the source are drawn.
    """
    if source.drawings:
        uses = uses_in(checking, source)
    else:
        here = routine_at(checking, source, offset)
        same = (
            []
            if here is None
            else [one for one in checking.routines.created if one.tree is here.tree]
        )
        routines = [one for one in same if checking.checked(one.key) is not None]
        uses = _uses(checking, source, routines)
    return next((use for use in uses if use.at <= offset <= use.end), None)


def _uses(checking: WarmChecking, source: Source, routines: Iterable[Signature]) -> list[SymbolUse]:
    """Return the names in the declarations of a source and in the bodies of some of its
    routines."""
    uses: dict[int, SymbolUse] = {}
    for outline in outline_in(checking, source):
        for symbol in _flat(outline):
            if symbol.at is not None:
                uses[symbol.at] = SymbolUse(symbol.at, symbol.at + len(symbol.name), symbol, True)
    for entry in entries_in(checking, source):
        for use in _in_declarations(checking, entry):
            uses.setdefault(use.at, use)
    for routine in routines:
        for use in _in_body(checking, routine):
            uses.setdefault(use.at, use)
    return sorted(uses.values(), key=lambda use: use.at)


def _flat(outline: Outline) -> Iterator[DeclaredSymbol]:
    yield outline.symbol
    for child in outline.children:
        yield from _flat(child)


def _in_body(checking: WarmChecking, routine: Signature) -> Iterator[SymbolUse]:
    if isinstance(routine.body, GraphicalBody):
        for drawn in drawn_names(routine.body, checking.uses_of(routine)):
            yield SymbolUse(drawn.at, drawn.end, drawn.symbol)
        return
    for one in checking.uses_of(routine):
        if one.body.signature.source is not routine.source:
            continue
        symbol = symbol_of(one)
        if symbol is None:
            continue
        name = getattr(one.tree, "name", "")
        at = one.tree.at
        if not name:  # E_State#Idle
            prefix, _, name = one.tree.text.partition("#")  # type: ignore[union-attr]
            at += len(prefix) + 1
        if _is_written(routine.source, at, name):
            yield SymbolUse(at, at + len(name), symbol)


def _is_written(source: Source, at: int, name: str) -> bool:
    return source.text[at : at + len(name)].lower() == name.lower()


# declarations -------------------------------------------------------------------------------------


def _in_declarations(checking: WarmChecking, entry: DeclaredUnit) -> Iterator[SymbolUse]:
    scope = checking.names.scopes.scope(entry)
    yield from _walk(checking, entry.source, entry.tree, scope)


def _walk(checking: WarmChecking, source: Source, root: Any, scope: Scope) -> Iterator[SymbolUse]:
    """Yield names of types, and names in expressions, of the declarations in a unit."""
    waiting: list[tuple[Any, Scope]] = [(root, scope)]
    while waiting:
        tree, here = waiting.pop()
        if isinstance(tree, tuple):
            waiting += [(item, here) for item in tree]
        elif isinstance(tree, NamedType):
            waiting.append((tree.generics, here))
            yield from _of_type(checking, source, tree, here)
        elif isinstance(tree, Method | Accessor):
            inner = Scope(source, here.owner, here.space, here)
            for block in tree.blocks:
                for declaration in block.variables:
                    for item in declaration.names:
                        inner.variables.setdefault(item.name.lower(), (block, declaration))
            waiting += [(getattr(tree, "returns", None), here), (tree.blocks, inner)]
        elif isinstance(tree, Declaration):
            waiting += [(tree.type, here), (tree.initial, here), (tree.arguments, here)]
        elif isinstance(tree, Expression) and path_of(tree) is not None:
            yield from _of_path(checking, source, tree, here)
        elif hasattr(tree, "__match_args__") and not isinstance(tree, Note):
            names = (n for n in tree.__match_args__ if n not in ("at", "body", "names", "note"))
            waiting += [(getattr(tree, n), here) for n in names]


def _of_type(
    checking: WarmChecking, source: Source, tree: NamedType, scope: Scope
) -> Iterator[SymbolUse]:
    entry = checking.names.scopes.find(tree.name, scope.space)
    if entry is not None:
        last = tree.name.rpartition(".")[2]
        at = tree.at + len(tree.name) - len(last)
        if _is_written(source, at, last):
            yield SymbolUse(at, at + len(last), symbol_of_unit(entry))


def _of_path(
    checking: WarmChecking, source: Source, tree: Any, scope: Scope
) -> Iterator[SymbolUse]:
    """Constants and values in an initial value, a bound or a length."""
    scopes = checking.names.scopes
    steps = []
    while hasattr(tree, "of"):
        steps.append(tree)
        tree = tree.of
    steps.append(tree)
    steps.reverse()
    path = [step.name.lower() for step in steps]
    if (own := _value_beside(scope, path[0], checking)) is not None:
        symbols: list[DeclaredSymbol | None] = [own]
    elif (variable := scopes.variable(tuple(path), scope)) is not None:
        declarer, rest = variable
        known = declarer.variables.get(rest[0])
        skipped = len(path) - len(rest)
        owner = None if not skipped else scopes.find(".".join(path[:skipped]), scope.space)
        symbols = [None] * max(skipped - 1, 0)
        symbols += [None if owner is None else symbol_of_unit(owner)] * bool(skipped)
        symbols.append(None if known is None else of_scope(checking, rest[0], declarer, known))
    elif values := scopes.values_of_enumerations(path[0], scope.space):
        symbols = [of_enum_value(values[0], path[0])]
    elif len(path) > 1 and (entry := scopes.find(".".join(path[:-1]), scope.space)) is not None:
        symbols = [None] * (len(path) - 2)
        symbols += [symbol_of_unit(entry), of_enum_value(entry, path[-1])]
    else:
        entry = scopes.find(path[0], scope.space)
        symbols = [None if entry is None else symbol_of_unit(entry)]
    for step, symbol in zip(steps, symbols, strict=False):
        if symbol is not None and _is_written(source, step.at, step.name):
            yield SymbolUse(step.at, step.at + len(step.name), symbol)


def _value_beside(scope: Scope, key: str, checking: WarmChecking) -> DeclaredSymbol | None:
    """Return a value of the enumeration that is being declared."""
    entry = checking.names.scopes.entries.get(scope.owner.lower())
    tree = None if entry is None else entry.tree
    if isinstance(tree, TypeDeclaration) and isinstance(tree.type, EnumOf) and entry is not None:
        return of_enum_value(entry, key)
    return None
