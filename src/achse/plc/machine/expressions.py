"""Values of the typed form in machine code."""

from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from achse.iec.elementary import BoolType, RealType
from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.native.backend import (
    ADDRESS,
    BOOL,
    F64,
    I64,
    U8,
    U64,
    FunctionBuilder,
    LocalVariable,
    MachineType,
    Operand,
    Relation,
)
from achse.plc.code.calls import HeldAddress
from achse.plc.machine.calls import CallTranslator
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.outside import OutsideTranslator
from achse.plc.machine.reals import RealTranslator
from achse.plc.machine.storages import MachineStorages, OwnBytes
from achse.plc.machine.texts import TextTranslator
from achse.plc.machine.values import (
    MachineText,
    MachineValue,
    NotTranslatedError,
    PackedBytes,
    is_packed,
    machine_type,
)
from achse.plc.memory import Area
from achse.st.check.kinds import counted
from achse.st.typed.expressions import (
    AddressOf,
    Composed,
    Computed,
    Conversion,
    Converted,
    Created,
    Deleted,
    EnumName,
    Invocation,
    Known,
    Latched,
    Operator,
    Queried,
    Read,
    Shortcut,
    Stored,
    TypedValue,
)
from achse.st.typed.project import Routine
from achse.st.values import UNITS_NS

if TYPE_CHECKING:
    from achse.plc.machine.module import ProjectTranslator

__all__ = ["ExpressionTranslator", "has_effect"]

_RELATIONS = {
    Operator.EQ: Relation.EQUAL,
    Operator.NE: Relation.NOT_EQUAL,
    Operator.LT: Relation.LESS,
    Operator.LE: Relation.LESS_EQUAL,
    Operator.GT: Relation.GREATER,
    Operator.GE: Relation.GREATER_EQUAL,
}
_TEXTS = frozenset(
    {
        Operator.LEN,
        Operator.LEFT,
        Operator.RIGHT,
        Operator.MID,
        Operator.CONCAT,
        Operator.INSERT,
        Operator.DELETE,
        Operator.REPLACE,
        Operator.FIND,
    }
)
_WITH_EFFECT = (Invocation, Stored, Latched, Created, Deleted, Queried)
_DAY_NS = 86_400 * 1_000_000_000
_LARGEST_BUFFER = 1 << 14
"""Bytes of a value that has no place in PLC memory; routines with larger ones stay plain."""


