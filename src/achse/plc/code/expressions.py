"""Values of the lowered form as Python expressions."""

import math
from collections.abc import Callable, Sequence
from functools import partial, reduce
from typing import Any

from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.plc.code.linker import Linker
from achse.plc.code.source import ATOM, CodeExpression, Precedence, exact, joined
from achse.plc.code.storages import Storages, format_of, local_name, ranged
from achse.plc.lowering import nodes
from achse.plc.lowering.calls import parameters_of
from achse.plc.lowering.places import is_large
from achse.st.check.kinds import counted, is_whole
from achse.st.typed.expressions import Conversion, EnumName, Known, Operator

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
_CHOICES = {
    Operator.MIN: ("min", 0),
    Operator.MAX: ("max", 0),
    Operator.SEL: ("selected", 1),
    Operator.MUX: ("chosen", 1),
}
"""Function, and the first operand that it gives."""
_SYSTEM = {
    Operator.LTIME: "system_ltime",
    Operator.TASK_INDEX: "system_task_index",
    Operator.RAISE: "raise_exception",
}
_EXTERNAL = {
    Conversion.RECODE_TEXT: "text_recoded",
    Conversion.WRITE_TEXT: "text_written",
    Conversion.READ_TEXT: "text_read",
}
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
    Operator(name): f"text_{name.lower()}"
    for name in ["LEN", "LEFT", "RIGHT", "MID", "CONCAT", "INSERT", "DELETE", "REPLACE", "FIND"]
}
_EXACT_SINGLE = 1 << 24
"""Whole numbers up to here are REALs as they are."""


