"""Meanings of expressions with missing names: the declared type, or the use.

Source: IEC 61131-3 (2013) tables 19 (calls) and 11 (types): what uses say of a declaration.
"""

from collections.abc import Sequence
from contextlib import suppress
from typing import TypeAlias

from achse.iec.errors import IecError
from achse.iec.names import ELEMENTARY
from achse.iec.structs import RecordKind
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Failed, Scope
from achse.st.missing.built_in import is_built_in
from achse.st.missing.trees import (
    bases_of,
    is_variable_list,
    part_of,
)
from achse.st.missing.types import MissingTypes
from achse.st.missing.uses import MissingUse
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    ArrayOf,
    Call,
    Dereference,
    Expression,
    GlobalName,
    Index,
    Literal,
    Member,
    Name,
    NamedType,
    PointerTo,
    ReferenceTo,
    StructOf,
    Super,
    This,
    TypeSpec,
    UnionOf,
)
from achse.st.syntax.units import (
    Function,
    GlobalList,
    Method,
    Part,
    Program,
    Property,
    TypeDeclaration,
)
from achse.st.values.functions import is_standard

Sense: TypeAlias = "MissingUse | DeclaredUnit | tuple[TypeSpec, Scope] | None"
"""Meaning of an expression: a missing name, a unit, a declared type with its scope, or none."""