class ExpressionTranslator:
    """Translates the values of one routine. `number` is the routine's place in the project."""

    def __init__(
        self, module: "ProjectTranslator", routine: Routine, number: int, builder: FunctionBuilder
    ) -> None:
        self.module = module
        self.routine = routine
        self.number_of_routine = number
        self.builder = builder
        builder.place = lambda: self.site(FaultKind.CALL)
        self.at = routine.at
        """Present offset in the source."""
        self.this = Operand(U64, "%this")
        self.instance = Operand(ADDRESS, "%instance")
        self.frame = Operand(ADDRESS, "%frame")
        self.frame_offset = Operand(U64, "%frame.offset")
        self.uses_instance = False
        self.aligned_instance = False
        self.areas: dict[Area, Operand] = {}
        self.locals: dict[str, LocalVariable | OwnBytes] = {}
        """Variables of the frame that need no address, by name."""
        self.storages = MachineStorages(self)
        self.calls = CallTranslator(self)
        self.outside = OutsideTranslator(self)
        self._reals = RealTranslator(self)
        self._texts = TextTranslator(self)
        self._variables = sorted(routine.frame.fields, key=lambda field: field.offset)
        self._offsets = [variable.offset for variable in self._variables]
        self._buffers: dict[int, list[Operand]] = {}
        self._lent: list[tuple[int, Operand]] = []

    # what the routine has --------------------------------------------------------------------

    def frame_variable(self, offset: int) -> Variable[Any, Any]:
        """The variable of the frame that has the byte at `offset`."""
        place = bisect_left(self._offsets, offset)
        if place == len(self._offsets) or self._offsets[place] != offset:
            place -= 1
        if place >= 0:
            variable = self._variables[place]
            if offset < variable.offset + max(variable.type.size, 1):
                return variable
        raise AssertionError(f"{self.routine.name}: nothing in the frame at {offset}")

    def area(self, area: Area) -> Operand:
        """Return the address at which an area begins."""
        found = self.areas.get(area)
        if found is None:
            found = self.areas[area] = Operand(ADDRESS, f"%area.{area.name.lower()}")
        return found

    def site(self, kind: FaultKind) -> int:
        """The number of what may happen where we are."""
        return self.module.sites.number(self.number_of_routine, self.at, kind)

    def place(self, at: int) -> None:
        """We are at another place of the source now."""
        self.at = at

    def buffer(self, size: int) -> Operand:
        """The address of bytes that are ours until the statement ends."""
        if size > _LARGEST_BUFFER:
            raise NotTranslatedError(f"a value of {size} bytes is computed")
        size = max(size + 15 & -16, 16)
        free = self._buffers.setdefault(size, [])
        found = free.pop() if free else self.builder.buffer(size)
        self._lent.append((size, found))
        return found

    def own(self, type: IecType[Any]) -> LocalVariable | OwnBytes:
        """Room for a variable that needs no address."""
        if not isinstance(type, StringType) and not is_packed(type):
            return self.builder.variable(machine_type(type))
        if type.size > _LARGEST_BUFFER:
            raise NotTranslatedError(f"a variable of {type.size} bytes is on the stack")
        length = self.builder.variable(I64) if isinstance(type, StringType) else None
        return OwnBytes(self.builder.buffer(max(type.size + 7 & -8, 8)), type.size, length)

    def end_statement(self) -> None:
        """Buffers are free again."""
        for size, buffer in self._lent:
            self._buffers[size].append(buffer)
        self._lent.clear()

    # values ----------------------------------------------------------------------------------

    def number(self, value: TypedValue) -> Operand:
        """A value in a register."""
        found = self.value(value)
        assert isinstance(found, Operand)
        return found

    def at_type(self, value: Operand, type: MachineType) -> Operand:
        """A value where its type has another name."""
        return value if value.type is type else self.builder.convert(value, type)

    def text(self, value: TypedValue) -> MachineText:
        """A text."""
        found = self.value(value)
        assert isinstance(found, MachineText)
        return found

    def several(self, values: Sequence[TypedValue]) -> list[MachineValue]:
        """Values one after the other: what a later one may change is copied before."""
        found: list[MachineValue] = []
        for place, value in enumerate(values):
            one = self.value(value)
            if (
                not isinstance(one, Operand)
                and not one.steady
                and any(has_effect(later) for later in values[place + 1 :])
            ):
                one = self.snapshot(one, value.type)
            found.append(one)
        return found

    def snapshot(self, value: Any, type: IecType[Any] | None = None) -> Any:
        """A copy of a text or record that nothing changes."""
        b = self.builder
        if isinstance(value, MachineText):
            assert isinstance(type, StringType)
            kept = self.buffer(type.length * type.unit)
            b.copy(kept, value.address, value.length)
            return MachineText(kept, value.length, steady=True)
        assert isinstance(value, PackedBytes)
        kept = self.buffer(value.size)
        b.copy(kept, value.address, value.size)
        return PackedBytes(kept, value.size, steady=True)

    def value(self, value: TypedValue) -> MachineValue:
        """A value, exactly of its type."""
        if isinstance(value, HeldAddress):
            return self.calls.held(value)
        match value:
            case Known():
                return self._known(value)
            case Read(storage):
                given = self.calls.result_read(storage)
                return self.storages.read(storage) if given is None else given
            case Converted():
                return self._converted(value)
            case Computed():
                return self._computed(value)
            case Stored(storage, inner):
                return self.storages.store(storage, lambda: self.value(inner))
            case AddressOf(storage, type):
                return self.at_type(self.storages.address(storage), machine_type(type))
            case Invocation():
                return self.calls.call(value)
            case Shortcut():
                return self._shortcut(value)
            case Latched(storage, inner, sets):
                return self.storages.latch(storage, lambda: self.number(inner), sets=sets)
            case Composed():
                return self._composed(value)
            case EnumName():
                return self.outside.text(value, [value.operand], value.type)
            case Created():
                raise NotTranslatedError("__NEW is done by Python")
            case Deleted():
                raise NotTranslatedError("__DELETE is done by Python")
            case Queried():
                raise NotTranslatedError("__QUERYINTERFACE or __QUERYPOINTER is done by Python")

    def _known(self, value: Known) -> MachineValue:
        known, type, b = value.value, value.type, self.builder
        if isinstance(known, bytes):
            address = b.module.data(known)
            if is_packed(type):
                return PackedBytes(address, len(known), steady=True)
            return MachineText(address, b.constant(I64, len(known)), steady=True)
        kind = machine_type(type)
        if kind.is_whole:
            whole = counted(type)
            cut = int(known) & (1 << 8 * whole.size) - 1
            known = cut - (1 << 8 * whole.size) if cut > whole.high else cut
        return b.constant(kind, known)

    def _composed(self, value: Composed) -> PackedBytes:
        b = self.builder
        parts = [(offset, self.number(part)) for offset, part in value.parts]
        record = self.buffer(len(value.image))
        b.copy(record, b.module.data(value.image), len(value.image))
        for offset, part in parts:
            b.store(part, record, offset)
        return PackedBytes(record, len(value.image), steady=True)

    def _shortcut(self, value: Shortcut) -> Operand:
        b = self.builder
        decided = b.variable(BOOL)
        b.set(decided, self.number(value.left))
        more, end = b.label(), b.label()
        b.branch(b.get(decided), *((more, end) if value.is_and else (end, more)))
        b.begin(more)
        b.set(decided, self.number(value.right))
        b.begin(end)
        return b.get(decided)

    # conversions -----------------------------------------------------------------------------

    def _converted(self, value: Converted) -> MachineValue:
        operand, type, b = value.operand, value.type, self.builder
        match value.rule:
            case Conversion.EXTEND | Conversion.CUT | Conversion.FROM_BOOL | Conversion.TO_BOOL:
                return b.convert(self.number(operand), machine_type(type))
            case Conversion.TO_REAL | Conversion.RESIZE_REAL:
                # Through 64 bits, as plain code: a large LINT is rounded twice.
                wide = b.convert(self.number(operand), F64)
                return b.convert(wide, machine_type(type))
            case Conversion.ROUND:
                wide = b.convert(self.number(operand), F64)
                (found,) = b.call(self.module.support.rounded, wide)
                return b.convert(found, machine_type(type))
            case Conversion.TRUNCATE:
                return self._truncated(b.convert(self.number(operand), F64), machine_type(type))
            case Conversion.RESCALE:
                assert operand.type is not None
                return self._rescaled(self.number(operand), operand.type, type)
            case Conversion.CUT_TEXT:
                assert isinstance(type, StringType)
                text = self.text(operand)
                limit = b.constant(I64, type.length * type.unit)
                fits = b.compare(Relation.LESS_EQUAL, text.length, limit)
                return MachineText(text.address, b.select(fits, text.length, limit), text.steady)
            case Conversion.READ_TEXT:
                return self.outside.number(value, self.text(operand), type)
        assert isinstance(type, StringType)
        return self.outside.text(value, [operand], type)

    def _truncated(self, value: Operand, type: MachineType) -> Operand:
        b = self.builder
        low = b.constant(F64, type.least - 1.0)
        high = b.constant(F64, -float(type.least))
        above = b.compare(Relation.GREATER, value, low)
        inside = b.bit_and(above, b.compare(Relation.LESS, value, high))
        return b.select(inside, b.convert(value, type), b.constant(type, type.least))

    def _rescaled(self, count: Operand, source: IecType[Any], target: IecType[Any]) -> Operand:
        b = self.builder
        found = b.convert(count, U64)
        unit = UNITS_NS.get(source.name, 1)
        if unit != 1:
            found = b.multiply(found, b.constant(U64, unit))
        day = b.constant(U64, _DAY_NS)
        if target.name in ("DATE", "LDATE"):
            found = b.subtract(found, b.remainder(found, day))
        elif target.name in ("TOD", "TIME_OF_DAY", "LTOD"):
            found = b.remainder(found, day)
        unit = UNITS_NS.get(target.name, 1)
        if unit != 1:
            found = b.divide(found, b.constant(U64, unit))
        return b.convert(found, machine_type(target))

    # operators -------------------------------------------------------------------------------

    def _computed(self, value: Computed) -> MachineValue:
        operator, operands, type, b = value.operator, value.operands, value.type, self.builder
        relation = _RELATIONS.get(operator)
        if relation is not None:
            return self._comparison(relation, operands)
        if operator in _TEXTS:
            return self._texts.computed(value)
        match operator:
            case Operator.SEL:
                which, no, yes = self.several(operands)
                assert isinstance(which, Operand)
                return self._one_of(which, yes, no)
            case Operator.IF:
                return self._if(*operands)
            case Operator.MUX:
                return self._mux(operands)
            case Operator.TIME | Operator.LTIME:
                (clock,) = b.call(self.module.support.clock)
                if operator is Operator.TIME:
                    clock = b.divide(clock, b.constant(U64, UNITS_NS["TIME"]))
                return b.convert(clock, machine_type(type))
            case Operator.TASK_INDEX:
                (number,) = b.call(self.module.support.task_index)
                return b.convert(number, machine_type(type))
            case Operator.RAISE:
                code = b.convert(self.number(operands[0]), I64)
                b.leave(self.site(FaultKind.RAISED), code)
                return code
        if isinstance(type, StringType):
            return self._choice(operator, self.several(operands))
        if isinstance(type, BoolType):
            return self._logic(operator, [self.number(one) for one in operands])
        if isinstance(type, RealType):
            return self._reals.computed(value)
        kind = machine_type(type)
        if operator in _SHIFTS:
            number = self.at_type(self.number(operands[0]), kind)
            return self._shift(operator, number, self.number(operands[1]))
        return self._whole(operator, [self.at_type(self.number(one), kind) for one in operands])

    def _one_of(self, which: Operand, yes: MachineValue, no: MachineValue) -> MachineValue:
        """One of two values that are both there."""
        b = self.builder
        if isinstance(yes, Operand) and isinstance(no, Operand):
            return b.select(which, yes, self.at_type(no, yes.type))
        if isinstance(yes, MachineText) and isinstance(no, MachineText):
            return MachineText(
                b.select(which, yes.address, no.address),
                b.select(which, yes.length, no.length),
                yes.steady and no.steady,
            )
        assert isinstance(yes, PackedBytes)
        assert isinstance(no, PackedBytes)
        address = b.select(which, yes.address, no.address)
        return PackedBytes(address, yes.size, yes.steady and no.steady)

    def _if(self, which: TypedValue, no: TypedValue, yes: TypedValue) -> MachineValue:
        """One of two values; nothing of the other is evaluated."""
        b = self.builder
        on_yes, on_no, end = b.label(), b.label(), b.label()
        b.branch(self.number(which), on_yes, on_no)
        kept: list[LocalVariable] = []
        found: list[MachineValue] = []
        for label, value in ((on_yes, yes), (on_no, no)):
            b.begin(label)
            one = self.value(value)
            pieces = _operands_of(one)
            kept = kept or [b.variable(piece.type) for piece in pieces]
            for variable, piece in zip(kept, pieces, strict=True):
                b.set(variable, self.at_type(piece, variable.type))
            found.append(one)
            b.jump(end)
        b.begin(end)
        first, *more = (b.get(variable) for variable in kept)
        steady = all(getattr(one, "steady", True) for one in found)
        if more:
            return MachineText(first, more[0], steady)
        if isinstance(found[0], PackedBytes):
            return PackedBytes(first, found[0].size, steady)
        return first

    def _mux(self, operands: Sequence[TypedValue]) -> MachineValue:
        b = self.builder
        which, *values = self.several(operands)
        assert isinstance(which, Operand)
        found = values[-1]
        for place in reversed(range(len(values) - 1)):
            here = b.compare(Relation.EQUAL, which, b.constant(which.type, place))
            found = self._one_of(here, values[place], found)
        return found

    def _comparison(self, relation: Relation, operands: Sequence[TypedValue]) -> Operand:
        b = self.builder
        left, right = self.several(operands)
        if isinstance(left, MachineText) and isinstance(right, MachineText):
            assert isinstance(operands[0].type, StringType)
            return self._texts.comparison(relation, left, right, operands[0].type.unit)
        if isinstance(left, PackedBytes) and isinstance(right, PackedBytes):
            return self._texts.comparison(relation, self._as_text(left), self._as_text(right), 1)
        assert isinstance(left, Operand)
        assert isinstance(right, Operand)
        if left.type is BOOL:
            left, right = b.convert(left, U8), b.convert(right, U8)
        return b.compare(relation, left, self.at_type(right, left.type))

    def _as_text(self, value: PackedBytes) -> MachineText:
        length = self.builder.constant(I64, value.size)
        return MachineText(value.address, length, value.steady)

    def _logic(self, operator: Operator, values: list[Operand]) -> Operand:
        b = self.builder
        if operator is Operator.NOT:
            return b.bit_not(values[0])
        if operator is Operator.LIMIT:
            low, value, high = values
            return b.bit_and(b.bit_or(value, low), high)
        return _folded(_LOGIC[operator](b), values)

    def _whole(self, operator: Operator, values: list[Operand]) -> Operand:
        b = self.builder
        first = values[0]
        match operator:
            case Operator.NEG:
                return b.negate(first)
            case Operator.ABS:
                return b.absolute(first)
            case Operator.NOT:
                return b.bit_not(first)
            case Operator.MIN | Operator.MAX | Operator.LIMIT:
                found = self._choice(operator, values)
                assert isinstance(found, Operand)
                return found
            case Operator.DIV:
                left, right = values
                if not (right.is_constant and int(right.text)):
                    there = b.compare(Relation.NOT_EQUAL, right, b.constant(right.type, 0))
                    b.require(there, self.site(FaultKind.DIVIDE))
                return b.divide(left, right)
            case Operator.MOD:
                return b.remainder(*values)
        return _folded(_ARITHMETIC[operator](b), values)

    def _shift(self, operator: Operator, value: Operand, count: Operand) -> Operand:
        b, type = self.builder, value.type
        if operator in (Operator.SHL, Operator.SHR):
            mask = 63 if type.bits == U64.bits else 31
            count = b.bit_and(count, b.constant(count.type, mask))
        return _SHIFTS[operator](b)(value, b.convert(count, type))

    def _choice(self, operator: Operator, values: Sequence[MachineValue]) -> MachineValue:
        """MIN, MAX, LIMIT: the first of equals stays, as in plain code."""
        if operator is Operator.LIMIT:
            low, value, high = values
            return self._better(Operator.MIN, self._better(Operator.MAX, value, low), high)
        found = values[0]
        for one in values[1:]:
            found = self._better(operator, found, one)
        return found

    def _better(self, operator: Operator, held: MachineValue, new: MachineValue) -> MachineValue:
        relation = Relation.LESS if operator is Operator.MIN else Relation.GREATER
        if isinstance(held, MachineText) and isinstance(new, MachineText):
            return self._one_of(self._texts.comparison(relation, new, held, 1), new, held)
        assert isinstance(held, Operand)
        assert isinstance(new, Operand)
        return self._one_of(self.builder.compare(relation, new, held), new, held)

    def choice(self, operator: Operator, values: Sequence[Operand]) -> Operand:
        """MIN, MAX and LIMIT of numbers."""
        found = self._choice(operator, values)
        assert isinstance(found, Operand)
        return found


