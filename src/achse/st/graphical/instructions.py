"""Instruction lists lowered to statements: an accumulator and what each line does with it.

The accumulator has the type of its last load and ends with the network, unless the list at a label
goes on with it. A function call does not change it, a load ends it.

Source: IEC 61131-3 (2013) table 68, and the list of operators in the vendor's manual.
"""

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from achse.st.graphical.body import Refused
from achse.st.graphical.networks import DrawnNetwork, Instruction
from achse.st.graphical.writer import call_of
from achse.st.lexis.codes import Code
from achse.st.syntax.tree import (
    Argument,
    Binary,
    Branch,
    Call,
    Expression,
    If,
    Jump,
    Literal,
    Name,
    Return,
    Statement,
    Unary,
)

if TYPE_CHECKING:
    from achse.st.graphical.writer import BodyStatements

_SIGNS = {
    "AND": "AND",
    "&": "AND",
    "OR": "OR",
    "XOR": "XOR",
    "ADD": "+",
    "SUB": "-",
    "MUL": "*",
    "DIV": "/",
    "MOD": "MOD",
    "GT": ">",
    "GE": ">=",
    "EQ": "=",
    "NE": "<>",
    "LE": "<=",
    "LT": "<",
}
_NEGATED = {"ANDN": "AND", "&N": "AND", "ORN": "OR", "XORN": "XOR"}
_CONDITIONS = {"": None, "C": True, "CN": False}


def needs_accumulator(network: DrawnNetwork) -> bool:
    """Return True if a list goes on with the accumulator of the list before its label."""
    for line in network.lines:
        operator = line.operator.upper()
        if operator or line.operand.text:
            return operator[:2] != "LD" and operator not in ("CAL", "JMP", "RET")
    return False


