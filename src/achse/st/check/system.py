"""Operators of addresses, types and memory: ADR, SIZEOF, __NEW, __QUERYINTERFACE and the like."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from achse.iec.arrays import ArrayType
from achse.iec.derived import InterfaceType, PointerType, resolved
from achse.iec.elementary import BOOL, BYTE, DINT, UDINT, IntegerType
from achse.iec.strings import STRING
from achse.iec.structs import RecordKind, StructType
from achse.iec.variables import Variable
from achse.st.check.anytype import type_class
from achse.st.check.conversions import converted
from achse.st.check.folding import folded
from achse.st.check.meanings import TypeName
from achse.st.check.names import replaced
from achse.st.check.operands import TypedOperand, known, texted
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Argument, Call, Expression, Index, Member, Name
from achse.st.typed.expressions import (
    Composed,
    Computed,
    Created,
    Deleted,
    Known,
    Operator,
    Queried,
    Read,
    Stored,
    TypedValue,
)
from achse.st.typed.places import PointerBase, flat
from achse.st.typed.project import RoutineKind

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

Special: TypeAlias = "Callable[[SystemOperators, list[Expression], int], TypedOperand]"


class SystemOperators:
    """Applies them in one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    @staticmethod
    def special(name: str) -> "Special | None":
        """Return the operator of that name, in upper case."""
        return _SPECIALS.get(name)

    def variable(self, name: str, at: int) -> TypedOperand | None:
        """Return names that are values: none of the checker's own at present."""
        return None

    def _take(self, name: str, trees: list[Expression], count: int, at: int) -> None:
        if len(trees) != count:
            raise Unexpected(
                at, f"{name} takes {count} arguments, got {len(trees)}", Code.ARGUMENT_COUNT
            )

    # addresses and sizes ---------------------------------------------------------------------

    def _address(self, trees: list[Expression], at: int) -> TypedOperand:
        body = self._body
        self._take("ADR", trees, 1, at)
        operand = body.expressions.operand(trees[0])
        pointer = body.checking.pointer_to(operand.type)
        if operand.storage is not None and operand.storage.bit is not None:
            body.warn(at, "a bit has no address: ADR gives that of its byte", Code.BIT_ADDRESS)
            storage = replaced(operand.storage, bit=None)
            operand = TypedOperand(operand.value, operand.type, storage)
        return TypedOperand(body.paths.address(operand, pointer, trees[0].at), pointer)

    def _bit_address(self, trees: list[Expression], at: int) -> TypedOperand:
        """Return the number of a bit from the start of its area."""
        body = self._body
        self._take("BITADR", trees, 1, at)
        operand = body.expressions.operand(trees[0])
        if operand.storage is None:
            raise Unexpected(at, "BITADR takes a variable", Code.ARGUMENT_TYPE)
        place = replaced(operand.storage, bit=None)
        address = body.paths.address(
            TypedOperand(operand.value, operand.type, place), body.checking.pointer_to(BYTE), at
        )
        low = converted(address, UDINT, at)
        inside = Computed(Operator.AND, (low, Known(0x0FFF_FFFF, UDINT, at)), UDINT, at)
        bits = Computed(Operator.MUL, (inside, Known(8, UDINT, at)), UDINT, at)
        number = Known(operand.storage.bit or 0, UDINT, at)
        return TypedOperand(Computed(Operator.ADD, (bits, number), UDINT, at), UDINT)

    def _size(self, trees: list[Expression], at: int) -> TypedOperand:
        body = self._body
        self._take("SIZEOF", trees, 1, at)
        type = body.expressions.type_operand(trees[0])
        if type is None:
            operand = body.expressions.operand(trees[0])
            if operand.bounds:
                return self._open_size(operand, at)
            type = operand.type
        return known(type.size, UDINT, at, loose=True)

    def _open_size(self, operand: TypedOperand, at: int) -> TypedOperand:
        """Compute the size of an ARRAY [*] from its bounds."""
        size: TypedValue = Known(operand.flat.size, DINT, at)
        for lower, upper in zip(operand.bounds[::2], operand.bounds[1::2], strict=True):
            span = Computed(Operator.SUB, (upper, lower), DINT, at)
            count = Computed(Operator.ADD, (span, Known(1, DINT, at)), DINT, at)
            size = Computed(Operator.MUL, (size, count), DINT, at)
        return TypedOperand(converted(size, UDINT, at), UDINT)

    def _lower(self, trees: list[Expression], at: int) -> TypedOperand:
        return self._bound("LOWER_BOUND", trees, 0, at)

    def _upper(self, trees: list[Expression], at: int) -> TypedOperand:
        return self._bound("UPPER_BOUND", trees, 1, at)

    def _bound(self, name: str, trees: list[Expression], which: int, at: int) -> TypedOperand:
        body = self._body
        self._take(name, trees, 2, at)
        operand = body.expressions.operand(trees[0])
        number = body.expressions.operand(trees[1]).constant
        type = operand.flat
        is_array = isinstance(type, ArrayType) or bool(operand.bounds)
        if not is_array:
            raise Unexpected(
                at, f"{name} takes an array, got a {operand.type.name}", Code.ARGUMENT_TYPE
            )
        if operand.bounds:
            count = len(operand.bounds) // 2
        else:
            assert isinstance(type, ArrayType)
            count = len(type.dimensions)
        if not isinstance(number, int) or not 1 <= number <= count:
            raise Unexpected(
                at, f"{name} takes the number of a dimension, 1..{count}", Code.ARGUMENT_TYPE
            )
        if operand.bounds:
            return TypedOperand(operand.bounds[2 * number - 2 + which], DINT)
        assert isinstance(type, ArrayType)
        bounds = type.dimensions[number - 1]
        return known(bounds.last if which else bounds.first, DINT, at)

    def _is_valid(self, trees: list[Expression], at: int) -> TypedOperand:
        """`__ISVALIDREF(r)`: whether a reference leads anywhere."""
        body = self._body
        self._take("__ISVALIDREF", trees, 1, at)
        operand = body.expressions.operand(trees[0])
        pointer: TypedValue | None = None
        if operand.reference is not None:
            pointer = Read(operand.reference, operand.reference.type, at)
        elif operand.storage is not None and isinstance(operand.storage.base, PointerBase):
            pointer = operand.storage.base.address
        elif isinstance(operand.flat, PointerType):
            pointer = operand.value
        if pointer is None:
            raise Unexpected(
                at, f"__ISVALIDREF takes a REFERENCE, got a {operand.type.name}", Code.ARGUMENT_TYPE
            )
        type = pointer.type
        assert type is not None
        return TypedOperand(Computed(Operator.NE, (pointer, Known(0, type, at)), BOOL, at), BOOL)

    # memory ----------------------------------------------------------------------------------

    def _created(self, trees: list[Expression], at: int) -> TypedOperand:
        """`__NEW(T)`, `__NEW(T, count)`, `__NEW(FB_X(nParameter := 1))`."""
        body = self._body
        if not 1 <= len(trees) <= 2:
            raise Unexpected(
                at,
                f"__NEW takes a type and a count, got {len(trees)} arguments",
                Code.ARGUMENT_COUNT,
            )
        first = trees[0]
        arguments: tuple[Argument, ...] = ()
        if isinstance(first, Call):
            arguments, first = first.arguments, first.of
        type = body.expressions.declared_type(first)
        if type is None:
            raise Unexpected(first.at, "__NEW takes a type", Code.ARGUMENT_TYPE)
        count: TypedValue | None = None
        if len(trees) == 2:
            operand = body.expressions.operand(trees[1])
            if not isinstance(operand.flat, IntegerType):
                raise Unexpected(
                    at, f"a count is a whole number, got a {operand.type.name}", Code.ARGUMENT_TYPE
                )
            count = converted(operand.value, DINT, at)
        stored: tuple[Stored, ...] = ()
        real = resolved(type)
        if isinstance(real, StructType):
            body.checking.require_record(real)
            stored = body.life.arguments(real, arguments, at)
        elif arguments:
            raise Unexpected(
                at, f"{type.name} has no FB_init to give arguments to", Code.INIT_ARGUMENTS
            )
        pointer = body.checking.pointer_to(type)
        return TypedOperand(Created(flat(type), count, stored, pointer, at), pointer)

    def _deleted(self, trees: list[Expression], at: int) -> TypedOperand:
        body = self._body
        self._take("__DELETE", trees, 1, at)
        operand = body.expressions.operand(trees[0])
        storage = operand.reference
        if isinstance(operand.flat, PointerType):
            storage = body.paths.storage(operand, at)  # also THIS, a VAR_IN_OUT, a reference
        if storage is None or not isinstance(storage.type, PointerType):
            raise Unexpected(
                at,
                f"__DELETE takes a pointer variable, got a {operand.type.name}",
                Code.ARGUMENT_TYPE,
            )
        return TypedOperand(Deleted(storage, None, at), operand.type)

    def _query_interface(self, trees: list[Expression], at: int) -> TypedOperand:
        return self._queried("__QUERYINTERFACE", trees, at)

    def _query_pointer(self, trees: list[Expression], at: int) -> TypedOperand:
        return self._queried("__QUERYPOINTER", trees, at)

    def _queried(self, name: str, trees: list[Expression], at: int) -> TypedOperand:
        body = self._body
        self._take(name, trees, 2, at)
        source = body.expressions.operand(trees[0])
        target = body.expressions.operand(trees[1])
        type = source.flat
        if isinstance(type, PointerType):
            value = source.value
        elif isinstance(type, StructType) and type.kind is RecordKind.FUNCTION_BLOCK:
            value = body.paths.address(source, body.checking.pointer_to(type), at)
        else:
            raise Unexpected(
                at,
                f"{name} takes an interface or a block, got a {source.type.name}",
                Code.ARGUMENT_TYPE,
            )
        storage = target.storage
        if storage is None or not isinstance(storage.type, PointerType):
            raise Unexpected(
                trees[1].at, f"{name} puts its result into a variable", Code.ARGUMENT_TYPE
            )
        interface = ""
        if name == "__QUERYINTERFACE":
            if not isinstance(storage.type, InterfaceType):
                raise Unexpected(
                    trees[1].at, f"{name} takes an interface variable second", Code.ARGUMENT_TYPE
                )
            interface = storage.type.name.lower()
        return TypedOperand(Queried(value, storage, interface, BOOL, at), BOOL)

    # several threads -------------------------------------------------------------------------

    def _test_and_set(self, trees: list[Expression], at: int) -> TypedOperand:
        """`TEST_AND_SET(x)`: the old value; x becomes 1. Nothing interrupts a task here."""
        self._take("TEST_AND_SET", trees, 1, at)
        return self._body.assignments.exchanged(trees[0], None, at)

    def _added(self, trees: list[Expression], at: int) -> TypedOperand:
        """`__XADD(pointer, summand)`: the old value of the target of a pointer."""
        self._take("__XADD", trees, 2, at)
        return self._body.assignments.added(trees[0], trees[1], at)

    def _swapped(self, trees: list[Expression], at: int) -> TypedOperand:
        """`__COMPARE_AND_SWAP(pointer, old, new)`: TRUE if it was `old`, and is `new` now."""
        self._take("__COMPARE_AND_SWAP", trees, 3, at)
        return self._body.assignments.swapped(trees[0], trees[1], trees[2], at)

    # names -----------------------------------------------------------------------------------

    def _unit_name(self, trees: list[Expression], at: int) -> TypedOperand:
        """`__POUNAME()`: the name of the routine."""
        signature = self._body.signature
        name = signature.name
        if signature.kind in (RoutineKind.GET, RoutineKind.SET):
            unit, _, last = name.rpartition(".")
            name = f"{unit}.{last[5:]}.{signature.kind.value.title()}"
        return texted(name, STRING(), at)

    def _position(self, trees: list[Expression], at: int) -> TypedOperand:
        """`__POSITION()`: line and column."""
        place = self._body.signature.source.locate(at)
        return texted(f"Line {place.line}, Column {place.column}", STRING(), at)

    def _variable_info(self, trees: list[Expression], at: int) -> TypedOperand:
        """`__VARINFO(x)`: a VAR_INFO record about a variable."""
        body = self._body
        self._take("__VARINFO", trees, 1, at)
        operand = body.expressions.operand(trees[0])
        if operand.storage is None:
            raise Unexpected(at, "__VARINFO takes a variable", Code.ARGUMENT_TYPE)
        meaning = body.names.find("VAR_INFO", at)
        assert isinstance(meaning, TypeName)
        record = resolved(meaning.type)
        assert isinstance(record, StructType)
        type = operand.type
        real = resolved(type)
        element = real.element if isinstance(real, ArrayType) else type
        bits = 1 if operand.storage.bit is not None else 8 * type.size
        values: dict[str, object] = {
            "Area": -1,
            "BitNo": -1 if operand.storage.bit is None else operand.storage.bit,
            "BitSize": min(bits, 0x7FFF),
            "TypeClass": type_class(type),
            "TypeName": type.name[:79],
            "NumElements": real.count if isinstance(real, ArrayType) else 0,
            "BaseTypeClass": type_class(element),
            "ElemBitSize": 8 * element.size if isinstance(real, ArrayType) else 0,
            "MemoryArea": 4 if not body.frame.find(_first(trees[0]).lower()) else 5,
            "Symbol": _path(trees[0])[:39],
        }
        image = record.encode(values)
        place = replaced(operand.storage, bit=None)
        pointer = body.checking.pointer_to(type)
        address = body.paths.address(TypedOperand(operand.value, type, place), pointer, at)
        low = folded(converted(address, UDINT, at))
        offset = Computed(Operator.AND, (low, Known(0x0FFF_FFFF, UDINT, at)), UDINT, at)
        parts = (
            (_offset(record, "ByteAddress"), low),
            (_offset(record, "ByteOffset"), offset),
        )
        return TypedOperand(Composed(image, parts, record, at), meaning.type)