def _folded(operation: Callable[[Operand, Operand], Operand], values: list[Operand]) -> Operand:
    found = values[0]
    for one in values[1:]:
        found = operation(found, one)
    return found


_ARITHMETIC: dict[Operator, Callable[[FunctionBuilder], Callable[..., Operand]]] = {
    Operator.ADD: lambda b: b.add,
    Operator.SUB: lambda b: b.subtract,
    Operator.MUL: lambda b: b.multiply,
    Operator.AND: lambda b: b.bit_and,
    Operator.OR: lambda b: b.bit_or,
    Operator.XOR: lambda b: b.bit_xor,
}
_LOGIC: dict[Operator, Callable[[FunctionBuilder], Callable[..., Operand]]] = {
    Operator.AND: lambda b: b.bit_and,
    Operator.OR: lambda b: b.bit_or,
    Operator.XOR: lambda b: b.bit_xor,
    Operator.MIN: lambda b: b.bit_and,
    Operator.MAX: lambda b: b.bit_or,
}
_SHIFTS: dict[Operator, Callable[[FunctionBuilder], Callable[..., Operand]]] = {
    Operator.SHL: lambda b: b.shift_left,
    Operator.SHR: lambda b: b.shift_right,
    Operator.ROL: lambda b: b.rotate_left,
    Operator.ROR: lambda b: b.rotate_right,
}


def _operands_of(value: MachineValue) -> list[Operand]:
    """Return the operands of a value in registers."""
    if isinstance(value, MachineText):
        return [value.address, value.length]
    return [value.address] if isinstance(value, PackedBytes) else [value]


def has_effect(value: TypedValue) -> bool:
    """Return True if evaluating a value may change memory."""
    if isinstance(value, _WITH_EFFECT):
        return True
    match value:
        case Converted(operand) | EnumName(operand):
            return has_effect(operand)
        case Computed(_, operands):
            return any(map(has_effect, operands))
        case Shortcut(_, left, right):
            return has_effect(left) or has_effect(right)
        case Composed(_, parts):
            return any(has_effect(part) for _, part in parts)
        case Read(storage) | AddressOf(storage):
            base = storage.base
            inner = getattr(base, "value", None) or getattr(base, "address", None)
            return (inner is not None and has_effect(inner)) or any(
                has_effect(step.index) for step in storage.steps
            )
    return False