class Meanings:
    """Knows what expressions mean by names, the missing ones too.

    `types` are missing types, `names` missing constants, variables and functions, `lists` those
    of `names` that have something behind a dot; all by name in lower case.
    """

    def __init__(self, names: Resolver) -> None:
        self._names = names
        self.scopes = names.scopes
        self.types = MissingTypes(names)
        self.names: dict[str, MissingUse] = {}
        self.lists: dict[str, MissingUse] = {}
        self.this: DeclaredUnit | None = None
        """The unit whose body is looked at."""

    def constant(self, tree: Expression, scope: Scope) -> Sense:
        """Return the meaning of a name in a bound: never a variable of a base."""
        if isinstance(tree, Name):
            return self._named(tree.name, scope, is_space=True)
        return self.of(tree, scope)

    def of(self, tree: Expression, scope: Scope) -> Sense:
        """Return the meaning of an expression."""
        match tree:
            case Name(name) | GlobalName(name):
                return self._named(name, scope)
            case Member(Name(space), name) if not space[:1].islower():
                # Behind a missing base, `Lib.x` is of a library rather than of the base.
                return self._member(tree.of, name, scope, self._named(space, scope, is_space=True))
            case Member(of, name):
                return self._member(of, name, scope, self.of(of, scope))
            case Index(of, indices):
                return self._index(self.of(of, scope), indices)
            case Dereference(of):
                sense = self.of(of, scope)
                if isinstance(of, This | Super):
                    return sense
                if isinstance(sense, MissingUse):
                    sense.target = sense.target or MissingUse(sense.name)
                    return sense.target
                if isinstance(sense, tuple) and isinstance(sense[0], PointerTo):
                    return sense[0].target, sense[1]
                return None
            case Call(of):
                return self._result(self.of(of, scope))
            case This():
                return self._own()
            case Super():
                tree_of = None if self.this is None else self.this.tree
                base = getattr(tree_of, "extends", None)
                return None if not isinstance(base, NamedType) else (base, scope)
            case _:
                return None

    def _own(self) -> Sense:
        entry = self.this
        return None if entry is None else (NamedType(entry.name), self.scopes.scope(entry))

    def _named(self, name: str, scope: Scope, *, is_space: bool = False) -> Sense:
        key = name.lower()
        if key in scope.values or is_built_in(name):
            return None
        if key.startswith("__"):
            return None
        own = self.scopes.own(key, scope)
        if own is not None:
            return own[1][1].type, own[0]
        is_inherited, inherited = self._inherited(name, scope, is_space)
        if is_inherited:
            return inherited
        is_known, sense = self._anywhere(name, scope)
        if is_known:
            return sense
        use = self.names.setdefault(key, MissingUse(name))
        if self.this is not None:
            use.units[self.this.name] = scope
        return use

    def _anywhere(self, name: str, scope: Scope) -> tuple[bool, Sense]:
        """Return True if a name alone is known; its meaning."""
        key = name.lower()
        unit = self.scopes.find(name, scope.space)
        if unit is not None:
            return True, unit
        if declared := self.scopes.globals.get(key):
            scope_of_list = self.scopes.scope(declared[0])
            return True, (scope_of_list.variables[key][1].type, scope_of_list)
        if key in self.types.uses:
            return True, self.types.uses[key]
        with suppress(Unexpected, Failed, IecError):
            if is_variable_list(self._names.predefined.find(name, 0)):
                return False, None
            if (
                key in self.scopes.loose_values
                or is_standard(name.upper())
                or self._names.predefined.find(name, 0) is not None
                or self._names.predefined.values(key)
                or self._names.constants.is_predefined(key)
            ):
                return True, None
        return False, None

    def _inherited(self, name: str, scope: Scope, is_space: bool) -> tuple[bool, Sense]:
        """Return True if a name is part of a unit or its base; its meaning."""
        entry = self.this
        seen: set[int] = set()
        while entry is not None and id(entry) not in seen:
            seen.add(id(entry))
            for part in getattr(entry.tree, "parts", ()):
                if part.name.lower() == name.lower():
                    return True, self._part_type(part, self.scopes.scope(entry))
            base = getattr(entry.tree, "extends", None)
            if not isinstance(base, NamedType):
                break
            if self.types.is_missing(base, scope):
                key = name.lower()
                is_known = key in self.scopes.entries or key in self.scopes.globals
                if is_known or is_space or key in ELEMENTARY:
                    return False, None
                return True, self.types.member(base, name)
            entry = self.scopes.find(base.name, scope.space)
            if entry is None:  # of a symbol file
                return True, None
        return False, None

    def _member(self, of: Expression, name: str, scope: Scope, whole: Sense) -> Sense:
        if isinstance(whole, MissingUse) and isinstance(of, Call):
            whole.is_method = True
        if isinstance(whole, MissingUse) and whole.is_part:
            if whole.block is not None and whole.block.kind is RecordKind.FUNCTION_BLOCK:
                spec = NamedType(whole.type)
                if self.types.is_missing(spec, scope):
                    part = self.types.member(spec, name)
                    if whole.owner is not None and not part.is_part:
                        whole.owner.is_required = True  # it holds the block that is declared
                    return part
            if whole.block is not None:
                return part_of(whole.block, name)
            spec = NamedType(whole.type)
            is_named = whole.is_interface and self.types.is_missing(spec, scope)
            return self.types.member(spec, name) if is_named else None
        if isinstance(whole, MissingUse):
            if self.types.uses.get(whole.name.lower()) is whole:
                whole.values.setdefault(name.lower(), name)
                return None
            if whole.type and not whole.is_part and not whole.members and whole.is_sure:
                spec = NamedType(whole.type)
                key = whole.type.lower()
                if key in self.types.uses or self.scopes.find(whole.type, "") is not None:
                    whole.is_written = True  # parts show a variable
                    return self.member_of((spec, scope), name)
            if isinstance(of, Name) and self.names.get(of.name.lower()) is whole:
                is_known, sense = self._anywhere(name, scope)
                if is_known:
                    whole.is_space = True
                    return sense
                self.lists[of.name.lower()] = whole
                predefined = self._names.predefined.find(of.name, 0)
                if (
                    is_variable_list(predefined)
                    and (listed := part_of(predefined, name)) is not None
                ):
                    whole.is_space = True
                    return whole.members.setdefault(name.lower(), listed)
                whole.member(name).space = whole
            return whole.member(name)
        if isinstance(whole, DeclaredUnit):
            if isinstance(whole.tree, GlobalList | Program):
                inside = self.scopes.scope(whole)
                if declared := inside.variables.get(name.lower()):
                    return declared[1].type, inside
            return None
        return None if whole is None else self.member_of(whole, name)

    def member_of(self, whole: tuple[TypeSpec, Scope], name: str) -> Sense:
        spec, scope = whole
        if isinstance(spec, ReferenceTo):
            return self.member_of((spec.target, scope), name)
        if isinstance(spec, StructOf | UnionOf):
            for member in spec.members:
                if any(item.name.lower() == name.lower() for item in member.names):
                    return member.type, scope
            return None
        if not isinstance(spec, NamedType):
            return None
        if self.types.is_missing(spec, scope):
            return self.types.member(spec, name)
        entry = self.scopes.find(spec.name, scope.space)
        seen: set[int] = set()
        while entry is not None and id(entry) not in seen:
            seen.add(id(entry))
            inside = self.scopes.scope(entry)
            if declared := inside.variables.get(name.lower()):
                return declared[1].type, inside
            for part in getattr(entry.tree, "parts", ()):
                if part.name.lower() == name.lower():
                    return self._part_type(part, inside)
            base = next(iter(bases_of(entry.tree)), None)
            if isinstance(entry.tree, TypeDeclaration):
                alias = entry.tree.type
                if isinstance(alias, ReferenceTo):
                    alias = alias.target
                base = alias if isinstance(alias, NamedType) else base
            if base is None:
                return None
            if self.types.is_missing(base, inside):
                return self.types.member(base, name)
            entry = self.scopes.find(base.name, inside.space)
        return None

    def _index(self, whole: Sense, indices: Sequence[Expression]) -> Sense:
        if isinstance(whole, tuple):
            type = self.types.use_at(whole)
            if type is None or type.block is not None or type.is_opaque:
                return self.element(whole)
            whole = type
        if not isinstance(whole, MissingUse):
            return None
        whole.element = whole.element or MissingUse(whole.name)
        whole.dimensions = max(whole.dimensions, len(indices))
        for index in indices:
            if isinstance(index, Literal) and index.text.isdecimal() and len(index.text) < 5:
                whole.highest = max(whole.highest, int(index.text))
            else:
                whole.is_indexed_by_variable = True
        return whole.element

    def enumeration_of(self, tree: Expression, scope: Scope) -> MissingUse | None:
        """Return the missing enumeration that a value with its name in front is of."""
        if not isinstance(tree, Member) or not isinstance(tree.of, Name):
            return None
        sense = self.of(tree, scope)
        if isinstance(sense, MissingUse):
            return sense.space
        return self.types.uses.get(tree.of.name.lower())

    def element(self, whole: tuple[TypeSpec, Scope]) -> tuple[TypeSpec, Scope] | None:
        spec, scope = whole
        if isinstance(spec, ReferenceTo):
            return self.element((spec.target, scope))
        if isinstance(spec, NamedType):
            entry = self.scopes.find(spec.name, scope.space)
            if entry is not None and isinstance(entry.tree, TypeDeclaration):
                inner = entry.tree.type
                if isinstance(inner, ArrayOf | PointerTo):
                    return self.element((inner, self.scopes.scope(entry)))
            return None
        if isinstance(spec, ArrayOf):
            return spec.element, scope
        return (spec.target, scope) if isinstance(spec, PointerTo) else None

    def _result(self, callee: Sense) -> Sense:
        if isinstance(callee, DeclaredUnit):
            tree = callee.tree
            if isinstance(tree, Function) and tree.returns is not None:
                return tree.returns, self.scopes.scope(callee)
            return None
        if isinstance(callee, MissingUse):
            callee.is_called = True
            return callee.result or callee
        return callee

    def _part_type(self, part: Part, scope: Scope) -> tuple[TypeSpec, Scope] | None:
        """Return the type of a property, or of what a method returns."""
        if isinstance(part, Property):
            return part.type, scope
        if isinstance(part, Method) and part.returns is not None:
            return part.returns, scope
        return None

    def method_of(self, callee: Expression, scope: Scope) -> tuple[Method, Scope] | None:
        """Return the declared method that a call calls, with the scope of its unit."""
        if isinstance(callee, Member):
            of = callee.of
            is_space = isinstance(of, Name) and not of.name[:1].islower()
            whole = self.constant(of, scope) if is_space else self.of(of, scope)
        else:
            whole = self._own() if isinstance(callee, Name) else None
        if isinstance(whole, tuple) and isinstance(whole[0], ReferenceTo):
            whole = whole[0].target, whole[1]
        if not isinstance(whole, tuple) or not isinstance(whole[0], NamedType):
            return None
        key = callee.name.lower() if isinstance(callee, Member | Name) else ""
        entry = self.scopes.find(whole[0].name, whole[1].space)
        waiting = [entry] if entry is not None else []
        seen: set[int] = set()
        while waiting:
            entry = waiting.pop()
            if id(entry) in seen:
                continue
            seen.add(id(entry))
            inside = self.scopes.scope(entry)
            for part in getattr(entry.tree, "parts", ()):
                if isinstance(part, Method) and part.name.lower() == key:
                    return part, inside
            bases = (self.scopes.find(base.name, inside.space) for base in bases_of(entry.tree))
            waiting += [base for base in bases if base is not None]
        return None
