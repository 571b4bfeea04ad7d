"""Constants by name: what a name in an expression is worth, where that can be known ahead.

Source: IEC 61131-3 (2013) tables 11 and 13.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, Protocol

from achse.iec.arrays import ArrayType
from achse.iec.derived import PointerType, ReferenceType, resolved
from achse.iec.enums import EnumType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.declared.predefined import PredefinedTypes
from achse.st.declared.scopes import Declared, DeclaredUnit, Failed, Scope, Scopes, with_bases
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    ArrayInitial,
    Declaration,
    Dereference,
    Expression,
    Index,
    Literal,
    Member,
    StructInitial,
    TypeOperand,
    TypeSpec,
)
from achse.st.syntax.units import FunctionBlock, TypeDeclaration
from achse.st.values.constants import Evaluator, Path, path_of
from achse.st.values.values import Constant, NotConstant, fitted


class _Types(Protocol):
    """Interface for making the types of constants."""

    def type_of(self, spec: TypeSpec, scope: Scope, hint: str) -> IecType[Any]: ...

    def entry_type(self, entry: DeclaredUnit, at: int) -> IecType[Any]: ...


class NamedConstants:
    """Evaluates constants, each at its first request.

    `constants` are those that no source declares, by name.
    """

    def __init__(
        self,
        scopes: Scopes,
        types: _Types,
        predefined: PredefinedTypes,
        constants: Mapping[str, object],
    ) -> None:
        self._scopes = scopes
        self._types = types
        self._predefined = predefined
        self._predefined_constants = {name.lower(): value for name, value in constants.items()}

    def is_predefined(self, key: str) -> bool:
        """Return True if a constant of that name, in lower case, is passed in."""
        return key in self._predefined_constants

    def known(self) -> Iterator[tuple[str, str, object]]:
        """Owner, name and value of each constant that is handed in, or was worked out so far."""
        for name, value in self._predefined_constants.items():
            yield "", name, value
        for scope in self._scopes.cached_scopes:
            for name, constant in scope.constants.items():
                if constant is not None:
                    yield scope.owner, name, constant.value

    def evaluator(
        self, scope: Scope, otherwise: Callable[[Expression], Constant] | None = None
    ) -> Evaluator:
        """Works out expressions as the inside of `scope` sees them."""
        names = (
            lambda path, at: self._lookup(path, at, scope),
            lambda operand: self._operand_type(operand, scope),
        )
        return Evaluator(*names) if otherwise is None else Evaluator(*names, otherwise)

    def constant(self, tree: Expression, scope: Scope) -> Constant:
        """Return the value of an expression. Raises `NotConstant`, `Unexpected`, `Failed`."""
        return self.evaluator(scope).value(tree)

    def check_names(self, tree: Expression, scope: Scope) -> None:
        """Raise `Unexpected` if a name in an expression means nothing."""
        with suppress(NotConstant):
            self.constant(tree, scope)

    def integer(self, tree: Expression, scope: Scope, what: str) -> int:
        """Return the whole number that an expression is. Raises `Unexpected`, `Failed`."""
        if isinstance(tree, Literal) and tree.text.isdecimal() and len(tree.text) < 20:
            return int(tree.text)
        return self.evaluator(scope).integer(tree, what, tree.at)

    def _lookup(self, path: Path, at: int, scope: Scope) -> Constant:
        keys = [part.lower() for part in path]
        if len(keys) == 1 and keys[0] in scope.values:
            return scope.values[keys[0]]
        own = self._scopes.own(keys[0], scope)
        if own is not None and not (len(keys) == 2 and self._scopes.is_enum(keys[0], scope.space)):
            return self.constant_of(*own, keys, at)
        if self.is_inherited(keys[0], scope) or self._scopes.is_property(keys[0], scope):
            raise NotConstant(at)
        if len(keys) == 1:
            return self.global_constant(keys[0], path[0], scope.space, at)
        if (constant := self._qualified(keys, scope.space, at)) is not None:
            return constant
        if keys[0] in self._scopes.globals:
            raise NotConstant(at)
        if keys[-1] in self._predefined_constants:
            return self._predefined_constant(keys[-1], at)
        if len(keys) > 1 and (
            keys[-1] in self._scopes.globals or keys[-1] in self._scopes.loose_values
        ):
            # The name of a library in front.
            space = self._scopes.library_named(keys[0]) or scope.space
            return self.global_constant(keys[-1], path[-1], space, at)
        if (value := self.of_library(keys)) is not None:
            return value
        raise Unexpected(
            at, f"no constant or variable is named '{'.'.join(path)[:80]}'", Code.UNKNOWN_NAME
        )

    def of_library(self, keys: Sequence[str]) -> Constant | None:
        """Return the value of `List.cMost` of a library that is here as a symbol file only."""
        return self._predefined.constant(keys) if len(keys) > 1 else None

    def is_inherited(self, key: str, scope: Scope) -> bool:
        """Return True if a variable comes from a base that no source declares."""
        for here in with_bases(scope):
            if here.extends is not None:
                base = self._predefined.find(here.extends.name, here.extends.at)
                return isinstance(base, StructType) and base.has_member(key)
        return False

    def global_constant(self, key: str, name: str, space: str, at: int) -> Constant:
        """Return the constant that a name means where nothing nearer has it, seen from a name
        space. Raises `NotConstant`."""
        matches = self._scopes.global_variables(key, space)
        if len(matches) > 1:
            places = " and ".join(scope.owner for scope, _ in matches[:3])
            raise Unexpected(
                at, f"'{name}' is declared in {places}: which one is meant?", Code.AMBIGUOUS_NAME
            )
        if matches:
            return self.constant_of(*matches[0], [key], at)
        values = self._scopes.values_of_enumerations(key, space)
        if len(values) > 1:
            places = " and ".join(entry.name for entry in values[:3])
            raise Unexpected(
                at, f"'{name}' is a value of {places}: which one is meant?", Code.AMBIGUOUS_NAME
            )
        if values:
            return self._enum_value(values[0], key, at)
        if key in self._predefined_constants:
            return self._predefined_constant(key, at)
        if key in self._scopes.entries:
            raise NotConstant(at)
        further = self._predefined.values(key)
        if len(further) > 1:
            places = " and ".join(item.type.name for item in further[:3] if item.type)
            raise Unexpected(
                at, f"'{name}' is a value of {places}: which one is meant?", Code.AMBIGUOUS_NAME
            )
        if further:
            return further[0]
        raise Unexpected(at, f"no constant or variable is named '{name[:80]}'", Code.UNKNOWN_NAME)

    def _qualified(self, keys: list[str], space: str, at: int) -> Constant | None:
        """`GVL.cMax`, `E_State.Idle`, `MAIN.nCount`, with name spaces in front."""
        for cut in range(1, len(keys)):
            name = ".".join(keys[:cut])
            entry = self._scopes.find(name, space)
            if entry is None:
                type = self._predefined.find(name, at)
                if type is not None and isinstance(type := resolved(type), EnumType):
                    return self._member(type, keys[cut], at)
            elif isinstance(entry.tree, TypeDeclaration):
                return self._enum_value(entry, keys[cut], at)
            else:
                scope = self._scopes.scope(entry)
                if keys[cut] not in scope.variables:
                    if cut + 1 < len(keys) and self._scopes.find(keys[cut], space) is not None:
                        continue  # a library that is named like a list
                    if self._scopes.is_property(keys[cut], scope):
                        raise NotConstant(at)
                    raise Unexpected(
                        at, f"{entry.name} has no variable '{keys[cut][:80]}'", Code.UNKNOWN_MEMBER
                    )
                return self.constant_of(scope, scope.variables[keys[cut]], keys[cut:], at)
        return None

    def _enum_value(self, entry: DeclaredUnit, key: str, at: int) -> Constant:
        type = resolved(self._types.entry_type(entry, at))
        if not isinstance(type, EnumType):
            raise Unexpected(at, f"{entry.name} is not an enumeration", Code.UNKNOWN_ENUM_VALUE)
        return self._member(type, key, at)

    def _member(self, type: EnumType[Any], key: str, at: int) -> Constant:
        for name, number in type.numbers.items():
            if name.lower() == key:
                return Constant(number, type)
        raise Unexpected(at, f"{type.name} has no value '{key[:80]}'", Code.UNKNOWN_ENUM_VALUE)

    def _predefined_constant(self, key: str, at: int) -> Constant:
        value = self._predefined_constants[key]
        if not isinstance(value, int | float | str):
            raise NotConstant(at)
        return Constant(value)

    def constant_of(self, scope: Scope, declared: Declared, keys: list[str], at: int) -> Constant:
        """Return the value of a constant. Raises `NotConstant` for other variables, and
        `Failed`."""
        block, declaration = declared
        initial = declaration.initial
        key = keys[0]
        if len(keys) == 1 and (known := scope.constants.get(key)) is not None:
            self._scopes.rest_on(scope.heights.get(key, 0))
            return known
        # What a constant structure or array holds is left to run time, like a variable.
        if "CONSTANT" not in block.qualifiers or len(keys) > 1:
            raise NotConstant(at)
        if initial is None or isinstance(initial, ArrayInitial | StructInitial):
            raise NotConstant(at)
        if key in scope.failed:
            raise Failed
        if key not in scope.constants:
            self._scopes.check_depth(at)
            scope.constants[key] = None
            try:
                with (
                    self._scopes.measured(scope.heights, key),
                    self._scopes.inside(scope.source),
                ):
                    scope.constants[key] = self._worked_out(declaration, initial, scope)
            except Failed:
                scope.failed.add(key)
                raise
            finally:
                if scope.constants[key] is None:
                    del scope.constants[key]
        constant = scope.constants[key]
        if constant is None:
            raise Unexpected(at, f"the constant '{key}' rests on itself", Code.CIRCULAR_DECLARATION)
        return constant

    def _worked_out(self, declaration: Declaration, initial: Expression, scope: Scope) -> Constant:
        hint = f"{scope.owner}.{declaration.names[0].name}"
        type = self._types.type_of(declaration.type, scope, hint)
        constant = self.constant(initial, scope)
        value = fitted(constant, type, initial.at)
        assert isinstance(value, int | float | str)
        return Constant(value, type)

    def _operand_type(self, operand: Expression, scope: Scope) -> IecType[Any]:
        """Return the type that SIZEOF and the like look at: one that is named, or that of a
        variable."""
        at = operand.at
        if isinstance(operand, TypeOperand):
            return self._types.type_of(operand.type, scope, scope.owner)
        if isinstance(operand, Index):
            whole = resolved(self._operand_type(operand.of, scope))
            if not isinstance(whole, ArrayType):
                raise Unexpected(at, f"{whole.name} is not an array", Code.BAD_INDEX)
            return whole.element
        if isinstance(operand, Dereference):
            pointer = resolved(self._operand_type(operand.of, scope))
            if not isinstance(pointer, PointerType):
                raise Unexpected(
                    at, f"{pointer.name} is not a pointer: ^ has no target", Code.NOT_A_POINTER
                )
            return pointer.target
        path = path_of(operand)
        if path is None and isinstance(operand, Member):
            return self._member_type(self._operand_type(operand.of, scope), operand.name, at)
        if path is None:
            raise NotConstant(at)
        if (variable := self._scopes.variable(path, scope)) is not None:
            owner, rest = variable
            self._scopes.check_depth(at)
            with self._scopes.inside(owner.source):
                declared = owner.variables[rest[0]][1]
                type = self._types.type_of(declared.type, owner, f"{owner.owner}.{rest[0]}")
            for name in rest[1:]:
                type = self._member_type(type, name, at)
            return type
        name = ".".join(path)
        predefined = self._predefined.find(name, at)
        if predefined is not None:
            return predefined
        entry = self._scopes.find(name, scope.space)
        if entry is not None and isinstance(entry.tree, TypeDeclaration | FunctionBlock):
            return self._types.entry_type(entry, at)
        raise NotConstant(at)

    def _member_type(self, whole: IecType[Any], name: str, at: int) -> IecType[Any]:
        real = resolved(whole)
        if isinstance(real, ReferenceType):
            real = resolved(real.target)
        if not isinstance(real, StructType):
            raise Unexpected(at, f"{whole.name} has no members", Code.UNKNOWN_MEMBER)
        return self._scopes.build(lambda: real.member(name).type, at)
