"""Expressions of a kernel function: what names, operators and calls of the source mean."""

import ast
import math
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

from achse.native.instructions import Instructions, Unit, real_constant
from achse.native.kinds import (
    BOOL,
    BYTE,
    INT,
    NOTHING,
    REAL,
    Kind,
    Record,
    Row,
    Scalar,
    Several,
    Value,
    joined,
    machine_types,
)

__all__ = ["LIBRARY", "Expressions"]

LIBRARY: dict[Callable[..., Any], str] = {
    getattr(math, name): name
    for name in (
        "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cosh", "cos", "erf", "exp",
        "expm1", "fmod", "log10", "log1p", "log", "pow", "sin", "sinh", "tan", "tanh",
    )
}  # fmt: skip
"""Functions that are those of the C library, from one or two floats to a float."""

_INTRINSICS: dict[Callable[..., Any], str] = {
    math.copysign: "copysign",
    math.fabs: "fabs",
    math.sqrt: "sqrt",
}
_ROUNDINGS: dict[Callable[..., Any], str] = {
    math.ceil: "ceil",
    math.floor: "floor",
    math.trunc: "trunc",
    round: "roundeven",
}


class Expressions(Instructions):
    """Writes the instructions that compute expressions; `local_names` are the function's own."""

    def __init__(self, unit: Unit, function: FunctionType, local_names: frozenset[str]) -> None:
        super().__init__(unit, function)
        self.local_names = local_names
        self.names: dict[str, Value] = {}
        """Addresses of the local names."""
        self._kinds: dict[ast.expr, Kind] = {}

    # -- kinds -------------------------------------------------------------------------------

    def kind_of(self, node: ast.expr) -> Kind:
        """The kind of an expression, without leaving instructions behind."""
        kind = self._kinds.get(node)
        if kind is None:
            lines, slots = len(self.lines), len(self.slots)
            kind = self._kinds[node] = self.value(node).kind
            del self.lines[lines:], self.slots[slots:]
        return kind

    def common(self, node: ast.AST, parts: Sequence[ast.expr]) -> Kind:
        """The kind that holds the values of all parts."""
        kind = self.kind_of(parts[0])
        for part in parts[1:]:
            both = joined(kind, self.kind_of(part))
            if both is None:
                raise self.refusal(node, f"values of different kinds in {ast.unparse(node)}")
            kind = both
        return kind

    def number(self, node: ast.expr) -> Value:
        value = self.value(node)
        if not isinstance(value.kind, Scalar):
            raise self.refusal(node, f"{ast.unparse(node)} is not a number")
        return value

    def as_real(self, node: ast.expr) -> str:
        return self.convert(self.number(node), REAL, node).operands[0]

    def as_int(self, node: ast.expr) -> str:
        return self.convert(self.number(node), INT, node).operands[0]

    # -- expressions -------------------------------------------------------------------------

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        if isinstance(node, ast.Name | ast.Attribute):
            known, thing = self.static(node)
            if known:
                return self.constant(thing, node)
        match node:
            case ast.Constant():
                return self.constant(node.value, node)
            case ast.Name():
                if node.id not in self.names:
                    raise self.refusal(node, f"{node.id} has no value yet")
                return self.load(self.names[node.id])
            case ast.Attribute():
                place = self.field(node)
                return self.load(place) if isinstance(place.kind, Scalar) else place
            case ast.Subscript():
                return self.item(node)
            case ast.BinOp():
                return self.arithmetic(node)
            case ast.UnaryOp():
                return self.unary(node)
            case ast.Compare() if len(node.ops) == 1:
                return Value(BOOL, (self.compare(node.ops[0], node.left, node.comparators[0]),))
            case ast.Compare():
                return self.choice(node, BOOL, node, ast.Constant(True), ast.Constant(False))
            case ast.BoolOp():
                return self.logical(node)
            case ast.IfExp():
                kind = self.common(node, [node.body, node.orelse])
                return self.choice(node, kind, node.test, node.body, node.orelse)
            case ast.Tuple():
                return self.several([self.value(part) for part in node.elts])
            case ast.Call():
                return self.call(node)
        raise self.refusal(node, f"{type(node).__name__} is not part of the kernel's language")

    def static(self, node: ast.expr) -> tuple[bool, Any]:
        """What a name outside the function stands for, if it is one."""
        if isinstance(node, ast.Name):
            if node.id in self.local_names:
                return False, None
            scope = self.function.__globals__
            if node.id in scope:
                return True, scope[node.id]
            builtins = scope["__builtins__"]
            builtins = builtins if isinstance(builtins, dict) else vars(builtins)
            if node.id in builtins:
                return True, builtins[node.id]
            raise self.refusal(node, f"nothing is called {node.id}")
        if isinstance(node, ast.Attribute):
            known, owner = self.static(node.value)
            if known:
                if not hasattr(owner, node.attr):
                    raise self.refusal(node, f"there is no {ast.unparse(node)}")
                return True, getattr(owner, node.attr)
        return False, None

    def constant(self, thing: object, node: ast.AST) -> Value:
        match thing:
            case bool():
                return Value(BOOL, ("true" if thing else "false",))
            case int() if -(1 << 63) <= thing < 1 << 63:
                return Value(INT, (str(int(thing)),))
            case float():
                return Value(REAL, (real_constant(thing),))
            case tuple():
                return self.several([self.constant(part, node) for part in thing])
        raise self.refusal(node, f"{thing!r} is not a number of 64 bits")

    def field(self, node: ast.Attribute) -> Value:
        """Address of a field of a record; a field of several numbers is a row, a reference the
        record it leads to."""
        owner = self.value(node.value)
        if not isinstance(owner.kind, Record):
            raise self.refusal(node, f"{ast.unparse(node.value)} is not a record")
        place = owner.kind.layout.fields.get(node.attr)
        if place is None:
            raise self.refusal(node, f"{owner.kind.layout.name} has no field {node.attr}")
        kind = REAL if place.is_real else INT
        address = self.emit(f"getelementptr i64, ptr {owner.operands[0]}, i64 {place.offset}")
        if place.refers is not None:
            return Value(Record(place.refers), (self.emit(f"load ptr, ptr {address}"),))
        if place.length:
            return Value(Row(kind), (address, str(place.length)))
        return Value(kind, (address,))

    def item(self, node: ast.Subscript) -> Value:
        known, thing = self.static(node.value)
        if known and isinstance(thing, tuple) and not isinstance(node.slice, ast.Constant):
            kind = REAL if any(isinstance(number, float) for number in thing) else INT
            table = Value(Row(kind), (self.unit.table(thing, kind), str(len(thing))))
            return self.load(self.element(table, node))
        owner = self.value(node.value)
        if isinstance(owner.kind, Row):
            place = self.element(owner, node)
            return self.load(place) if isinstance(place.kind, Scalar) else place
        if isinstance(owner.kind, Several) and isinstance(node.slice, ast.Constant):
            index = node.slice.value
            if isinstance(index, int) and 0 <= index < len(owner.kind.kinds):
                return self.parts(owner)[index]
        raise self.refusal(node, f"no element {ast.unparse(node)}")

    def element(self, row: Value, node: ast.Subscript) -> Value:
        """Address of an element; an index below 0 counts from the end."""
        assert isinstance(row.kind, Row)
        address, length = row.operands
        index = self.as_int(node.slice)
        if not index.isdecimal():
            below = self.emit(f"icmp slt i64 {index}, 0")
            from_end = self.emit(f"add i64 {index}, {length}")
            index = self.emit(f"select i1 {below}, i64 {from_end}, i64 {index}")
        if isinstance(row.kind.of, Record):
            index = self.emit(f"mul i64 {index}, {row.kind.of.layout.words}")
        step = "i8" if row.kind.of == BYTE else "i64"
        return Value(row.kind.of, (self.emit(f"getelementptr {step}, ptr {address}, i64 {index}"),))

    # -- numbers -----------------------------------------------------------------------------

    def arithmetic(self, node: ast.BinOp) -> Value:
        return self.combine(node.op, self.number(node.left), self.number(node.right), node)

    def unary(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            operand = self.truth(self.value(node.operand), node)
            return Value(BOOL, (self.emit(f"xor i1 {operand}, true"),))
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
            return self.constant(-node.operand.value, node)  # type: ignore[operator]
        value = self.number(node.operand)
        if value.kind is BOOL:
            value = self.convert(value, INT, node)
        (operand,) = value.operands
        if isinstance(node.op, ast.UAdd):
            return value
        if isinstance(node.op, ast.Invert):
            if value.kind is REAL:
                raise self.refusal(node, "no ~ of a float")
            return Value(INT, (self.emit(f"xor i64 {operand}, -1"),))
        if value.kind is REAL:
            return Value(REAL, (self.emit(f"fneg double {operand}"),))
        return Value(INT, (self.emit(f"sub i64 0, {operand}"),))

    def compare(self, op: ast.cmpop, left: ast.expr, right: ast.expr) -> str:
        """One comparison, as i1."""
        if isinstance(op, ast.In | ast.NotIn):
            return self.contained(left, right, isinstance(op, ast.In))
        return self.relation(op, self.number(left), self.number(right), left)

    def contained(self, left: ast.expr, right: ast.expr, inside: bool) -> str:
        """Whether a number is one of a tuple."""
        value, among = self.number(left), self.value(right)
        if not isinstance(among.kind, Several):
            raise self.refusal(right, f"{ast.unparse(right)} is not a tuple")
        found = "false"
        for member in self.parts(among):
            equal = self.relation(ast.Eq(), value, member, right)
            found = self.emit(f"or i1 {found}, {equal}")
        return found if inside else self.emit(f"xor i1 {found}, true")

    # -- choices -----------------------------------------------------------------------------

    def branch(self, test: ast.expr, yes: str, no: str) -> None:
        """Go on at `yes` if the test holds, else at `no`; evaluates no more than needed."""
        match test:
            case ast.BoolOp():
                for part in test.values[:-1]:
                    go_on = self.block()
                    if isinstance(test.op, ast.And):
                        self.branch(part, go_on, no)
                    else:
                        self.branch(part, yes, go_on)
                    self.begin(go_on)
                self.branch(test.values[-1], yes, no)
            case ast.UnaryOp(op=ast.Not()):
                self.branch(test.operand, no, yes)
            case ast.Compare() if len(test.ops) > 1:
                left = self.number(test.left)
                for n, (op, node) in enumerate(zip(test.ops, test.comparators, strict=True)):
                    right = self.number(node)
                    holds = self.relation(op, left, right, test)
                    go_on = yes if n == len(test.ops) - 1 else self.block()
                    self.lines.append(f"  br i1 {holds}, label %{go_on}, label %{no}")
                    if go_on != yes:
                        self.begin(go_on)
                    left = right
            case _:
                holds = self.truth(self.value(test), test)
                self.lines.append(f"  br i1 {holds}, label %{yes}, label %{no}")

    def choice(
        self, node: ast.AST, kind: Kind, test: ast.expr, body: ast.expr, orelse: ast.expr
    ) -> Value:
        """One value or the other."""
        slot, yes, no, end = self.slot(kind), self.block(), self.block(), self.block()
        self.branch(test, yes, no)
        for label, branch in ((yes, body), (no, orelse)):
            self.begin(label)
            self.store(self.convert(self.value(branch), kind, node), slot)
            self.jump(end)
        self.begin(end)
        return self.load(slot)

    def logical(self, node: ast.BoolOp) -> Value:
        """`and` and `or` as values: the operand that decides."""
        kind = self.common(node, node.values)
        slot, end = self.slot(kind), self.block()
        for part in node.values[:-1]:
            value = self.value(part)
            self.store(self.convert(value, kind, part), slot)
            holds, go_on = self.truth(value, part), self.block()
            ways = (go_on, end) if isinstance(node.op, ast.And) else (end, go_on)
            self.lines.append(f"  br i1 {holds}, label %{ways[0]}, label %{ways[1]}")
            self.begin(go_on)
        last = node.values[-1]
        self.store(self.convert(self.value(last), kind, last), slot)
        self.jump(end)
        self.begin(end)
        return self.load(slot)

    # -- calls -------------------------------------------------------------------------------

    def call(self, node: ast.Call) -> Value:
        known, callee = self.static(node.func)
        if not known:
            raise self.refusal(node, f"{ast.unparse(node.func)} is no function of a module")
        if isinstance(callee, FunctionType):
            return self.call_kernel(node, callee)
        if node.keywords or not node.args:
            raise self.refusal(node, f"arguments of {ast.unparse(node)}")
        first, count = node.args[0], len(node.args)
        if callee in LIBRARY:
            return Value(REAL, (self.library(LIBRARY[callee], *map(self.as_real, node.args)),))
        if callee in _INTRINSICS:
            return Value(
                REAL, (self.intrinsic(_INTRINSICS[callee], *map(self.as_real, node.args)),)
            )
        if callee in (min, max) and count > 1:
            return self.extreme(node, ast.Lt() if callee is min else ast.Gt())
        if count != 1:
            raise self.refusal(node, f"arguments of {ast.unparse(node)}")
        if callee is len:
            row = self.value(first)
            if isinstance(row.kind, Row):
                return Value(INT, (row.operands[1],))
        elif callee in (math.isfinite, math.isinf, math.isnan):
            return Value(BOOL, (self.classify(callee, self.as_real(first)),))
        elif callee is bool:
            return Value(BOOL, (self.truth(self.value(first), first),))
        elif callee is float:
            return self.convert(self.number(first), REAL, first)
        elif callee is abs:
            return self.magnitude(first)
        elif callee is int or callee in _ROUNDINGS:
            number = self.number(first)
            if number.kind is not REAL:
                return self.convert(number, INT, first)
            (operand,) = number.operands
            if callee is not int:
                operand = self.intrinsic(_ROUNDINGS[callee], operand)
            return Value(INT, (self.whole(operand),))
        raise self.refusal(node, f"{ast.unparse(node.func)} is not part of the kernel's language")

    def call_kernel(self, node: ast.Call, function: FunctionType) -> Value:
        """A call of another function of the kernel."""
        signature = self.unit.signature(function)
        given: dict[str, Value] = {}
        for name, argument in zip(signature.names, node.args, strict=False):
            given[name] = self.value(argument)
        for keyword in node.keywords:
            if keyword.arg is None or keyword.arg in given or keyword.arg not in signature.names:
                raise self.refusal(node, f"argument {keyword.arg}")
            given[keyword.arg] = self.value(keyword.value)
        for name, default in signature.defaults.items():
            if name not in given:
                given[name] = self.constant(default, node)
        if len(given) != len(signature.names) or len(node.args) > len(signature.names):
            raise self.refusal(node, f"{function.__name__} takes {', '.join(signature.names)}")
        arguments: list[str] = []
        for name, kind in zip(signature.names, signature.kinds, strict=True):
            value = self.convert(given[name], kind, node)
            arguments += map(" ".join, zip(machine_types(kind), value.operands, strict=True))
        result = machine_types(signature.result)
        text = f"{signature.symbol}({', '.join(arguments)})"
        if not result:
            self.lines.append(f"  call void {text}")
            return Value(NOTHING, ())
        if len(result) == 1:
            return Value(signature.result, (self.emit(f"call {result[0]} {text}"),))
        whole = "{ " + ", ".join(result) + " }"
        all_of_it = self.emit(f"call {whole} {text}")
        return Value(
            signature.result,
            tuple(self.emit(f"extractvalue {whole} {all_of_it}, {n}") for n in range(len(result))),
        )

    def magnitude(self, node: ast.expr) -> Value:
        value = self.number(node)
        if value.kind is REAL:
            return Value(REAL, (self.intrinsic("fabs", value.operands[0]),))
        (operand,) = self.convert(value, INT, node).operands
        below = self.emit(f"icmp slt i64 {operand}, 0")
        negated = self.emit(f"sub i64 0, {operand}")
        return Value(INT, (self.emit(f"select i1 {below}, i64 {negated}, i64 {operand}"),))

    def extreme(self, node: ast.Call, op: ast.cmpop) -> Value:
        """`min` and `max`: a later number only if it is really beyond."""
        kind = self.common(node, node.args)
        assert isinstance(kind, Scalar)
        best = self.convert(self.number(node.args[0]), kind, node)
        for argument in node.args[1:]:
            other = self.convert(self.number(argument), kind, node)
            beyond = self.relation(op, other, best, node)
            a, b = other.operands[0], best.operands[0]
            machine = kind.machine
            best = Value(kind, (self.emit(f"select i1 {beyond}, {machine} {a}, {machine} {b}"),))
        return best
