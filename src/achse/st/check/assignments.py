"""Assignments: `:=`, `REF=`, `S=`, `R=`, alone and in chains."""

from typing import TYPE_CHECKING, Any

from achse.iec.derived import (
    AliasType,
    PointerType,
    SubrangeType,
    resolved,
)
from achse.iec.elementary import BOOL, DINT, BoolType, IntegerType
from achse.iec.enums import EnumType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.check.conversions import converted
from achse.st.check.kinds import common_integer, is_interface, is_whole, same_shape
from achse.st.check.meanings import PropertyUse
from achse.st.check.operands import TypedOperand, constant_operand, known
from achse.st.check.signatures import attributes_in
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Assign, Expression, Name
from achse.st.typed.expressions import Computed, Known, Latched, Operator, Read, Stored, TypedValue
from achse.st.typed.places import PointerBase, Storage, flat
from achse.st.values.values import Constant

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody


def subrange_of(type: IecType[Any]) -> SubrangeType | None:
    """Return the sub-range that a declared type is, if it is one."""
    while isinstance(type, AliasType):
        if isinstance(type, SubrangeType):
            return type
        type = type.base
    return None


def _own_value(tree: Expression, target: IecType[Any], value: TypedOperand) -> TypedOperand | None:
    """Return the value that an enumeration has by a name, where the name also means what does not
    fit: `State := EXECUTE` in a method Execute that gives a BOOL."""
    enum = resolved(target)
    if not (isinstance(tree, Name) and isinstance(enum, EnumType)) or is_whole(value.flat):
        return None
    numbers = (n for name, n in enum.numbers.items() if name.lower() == tree.name.lower())
    number = next(numbers, None)
    return None if number is None else constant_operand(Constant(number, enum), tree.at)


