"""Values of the typed form as Python expressions."""

import math
from functools import partial, reduce
from typing import Any

from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.code.calls import CallWriter, HeldAddress, is_plain
from achse.plc.code.linker import Linker
from achse.plc.code.source import ATOM, CodeExpression, Precedence, exact, joined
from achse.plc.code.storages import Storages, format_of
from achse.st.check.kinds import counted, is_whole
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
from achse.st.typed.places import Storage
from achse.st.typed.project import Routine

__all__ = ["ExpressionWriter", "may_be_invalid"]

_ARITHMETIC = {
    Operator.ADD: ("+", Precedence.ADD),
    Operator.SUB: ("-", Precedence.ADD),
    Operator.MUL: ("*", Precedence.MUL),
}
_BITWISE = {
    Operator.AND: ("&", Precedence.BIT_AND),
    Operator.OR: ("|", Precedence.BIT_OR),
    Operator.XOR: ("^", Precedence.BIT_XOR),
}
_COMPARISONS = {
    Operator.EQ: "==",
    Operator.NE: "!=",
    Operator.LT: "<",
    Operator.LE: "<=",
    Operator.GT: ">",
    Operator.GE: ">=",
}
_CHOICES = {Operator.MIN: "min", Operator.MAX: "max", Operator.LIMIT: "limited"}
_MATHEMATICS = {
    Operator.SQRT: "sqrt",
    Operator.LN: "log",
    Operator.LOG: "log10",
    Operator.EXP: "exp",
    Operator.EXPT: "power",
    Operator.SIN: "sin",
    Operator.COS: "cos",
    Operator.TAN: "tan",
    Operator.ASIN: "asin",
    Operator.ACOS: "acos",
    Operator.ATAN: "atan",
}
_TEXTS = {
    Operator.LEN: "text_length",
    Operator.LEFT: "text_left",
    Operator.RIGHT: "text_right",
    Operator.MID: "text_mid",
    Operator.CONCAT: "text_concat",
    Operator.INSERT: "text_insert",
    Operator.DELETE: "text_delete",
    Operator.REPLACE: "text_replace",
    Operator.FIND: "text_find",
}
_EXACT_SINGLE = 1 << 24
"""Whole numbers up to here are REALs as they are."""


