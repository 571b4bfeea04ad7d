"""Meanings of expressions with missing names: the declared type, or the use.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration.
"""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeAlias

from achse.iec.arrays import ArrayType
from achse.iec.derived import AliasType, InterfaceType, OpaqueType, resolved
from achse.iec.errors import IecError
from achse.iec.names import ELEMENTARY
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Failed, Scope
from achse.st.declared.signatures import BlockSignature
from achse.st.missing.built_in import is_built_in, result_text
from achse.st.missing.trees import (
    bases_of,
    is_plain,
    is_variable_list,
    literal_text,
    part_of,
)
from achse.st.missing.uses import MissingUse
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.printer import print_type
from achse.st.syntax.tree import (
    ArrayOf,
    Binary,
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
    StringOf,
    StructOf,
    Super,
    This,
    TypeSpec,
    Unary,
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

_IDENTIFIER = re.compile(r"\w+(?:\.\w+)*", re.ASCII)
TRUTHS = ("AND", "OR", "XOR", "AND_THEN", "OR_ELSE", "&")
_COMPARING = ("=", "<>", "<", "<=", ">", ">=")
_LONG_SUM = 8
"""Most operands of an expression with types."""
Sense: TypeAlias = "MissingUse | DeclaredUnit | tuple[TypeSpec, Scope] | None"
"""Meaning of an expression: a missing name, a unit, a declared type with its scope, or none."""


class Meanings:
    """Knows which names are missing, and what expressions mean by them.

    `types` are missing types, `names` missing constants, variables and functions, `lists` those
    of `names` that have something behind a dot; all by name in lower case.
    """

    def __init__(self, names: Resolver) -> None:
        self._names = names
        self.scopes = names.scopes
        self.types: dict[str, MissingUse] = {}
        self.names: dict[str, MissingUse] = {}
        self.lists: dict[str, MissingUse] = {}
        self.this: DeclaredUnit | None = None
        """The unit whose body is looked at."""
        self._others: dict[int, bool] = {}
        self._is_other_by_name: dict[tuple[str, str], bool] = {}
        self._blocks: dict[str, StructType[Any]] = {}
        """Blocks of symbol files, whose bodies and methods nothing declares."""
        self._opaque: dict[str, IecType[Any]] = {}
        """Types of symbol files with a size alone, and interfaces without methods."""

    def is_missing(self, spec: NamedType, scope: Scope) -> bool:
        """Return True if nothing, or a block's variables alone, declare a type."""
        key = (spec.name.lower(), scope.space)
        if key not in self._is_other_by_name:
            try:
                self._is_other_by_name[key] = self.scopes.find(
                    spec.name, scope.space
                ) is None and self._is_without_source(spec)
            except (Unexpected, Failed, IecError):
                self._is_other_by_name[key] = False
        return self._is_other_by_name[key]

    def _is_without_source(self, spec: NamedType) -> bool:
        predefined = self._names.predefined
        type = predefined.find(spec.name, spec.at)
        name = spec.name.rpartition(".")[2]
        if spec.name in predefined or name in predefined:
            return False
        if isinstance(type, StructType) and (
            type.kind is RecordKind.FUNCTION_BLOCK or self._is_other(type)
        ):
            self._blocks[name.lower()] = type
            return True
        if isinstance(type, OpaqueType | InterfaceType):
            self._opaque[name.lower()] = type
            return True
        return type is None

    def _is_other(self, type: IecType[Any]) -> bool:
        """Return True if a structure of a symbol file holds a type of a library of ours that has
        another size there: the file is of another version of the library."""
        known = self._others.get(id(type))
        if known is not None:
            return known
        self._others[id(type)] = False
        inner = type
        while isinstance(inner, ArrayType | AliasType):
            inner = inner.element if isinstance(inner, ArrayType) else inner.base
        if not isinstance(inner, StructType):
            return False
        entry = self.scopes.find(inner.name, "")
        if entry is not None:
            is_other = entry.is_built_in and self._names.entry_type(entry, 0).size != inner.size
        else:
            is_other = inner.kind is RecordKind.STRUCT and any(
                self._is_other(member.type) for member in inner.members
            )
        self._others[id(type)] = is_other
        return is_other

    def is_of_symbol_file(self, name: str) -> bool:
        """Return True if a symbol file has the variables or the size of a missing type."""
        return name in self._blocks or name in self._opaque

    def use(self, spec: NamedType) -> MissingUse:
        space, _, name = spec.name.rpartition(".")
        key = name.lower()
        if key not in self.types:
            self.types[key] = MissingUse(
                name,
                block=self._blocks.get(key),
                is_opaque=key in self._opaque,
                is_interface=isinstance(self._opaque.get(key), InterfaceType),
            )
            block = self._blocks.get(key)
            self.types[key].is_required = block is not None and block.kind is RecordKind.STRUCT
            if self.is_of_symbol_file(key):
                self.types[key].signature = self._names.predefined.signature(spec.name)
        use = self.types[key]
        use.library = use.library or space
        return use

    # what an expression means ------------------------------------------------------------------

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
        if key in self.types:
            return True, self.types[key]
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
            if self.is_missing(base, scope):
                key = name.lower()
                is_known = key in self.scopes.entries or key in self.scopes.globals
                if is_known or is_space or key in ELEMENTARY:
                    return False, None
                return True, self._missing_member(base, name)
            entry = self.scopes.find(base.name, scope.space)
            if entry is None:  # of a symbol file
                return True, None
        return False, None

    def missing_base(self, entry: DeclaredUnit | None) -> MissingUse | None:
        """Return the base of a block, or of its bases, that nothing declares."""
        seen: set[int] = set()
        while entry is not None and id(entry) not in seen:
            seen.add(id(entry))
            base = next(iter(bases_of(entry.tree)), None)
            if base is None:
                return None
            if self.is_missing(base, self.scopes.scope(entry)):
                return self.use(base)
            entry = self.scopes.find(base.name, entry.space)
        return None

    def _member(self, of: Expression, name: str, scope: Scope, whole: Sense) -> Sense:
        if isinstance(whole, MissingUse) and isinstance(of, Call):
            whole.is_method = True
        if isinstance(whole, MissingUse) and whole.is_part:
            if whole.block is not None and whole.block.kind is RecordKind.FUNCTION_BLOCK:
                spec = NamedType(whole.type)
                if self.is_missing(spec, scope):
                    part = self._missing_member(spec, name)
                    if whole.owner is not None and not part.is_part:
                        whole.owner.is_required = True  # it holds the block that is declared
                    return part
            if whole.block is not None:
                return part_of(whole.block, name)
            spec = NamedType(whole.type)
            is_named = whole.is_interface and self.is_missing(spec, scope)
            return self._missing_member(spec, name) if is_named else None
        if isinstance(whole, MissingUse):
            if self.types.get(whole.name.lower()) is whole:
                whole.values.setdefault(name.lower(), name)
                return None
            if whole.type and not whole.is_part and not whole.members and whole.is_sure:
                spec = NamedType(whole.type)
                key = whole.type.lower()
                if key in self.types or self.scopes.find(whole.type, "") is not None:
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
        if self.is_missing(spec, scope):
            return self._missing_member(spec, name)
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
            if self.is_missing(base, inside):
                return self._missing_member(base, name)
            entry = self.scopes.find(base.name, inside.space)
        return None

    def _missing_member(self, spec: NamedType, name: str) -> MissingUse:
        """Return a part of a missing type; one that a symbol file has is known by its type
        alone."""
        use = self.use(spec)
        part = None if use.block is None else part_of(use.block, name)
        if part is not None:
            part.owner = use
            return part
        member = use.member(name)
        self._sign(member, use.signature)
        return member

    def _sign(self, member: MissingUse, signature: BlockSignature | None) -> None:
        """Note the type of a property, or the result of a method, by a signature or its bases."""
        key = member.name.lower()
        seen: set[str] = set()
        while signature is not None:
            if item := signature.properties.get(key):
                member.type = item.type
            if method := signature.methods.get(key):
                member.method = method
                member.result = self._part(member.name, method.returns)
            if member.type or member.result or signature.extends in seen:
                return
            seen.add(signature.extends)
            signature = self._names.predefined.signature(signature.extends)

    def _part(self, name: str, text: str) -> MissingUse:
        """Return a value whose type a symbol file has, as text."""
        type = None
        if _IDENTIFIER.fullmatch(text):
            type = self._names.predefined.find(text, 0)
        inner = None if type is None else resolved(type)
        return MissingUse(
            name,
            text,
            block=inner if isinstance(inner, StructType) else None,
            is_part=True,
            is_interface=isinstance(inner, InterfaceType),
        )

    def _index(self, whole: Sense, indices: Sequence[Expression]) -> Sense:
        if isinstance(whole, tuple):
            type = self.type_use(whole)
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
        return self.types.get(tree.of.name.lower())

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

    def type_use(self, at: tuple[TypeSpec, Scope]) -> MissingUse | None:
        """Return the missing type that a variable is of, if it is."""
        spec, scope = at
        if isinstance(spec, ReferenceTo):
            return self.type_use((spec.target, scope))
        if isinstance(spec, NamedType) and self.is_missing(spec, scope):
            return self.use(spec)
        return None

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

    # texts of types ----------------------------------------------------------------------------

    def spec_text(self, at: tuple[TypeSpec, Scope]) -> str:
        """Return a type as text that means the same elsewhere; nothing if it cannot."""
        spec, scope = at
        if isinstance(spec, ReferenceTo):
            return self.spec_text((spec.target, scope))
        if isinstance(spec, StringOf) and (spec.length is None or isinstance(spec.length, Literal)):
            return print_type(spec)
        if isinstance(spec, PointerTo) and (inner := self.spec_text((spec.target, scope))):
            return f"POINTER TO {inner}"
        if isinstance(spec, NamedType) and not spec.generics:
            return spec.name.rpartition(".")[2] if self.is_missing(spec, scope) else spec.name
        if isinstance(spec, ArrayOf) and (inner := self.spec_text((spec.element, scope))):
            if inner.startswith("ARRAY [*"):
                return ""
            is_known = all(is_plain(one, self.scopes) for one in spec.dimensions)
            bounds = spec.dimensions if is_known else (None,) * len(spec.dimensions)
            return print_type(replace(spec, dimensions=bounds, element=NamedType(inner)))
        return ""

    def text(self, tree: Expression, scope: Scope) -> str:
        """Return the type of an expression, where it shows."""
        if isinstance(tree, Literal):
            return literal_text(tree)
        if isinstance(tree, Unary):
            return "BOOL" if tree.operator == "NOT" else self.text(tree.operand, scope)
        if isinstance(tree, Binary):
            if tree.operator in _COMPARING:
                return "BOOL"
            for _ in range(_LONG_SUM):
                if text := self.text(tree.right, scope):
                    return text
                if not isinstance(tree.left, Binary):
                    break
                tree = tree.left
            left = "" if isinstance(tree.left, Binary) else self.text(tree.left, scope)
            return left or ("BOOL" if tree.operator.upper() in TRUTHS else "")
        callee = tree.of if isinstance(tree, Call) else None
        if isinstance(callee, Name) and (result := result_text(callee.name)):
            return result
        sense = self.of(tree, scope)
        if isinstance(sense, tuple):
            return self.spec_text(sense)
        return sense.type if isinstance(sense, MissingUse) else ""