_SPECIALS: dict[str, Special] = {
    "ADR": SystemOperators._address,
    "BITADR": SystemOperators._bit_address,
    "SIZEOF": SystemOperators._size,
    "XSIZEOF": SystemOperators._size,
    "LOWER_BOUND": SystemOperators._lower,
    "UPPER_BOUND": SystemOperators._upper,
    "__NEW": SystemOperators._created,
    "__DELETE": SystemOperators._deleted,
    "__ISVALIDREF": SystemOperators._is_valid,
    "__QUERYINTERFACE": SystemOperators._query_interface,
    "__QUERYPOINTER": SystemOperators._query_pointer,
    "__VARINFO": SystemOperators._variable_info,
    "__POUNAME": SystemOperators._unit_name,
    "__POSITION": SystemOperators._position,
    "TEST_AND_SET": SystemOperators._test_and_set,
    "__XADD": SystemOperators._added,
    "__COMPARE_AND_SWAP": SystemOperators._swapped,
}


def _offset(record: StructType[Any], name: str) -> int:
    member: Variable[Any, Any] = record.member(name)
    return member.offset


def _first(tree: Expression) -> str:
    while isinstance(tree, Member | Index):
        tree = tree.of
    return tree.name if isinstance(tree, Name) else ""


def _path(tree: Expression) -> str:
    if isinstance(tree, Member):
        before = _path(tree.of)
        return f"{before}.{tree.name}" if before else tree.name
    if isinstance(tree, Index):
        return _path(tree.of)
    return tree.name if isinstance(tree, Name) else ""
