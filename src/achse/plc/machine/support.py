"""Support functions for machine code: functions of its own module, and Python."""

from collections.abc import Mapping

from achse.native.backend import (
    ADDRESS,
    BOOL,
    F64,
    I32,
    I64,
    U8,
    U16,
    U64,
    CallTarget,
    FunctionBuilder,
    FunctionSignature,
    ModuleBuilder,
    ModuleInterface,
    Operand,
    Relation,
    Rounding,
)
from achse.plc.memory import ADDRESS_BITS, Area

AREA_WORDS = "areas"
"""Table of areas: address and length, by the number in addresses; number 0 is empty."""
FRAME_WORDS = "frames"
"""Size of the frames in use."""
COUNT_WORDS = "counts"
"""Counters of statements and branches, in a module that has any."""
ENTRIES = "entries"
"""Table of what Python calls."""

WORD = 8
AREA_ROW = 2 * WORD
AREAS = len(Area) + 1

_LOWEST = -(2.0**63)

CALLBACKS: Mapping[str, FunctionSignature] = {
    "call_plain": FunctionSignature((I64, ADDRESS)),
    "clock": FunctionSignature((), (U64,)),
    "task_index": FunctionSignature((), (I64,)),
    "caught": FunctionSignature((), (I64,)),
    "push_exception": FunctionSignature(),
    "reraise": FunctionSignature(),
    "missing": FunctionSignature((U64, I64)),
    "make_text": FunctionSignature((I64, I64, ADDRESS, I64, ADDRESS), (I64,)),
    "text_read": FunctionSignature((I64, ADDRESS, I64), (I64,)),
}

_CALLS: Mapping[str, tuple[type, ...]] = {}


def _exported(name: str, parameters: tuple[object, ...]) -> CallTarget:
    signature = FunctionSignature(parameters)  # type: ignore[arg-type]
    return CallTarget(f'@"{name}"', signature, faults=True, convention=True)


INTERFACE = ModuleInterface(
    {
        "call": _exported("call", (ADDRESS,)),
        "call_with": _exported("call_with", (ADDRESS, U64)),
    },
    CALLBACKS,
    {AREA_WORDS: 2 * AREAS, FRAME_WORDS: 1},
)
"""Interface of all modules of Structured Text."""


