"""Functions of texts in machine code: positions count from 1, at most 255 characters."""

from typing import TYPE_CHECKING

from achse.iec.strings import StringType
from achse.native.backend import I32, I64, Operand, Relation
from achse.plc.lowering.nodes import Compute
from achse.plc.lowering.places import BYTES_A_PASS, is_large
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.values import MachineText, MachineValue, machine_type
from achse.st.typed.expressions import Operator

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

_LONGEST = 255
_LONGEST_LENGTH = 0x7FFF


class TextTranslator:
    """Operators of texts, for one routine."""

    def __init__(self, expressions: "ExpressionTranslator") -> None:
        self._of = expressions

    def computed(self, value: Compute) -> MachineValue:
        """Return a text, or a number."""
        of = self._of
        b = of.builder
        type = value.operands[0].type
        assert isinstance(type, StringType)
        unit = type.unit
        texts: list[MachineText] = []
        numbers: list[Operand] = []
        for one in map(of.value, value.operands):
            if isinstance(one, MachineText):
                texts.append(one)
            else:
                assert isinstance(one, Operand)
                numbers.append(b.convert(one, I64))
        text = texts[0]
        match value.operator:
            case Operator.LEN:
                length = b.divide(text.length, self._number(unit))
                return b.convert(
                    self._least(length, self._number(_LONGEST_LENGTH)), machine_type(value.type)
                )
            case Operator.FIND:
                other = texts[1]
                if any(is_large(one.type) for one in value.operands):
                    compared = b.multiply(text.length, other.length)
                    passes = b.shift_right(compared, self._number(BYTES_A_PASS.bit_length() - 1))
                    b.spend(passes, of.site(FaultKind.BUDGET))
                (result,) = b.call(
                    of.module.support.find,
                    text.address,
                    text.length,
                    other.address,
                    other.length,
                    self._number(unit),
                )
                return b.convert(result, machine_type(value.type))
            case Operator.LEFT:
                return self._cut(text, self._bytes(numbers[0], unit), unit)
            case Operator.RIGHT:
                text = self._cut(text, None, unit)
                start = b.subtract(text.length, self._bytes(numbers[0], unit))
                return self._slice(text, self._most(start, self._number(0)), text.length)
            case Operator.MID:
                return self._mid(text, numbers[0], numbers[1], unit)
            case Operator.CONCAT:
                return self._joined(texts, unit)
            case Operator.INSERT:
                return self._inserted(text, texts[1], self._bytes_at(numbers[0], unit), unit)
            case Operator.DELETE:
                return self._deleted(text, numbers[0], numbers[1], unit)
        rest = self._deleted(text, numbers[0], numbers[1], unit)  # REPLACE
        position = self._most(b.subtract(numbers[1], self._number(1)), self._number(0))
        return self._inserted(rest, texts[1], self._bytes_at(position, unit), unit)

    def comparison(
        self, relation: Relation, left: MachineText, right: MachineText, unit: int
    ) -> Operand:
        """Byte by byte; of a WSTRING character by character."""
        of = self._of
        b = of.builder
        if relation in (Relation.EQUAL, Relation.NOT_EQUAL):
            unit = 1
        (order,) = b.call(
            of.module.support.compare(unit),
            left.address,
            left.length,
            right.address,
            right.length,
        )
        return b.compare(relation, order, b.constant(I32, 0))

    # pieces ----------------------------------------------------------------------------------

    def _number(self, number: int) -> Operand:
        return self._of.builder.constant(I64, number)

    def _least(self, a: Operand, c: Operand) -> Operand:
        b = self._of.builder
        return b.select(b.compare(Relation.LESS, a, c), a, c)

    def _most(self, a: Operand, c: Operand) -> Operand:
        b = self._of.builder
        return b.select(b.compare(Relation.GREATER, a, c), a, c)

    def _bytes_at(self, position: Operand, unit: int) -> Operand:
        return self._of.builder.multiply(position, self._number(unit))

    def _bytes(self, size: Operand, unit: int) -> Operand:
        """Return bytes of a number of characters, none if it is below 0."""
        return self._bytes_at(self._most(size, self._number(0)), unit)

    def _cut(self, text: MachineText, length: Operand | None, unit: int) -> MachineText:
        """Return the beginning, of at most 255 characters."""
        limit = self._number(_LONGEST * unit)
        limit = limit if length is None else self._least(length, limit)
        return MachineText(text.address, self._least(text.length, limit), text.steady)

    def _slice(self, text: MachineText, start: Operand, end: Operand) -> MachineText:
        b = self._of.builder
        return MachineText(b.address(text.address, start), b.subtract(end, start), text.steady)

    def _range(
        self, text: MachineText, length: Operand, position: Operand, unit: int
    ) -> tuple[Operand, Operand, Operand]:
        """Return a flag if length and position select anything, and begin and end of the selection
        in the text."""
        b = self._of.builder
        first = b.compare(Relation.GREATER, position, self._number(0))
        some = b.bit_and(first, b.compare(Relation.GREATER, length, self._number(0)))
        start = self._bytes_at(b.subtract(position, self._number(1)), unit)
        end = b.add(start, self._bytes_at(length, unit))
        return some, self._least(start, text.length), self._least(end, text.length)

    def _mid(self, text: MachineText, length: Operand, position: Operand, unit: int) -> MachineText:
        b = self._of.builder
        text = self._cut(text, None, unit)
        some, start, end = self._range(text, length, position, unit)
        nothing = self._number(0)
        return self._slice(text, b.select(some, start, nothing), b.select(some, end, nothing))

    def _deleted(
        self, text: MachineText, length: Operand, position: Operand, unit: int
    ) -> MachineText:
        b = self._of.builder
        text = self._cut(text, None, unit)
        some, start, end = self._range(text, length, position, unit)
        start = b.select(some, start, text.length)
        end = b.select(some, end, text.length)
        head = MachineText(text.address, start)
        return self._joined([head, self._slice(text, end, text.length)], unit)

    def _inserted(
        self, text: MachineText, other: MachineText, at: Operand, unit: int
    ) -> MachineText:
        b = self._of.builder
        above = b.compare(Relation.GREATER_EQUAL, at, self._number(0))
        inside = b.bit_and(above, b.compare(Relation.LESS_EQUAL, at, text.length))
        at = b.select(inside, at, text.length)
        added = b.select(inside, other.length, self._number(0))
        head = MachineText(text.address, at)
        return self._joined(
            [head, MachineText(other.address, added), self._slice(text, at, text.length)], unit
        )

    def _joined(self, pieces: list[MachineText], unit: int) -> MachineText:
        """One after the other, at most 255 characters."""
        of = self._of
        b = of.builder
        whole = of.buffer(_LONGEST * unit)
        length = self._number(0)
        for piece in pieces:
            room = b.subtract(self._number(_LONGEST * unit), length)
            size = self._least(piece.length, room)
            b.copy(b.address(whole, length), piece.address, size)
            length = b.add(length, size)
        return MachineText(whole, length, steady=True)
