"""Expressions: from the tree to values, one construct after the other."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from achse.iec.derived import InterfaceType, resolved
from achse.iec.elementary import BOOL, BYTE, DWORD, LWORD, WORD
from achse.iec.enums import EnumType
from achse.iec.errors import IecError, IecValueError
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Address as Place
from achse.st.check.meanings import (
    BaseInstance,
    BuiltinName,
    Callee,
    Meaning,
    PropertyUse,
    SpaceName,
    TypeName,
    UnitName,
)
from achse.st.check.operands import TypedOperand, constant_operand
from achse.st.lexis.codes import Code
from achse.st.lexis.literals import literal_value
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    Assign,
    Binary,
    Call,
    Dereference,
    DirectAddress,
    Expression,
    GlobalName,
    Index,
    Literal,
    Member,
    Name,
    PartOf,
    Super,
    This,
    TypeOperand,
    Unary,
)
from achse.st.syntax.units import FunctionBlock, TypeDeclaration
from achse.st.typed.expressions import Read
from achse.st.typed.places import ImageBase, Storage
from achse.st.values.constants import path_of
from achse.st.values.values import Constant

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody


class ExpressionChecker:
    """Checks the expressions of one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    def operand(self, tree: Expression) -> TypedOperand:
        """Return an expression as a value. Raises `Unexpected` and `Failed`."""
        meaning = _READERS[tree.__class__](self, tree)
        if not isinstance(meaning, TypedOperand):
            meaning = self.as_operand(meaning, tree.at)
        if meaning.value.type is None:
            return self._body.calls.valued(meaning, tree.at)
        return meaning

    def as_operand(self, meaning: Meaning, at: int) -> TypedOperand:
        """Return a meaning as a value: a property is read, a function is called."""
        match meaning:
            case TypedOperand():
                return meaning
            case PropertyUse():
                return self._body.calls.read_property(meaning)
            case Callee() | BuiltinName():
                return self.called_without_arguments(meaning, at)
            case BaseInstance():
                this = self._body.names.this_operand(at)
                assert this is not None
                return this
            case TypeName(name=name) | UnitName(name=name):
                raise Unexpected(at, f"{name} is not a value", Code.NOT_A_VALUE)
            case SpaceName(name, place):
                constants = self._body.checking.names.constants
                value = constants.of_library(name.lower().split("."))
                if value is None:
                    raise self._body.names.unknown(name, place)
                return constant_operand(value, place)

    def called_without_arguments(self, meaning: Meaning, at: int) -> TypedOperand:
        """Call a routine without parentheses, as older sources do, or read the value."""
        if isinstance(meaning, Callee):
            return self._body.calls.invoke(meaning, (), at)
        if isinstance(meaning, BuiltinName):
            return self._body.builtins.call(meaning.name, (), at)
        return self.as_operand(meaning, at)

    def meaning(self, tree: Expression) -> Meaning:
        """Return the meaning of an expression: a value, or anything else that a name can be."""
        return _READERS[tree.__class__](self, tree)

    def type_operand(self, tree: Expression) -> IecType[Any] | None:
        """Return the type that an expression names; None if it is a value."""
        if isinstance(tree, TypeOperand):
            body = self._body
            return body.checking.names.type_of(tree.type, body.scope, body.signature.name)
        if isinstance(tree, Name | Member):
            meaning = self.meaning_or_type(tree)
            if isinstance(meaning, TypeName):
                return meaning.type
        return None

    def declared_type(self, tree: Expression) -> IecType[Any] | None:
        """Return the type that a name means where only a type can stand, whatever else has the
        name."""
        path = path_of(tree)
        if path is not None:
            body = self._body
            entry = body.checking.names.scopes.find(".".join(path), body.scope.space)
            if entry is not None and isinstance(entry.tree, TypeDeclaration | FunctionBlock):
                return body.checking.names.entry_type(entry, tree.at)
        return self.type_operand(tree)

    def meaning_or_type(self, tree: Name | Member) -> Meaning:
        """Return the meaning, but prefer the type for a name of both a type and a function."""
        meaning = self.meaning(tree)
        if isinstance(meaning, BuiltinName):
            type = self._body.checking.names.predefined.find(meaning.name, tree.at)
            if type is not None:
                return TypeName(type, None, meaning.name, tree.at)
        return meaning

    # leaves ----------------------------------------------------------------------------------

    def _literal(self, tree: Literal) -> Meaning:
        try:
            type, value, enum = literal_value(tree.text)
        except (IecValueError, ValueError) as error:
            raise Unexpected(tree.at, str(error), Code.BAD_LITERAL) from None
        if enum:
            meaning = self._enum_literal(enum, value, tree.at)
            self._body.note_use(tree, None, meaning)
            return meaning
        is_bits = type is None and isinstance(value, int) and "#" in tree.text
        return constant_operand(Constant(value, type), tree.at, is_bits=is_bits)

    def _enum_literal(self, enum: str, value: object, at: int) -> Meaning:
        """`E_State#Idle`, `E_State#2`."""
        body = self._body
        meaning = body.names.find(enum, at)
        real = resolved(meaning.type) if isinstance(meaning, TypeName) else None
        if not isinstance(real, EnumType):
            raise Unexpected(at, f"'{enum[:80]}' is not an enumeration", Code.UNKNOWN_ENUM_VALUE)
        if isinstance(value, str):
            for name, number in real.numbers.items():
                if name.lower() == value.lower():
                    return constant_operand(Constant(number, real), at)
            raise Unexpected(
                at, f"{real.name} has no value '{value[:80]}'", Code.UNKNOWN_ENUM_VALUE
            )
        assert isinstance(value, int)
        return constant_operand(Constant(value, real), at)

    def _name(self, tree: Name) -> Meaning:
        body = self._body
        if not tree.name:
            raise Unexpected(tree.at, "an expression is missing", Code.NOT_A_VALUE)
        meaning = body.names.find(tree.name, tree.at)
        if body.checking.uses is not None:
            body.note_use(tree, None, meaning)
        if meaning is not None:
            return meaning
        special = body.builtins.variable(tree.name, tree.at)
        return SpaceName(tree.name, tree.at) if special is None else special

    def _global_name(self, tree: GlobalName) -> Meaning:
        meaning = self._body.names.outer(tree.name, tree.at)
        self._body.note_use(tree, None, meaning)
        return SpaceName(tree.name, tree.at) if meaning is None else meaning

    def _address(self, tree: DirectAddress) -> Meaning:
        """`%MW10` in a body."""
        try:
            place = Place.parse(tree.text)
        except IecError as error:
            raise Unexpected(tree.at, str(error), Code.BAD_ADDRESS) from None
        if place.byte is None:
            raise Unexpected(
                tree.at, f"{tree.text} is allowed in declarations only", Code.BAD_ADDRESS
            )
        type = BOOL if place.bit is not None else _WIDTHS.get(place.width, BYTE)
        base = ImageBase(place.area)
        storage = Storage(base, place.byte, type, place.bit, name=tree.text, at=tree.at)
        return TypedOperand(Read(storage, type, tree.at), type, storage)

    def _this(self, tree: This) -> Meaning:
        body = self._body
        address = body.names.this_address(tree.at)
        if address is None:
            raise Unexpected(tree.at, "THIS is in function blocks only", Code.NO_THIS_OR_SUPER)
        assert body.this is not None
        return TypedOperand(address, body.checking.pointer_to(body.this))

    def _super(self, tree: Super) -> Meaning:
        return self._body.paths.base_instance(tree.at)

    def _type(self, tree: TypeOperand) -> Meaning:
        type = self.type_operand(tree)
        assert type is not None
        return TypeName(type, None, type.name, tree.at)

    # steps -----------------------------------------------------------------------------------

    def _member(self, tree: Member) -> Meaning:
        if self._body.checking.uses is None:
            return self._body.paths.member(tree)
        whole = self.meaning(tree.of)
        meaning = self._body.paths.member(tree)
        self._body.note_use(tree, whole, meaning)
        return meaning

    def _part_of(self, tree: PartOf) -> Meaning:
        return self._body.paths.part_of(tree)

    def _index(self, tree: Index) -> Meaning:
        return self._body.elements.index(tree)

    def _dereference(self, tree: Dereference) -> Meaning:
        return self._body.paths.dereference(tree)

    def _call(self, tree: Call) -> Meaning:
        return self._body.calls.call(tree)

    # operators -------------------------------------------------------------------------------

    def _chain(self, tree: Binary) -> TypedOperand:
        """Long sums lean to the left: that side is walked, not descended."""
        operators = self._body.operators
        first = tree.left
        if first.__class__ is not Binary:
            left, right = self.operand(first), self.operand(tree.right)
            return operators.binary(tree.operator, left, right, tree.at)
        chain = [tree]
        while isinstance(first, Binary):
            chain.append(first)
            first = first.left
        left = self.operand(first)
        is_long = len(chain) > _LONG
        for node in reversed(chain):
            right = self.operand(node.right)
            left = operators.binary(node.operator, left, right, node.at, is_long=is_long)
        return left

    def _unary(self, tree: Unary) -> Meaning:
        return self._body.operators.unary(tree.operator, self.operand(tree.operand), tree.at)

    def _assign(self, tree: Assign) -> Meaning:
        return self._body.assignments.assign(tree)

    # callable --------------------------------------------------------------------------------

    def callee(self, tree: Expression) -> Meaning:
        """Return the target of a call: a routine, an instance, a program."""
        meaning = self.meaning(tree)
        if isinstance(meaning, PropertyUse):
            meaning = self._body.calls.read_property(meaning)
        if (
            isinstance(meaning, TypedOperand)
            and not _is_instance(meaning)
            and isinstance(tree, Name)
        ):
            # The result of a function has the name that calls it.
            routine = self._body.names.routine(tree.name, tree.at)
            if routine is not None:
                return routine
        return meaning


def _is_instance(operand: TypedOperand) -> bool:
    type = operand.flat
    if isinstance(type, InterfaceType):
        return False
    return isinstance(type, StructType) and type.kind is RecordKind.FUNCTION_BLOCK


_LONG = 50
"""Operators in a row from which on a difference is a sum, so that code does not nest too deep."""

_WIDTHS: dict[str, IecType[Any]] = {"B": BYTE, "W": WORD, "D": DWORD, "L": LWORD}

_READERS: dict[type, Callable[[ExpressionChecker, Any], Meaning]] = {
    Binary: ExpressionChecker._chain,
    DirectAddress: ExpressionChecker._address,
    Literal: ExpressionChecker._literal,
    Name: ExpressionChecker._name,
    GlobalName: ExpressionChecker._global_name,
    This: ExpressionChecker._this,
    Super: ExpressionChecker._super,
    Member: ExpressionChecker._member,
    PartOf: ExpressionChecker._part_of,
    Index: ExpressionChecker._index,
    Dereference: ExpressionChecker._dereference,
    Call: ExpressionChecker._call,
    Unary: ExpressionChecker._unary,
    Assign: ExpressionChecker._assign,
    TypeOperand: ExpressionChecker._type,
}