class ExpressionWriter:
    """Writes the values of one routine."""

    def __init__(self, routine: Routine, linker: Linker) -> None:
        self.routine = routine
        self.linker = linker
        self.storages = Storages(self)
        self.calls = CallWriter(self)
        self.uses_instance = False
        self.needs_frame = False
        self.instance_formats: set[str] = set()
        """Formats of the views of the instance that are needed."""
        self.bases: set[tuple[str, int]] = set()
        """Index bases that are needed: `t2` is the instance's address in units of 2 bytes."""
        self._temporaries = 0
        self._variables = sorted(routine.frame.fields, key=lambda field: field.offset)

    # what the routine has --------------------------------------------------------------------

    def temporary(self) -> str:
        """A Python variable that nothing else uses."""
        self._temporaries += 1
        return f"x{self._temporaries}"

    def base_index(self, base: str, size: int) -> str:
        """Return the expression for the begin of the instance or frame, in units of that many
        bytes."""
        if base == "t":
            self.uses_instance = True
        self.bases.add((base, size))
        return f"{base}{size}"

    def frame_variable(self, offset: int) -> Variable[Any, Any]:
        """The variable of the frame that has the byte at `offset`."""
        for variable in self._variables:
            if variable.offset <= offset < variable.offset + max(variable.type.size, 1):
                return variable
        raise AssertionError(f"{self.routine.name}: nothing in the frame at {offset}")

    def callee_storage(self, storage: Storage) -> Storage:
        """Return a storage of the callee as the caller addresses it."""
        return self.calls.storage_of(storage)

    # values ----------------------------------------------------------------------------------

    def exact_value(self, value: TypedValue) -> CodeExpression:
        """A value in the range of its type."""
        piece = self.value(value)
        type = value.type
        if type is not None and is_whole(type):
            return exact(piece, counted(type))
        if piece.loose and isinstance(type, RealType) and type.size == 4:
            return CodeExpression(f"single({piece.text})")
        return piece

    def condition(self, value: TypedValue) -> str:
        """A BOOL where only its truth counts."""
        text = self.value(value).text
        return text.removesuffix(" != 0") if text.count(" ") == 2 else text

    def value(self, value: TypedValue) -> CodeExpression:
        """A value; a whole number right in its low bits, a REAL perhaps not rounded yet."""
        if isinstance(value, HeldAddress):
            return CodeExpression(value.name, ATOM, 0, (1 << 64) - 1)
        match value:
            case Known():
                return self._known(value)
            case Read(storage):
                return self.calls.result_read(storage) or self.storages.read(storage)
            case AddressOf(storage):
                return self.storages.address(storage)
            case Converted():
                return self._converted(value)
            case Computed():
                return self._computed(value)
            case Shortcut(is_and, left, right):
                level = Precedence.AND if is_and else Precedence.OR
                word = "and" if is_and else "or"
                return CodeExpression(
                    f"{self.value(left).at(level)} {word} {self.value(right).at(level + 1)}", level
                )
            case Stored(storage, inner):
                return self.storages.store_expression(storage, self.value(inner))
            case Latched(storage, inner, sets):
                return self.storages.latch(storage, self.value(inner), sets=sets)
            case Invocation():
                return self.calls.expression(value)
            case Composed():
                return self._composed(value)
            case EnumName(operand, names, type):
                assert isinstance(type, StringType)
                table = self.linker.constant(dict(names))
                number = self.exact_value(operand).text
                size = type.length * type.unit
                return CodeExpression(f"enum_name({number}, {table})[:{size}]")
            case Created():
                return self.calls.created(value)
            case Deleted(pointer):
                return CodeExpression(
                    f"({self.calls.deleted(self.exact_value(Read(pointer, pointer.type)))},"
                    f" {self.storages.store_expression(pointer, CodeExpression('0')).text})[0]"
                )
            case Queried():
                return self._queried(value)

    def _known(self, value: Known) -> CodeExpression:
        known = value.value
        if isinstance(known, bool):
            return CodeExpression(str(known))
        if isinstance(known, int):
            level = ATOM if known >= 0 else Precedence.UNARY
            return CodeExpression(str(known), level, known, known)
        if isinstance(known, float):
            if not math.isfinite(known):
                return CodeExpression(self.linker.constant(known))
            level = ATOM if math.copysign(1, known) > 0 else Precedence.UNARY
            return CodeExpression(repr(known), level)
        return CodeExpression(repr(known) if len(known) <= 64 else self.linker.constant(known))

    def _composed(self, value: Composed) -> CodeExpression:
        places = self.linker.constant(
            tuple((offset, self._packed(part)) for offset, part in value.parts)
        )
        parts = "".join(f"{self.exact_value(part).text}, " for _, part in value.parts)
        return CodeExpression(f"composed({self.linker.constant(value.image)}, {places}, ({parts}))")

    def _packed(self, part: TypedValue) -> str:
        """The format of a value in a record."""
        assert part.type is not None
        return format_of(part.type)

    def _queried(self, value: Queried) -> CodeExpression:
        source = self.exact_value(value.source).text
        name = self.temporary()
        found = CodeExpression(f"queried({source}, {value.interface!r})", ATOM, 0, (1 << 64) - 1)
        stored = self.storages.store_expression(
            value.target, CodeExpression(f"({name} := {found.text})")
        )
        return CodeExpression(f"({stored.text}, {name} != 0)[-1]")

    # conversions -----------------------------------------------------------------------------

    def _converted(self, value: Converted) -> CodeExpression:
        operand, target, source = value.operand, value.type, value.operand.type
        assert source is not None
        match value.rule:
            case Conversion.EXTEND:
                return self.exact_value(operand)
            case Conversion.CUT:
                widens = target.size > source.size
                return self.exact_value(operand) if widens else self.value(operand)
            case Conversion.TO_REAL:
                piece = self.exact_value(operand)
                small = piece.low >= -_EXACT_SINGLE and piece.high <= _EXACT_SINGLE
                return CodeExpression(
                    f"float({piece.text})", ATOM, loose=target.size == 4 and not small
                )
            case Conversion.RESIZE_REAL:
                return self.exact_value(operand)._replace(loose=target.size == 4)
            case Conversion.ROUND | Conversion.TRUNCATE:
                text = self.exact_value(operand).text
                if value.rule is Conversion.ROUND:
                    return CodeExpression(f"whole({text})", ATOM, -(1 << 63), (1 << 63) - 1)
                held = counted(target)
                return CodeExpression(f"truncated({text}, {held.low})", ATOM, held.low, held.high)
            case Conversion.TO_BOOL:
                return CodeExpression(
                    f"{self.exact_value(operand).at(Precedence.COMPARE + 1)} != 0",
                    Precedence.COMPARE,
                )
            case Conversion.FROM_BOOL:
                if isinstance(target, RealType):
                    return CodeExpression(f"float({self.value(operand).text})")
                return CodeExpression(
                    f"+{self.value(operand).at(Precedence.UNARY + 1)}", Precedence.UNARY, 0, 1
                )
            case Conversion.RESCALE:
                names = f"{self.linker.constant(source)}, {self.linker.constant(target)}"
                whole = counted(target)
                text = f"rescaled({self.exact_value(operand).text}, {names})"
                return CodeExpression(text, ATOM, whole.low, whole.high)
        return self._converted_text(value, source, target)

    def _converted_text(
        self, value: Converted, source: IecType[Any], target: IecType[Any]
    ) -> CodeExpression:
        piece = self.exact_value(value.operand)
        if value.rule is Conversion.CUT_TEXT:
            assert isinstance(target, StringType)
            return CodeExpression(f"{piece.at(ATOM)}[:{target.unit * target.length}]")
        name = {
            Conversion.RECODE_TEXT: "text_recoded",
            Conversion.WRITE_TEXT: "text_written",
            Conversion.READ_TEXT: "text_read",
        }[value.rule]
        kinds = f"{self.linker.constant(source)}, {self.linker.constant(target)}"
        text = f"{name}({piece.text}, {kinds})"
        if is_whole(target):
            whole = counted(target)
            return CodeExpression(text, ATOM, whole.low, whole.high)
        return CodeExpression(text)

    # operators -------------------------------------------------------------------------------

    def _computed(self, value: Computed) -> CodeExpression:
        operator, operands = value.operator, value.operands
        if operator in _COMPARISONS:
            return self._comparison(_COMPARISONS[operator], operands)
        if operator in _TEXTS:
            return self._text_function(value)
        match operator:
            case Operator.SEL:
                which, no, yes = (self.exact_value(one) for one in operands)
                return self._choice(f"selected({which.text}, {no.text}, {yes.text})", (no, yes))
            case Operator.IF:
                which = self.exact_value(operands[0])
                no, yes = (self.exact_value(one) for one in operands[1:])
                return self._choice(f"({yes.text} if {which.text} else {no.text})", (no, yes))
            case Operator.MUX:
                pieces = [self.exact_value(one) for one in operands]
                return self._choice(
                    f"chosen({', '.join(piece.text for piece in pieces)})", pieces[1:]
                )
            case Operator.TIME | Operator.LTIME | Operator.TASK_INDEX:
                whole = counted(value.type)
                return CodeExpression(
                    f"system_{operator.value.lower()}()", ATOM, whole.low, whole.high
                )
            case Operator.RAISE:
                return CodeExpression(f"raise_exception({self.exact_value(operands[0]).text})")
        if isinstance(value.type, BoolType):
            return self._logic(operator, operands)
        if isinstance(value.type, RealType):
            return self._real(operator, operands, value.type)
        if operator in _CHOICES:
            pieces = [self.exact_value(one) for one in operands]
            text = f"{_CHOICES[operator]}({', '.join(piece.text for piece in pieces)})"
            return self._choice(text, pieces)
        return self._whole(operator, operands, counted(value.type))

    def _choice(self, text: str, pieces: Any) -> CodeExpression:
        low = min(piece.low for piece in pieces)
        return CodeExpression(text, ATOM, low, max(piece.high for piece in pieces))

    def _comparison(self, sign: str, operands: tuple[TypedValue, ...]) -> CodeExpression:
        left, right = (self.exact_value(one) for one in operands)
        above = Precedence.COMPARE + 1
        type = operands[0].type
        if isinstance(type, StringType) and type.unit == 2 and sign not in ("==", "!="):
            return CodeExpression(
                f"text_units({left.text}) {sign} text_units({right.text})", Precedence.COMPARE
            )
        return CodeExpression(f"{left.at(above)} {sign} {right.at(above)}", Precedence.COMPARE)

    def _text_function(self, value: Computed) -> CodeExpression:
        type = value.operands[0].type
        assert isinstance(type, StringType)
        arguments = ", ".join(self.exact_value(one).text for one in value.operands)
        return CodeExpression(
            f"{_TEXTS[value.operator]}({arguments}, {type.unit})", ATOM, 0, 0x7FFF
        )

    def _logic(self, operator: Operator, operands: tuple[TypedValue, ...]) -> CodeExpression:
        if operator is Operator.NOT:
            return CodeExpression(
                f"not {self.value(operands[0]).at(Precedence.NOT)}", Precedence.NOT
            )
        if operator in _CHOICES:
            arguments = ", ".join(self.value(one).text for one in operands)
            return CodeExpression(f"{_CHOICES[operator]}({arguments})")
        sign, level = _BITWISE[operator]
        pieces = [self.value(one) for one in operands]
        return reduce(lambda left, right: joined(left, sign, right, level, 0, 0), pieces)

    def _real(
        self, operator: Operator, operands: tuple[TypedValue, ...], type: RealType
    ) -> CodeExpression:
        if operator in _ARITHMETIC:
            return self._real_arithmetic(operator, operands, type)
        pieces = [self.exact_value(one) for one in operands]
        if operator is Operator.DIV:
            divisor = operands[1]
            if isinstance(divisor, Known) and divisor.value:
                return joined(pieces[0], "/", pieces[1], Precedence.MUL, 0, 0)._replace(loose=True)
            return CodeExpression(f"divided({pieces[0].text}, {pieces[1].text})", loose=True)
        if operator is Operator.NEG:
            return CodeExpression(f"-{pieces[0].at(Precedence.UNARY)}", Precedence.UNARY)
        arguments = ", ".join(piece.text for piece in pieces)
        if operator is Operator.ABS:
            return CodeExpression(f"abs({arguments})")
        if operator in _CHOICES:
            return CodeExpression(f"{_CHOICES[operator]}({arguments})")
        return CodeExpression(f"{_MATHEMATICS[operator]}({arguments})", loose=True)

    def _real_arithmetic(
        self, operator: Operator, operands: tuple[TypedValue, ...], type: RealType
    ) -> CodeExpression:
        """Sums and products, as far as they are one expression.

        Infinity minus infinity and 0 times infinity are invalid operations: with exceptions on,
        a result that is NaN although no operand was one stops the program.
        """
        if not (self.linker.exceptions and may_be_invalid(operator, operands)):
            pieces = [self.exact_value(one) for one in operands]
            return reduce(partial(_real_joined, operator, type.size == 4), pieces)
        leaves: list[str] = []
        text = self._real_chain(operator, operands, type, leaves).text
        name = self.temporary()
        checked = f"({name} if ({name} := {text}) == {name} else invalid({', '.join(leaves)}))"
        return CodeExpression(checked, loose=True)

    def _real_chain(
        self,
        operator: Operator,
        operands: tuple[TypedValue, ...],
        type: RealType,
        leaves: list[str],
    ) -> CodeExpression:
        pieces: list[CodeExpression] = []
        for one in operands:
            if isinstance(one, Computed) and one.operator in _ARITHMETIC:
                piece = self._real_chain(one.operator, one.operands, type, leaves)
                if type.size == 4:
                    piece = CodeExpression(f"single({piece.text})")
            else:
                piece = self.exact_value(one)
                if not isinstance(one, Known):
                    if not (isinstance(one, Read) and is_plain(one.storage)):
                        name = self.temporary()
                        piece = CodeExpression(f"({name} := {piece.text})")
                        leaves.append(name)
                    else:
                        leaves.append(piece.text)
            pieces.append(piece)
        return reduce(partial(_real_joined, operator, type.size == 4), pieces)

    def _whole(
        self, operator: Operator, operands: tuple[TypedValue, ...], type: IntegerType
    ) -> CodeExpression:
        if operator in _ARITHMETIC:
            return self._arithmetic(operator, operands)
        pieces = [self.exact_value(one) for one in operands]
        first = pieces[0]
        match operator:
            case Operator.NEG:
                text = f"-{first.at(Precedence.UNARY)}"
                return CodeExpression(text, Precedence.UNARY, -first.high, -first.low)
            case Operator.ABS:
                return CodeExpression(
                    f"abs({first.text})", ATOM, 0, max(abs(first.low), abs(first.high))
                )
            case Operator.NOT:
                text = f"~{first.at(Precedence.UNARY)}"
                return CodeExpression(text, Precedence.UNARY, ~first.high, ~first.low)
            case Operator.AND | Operator.OR | Operator.XOR:
                return reduce(partial(_bitwise, operator, type), pieces)
            case Operator.DIV:
                return self._division(pieces, type)
            case Operator.MOD:
                left, right = pieces
                if left.low >= 0 and right.low > 0:
                    high = min(left.high, right.high - 1)
                    return joined(left, "%", right, Precedence.MUL, 0, high)
                return CodeExpression(
                    f"remainder({left.text}, {right.text})", ATOM, type.low, type.high
                )
        return self._shift(operator, first, pieces[1], type)

    def _arithmetic(self, operator: Operator, operands: tuple[TypedValue, ...]) -> CodeExpression:
        return reduce(partial(_arithmetic, operator), map(self.value, operands))

    def _division(self, pieces: list[CodeExpression], type: IntegerType) -> CodeExpression:
        left, right = pieces
        if left.low >= 0 and right.low > 0:
            return joined(left, "//", right, Precedence.MUL, 0, left.high)
        # The lowest number divided by -1 is one more than the highest.
        return CodeExpression(f"quotient({left.text}, {right.text})", ATOM, type.low, type.high + 1)

    def _shift(
        self, operator: Operator, value: CodeExpression, count: CodeExpression, type: IntegerType
    ) -> CodeExpression:
        width = 8 * type.size
        if operator in (Operator.ROL, Operator.ROR):
            turns = count.text if operator is Operator.ROL else f"-{count.at(Precedence.UNARY)}"
            return CodeExpression(
                f"rotated({value.text}, {turns}, {width})", ATOM, 0, (1 << width) - 1
            )
        mask = 63 if type.size == 8 else 31
        if count.low == count.high:
            count = CodeExpression(str(count.low & mask), ATOM, count.low & mask, count.low & mask)
        elif not (count.low >= 0 and count.high <= mask):
            count = CodeExpression(
                f"{count.at(Precedence.BIT_AND)} & {mask}", Precedence.BIT_AND, 0, mask
            )
        if operator is Operator.SHR:
            low = min(value.low >> count.low, value.low >> count.high)
            high = max(value.high >> count.low, value.high >> count.high)
            return joined(value, ">>", count, Precedence.SHIFT, low, high)
        low, high = min(value.low << count.high, 0), max(value.high << count.high, 0)
        return joined(value, "<<", count, Precedence.SHIFT, low, high)