class Support:
    """Functions of a module that the code of all routines calls."""

    def __init__(self, module: ModuleBuilder) -> None:
        self._module = module
        self.areas = module.words(AREA_WORDS, 2 * AREAS)
        self.frames = module.words(FRAME_WORDS, 1)
        functions = {
            name: module.callback(name, signature.parameters, signature.results)
            for name, signature in CALLBACKS.items()
        }
        self.call_plain = functions["call_plain"]
        self.clock = functions["clock"]
        self.task_index = functions["task_index"]
        self.caught = functions["caught"]
        self.push_exception = functions["push_exception"]
        self.reraise = functions["reraise"]
        self.missing = functions["missing"]
        self.make_text = functions["make_text"]
        self.text_read = functions["text_read"]
        self.locate = self._locate()
        self.rounded = self._rounded()
        self.find = self._find()
        self._lengths = {1: self._length(1), 2: self._length(2)}
        self._compares = {1: self._compare(), 2: self._compare_wide()}
        self._write_entries()

    def length(self, unit: int) -> CallTarget:
        """Return bytes of a text before its NUL, at most so many."""
        return self._lengths[unit]

    def compare(self, unit: int) -> CallTarget:
        """I32: below 0, 0 or above 0, of two texts."""
        return self._compares[unit]

    def _write_entries(self) -> None:
        """Write the functions that Python calls: a function of the table of entries, with one
        argument or none."""
        for name, target in INTERFACE.functions.items():
            types = target.signature.parameters
            b = self._module.function(name, types, exported=True, faults=True)
            where, *arguments = b.parameters
            like = CallTarget("", FunctionSignature(types[1:]), faults=True)
            b.call_at(where, like, *arguments)
            b.return_()

    def _locate(self) -> CallTarget:
        """(address, size): the machine address; 0 unless all of these bytes are PLC memory."""
        b = self._module.function("locate", [U64, I64], [ADDRESS])
        address, size = b.parameters
        number = b.shift_right(address, b.constant(U64, ADDRESS_BITS))
        inside = b.compare(Relation.LESS, number, b.constant(U64, AREAS))
        number = b.select(inside, number, b.constant(U64, 0))
        row = b.address(self.areas, number, AREA_ROW)
        offset = b.bit_and(address, b.constant(U64, (1 << ADDRESS_BITS) - 1))
        end = b.add(b.convert(offset, I64), size)
        good = b.compare(Relation.LESS_EQUAL, end, b.load(I64, row, WORD))
        good = b.bit_and(good, b.compare(Relation.NOT_EQUAL, number, b.constant(U64, 0)))
        place = b.address(b.load(ADDRESS, row), offset)
        b.return_(b.select(good, place, Operand(ADDRESS, "null")))
        return b.function

    def _rounded(self) -> CallTarget:
        """Return a real as I64: nearest, halves away from zero; NaN is 0, what is too large the
        lowest."""
        b = self._module.function("rounded", [F64], [I64])
        (value,) = b.parameters
        size = b.absolute(value)
        down = b.round(size, Rounding.DOWN)
        half = b.compare(Relation.GREATER_EQUAL, b.subtract(size, down), b.constant(F64, 0.5))
        whole = b.add(b.convert(down, I64), b.convert(half, I64))
        below = b.compare(Relation.LESS, value, b.constant(F64, 0.0))
        signed = b.select(below, b.negate(whole), whole)
        fits = b.compare(Relation.LESS, size, b.constant(F64, -_LOWEST))
        signed = b.select(fits, signed, b.constant(I64, I64.least))
        number = b.compare(Relation.EQUAL, value, value)
        b.return_(b.select(number, signed, b.constant(I64, 0)))
        return b.function

    def _length(self, unit: int) -> CallTarget:
        """(text, limit in bytes): bytes before the NUL."""
        kind = U8 if unit == 1 else U16
        b = self._module.function(f"length.{unit}", [ADDRESS, I64], [I64])
        text, limit = b.parameters
        at = b.variable(I64)
        b.set(at, b.constant(I64, 0))
        again, look, more, end = b.label(), b.label(), b.label(), b.label()
        b.begin(again)
        b.branch(b.compare(Relation.LESS, b.get(at), limit), look, end)
        b.begin(look)
        here = b.load(kind, text, b.get(at))
        b.branch(b.compare(Relation.EQUAL, here, b.constant(kind, 0)), end, more)
        b.begin(more)
        b.set(at, b.add(b.get(at), b.constant(I64, unit)))
        b.jump(again)
        b.begin(end)
        b.return_(b.get(at))
        return b.function

    def _compare(self) -> CallTarget:
        b = self._module.function("compare.1", [ADDRESS, I64, ADDRESS, I64], [I32])
        left, left_size, right, right_size = b.parameters
        memcmp = self._module.c_function("memcmp", (ADDRESS, ADDRESS, I64), I32)
        size = b.select(b.compare(Relation.LESS, left_size, right_size), left_size, right_size)
        (order,) = b.call(memcmp, left, right, size)
        differ = b.compare(Relation.NOT_EQUAL, order, b.constant(I32, 0))
        b.return_(b.select(differ, order, self._order(b, left_size, right_size)))
        return b.function

    def _order(self, b: FunctionBuilder, left: Operand, right: Operand) -> Operand:
        """-1, 0 or 1."""
        above = b.convert(b.compare(Relation.GREATER, left, right), I32)
        return b.subtract(above, b.convert(b.compare(Relation.LESS, left, right), I32))

    def _compare_wide(self) -> CallTarget:
        b = self._module.function("compare.2", [ADDRESS, I64, ADDRESS, I64], [I32])
        left, left_size, right, right_size = b.parameters
        size = b.select(b.compare(Relation.LESS, left_size, right_size), left_size, right_size)
        at, order = b.variable(I64), b.variable(I32)
        b.set(at, b.constant(I64, 0))
        again, look, more, lengths, end = (b.label() for _ in range(5))
        b.begin(again)
        b.branch(b.compare(Relation.LESS, b.get(at), size), look, lengths)
        b.begin(look)
        one, other = b.load(U16, left, b.get(at)), b.load(U16, right, b.get(at))
        b.set(order, self._order(b, b.convert(one, I64), b.convert(other, I64)))
        b.set(at, b.add(b.get(at), b.constant(I64, U16.size)))
        b.branch(b.convert(b.get(order), BOOL), end, more)
        b.begin(more)
        b.jump(again)
        b.begin(lengths)
        b.set(order, self._order(b, left_size, right_size))
        b.begin(end)
        b.return_(b.get(order))
        return b.function

    def _find(self) -> CallTarget:
        """(text, size, other, size, unit): where the other begins, from 1; 0 if it is not there."""
        b = self._module.function("find", [ADDRESS, I64, ADDRESS, I64, I64], [I64])
        text, size, other, other_size, unit = b.parameters
        memcmp = self._module.c_function("memcmp", (ADDRESS, ADDRESS, I64), I32)
        at = b.variable(I64)
        zero = b.constant(I64, 0)
        b.set(at, zero)
        again, look, hit, more, none = (b.label() for _ in range(5))
        b.branch(b.compare(Relation.EQUAL, other_size, zero), none, again)
        b.begin(again)
        end = b.add(b.get(at), other_size)
        b.branch(b.compare(Relation.LESS_EQUAL, end, size), look, none)
        b.begin(look)
        (order,) = b.call(memcmp, b.address(text, b.get(at)), other, other_size)
        b.branch(b.compare(Relation.EQUAL, order, b.constant(I32, 0)), hit, more)
        b.begin(more)
        b.set(at, b.add(b.get(at), unit))
        b.jump(again)
        b.begin(hit)
        b.return_(b.add(b.divide(b.get(at), unit), b.constant(I64, 1)))
        b.begin(none)
        b.return_(zero)
        return b.function