class ExpressionWriter:
    """Writes the values of one routine."""

    def __init__(self, linker: Linker) -> None:
        self.linker = linker
        self.storages = Storages(self)
        self.instance_formats: set[str] = set()
        """Formats of the views of the instance that are needed."""
        self.bases: set[tuple[str, int]] = set()
        """Index bases that are needed: `t2` is the instance's address in units of 2 bytes."""
        self._temporaries = 0
        self.temporaries: dict[int, CodeExpression] = {}
        """Temporaries of the lowered form."""

    def temporary(self) -> str:
        """Return a Python variable that nothing else uses."""
        self._temporaries += 1
        return f"x{self._temporaries}"

    def base_index(self, base: str, size: int) -> str:
        """Return the expression for the begin of the instance or frame, in units of that many
        bytes."""
        self.bases.add((base, size))
        return f"{base}{size}"

    # values ----------------------------------------------------------------------------------

    def exact_value(self, value: nodes.LoweredValue) -> CodeExpression:
        """Return a value in the range of its type."""
        piece = self.value(value)
        type = value.type
        if type is not None and is_whole(type):
            return exact(piece, counted(type))
        if piece.loose and isinstance(type, RealType) and type.size == 4:
            return CodeExpression(f"single({piece.text})")
        return piece

    def condition(self, value: nodes.LoweredValue) -> str:
        """Return a BOOL where only its truth counts."""
        text = self.value(value).text
        return text.removesuffix(" != 0") if text.count(" ") == 2 else text

    def value(self, value: nodes.LoweredValue) -> CodeExpression:
        """Return a value; a whole number right in its low bits, a REAL perhaps not rounded yet."""
        return _WRITERS[type(value)](self, value)

    def effect(self, value: nodes.LoweredValue) -> str:
        """Return a line that evaluates a value for what it does."""
        if isinstance(value, nodes.StoreValue) and (value.value_first or not value.place.terms):
            return self.storages.store_statement(value.place, self.value(value.value))
        if isinstance(value, nodes.Keep):
            return f"{self.keep(value.temporary)} = {self.exact_value(value.value).text}"
        if isinstance(value, nodes.RoutineCall) and value.outputs:
            name, text = self._call_with_outputs(value)
            return f"{name} = {text}"
        return self.value(value).text

    def _listed(self, values: Sequence[nodes.LoweredValue]) -> str:
        return ", ".join(self.exact_value(one).text for one in values)

    def keep(self, temporary: nodes.Temporary) -> str:
        """Return the Python variable that a temporary is."""
        name = self.temporary()
        self.temporaries[temporary.number] = ranged(name, temporary.type)
        return name

    def known(self, value: Known) -> CodeExpression:
        """Return a constant."""
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

    def keeping(self, value: nodes.Keep) -> CodeExpression:
        """Keep a value that is needed again."""
        piece = self.exact_value(value.value)
        if value.is_repeatable:
            self.temporaries[value.temporary.number] = piece
            return piece
        return CodeExpression(
            f"({self.keep(value.temporary)} := {piece.text})", ATOM, piece.low, piece.high
        )

    def check(self, value: nodes.Check) -> CodeExpression:
        """Return a real that is not NaN unless an operand is."""
        text, name = self.value(value.value).text, self.temporary()
        leaves = self._listed(value.operands)
        checked = f"({name} if ({name} := {text}) == {name} else invalid({leaves}))"
        return CodeExpression(checked, loose=True)

    def choice(self, value: nodes.LazyChoice) -> CodeExpression:
        """One of two values, of which the other is not evaluated."""
        for decided, other, word, level in (
            (value.no, value.yes, "and", Precedence.AND),
            (value.yes, value.no, "or", Precedence.OR),
        ):
            if isinstance(decided, Known) and decided.value is (word == "or"):
                left, right = self.value(value.condition), self.value(other)
                return CodeExpression(f"{left.at(level)} {word} {right.at(level + 1)}", level)
        which = self.value(value.condition)
        no, yes = self.exact_value(value.no), self.exact_value(value.yes)
        return _one_of(f"({yes.text} if {which.text} else {no.text})", (no, yes))

    def sequence(self, value: nodes.Sequence) -> CodeExpression:
        """Effects and then a value."""
        texts = [self.value(one).text for one in value.effects]
        piece = self.value(value.value)
        text = f"({', '.join([*texts, piece.text])})[-1]"
        return piece._replace(text=text, level=ATOM)

    def condition_bit(self, value: nodes.ConditionBit) -> CodeExpression:
        """Return a condition, which is a bit of a vector, too."""
        name, text = self.temporaries[value.vector.number].text, self.value(value.value).text
        return CodeExpression(f"(({name} := {name} | {1 << value.bit}) > 0 if {text} else False)")

    def count_vector(self, value: nodes.CountVector) -> CodeExpression:
        """Return a decision, and one more in the counter of its vector."""
        name = self.keep(value.vector)
        text = self.value(value.value).text
        return CodeExpression(f"({name} := 0, {text}, count({value.first} + {name}))[1]")

    def record(self, value: nodes.RecordValue) -> CodeExpression:
        """Return a record made on the spot."""
        places = []
        for offset, part in value.parts:
            assert part.type is not None
            places.append((offset, format_of(part.type)))
        names = f"{self.linker.constant(value.image)}, {self.linker.constant(tuple(places))}"
        parts = "".join(f"{self.exact_value(part).text}, " for _, part in value.parts)
        return CodeExpression(f"composed({names}, ({parts}))")

    # calls -----------------------------------------------------------------------------------

    def call(self, call: nodes.RoutineCall) -> CodeExpression:
        """Return a call; with outputs, a tuple of result and outputs."""
        if not call.outputs:
            return ranged(self._call_text(call), call.type)
        name, text = self._call_with_outputs(call)
        return CodeExpression(f"({name} := {text})")

    def _call_with_outputs(self, call: nodes.RoutineCall) -> tuple[str, str]:
        """Return the Python variable that the results are in, and the call."""
        text, name = self._call_text(call), self.temporary()
        for number, output in enumerate(call.outputs):
            self.temporaries[output.number] = ranged(f"{name}[{number}]", output.type)
        return name, text

    def _call_text(self, call: nodes.RoutineCall) -> str:
        name = self.linker.name_of(call.routine.key)
        arguments: list[str] = []
        if call.instance is not None:
            address = self.exact_value(call.instance).text
            if call.entry is not None:
                looked_up = address
                if not address.isalnum():
                    address = self.temporary()
                    looked_up = f"{address} := {looked_up}"
                name = f"dispatched({looked_up}, {call.entry!r})"
            arguments.append(address)
        pieces = [(one, self.exact_value(value).text) for one, value in call.arguments]
        if [one.name for one, _ in pieces] == [one.name for one in parameters_of(call.routine)]:
            arguments += [text for _, text in pieces]
        else:
            arguments += [f"{local_name(one)}={text}" for one, text in pieces]
        return f"{name}({', '.join(arguments)})"

    def creation(self, value: nodes.Creation) -> CodeExpression:
        """`__NEW`."""
        count, create = self.exact_value(value.count).text, "None"
        if value.effects:
            pointer = self.keep(value.pointer)
            effects = "".join(f"{self.value(one).text}, " for one in value.effects)
            create = f"lambda {pointer}: ({effects})"
        text = f"new_memory({self.linker.constant(value.of)}, {count}, {create})"
        return ranged(text, value.type)

    def service(self, value: nodes.RuntimeCall) -> CodeExpression:
        """Return a function of the runtime."""
        texts = [self.exact_value(one).text for one in value.operands]
        if value.argument is not None:
            texts.append(repr(value.argument))
        return ranged(f"{value.name}({', '.join(texts)})", value.type)

    # conversions -----------------------------------------------------------------------------

    def converted(self, value: nodes.Convert) -> CodeExpression:
        """Return a value at another type."""
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
            case Conversion.ROUND:
                text = f"whole({self.exact_value(operand).text})"
                return CodeExpression(text, ATOM, -(1 << 63), (1 << 63) - 1)
            case Conversion.TRUNCATE:
                low = counted(target).low
                return ranged(f"truncated({self.exact_value(operand).text}, {low})", target)
            case Conversion.TO_BOOL:
                return CodeExpression(
                    f"{self.exact_value(operand).at(Precedence.COMPARE + 1)} != 0",
                    Precedence.COMPARE,
                )
            case Conversion.FROM_BOOL:
                piece = self.value(operand)
                if isinstance(target, RealType):
                    return CodeExpression(f"float({piece.text})")
                return CodeExpression(f"+{piece.at(Precedence.UNARY + 1)}", Precedence.UNARY, 0, 1)
        assert isinstance(target, StringType)  # CUT_TEXT
        return CodeExpression(f"{self.value(operand).at(ATOM)}[:{target.unit * target.length}]")

    def external(self, value: nodes.External) -> CodeExpression:
        """Return a conversion from or to text."""
        piece, source, target = self.exact_value(value.operand), value.source, value.type
        if isinstance(source, EnumName):
            assert isinstance(target, StringType)
            table = self.linker.constant(dict(source.names))
            size = target.length * target.unit
            return CodeExpression(f"enum_name({piece.text}, {table})[:{size}]")
        kinds = f"{self.linker.constant(source.operand.type)}, {self.linker.constant(target)}"
        return ranged(f"{_EXTERNAL[source.rule]}({piece.text}, {kinds})", target)

    # operators -------------------------------------------------------------------------------

    def computed(self, value: nodes.Compute) -> CodeExpression:
        """Return an operator."""
        operator, operands, type = value.operator, value.operands, value.type
        is_real = isinstance(type, RealType)
        if operator in _ARITHMETIC and not is_real:
            return reduce(partial(_arithmetic, operator), map(self.value, operands))
        pieces = [self.exact_value(one) for one in operands]
        if operator in _COMPARISONS:
            return _comparison(_COMPARISONS[operator], pieces, operands[0].type)
        if operator in _TEXTS:
            unit = operands[0].type.unit  # type: ignore[union-attr]
            name = _TEXTS[operator]
            if operator is Operator.FIND and any(is_large(one.type) for one in operands):
                name = "find_in_large"
            return CodeExpression(_called(name, pieces, f", {unit}"), ATOM, 0, 0x7FFF)
        if operator in _CHOICES:
            name, first = _CHOICES[operator]
            return _one_of(_called(name, pieces), pieces[first:])
        if operator in _SYSTEM:
            return ranged(_called(_SYSTEM[operator], pieces), type)
        if operator in _BITWISE:
            return reduce(partial(_bitwise, operator, type), pieces)
        if isinstance(type, BoolType):
            return CodeExpression(f"not {pieces[0].at(Precedence.NOT)}", Precedence.NOT)
        if is_real:
            return _real(operator, pieces, operands, type.size == 4)
        return _whole(operator, pieces, counted(type))