class Assignments:
    """Checks the assignments of one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    def assign(self, tree: Assign) -> TypedOperand:
        """Return an assignment; as a value it is what was assigned. Raises `Unexpected`."""
        if tree.operator == "REF=":
            return self._bind(tree)
        body = self._body
        target = body.expressions.meaning(tree.target)
        if isinstance(target, PropertyUse):
            return self._to_property(target, tree)
        target = body.expressions.as_operand(target, tree.target.at)
        storage = target.storage
        if storage is None:
            raise Unexpected(
                tree.at,
                "expected a variable before the assignment, got a value",
                Code.NOT_ASSIGNABLE,
            )
        body.check_writable(target, tree.target.at)
        value = body.expressions.operand(tree.value)
        if tree.operator != ":=":
            return self._latch(tree, storage, target, value)
        value = _own_value(tree.value, target.type, value) or value
        return self.store(storage, target.type, value, tree.value.at, tree.at)

    def store(
        self, storage: Storage, type: IecType[Any], value: TypedOperand, value_at: int, at: int
    ) -> TypedOperand:
        """Return a value put into a variable of a type."""
        body = self._body
        converted_value = body.converter.implicit(value, type, value_at)
        if isinstance(storage.type, StructType):
            self._check_copy(storage.type, at)
        limits = subrange_of(type)
        if limits is not None:
            number = converted_value.value if isinstance(converted_value, Known) else limits.low
            if isinstance(number, int) and not limits.low <= number <= limits.high:
                body.warn(value_at, f"{number} is outside {limits.name}", Code.OUTSIDE_SUBRANGE)
            converted_value = body.checks.in_range(converted_value, value, limits, value_at)
        stored = Stored(storage, converted_value, storage.type, at)
        return TypedOperand(stored, type, storage)

    def _check_copy(self, type: StructType[Any], at: int) -> None:
        """Raise `Unexpected` for blocks that are not to be copied."""
        entry = self._body.checking.names.entry_of(type)
        if entry is not None and "no_assign" in attributes_in(entry.tree):
            raise Unexpected(
                at, f"{entry.name} has attribute no_assign: it is not copied", Code.NOT_ASSIGNABLE
            )

    def _to_property(self, use: PropertyUse, tree: Assign) -> TypedOperand:
        body = self._body
        if tree.operator != ":=":
            raise Unexpected(
                tree.at, f"{tree.operator} takes a variable, got a property", Code.NOT_ASSIGNABLE
            )
        if not body.calls.has_set(use):
            # A property of a REFERENCE is read, and its target is written.
            target = body.calls.read_property(use)
            if target.storage is None or not isinstance(target.storage.base, PointerBase):
                raise Unexpected(
                    tree.at,
                    f"property {use.tree.name} has no SET: it cannot be written",
                    Code.PROPERTY_ACCESS,
                )
            value = body.expressions.operand(tree.value)
            return self.store(target.storage, target.type, value, tree.value.at, tree.at)
        value = body.expressions.operand(tree.value)
        return TypedOperand(body.calls.write_property(use, value, tree.value.at), value.type)

    def _latch(
        self, tree: Assign, storage: Storage, target: TypedOperand, value: TypedOperand
    ) -> TypedOperand:
        """`S=` and `R=`: they pass their value on, whatever the variable becomes."""
        if not isinstance(target.flat, BoolType):
            raise Unexpected(
                tree.at,
                f"{tree.operator} takes a BOOL, got a {target.type.name}",
                Code.BOOL_EXPECTED,
            )
        truth = self._body.truth(value, tree.value.at)
        return TypedOperand(Latched(storage, truth, tree.operator == "S=", BOOL, tree.at), BOOL)

    # references ------------------------------------------------------------------------------

    def _bind(self, tree: Assign) -> TypedOperand:
        """`r REF= x`: where a reference leads."""
        body = self._body
        target = body.expressions.meaning(tree.target)
        if isinstance(target, PropertyUse):
            value = body.expressions.operand(tree.value)
            return TypedOperand(body.calls.write_property(target, value, tree.value.at), value.type)
        operand = body.expressions.as_operand(target, tree.target.at)
        storage = operand.reference
        if storage is None:
            if isinstance(operand.flat, PointerType) and operand.storage is not None:
                storage = operand.storage
            else:
                raise Unexpected(
                    tree.target.at,
                    f"REF= binds a REFERENCE, got a {operand.type.name}",
                    Code.REFERENCE_TARGET,
                )
        address = self.bound_address(storage.type, operand.type, tree.value)
        return TypedOperand(Stored(storage, address, storage.type, tree.at), operand.type)

    def bound_address(
        self, pointer: IecType[Any], target: IecType[Any], tree: Expression
    ) -> TypedValue:
        """Return the address that a reference to `target` is bound to."""
        body = self._body
        value = body.expressions.operand(tree)
        if value.is_constant and value.constant == 0 and value.storage is None:
            return Known(0, pointer, tree.at)
        is_address = isinstance(value.flat, PointerType) and not is_interface(value.flat)
        if is_address and not isinstance(flat(target), PointerType):
            # An address as it is: `ref REF= pointer` is taken by the vendor's compiler.
            body.warn(
                tree.at,
                "REF= takes a variable, got a pointer: write ^ after it",
                Code.REFERENCE_TYPE,
            )
            return value.value
        wanted = flat(target)
        if not same_shape(value.flat, wanted):
            is_record = isinstance(wanted, StructType) or isinstance(value.flat, StructType)
            if is_record or wanted.size != value.flat.size:
                message = f"a REFERENCE TO {target.name} is bound to a {value.type.name}"
                body.warn(tree.at, message, Code.REFERENCE_TYPE)
        return body.paths.address(value, pointer, tree.at)

    # old value out, new value in ---------------------------------------------------------------

    def exchanged(self, tree: Expression, value: TypedValue | None, at: int) -> TypedOperand:
        """TEST_AND_SET: the variable becomes 1; its old value is the result."""
        body = self._body
        operand = body.expressions.operand(tree)
        storage = operand.storage
        if storage is None or not isinstance(storage.type, IntegerType | BoolType):
            raise Unexpected(
                at,
                f"TEST_AND_SET takes a whole number, got a {operand.type.name}",
                Code.ARGUMENT_TYPE,
            )
        new = value or known(1, storage.type, at).value
        if isinstance(storage.type, BoolType):
            new = Known(True, BOOL, at)
        return self._old_of(storage, operand, new, at)

    def added(self, pointer: Expression, summand: Expression, at: int) -> TypedOperand:
        """`__XADD`: adds to the target of a pointer; its old value is the result."""
        body = self._body
        operand, storage = self._pointed("__XADD", pointer, at)
        target = operand.flat
        assert isinstance(target, IntegerType)
        more = body.expressions.operand(summand)
        machine = common_integer(target, target)
        values = (converted(operand.value, machine, at), converted(more.value, machine, at))
        total = converted(Computed(Operator.ADD, values, machine, at), target, at)
        return self._old_of(storage, operand, total, at)

    def swapped(
        self, pointer: Expression, old: Expression, new: Expression, at: int
    ) -> TypedOperand:
        """`__COMPARE_AND_SWAP`: whether the target of a pointer was `old`; then it is `new`."""
        body = self._body
        operand, storage = self._pointed("__COMPARE_AND_SWAP", pointer, at)
        type = operand.flat
        before = body.converter.implicit(body.expressions.operand(old), operand.type, old.at)
        after = body.converter.implicit(body.expressions.operand(new), operand.type, new.at)
        temporary = body.frame.storage(body.frame.temporary(type), at)
        is_old = Computed(Operator.EQ, (Read(storage, type, at), before), BOOL, at)
        noted = Stored(temporary, converted(is_old, type, at), type, at)
        was_old = Computed(Operator.NE, (Read(temporary, type, at), Known(0, type, at)), BOOL, at)
        chosen = Computed(Operator.SEL, (was_old, Read(storage, type, at), after), type, at)
        stored = Stored(storage, chosen, type, at)
        exchange = Computed(Operator.MUX, (Known(0, DINT, at), noted, stored), type, at)
        return TypedOperand(Computed(Operator.NE, (exchange, Known(0, type, at)), BOOL, at), BOOL)

    def _pointed(self, name: str, pointer: Expression, at: int) -> tuple[TypedOperand, Storage]:
        """Return the whole number that a pointer points to."""
        place = self._body.expressions.operand(pointer)
        type = place.flat
        if not isinstance(type, PointerType) or not isinstance(flat(type.target), IntegerType):
            raise Unexpected(
                at,
                f"{name} takes a pointer to a whole number, got {place.type.name}",
                Code.ARGUMENT_TYPE,
            )
        target = flat(type.target)
        storage = Storage(PointerBase(place.value), 0, target, at=at)
        return TypedOperand(Read(storage, target, at), type.target, storage), storage

    def _old_of(
        self, storage: Storage, operand: TypedOperand, new: TypedValue, at: int
    ) -> TypedOperand:
        """Return the old value, kept in a temporary while the new one is stored: SEL takes the
        first."""
        body = self._body
        type = operand.flat
        temporary = body.frame.storage(body.frame.temporary(type), at)
        old = Stored(temporary, Read(storage, type, at), type, at)
        stored = Stored(storage, new, type, at)
        exchange = Computed(Operator.MUX, (Known(0, DINT, at), old, stored), type, at)
        return TypedOperand(exchange, operand.type)
