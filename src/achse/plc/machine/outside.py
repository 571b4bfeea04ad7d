"""Python's part of machine code: texts of numbers, names of enumerations, other encodings."""

import struct
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

from achse.iec.elementary import BoolType, RealType
from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.native.backend import ADDRESS, BOOL, F64, I64, U8, Operand
from achse.plc.code.texts import TEXTS
from achse.plc.lowering.nodes import External
from achse.plc.machine.values import MachineText, MachineValue, machine_type
from achse.st.check.kinds import counted
from achse.st.typed.expressions import Conversion, Converted, EnumName, TypedValue
from achse.st.typed.project import Routine

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

_BY_PYTHON = frozenset({Conversion.RECODE_TEXT, Conversion.WRITE_TEXT, Conversion.READ_TEXT})


class OutsideTranslator:
    """Writes the calls of Python that values of one routine need."""

    def __init__(self, expressions: "ExpressionTranslator") -> None:
        self._of = expressions

    def converted(self, value: External) -> MachineValue:
        """Return a text that Python makes of a value, or a number that Python reads from a text."""
        of, type = self._of, value.type
        b = of.builder
        operand = of.value(value.operand)
        number = b.constant(I64, of.module.outside(of.number_of_routine, value.source))
        if not isinstance(type, StringType):
            assert isinstance(operand, MachineText)
            (bits,) = b.call(of.module.support.text_read, number, operand.address, operand.length)
            wanted = machine_type(type)
            return b.convert(b.reinterpret(bits, F64) if wanted.is_real else bits, wanted)
        bits, address, length = b.constant(I64, 0), Operand(ADDRESS, "null"), b.constant(I64, 0)
        if isinstance(operand, MachineText):
            address, length = operand.address, operand.length
        else:
            assert isinstance(operand, Operand)
            bits = self._bits(operand)
        buffer = of.buffer(type.length * type.unit)
        (size,) = b.call(of.module.support.make_text, number, bits, address, length, buffer)
        return MachineText(buffer, size, steady=True)

    def _bits(self, value: Operand) -> Operand:
        b = self._of.builder
        if value.type.is_real:
            return b.reinterpret(b.convert(value, F64), I64)
        if value.type is BOOL:
            value = b.convert(value, U8)
        return b.convert(value, I64)


def nodes_outside(routine: Routine) -> Iterator[TypedValue]:
    """Return the nodes of a routine that Python does, always in the same order."""
    for part in (routine.opening, routine.body or ()):
        yield from _nodes_by_python(part)


def _nodes_by_python(part: Any) -> Iterator[TypedValue]:
    if isinstance(part, tuple):
        for one in part:
            yield from _nodes_by_python(one)
    elif is_dataclass(part) and not isinstance(part, type):
        if isinstance(part, EnumName) or (isinstance(part, Converted) and part.rule in _BY_PYTHON):
            yield part
        if type(part).__module__.startswith(_TYPED):
            for field in fields(part):
                yield from _nodes_by_python(getattr(part, field.name))


_TYPED = "achse.st.typed"


def decoded(word: int, type: IecType[Any]) -> Any:
    """Return the value of a type in a word of 64 bits."""
    if isinstance(type, BoolType):
        return word & 0xFF != 0
    if isinstance(type, RealType):
        return struct.unpack("<d", struct.pack("<q", word))[0]
    whole = counted(type)
    bits = word & (1 << 8 * whole.size) - 1
    return bits - (1 << 8 * whole.size) if bits > whole.high else bits


def encoded(value: Any, type: IecType[Any]) -> int:
    """Return the word of 64 bits that a value of a type is in."""
    if isinstance(type, RealType):
        number: int = struct.unpack("<q", struct.pack("<d", value))[0]
        return number
    return int(value)


def maker_of(node: TypedValue) -> Callable[[int, bytes], bytes]:
    """Return the function that makes the text of a node, from a word or a text."""
    if isinstance(node, EnumName):
        names, kind, text_type = dict(node.names), node.operand.type, node.type
        assert kind is not None
        assert isinstance(text_type, StringType)
        size = text_type.length * text_type.unit

        def named(bits: int, _: bytes) -> bytes:
            number = decoded(bits, kind)
            return (names.get(number) or str(number).encode())[:size]

        return named
    assert isinstance(node, Converted)
    source, target = node.operand.type, node.type
    assert source is not None
    assert isinstance(target, StringType)
    room = target.length * target.unit
    if node.rule is Conversion.RECODE_TEXT:
        recode = TEXTS["text_recoded"]
        return lambda _, text: bytes(recode(text, source, target))[:room]
    write = TEXTS["text_written"]
    return lambda bits, _: bytes(write(decoded(bits, source), source, target))[:room]


def reader_of(node: TypedValue) -> Callable[[bytes], int]:
    """Return the function that reads the number of a node from a text, as a word."""
    assert isinstance(node, Converted)
    source, target, read = node.operand.type, node.type, TEXTS["text_read"]

    def word(text: bytes) -> int:
        number = encoded(read(text, source, target), target) & (1 << 64) - 1
        return number - (1 << 64) if number >> 63 else number

    return word