def _called(name: str, pieces: Sequence[CodeExpression], more: str = "") -> str:
    return f"{name}({', '.join(piece.text for piece in pieces)}{more})"


def _one_of(text: str, pieces: Sequence[CodeExpression]) -> CodeExpression:
    """Return a text that is one of several values."""
    low, high = min(piece.low for piece in pieces), max(piece.high for piece in pieces)
    return CodeExpression(text, ATOM, low, high)


def _comparison(
    sign: str, pieces: Sequence[CodeExpression], type: IecType[Any] | None
) -> CodeExpression:
    left, right = pieces
    above = Precedence.COMPARE + 1
    if isinstance(type, StringType) and type.unit == 2 and sign not in ("==", "!="):
        text = f"text_units({left.text}) {sign} text_units({right.text})"
        return CodeExpression(text, Precedence.COMPARE)
    return CodeExpression(f"{left.at(above)} {sign} {right.at(above)}", Precedence.COMPARE)


def _real(
    operator: Operator,
    pieces: Sequence[CodeExpression],
    operands: Sequence[nodes.LoweredValue],
    rounds: bool,
) -> CodeExpression:
    if operator in _ARITHMETIC:
        return reduce(partial(_real_joined, operator, rounds), pieces)
    match operator:
        case Operator.DIV:
            divisor = operands[1]
            if isinstance(divisor, Known) and divisor.value:
                return joined(pieces[0], "/", pieces[1], Precedence.MUL, 0, 0)._replace(loose=True)
            return CodeExpression(_called("divided", pieces), loose=True)
        case Operator.NEG:
            return CodeExpression(f"-{pieces[0].at(Precedence.UNARY)}", Precedence.UNARY)
        case Operator.ABS:
            return CodeExpression(_called("abs", pieces))
    return CodeExpression(_called(_MATHEMATICS[operator], pieces), loose=True)