class InstructionList:
    """Writes the lines of one network. Lists at labels in `carrying` go on with the accumulator
    of the jumps to them; with `leads_on` the next one does."""

    def __init__(
        self,
        writer: "BodyStatements",
        network: DrawnNetwork,
        carrying: Collection[str] = (),
        *,
        leads_on: bool = False,
    ) -> None:
        self._writer = writer
        self._network = network
        self._carrying = carrying
        self._leads_on = leads_on
        self._value: Expression | None = None
        self._stack: list[tuple[str, bool, Expression]] = []
        """Operators with an open bracket: sign, whether it negates, the accumulator before."""

    def write(self) -> None:
        """Write all lines. Raises `Refused` and `Unexpected`."""
        writer = self._writer
        lines = iter(self._network.lines)
        if self._network.target.lower() in self._carrying:
            self._value = writer.carried
        for number, line in enumerate(lines, 1):
            writer.location = f"network {self._network.number}, line {number}"
            at = writer.at(line.at)
            operator = line.operator.upper()
            if not operator and not line.operand.text:
                if line.postfix == ")":
                    self._close(at)
                continue
            if line.prefix:
                raise Refused(
                    at,
                    f"'{line.prefix}' outside of a call is not supported",
                    Code.UNSUPPORTED_DRAWING,
                )
            if operator[:3] == "CAL" and operator[3:] in _CONDITIONS:
                arguments = [] if line.postfix != "(" else self._arguments(lines, at)
                self._call(line, _CONDITIONS[operator[3:]], arguments, at)
            else:
                self._line(line, operator, at)
        if self._stack:
            raise Refused(
                writer.at(self._network.at), "a bracket is not closed", Code.INCOMPLETE_DRAWING
            )
        if self._leads_on:
            self._carry(writer.at(self._network.at))
        result = writer.body.owner.result
        if result and self._value is not None:
            at = writer.at(self._network.at)
            writer.assign(Name(result, at), self._value, at)

    # lines -------------------------------------------------------------------------------------

    def _line(self, line: Instruction, operator: str, at: int) -> None:
        opens = operator.endswith("(") or line.postfix == "("
        operator = operator.removesuffix("(")
        if operator == ")":
            self._close(at)
            return
        sign = _SIGNS.get(operator) or _NEGATED.get(operator)
        if sign and opens:
            self._stack.append((sign, operator in _NEGATED, self._stable_value(at)))
            self._value = None
            if line.operand.text:
                self._value = self._operand(line, at)
        elif sign:
            self._combine(sign, self._operand(line, at), operator in _NEGATED, at)
        elif operator in ("LD", "LDN"):
            value = self._operand(line, at)
            self._value = Unary("NOT", value, at) if operator == "LDN" else value
        elif operator in ("ST", "STN"):
            value = self._stable_value(at)
            target = self._operand(line, at)
            value = Unary("NOT", value, at) if operator == "STN" else value
            self._writer.assign(target, value, at)
        elif operator in ("S", "R"):
            self._writer.assign(self._operand(line, at), self._stable_value(at), at, f"{operator}=")
        elif operator == "NOT":
            self._value = Unary("NOT", self._stable_value(at), at)
        elif operator[:3] == "JMP" and operator[3:] in _CONDITIONS:
            if line.operand.text.lower() in self._carrying:
                self._carry(at)
            self._leave(Jump(line.operand.text, at), _CONDITIONS[operator[3:]], at)
        elif operator[:3] == "RET" and operator[3:] in _CONDITIONS:
            self._leave(Return(at), _CONDITIONS[operator[3:]], at)
        else:
            self._function(line, at)
        if line.postfix == ")":
            self._close(at)

    def _operand(self, line: Instruction, at: int) -> Expression:
        if line.operand.text in ("", "???") or line.operand.modifiers:
            raise Refused(
                at, f"{line.operator} has no operand that is supported", Code.INCOMPLETE_DRAWING
            )
        return self._writer.expression(line.operand.text, at)

    def _combine(self, sign: str, right: Expression, negates: bool, at: int) -> None:
        if negates:
            right = Unary("NOT", right, at)
        self._value = Binary(sign, self._loaded(at), right, at)

    def _close(self, at: int) -> None:
        if not self._stack:
            raise Refused(at, "a bracket is closed that is not open", Code.INCOMPLETE_DRAWING)
        inner = self._loaded(at)
        sign, negates, self._value = self._stack.pop()
        self._combine(sign, inner, negates, at)

    def _loaded(self, at: int) -> Expression:
        if self._value is None:
            raise Refused(
                at, "the accumulator is used before a value is loaded", Code.INCOMPLETE_DRAWING
            )
        return self._value

    def _stable_value(self, at: int) -> Expression:
        """Return the accumulator as a value that stays what it is now."""
        value = self._loaded(at)
        if not isinstance(value, Literal) and not (
            isinstance(value, Name) and value.name.startswith("__")
        ):
            value = self._value = self._writer.let(self._writer.hidden("acc"), value, at)
        return value

    def _carry(self, at: int) -> None:
        """Keep the accumulator for the label that goes on with it."""
        writer = self._writer
        if self._value is None:
            return
        if writer.carried is None:
            writer.carried = writer.let(writer.hidden("carried"), self._value, at)
        elif self._value is not writer.carried:
            writer.assign(writer.carried, self._value, at)

    # calls -------------------------------------------------------------------------------------

    def _arguments(self, lines: Iterator[Instruction], at: int) -> list[Argument]:
        arguments = []
        for line in lines:
            here = self._writer.at(line.at)
            if line.operator and line.operand.text:
                value = self._writer.expression(line.operand.text, here)
                arguments.append(Argument(line.operator, value, line.prefix == "=>", here))
            if line.postfix.endswith(")"):
                return arguments
        raise Refused(at, "a call is not closed", Code.INCOMPLETE_DRAWING)

    def _call(
        self, line: Instruction, condition: bool | None, arguments: list[Argument], at: int
    ) -> None:
        inputs = [
            (one.name, one.value, one.is_output) for one in arguments if one.value is not None
        ]
        target = self._writer.expression(line.operand.text, at)
        call = call_of(target, inputs, at) if inputs or not isinstance(target, Call) else target
        self._leave(call, condition, at)

    def _leave(self, statement: Statement, condition: bool | None, at: int) -> None:
        """Write a statement that depends on the accumulator if it has a condition."""
        if self._value is not None:
            self._stable_value(at)
        if condition is None:
            self._writer.out.append(statement)
            return
        value = self._stable_value(at)
        value = value if condition else Unary("NOT", value, at)
        self._writer.out.append(If((Branch(value, (statement,), at),), (), at))

    def _function(self, line: Instruction, at: int) -> None:
        """Call a function: the accumulator is its first argument."""
        arguments = [("", self._stable_value(at), False)]
        if line.operand.text:
            call = self._writer.expression(f"f({line.operand.text})", at)
            further = getattr(call, "arguments", ())
            arguments += [(one.name, one.value, False) for one in further]
        of = self._writer.expression(line.operator, at)
        self._value = call_of(of, arguments, at)