def may_be_invalid(operator: Operator, operands: tuple[TypedValue, ...]) -> bool:
    """Return True if sums or products of reals in this expression can be NaN for numbers as
    operands."""
    if any(
        isinstance(one, Computed)
        and one.operator in _ARITHMETIC
        and may_be_invalid(one.operator, one.operands)
        for one in operands
    ):
        return True
    unbounded = sum(not _is_finite(one) for one in operands)
    if operator is not Operator.MUL:
        return unbounded > 1
    return unbounded > 1 or (unbounded == 1 and any(map(_may_be_zero, operands)))


def _may_be_zero(value: TypedValue) -> bool:
    """Return True if a finite number may be 0."""
    return _is_finite(value) and not (isinstance(value, Known) and value.value)


def _is_finite(value: TypedValue) -> bool:
    """Return True if a real is a finite number, whatever is in memory."""
    if isinstance(value, Known):
        return isinstance(value.value, int | float) and math.isfinite(value.value)
    if isinstance(value, Converted):
        return value.rule in (Conversion.TO_REAL, Conversion.FROM_BOOL)
    return isinstance(value, Computed) and value.operator in (Operator.SIN, Operator.COS)


def _real_joined(
    operator: Operator, rounds: bool, left: CodeExpression, right: CodeExpression
) -> CodeExpression:
    """One operation of reals; of REAL, what came before of the same operator is rounded first."""
    sign, level = _ARITHMETIC[operator]
    if rounds and left.loose:
        left = CodeExpression(f"single({left.text})")
    return joined(left, sign, right, level, 0, 0)._replace(loose=True)


def _arithmetic(operator: Operator, left: CodeExpression, right: CodeExpression) -> CodeExpression:
    """One operation of whole numbers, and what it can be."""
    sign, level = _ARITHMETIC[operator]
    if operator is Operator.ADD:
        low, high = left.low + right.low, left.high + right.high
    elif operator is Operator.SUB:
        low, high = left.low - right.high, left.high - right.low
    else:
        corners = [a * b for a in (left.low, left.high) for b in (right.low, right.high)]
        low, high = min(corners), max(corners)
    return joined(left, sign, right, level, low, high)


def _bitwise(
    operator: Operator, type: IntegerType, left: CodeExpression, right: CodeExpression
) -> CodeExpression:
    """One operation of bits, and what it can be."""
    sign, level = _BITWISE[operator]
    low, high = type.low, type.high
    if operator is Operator.AND and (left.low >= 0 or right.low >= 0):
        low = 0
        high = min(piece.high for piece in (left, right) if piece.low >= 0)
    elif left.low >= 0 and right.low >= 0:
        low = 0
        high = (1 << max(left.high, right.high).bit_length()) - 1
    return joined(left, sign, right, level, low, high)
