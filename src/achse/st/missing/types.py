"""Missing types: which types that units name nothing declares, and what is known of each.

Source: IEC 61131-3 (2013) table 11: what uses say of a declaration; symbol files (`.tmc`) of
TwinCAT 3, seen in public projects.
"""

import re
from collections.abc import Iterator
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import AliasType, InterfaceType, OpaqueType, resolved
from achse.iec.errors import IecError
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DeclaredUnit, Failed, Scope
from achse.st.declared.signatures import BlockSignature
from achse.st.missing.trees import bases_of, part_of
from achse.st.missing.uses import MissingUse
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import NamedType, ReferenceTo, TypeSpec
from achse.st.syntax.units import FunctionBlock

_IDENTIFIER = re.compile(r"\w+(?:\.\w+)*", re.ASCII)


class MissingTypes:
    """Types that no source declares; of some a symbol file has the variables or the size.

    `uses` are the missing types that were met, by name in lower case.
    """

    def __init__(self, names: Resolver) -> None:
        self._names = names
        self.scopes = names.scopes
        self.uses: dict[str, MissingUse] = {}
        self._is_missing: dict[tuple[str, str], bool] = {}
        """Results of `is_missing`, by name and name space."""
        self._is_other_version: dict[int, bool] = {}
        """Results of `_is_of_other_version`, by identity."""
        self._blocks: dict[str, StructType[Any]] = {}
        """Blocks of symbol files, whose bodies and methods nothing declares."""
        self._opaque: dict[str, IecType[Any]] = {}
        """Types of symbol files with a size alone, and interfaces without methods."""

    def is_missing(self, spec: NamedType, scope: Scope) -> bool:
        """Return True if nothing, or a block's variables alone, declare a type."""
        key = (spec.name.lower(), scope.space)
        if key not in self._is_missing:
            try:
                self._is_missing[key] = self.scopes.find(
                    spec.name, scope.space
                ) is None and self._is_without_source(spec)
            except (Unexpected, Failed, IecError):
                self._is_missing[key] = False
        return self._is_missing[key]

    def _is_without_source(self, spec: NamedType) -> bool:
        predefined = self._names.predefined
        type = predefined.find(spec.name, spec.at)
        name = spec.name.rpartition(".")[2]
        if spec.name in predefined or name in predefined:
            return False
        if isinstance(type, StructType) and (
            type.kind is RecordKind.FUNCTION_BLOCK or self._is_of_other_version(type)
        ):
            self._blocks[name.lower()] = type
            return True
        if isinstance(type, OpaqueType | InterfaceType):
            self._opaque[name.lower()] = type
            return True
        return type is None

    def _is_of_other_version(self, type: IecType[Any]) -> bool:
        """Return True if a structure of a symbol file holds a type of a library of ours that has
        another size there: the file is of another version of the library."""
        known = self._is_other_version.get(id(type))
        if known is not None:
            return known
        self._is_other_version[id(type)] = False
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
                self._is_of_other_version(member.type) for member in inner.members
            )
        self._is_other_version[id(type)] = is_other
        return is_other

    def is_of_symbol_file(self, name: str) -> bool:
        """Return True if a symbol file has the variables or the size of a missing type."""
        return name in self._blocks or name in self._opaque

    def use(self, spec: NamedType) -> MissingUse:
        """Return what is known of a missing type, from now on among `uses`."""
        space, _, name = spec.name.rpartition(".")
        key = name.lower()
        if key not in self.uses:
            self.uses[key] = MissingUse(
                name,
                block=self._blocks.get(key),
                is_opaque=key in self._opaque,
                is_interface=isinstance(self._opaque.get(key), InterfaceType),
            )
            block = self._blocks.get(key)
            self.uses[key].is_required = block is not None and block.kind is RecordKind.STRUCT
            if self.is_of_symbol_file(key):
                self.uses[key].signature = self._names.predefined.signature(spec.name)
        use = self.uses[key]
        use.library = use.library or space
        return use

    def use_at(self, at: tuple[TypeSpec, Scope]) -> MissingUse | None:
        """Return the missing type that a variable is of, if it is."""
        spec, scope = at
        if isinstance(spec, ReferenceTo):
            return self.use_at((spec.target, scope))
        if isinstance(spec, NamedType) and self.is_missing(spec, scope):
            return self.use(spec)
        return None

    def base_of(self, entry: DeclaredUnit | None) -> MissingUse | None:
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

    def interfaces_of(self, entry: DeclaredUnit) -> Iterator[MissingUse]:
        """Yield the interfaces of a block that are missing, those behind declared ones too."""
        scope = self.scopes.scope(entry)
        waiting = [(scope, one) for one in getattr(entry.tree, "implements", ())]
        seen: set[int] = set()
        while waiting:
            scope, one = waiting.pop()
            if self.is_missing(one, scope):
                yield self.use(one)
                continue
            unit = self.scopes.find(one.name, scope.space)
            if unit is not None and id(unit) not in seen:
                seen.add(id(unit))
                inside = self.scopes.scope(unit)
                waiting += [(inside, base) for base in bases_of(unit.tree)]

    def base_with_init(self, entry: DeclaredUnit | None) -> MissingUse | None:
        """Return the missing base of a block whose `FB_init` takes the arguments of a declaration,
        None if a declared block has it."""
        seen: set[int] = set()
        while entry is not None and id(entry) not in seen:
            seen.add(id(entry))
            if any(part.name.lower() == "fb_init" for part in getattr(entry.tree, "parts", ())):
                return None
            base = next(iter(bases_of(entry.tree)), None)
            if base is None or not isinstance(entry.tree, FunctionBlock):
                return None
            scope = self.scopes.scope(entry)
            if self.is_missing(base, scope):
                return self.use(base)
            entry = self.scopes.find(base.name, scope.space)
        return None

    def member(self, spec: NamedType, name: str) -> MissingUse:
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