def _whole(
    operator: Operator, pieces: Sequence[CodeExpression], type: IntegerType
) -> CodeExpression:
    """Return an operator of whole numbers."""
    first = pieces[0]
    match operator:
        case Operator.NEG:
            text = f"-{first.at(Precedence.UNARY)}"
            return CodeExpression(text, Precedence.UNARY, -first.high, -first.low)
        case Operator.ABS:
            high = max(abs(first.low), abs(first.high))
            return CodeExpression(f"abs({first.text})", ATOM, 0, high)
        case Operator.NOT:
            text = f"~{first.at(Precedence.UNARY)}"
            return CodeExpression(text, Precedence.UNARY, ~first.high, ~first.low)
        case Operator.DIV:
            if first.low >= 0 and pieces[1].low > 0:
                return joined(first, "//", pieces[1], Precedence.MUL, 0, first.high)
            # The lowest number divided by -1 is one more than the highest.
            return CodeExpression(_called("quotient", pieces), ATOM, type.low, type.high + 1)
        case Operator.MOD:
            if first.low >= 0 and pieces[1].low > 0:
                high = min(first.high, pieces[1].high - 1)
                return joined(first, "%", pieces[1], Precedence.MUL, 0, high)
            return CodeExpression(_called("remainder", pieces), ATOM, type.low, type.high)
    return _shift(operator, first, pieces[1], 8 * type.size)


def _shift(
    operator: Operator, value: CodeExpression, count: CodeExpression, width: int
) -> CodeExpression:
    if operator in (Operator.ROL, Operator.ROR):
        turns = count.text if operator is Operator.ROL else f"-{count.at(Precedence.UNARY)}"
        text = f"rotated({value.text}, {turns}, {width})"
        return CodeExpression(text, ATOM, 0, (1 << width) - 1)
    if operator is Operator.SHR:
        low = min(value.low >> count.low, value.low >> count.high)
        high = max(value.high >> count.low, value.high >> count.high)
        return joined(value, ">>", count, Precedence.SHIFT, low, high)
    low, high = min(value.low << count.high, 0), max(value.high << count.high, 0)
    return joined(value, "<<", count, Precedence.SHIFT, low, high)


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
    operator: Operator, type: IecType[Any], left: CodeExpression, right: CodeExpression
) -> CodeExpression:
    """One operation of bits, and what it can be; of BOOLs, too."""
    sign, level = _BITWISE[operator]
    if operator is Operator.AND and (left.low >= 0 or right.low >= 0):
        low, high = 0, min(piece.high for piece in (left, right) if piece.low >= 0)
        mask = right.low
        if right.text.isdigit() and mask & mask + 1 == 0 and 0 <= left.low <= left.high <= mask:
            return left
    elif left.low >= 0 and right.low >= 0:
        low, high = 0, (1 << max(left.high, right.high).bit_length()) - 1
    else:
        whole = counted(type)
        low, high = whole.low, whole.high
    return joined(left, sign, right, level, low, high)


_WRITERS: dict[type[Any], Callable[[ExpressionWriter, Any], CodeExpression]] = {
    Known: ExpressionWriter.known,
    nodes.Temporary: lambda of, value: of.temporaries[value.number],
    nodes.Keep: ExpressionWriter.keeping,
    nodes.LoadValue: lambda of, value: of.storages.read(value.place, spends=value.spends),
    nodes.PlaceAddress: lambda of, value: of.storages.address(value.place),
    nodes.Copy: lambda of, value: of.value(value.value),
    nodes.Convert: ExpressionWriter.converted,
    nodes.External: ExpressionWriter.external,
    nodes.Compute: ExpressionWriter.computed,
    nodes.Check: ExpressionWriter.check,
    nodes.LazyChoice: ExpressionWriter.choice,
    nodes.Sequence: ExpressionWriter.sequence,
    nodes.StoreValue: lambda of, value: of.storages.store_expression(
        value.place, of.value(value.value)
    ),
    nodes.RoutineCall: ExpressionWriter.call,
    nodes.RecordValue: ExpressionWriter.record,
    nodes.Creation: ExpressionWriter.creation,
    nodes.RuntimeCall: ExpressionWriter.service,
    nodes.ConditionBit: ExpressionWriter.condition_bit,
    nodes.CountVector: ExpressionWriter.count_vector,
    nodes.Count: lambda of, value: CodeExpression(f"count({value.number})"),
}
