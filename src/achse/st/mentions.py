"""Mentions: the units that a unit names in its declarations and bodies.

Names of variables, methods and actions of the unit itself hide units with the same name. Of a
drawn body all words count, since its boxes name blocks in text.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from achse.st.declared.scopes import DeclaredUnit, Scopes, with_bases
from achse.st.graphical.body import GraphicalBody
from achse.st.syntax.nodes import field_names
from achse.st.syntax.tree import (
    Declaration,
    GlobalName,
    Literal,
    Member,
    Name,
    NamedType,
    Note,
    VarBlock,
)
from achse.st.syntax.units import Accessor, Method
from achse.st.values.constants import path_of

_WORD = re.compile(r"[A-Za-z_]\w*")


class Mentions:
    """Units that a unit names, and names that nothing here declares, in lower case."""

    __slots__ = ("units", "unknown")

    def __init__(self) -> None:
        self.units: set[DeclaredUnit] = set()
        self.unknown: set[str] = set()


def mentions_of(entry: DeclaredUnit, scopes: Scopes) -> Mentions:
    """Return the mentions of a unit."""
    walk = _Walk(entry, scopes)
    walk.visit(entry.tree, walk.own_names())
    return walk.mentions


class _Walk:
    """Walk through the syntax tree of one unit."""

    def __init__(self, entry: DeclaredUnit, scopes: Scopes) -> None:
        self.mentions = Mentions()
        self._entry = entry
        self._scopes = scopes
        self._paths: set[tuple[str, ...]] = set()

    def own_names(self) -> frozenset[str]:
        """Variables and parts of the unit and of its bases, in lower case."""
        names: set[str] = set()
        for scope in with_bases(self._scopes.scope(self._entry)):
            names.update(scope.variables)
            entry = self._scopes.entries.get(scope.owner.lower())
            names.update(
                part.name.lower() for part in getattr(getattr(entry, "tree", None), "parts", ())
            )
        return frozenset(names) - self._external(getattr(self._entry.tree, "blocks", ()))

    @staticmethod
    def _external(blocks: Iterable[VarBlock]) -> frozenset[str]:
        """Return names of VAR_EXTERNAL, which mean global variables."""
        return frozenset(
            item.name.lower()
            for block in blocks
            if block.section == "VAR_EXTERNAL"
            for declaration in block.variables
            for item in declaration.names
        )

    def visit(self, root: Any, local: frozenset[str]) -> None:
        """Note the names in a tree; those in `local` are not units."""
        stack = [root]
        while stack:
            tree = stack.pop()
            if isinstance(tree, tuple):
                stack += tree
            elif isinstance(tree, Name | Member | GlobalName):
                path = path_of(tree)
                if path is None:
                    while isinstance(tree, Member):
                        tree = tree.of
                    stack.append(tree)
                elif isinstance(_root(tree), GlobalName) or path[0].lower() not in local:
                    self._note(path)
            elif isinstance(tree, NamedType):
                self._note(tuple(tree.name.split(".")))
                stack += tree.generics
            elif isinstance(tree, Literal):
                prefix, mark, _ = tree.text.partition("#")
                if mark and tree.kind == "typed":
                    self._note(tuple(prefix.split(".")))
            elif isinstance(tree, Declaration):
                stack += (tree.type, tree.arguments, tree.initial)
            elif isinstance(tree, Method | Accessor) and tree is not root:
                inside = {
                    item.name.lower()
                    for block in tree.blocks
                    for declaration in block.variables
                    for item in declaration.names
                }
                self.visit(tree, (local | inside) - self._external(tree.blocks))
            elif isinstance(tree, GraphicalBody):
                for word in set(_WORD.findall(tree.text)):
                    self._note((word,))
            elif hasattr(tree, "__dataclass_fields__") and not isinstance(tree, Note):
                stack += [getattr(tree, name) for name in field_names(tree.__class__)]

    def _note(self, path: Sequence[str]) -> None:
        """Note the unit that a path means: by its first name, else behind names of libraries."""
        keys = tuple(name.lower() for name in path)
        if keys in self._paths:
            return
        self._paths.add(keys)
        scopes, space = self._scopes, self._entry.space
        by_name: tuple[Mapping[str, Sequence[DeclaredUnit]], ...] = (
            scopes.globals,
            scopes.loose_values,
            scopes.list_properties,
        )
        for count in range(1, len(keys) + 1):
            units = [unit for index in by_name for unit in index.get(keys[count - 1], ())]
            entry = scopes.find(".".join(keys[:count]), space)
            if entry is not None:
                units.append(entry)
            if units:
                self.mentions.units.update(units)
                return
            self.mentions.unknown.add(keys[count - 1])


def _root(tree: Any) -> Any:
    while isinstance(tree, Member):
        tree = tree.of
    return tree
