"""Boxes, targets and flags of networks and charts, once their inputs are evaluated.

Source: IEC 61131-3 (2013) §8.1.6 for EN and ENO; bodies of public TwinCAT 3 projects.
"""

import re
from collections.abc import Sequence
from itertools import pairwise

from achse.iec.elementary import IntegerType, RealType
from achse.iec.names import ELEMENTARY
from achse.st.graphical.body import GraphicalBody, Refused
from achse.st.graphical.networks import Box, BoxInput, BoxOutput, Modifier, NetworkOperand
from achse.st.graphical.writer import BodyStatements, call_of
from achse.st.lexis.codes import Code
from achse.st.syntax.nodes import changed
from achse.st.syntax.tree import (
    Binary,
    Branch,
    Expression,
    If,
    Jump,
    Let,
    Literal,
    Member,
    Name,
    Return,
    Statement,
    Unary,
)

EDGES = Modifier.RISING | Modifier.FALLING
UNFINISHED = "???"
"""Text of an operand, target or instance that was never filled in."""
_SIGNS = {
    "and": "AND",
    "or": "OR",
    "xor": "XOR",
    "add": "+",
    "sub": "-",
    "minus": "-",
    "mul": "*",
    "div": "/",
    "mod": "MOD",
    "eq": "=",
    "ne": "<>",
    "gt": ">",
    "ge": ">=",
    "lt": "<",
    "le": "<=",
}
_POSITIONAL = frozenset(
    ["not", "move", "sel", "mux", "limit", "min", "max", "shl", "shr", "rol", "ror", "abs", "sqrt",
     "ln", "log", "exp", "sin", "cos", "tan", "asin", "acos", "atan", "expt", "trunc", "len",
     "left", "right", "mid", "concat", "insert", "delete", "replace", "find", "sizeof", "adr"]
)  # fmt: skip
_EXTENSIBLE = frozenset(["concat"])
"""Functions of two inputs in text whose boxes may have more."""
_CONVERSION = re.compile(r"(?:[a-z]+\w*_)?to_[a-z]+\w*|trunc_\w+")
_ALL_SIGNS = frozenset(_SIGNS.values())
_KINDS = {"&": "and", **{sign: kind for kind, sign in _SIGNS.items() if kind != "minus"}}
COMPARISONS = frozenset(("=", "<>", ">", ">=", "<", "<="))
_FALSE = Literal("boolean", "FALSE")
_START_VALUES = {
    **{
        type.name: Literal("typed", f"{type.name}#0")
        for type in ELEMENTARY.values()
        if isinstance(type, IntegerType | RealType)
    },
    **{type: Literal("typed", f"{type}#0s") for type in ("TIME", "LTIME")},
}
"""Start values of memories of outputs, by their type; that of a BOOL is FALSE."""


def memory_of(body: GraphicalBody, key: str) -> str:
    """Return the name of the memory of an edge; `key` is the number of its node in the body."""
    owner = body.owner
    return f"__{owner.unit}_{owner.part}_{key}"


def sign_of_operator(name: str) -> str:
    """Return the sign of an operator in Structured Text; empty for what is called like a
    function."""
    return name if name in _ALL_SIGNS else _SIGNS.get(name.lower(), "")


def operator_of(node: Box) -> str:
    """Return the kind of a box in lower case: `and` too for a box `&`, `gt` for one `>`."""
    return _KINDS.get(node.type, node.call.lower())


def call_of_operator(name: str) -> str:
    """Return the kind of call of a box that is an operator or a function of the language, whose
    inputs have an order and no names; empty for the name of a unit."""
    key = name.lower()
    if sign_of_operator(name) or key in _POSITIONAL or _CONVERSION.fullmatch(key):
        return name.title()
    return ""


def sign_of(node: Box) -> str:
    """Return the sign of a box; empty for what is called like a function."""
    return sign_of_operator(operator_of(node))


def both(left: Expression | None, right: Expression, at: int) -> Expression:
    """`left AND right`; None is TRUE."""
    return right if left is None else Binary("AND", left, right, at)


class BoxWriter(BodyStatements):
    """Writes the execution of boxes and what is assigned from them."""

    def store(self, target: NetworkOperand, value: Expression) -> None:
        """Write a value to a target: a variable, a coil, a jump, a return."""
        modifiers = target.modifiers
        if modifiers & Modifier.JUMP:
            at = self.at(target.at, f"jump to {target.text}")
            self.leave(Jump(target.text, at), value, at)
        elif modifiers & Modifier.RETURN:
            at = self.at(target.at, "return")
            self.leave(Return(at), value, at)
        elif modifiers & EDGES:
            at = self.at(target.at)
            raise Refused(
                at, f"an edge on the coil {target.text} is not supported", Code.UNSUPPORTED_DRAWING
            )
        else:
            at = self.at(target.at)
            place = self.target(target, at)
            if modifiers & Modifier.SET:
                operator = "R=" if modifiers & Modifier.NEGATED else "S="
                self.assign(place, value, at, operator)
            else:
                if modifiers & Modifier.NEGATED:
                    value = Unary("NOT", value, at)
                self.assign(place, value, at)

    def leave(self, statement: Statement, value: Expression, at: int) -> None:
        """Write a jump or return under a condition."""
        if isinstance(value, Literal) and value.text.upper() == "TRUE":
            self.out.append(statement)
        else:
            self.out.append(If((Branch(value, (statement,), at),), (), at))

    def target(self, target: NetworkOperand, at: int) -> Expression:
        if target.text in ("", UNFINISHED):
            raise Refused(
                at,
                "a target is not filled in: expected a variable, got '???'",
                Code.INCOMPLETE_DRAWING,
            )
        return self.expression(target.text, at)

    def modified(self, value: Expression, modifiers: int, key: str, at: int) -> Expression:
        """Negate first, then detect the edge."""
        if modifiers & ~(Modifier.NEGATED | EDGES):
            raise Refused(
                at,
                "an operand that is set, reset, jump or return is not supported",
                Code.UNSUPPORTED_DRAWING,
            )
        if modifiers & Modifier.NEGATED:
            value = Unary("NOT", value, at)
        if modifiers & EDGES:
            if not self.body.owner.keeps_memory:
                raise Refused(
                    at, "a function keeps no memory: an edge needs one", Code.INCOMPLETE_DRAWING
                )
            if modifiers & EDGES == EDGES:
                raise Refused(
                    at,
                    "a rising and falling edge in one place is not supported",
                    Code.UNSUPPORTED_DRAWING,
                )
            rises = bool(modifiers & Modifier.RISING)
            return self.edge(memory_of(self.body, key), value, rises=rises, at=at)
        return value

    def assign_outputs(self, node: Box, value: Expression) -> None:
        """Write the result of an operator to the targets at its output."""
        for output in node.outputs:
            if output.target is not None:
                self.store(output.target, value)

    def simple(self, value: Expression, at: int) -> Expression:
        """Return a value that may be used several times."""
        if isinstance(value, Literal) or (isinstance(value, Name) and value.name[:2] == "__"):
            return value
        return self.let(self.hidden("power"), value, at)

    def frozen(self, value: Expression, index: int, at: int) -> Expression:
        """Return a value as it was before the statement at an index."""
        if isinstance(value, Literal) or (isinstance(value, Name) and value.name[:2] == "__"):
            return value
        name = self.hidden("read")
        self.out.insert(index, Let(name, value, at))
        return Name(name, at)

    def executed(
        self, node: Box, inputs: list[tuple[BoxInput, Expression]], at: int, *, is_read: bool
    ) -> Expression | None:
        """Write the execution of a box and of the targets at its outputs; return the output that
        the node around it reads."""
        match node.call:
            case "FunctionBlock":
                return self._block(node, inputs, at, is_read=is_read)
            case "Function" | "Method" | "Program" | "Action":
                return self._routine(node, inputs, at, is_read=is_read)
            case "None":
                if node.text is not None:
                    self.out += self.parsed_statements(node.text, at)
                    return None
                if node.type.upper() == "EXECUTE":
                    return None
                if node.instance:
                    return self._block(node, inputs, at, is_read=is_read)
                return self._routine(node, inputs, at, is_read=is_read)
        value = self.operator(node, inputs, at)
        self.assign_outputs(node, value)
        return value

    def _block(
        self, node: Box, inputs: list[tuple[BoxInput, Expression]], at: int, *, is_read: bool
    ) -> Expression | None:
        """Call an instance, then write its outputs to their targets."""
        if node.instance in ("", UNFINISHED):
            raise Refused(at, f"the box {node.type} has no instance", Code.INCOMPLETE_DRAWING)
        instance = self.expression(node.instance, at)
        pins = self.scope.pins(node.type) if self._lacks_names(node) else None
        if self._lacks_names(node) and pins is None:
            raise Refused(
                at,
                f"the pins of {node.type} are not known: it is not declared",
                Code.INCOMPLETE_DRAWING,
            )
        names = [pin.name for pin, _ in inputs]
        outputs = node.outputs
        if pins is not None:
            places = {id(pin): number for number, pin in enumerate(node.inputs)}
            names = [_named(pins.inputs, places[id(pin)], node, at) for pin, _ in inputs]
            outputs = tuple(
                changed(output, name=_named(pins.outputs, number, node, at))
                if output.target is not None or output.is_read
                else output
                for number, output in enumerate(outputs)
            )
        arguments = [(name, value, False) for name, (_, value) in zip(names, inputs, strict=True)]
        self.out.append(call_of(instance, arguments, at))
        base = instance
        if node.instance.upper().replace(" ", "") == "SUPER^":
            base = self.expression("THIS^", at)
        for output in outputs:
            if output.target is not None and not output.is_read:
                self.store(output.target, Member(base, output.name, at))
        read = next((output for output in outputs if output.is_read), None)
        if not is_read or read is None:
            return None
        return Member(base, read.name, at)

    def _lacks_names(self, node: Box) -> bool:
        """True for a box whose pins have only an order."""
        return any(not pin.name for pin in node.inputs) or any(
            not output.name and (output.target is not None or output.is_read)
            for output in node.outputs
        )

    def _routine(
        self, node: Box, inputs: list[tuple[BoxInput, Expression]], at: int, *, is_read: bool
    ) -> Expression | None:
        """Call a function, method, program or action."""
        of = self.expression(node.type, at)
        if node.instance not in ("", UNFINISHED):
            of = Member(self.expression(node.instance, at), node.type, at)
        last = node.type.rpartition(".")[2].lower()
        by_name = all(pin.name for pin, _ in inputs)
        arguments = [(pin.name if by_name else "", value, False) for pin, value in inputs]
        after: list[tuple[BoxOutput, Expression]] = []
        result: BoxOutput | None = None
        value: Expression | None = None
        for output in node.outputs:
            is_result = output.name == "" or output.name.lower() == last
            if is_result:
                result = output
                continue
            if output.target is None and not (output.is_read and is_read):
                continue
            if output.target is not None and not output.target.modifiers:
                target = self.target(output.target, self.at(output.target.at))
            else:  # set, reset, negated, or read by what is around
                start = _START_VALUES.get(output.type.upper(), _FALSE)
                target = self.let(self.hidden("output"), start, at)
                if output.target is not None:
                    after.append((output, target))
                else:
                    value = target
            arguments.append((output.name, target, True))
        call = call_of(of, arguments, at)
        wanted = result is not None and (result.target is not None or (result.is_read and is_read))
        if wanted and result is not None:
            result_value: Expression = call
            if result.is_read and is_read:
                value = result_value = self.let(self.hidden("result"), call, at)
            if result.target is not None:
                self.store(result.target, result_value)
        else:
            self.out.append(call)
        for output, target in after:
            assert output.target is not None
            self.store(output.target, target)
        return value

    def operator(self, node: Box, inputs: list[tuple[BoxInput, Expression]], at: int) -> Expression:
        """Return the value of an operator."""
        values = [value for _, value in inputs]
        sign = sign_of(node)
        if not values:
            raise Refused(at, f"the box {node.type} has no input", Code.INCOMPLETE_DRAWING)
        if node.call.lower() == "move":
            return values[0]
        if node.call.lower() == "not":
            return Unary("NOT", values[0], at)
        if sign == "-" and len(values) == 1:
            return Unary("-", values[0], at)
        if sign in COMPARISONS:
            pairs = pairwise(values)
            result: Expression | None = None
            for left, right in pairs:
                result = both(result, Binary(sign, left, right, at), at)
            if result is None:
                raise Refused(
                    at, f"the box {node.type} has one input only", Code.INCOMPLETE_DRAWING
                )
            return result
        if sign:
            value = values[0]
            for right in values[1:]:
                value = Binary(sign, value, right, at)
            return value
        of = self.expression(node.type, at)
        while node.call.lower() in _EXTENSIBLE and len(values) > 2:
            first = call_of(of, [("", one, False) for one in values[:2]], at)
            values = [first, *values[2:]]
        return call_of(of, [("", one, False) for one in values], at)


def _named(names: Sequence[str], number: int, node: Box, at: int) -> str:
    if number >= len(names):
        raise Refused(
            at,
            f"{node.type} has {len(names)} such pins, expected {number + 1}",
            Code.INCOMPLETE_DRAWING,
        )
    return names[number]
