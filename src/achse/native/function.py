"""Statements of a kernel function, and the function around them."""

import ast
from types import FunctionType

from achse.native.expressions import Expressions
from achse.native.instructions import Signature, Unit
from achse.native.kinds import (
    BYTE,
    INT,
    NOTHING,
    Kind,
    Row,
    Scalar,
    Several,
    Value,
    joined,
    machine_types,
)

__all__ = ["Body"]


class _Changed(Exception):
    """A local name turned out to hold a wider kind than was thought; begin anew."""


class Body(Expressions):
    """One function of the kernel."""

    def __init__(
        self, unit: Unit, function: FunctionType, signature: Signature, source: ast.FunctionDef
    ) -> None:
        stored = {
            node.id
            for node in ast.walk(source)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        super().__init__(unit, function, frozenset(stored | set(signature.names)))
        self._signature = signature
        self._source = source
        self._wide: dict[str, Kind] = {}
        self._loops: list[tuple[str, str]] = []
        """Of each loop around: where `continue` and `break` lead."""

    def text(self, linkage: str) -> str:
        """The function as LLVM assembly."""
        while True:
            try:
                return self._text(linkage)
            except _Changed:
                continue

    def _text(self, linkage: str) -> str:
        self.lines, self.slots, self.names, self._loops = [], [], {}, []
        self._kinds.clear()
        parameters: list[str] = []
        for name, kind in zip(self._signature.names, self._signature.kinds, strict=True):
            machines = machine_types(kind)
            operands = tuple(f"%{name}.{n}" for n in range(len(machines)))
            parameters += map(" ".join, zip(machines, operands, strict=True))
            self.assign_name(name, Value(kind, operands), self._source)
        ended = self.statements(self._source.body)
        result = machine_types(self._signature.result)
        if not ended:
            self.lines.append("  unreachable" if result else "  ret void")
        head = f"define {linkage}{_returned(result)} {self._signature.symbol}"
        lines = [f"{head}({', '.join(parameters)}) nounwind {{", "begin:"]
        return "\n".join([*lines, *self.slots, *self.lines, "}"])

    # -- statements --------------------------------------------------------------------------

    def statements(self, body: list[ast.stmt]) -> bool:
        """A sequence of statements; whether control never comes to its end."""
        return any(self.statement(node) for node in body)

    def statement(self, node: ast.stmt) -> bool:
        match node:
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                pass
            case ast.Expr():
                self.value(node.value)
            case ast.Assign():
                value = self.value(node.value)
                for target in node.targets:
                    self.assign(target, value)
            case ast.AnnAssign():
                if node.value is not None:
                    self.assign(node.target, self.value(node.value))
            case ast.AugAssign():
                before, other = self.number(node.target), self.number(node.value)
                self.assign(node.target, self.combine(node.op, before, other, node))
            case ast.If():
                return self.condition(node)
            case ast.While(orelse=[]):
                self.loop(node)
            case ast.For(orelse=[]):
                self.count(node)
            case ast.Return():
                self.give_back(node)
                return True
            case ast.Break() | ast.Continue():
                self.jump(self._loops[-1][isinstance(node, ast.Break)])
                return True
            case _:
                raise self.refusal(
                    node, f"{type(node).__name__} is not part of the kernel's language"
                )
        return False

    def assign(self, target: ast.expr, value: Value) -> None:
        match target:
            case ast.Name():
                self.assign_name(target.id, value, target)
            case ast.Attribute():
                self.put(value, self.field(target), target)
            case ast.Subscript():
                owner = self.value(target.value)
                if not isinstance(owner.kind, Row):
                    raise self.refusal(target, f"{ast.unparse(target.value)} is not a sequence")
                self.put(value, self.element(owner, target), target)
            case ast.Tuple():
                members = self.parts(value) if isinstance(value.kind, Several) else []
                if len(members) != len(target.elts):
                    raise self.refusal(target, f"{len(target.elts)} values expected")
                for part, member in zip(target.elts, members, strict=True):
                    self.assign(part, member)
            case _:
                raise self.refusal(target, f"cannot assign to {ast.unparse(target)}")

    def put(self, value: Value, place: Value, node: ast.AST) -> None:
        if not isinstance(place.kind, Scalar):
            raise self.refusal(node, "only numbers can be stored in a record")
        if place.kind == BYTE:
            (word,) = self.convert(value, INT, node).operands
            value = Value(BYTE, (self.emit(f"trunc i64 {word} to i8"),))
        self.store(self.convert(value, place.kind, node), place)

    def assign_name(self, name: str, value: Value, node: ast.AST) -> None:
        """A local name has one kind in the whole function, the widest of those assigned."""
        known = self._wide.get(name)
        kind = value.kind if known is None else joined(known, value.kind)
        if kind is None:
            raise self.refusal(node, f"{name} holds values of different kinds")
        self._wide[name] = kind
        if known is not None and kind != known and name in self.names:
            raise _Changed
        if name not in self.names:
            self.names[name] = self.slot(kind)
        self.store(self.convert(value, kind, node), self.names[name])

    def condition(self, node: ast.If) -> bool:
        yes, no, end = self.block(), self.block(), self.block()
        self.branch(node.test, yes, no if node.orelse else end)
        self.begin(yes)
        ended = self.statements(node.body)
        if not ended:
            self.jump(end)
        if node.orelse:
            self.begin(no)
            if not self.statements(node.orelse):
                self.jump(end)
                ended = False
        else:
            ended = False
        if not ended:
            self.begin(end)
        return ended

    def loop(self, node: ast.While) -> None:
        again, body, end = self.block(), self.block(), self.block()
        self.jump(again)
        self.begin(again)
        self.branch(node.test, body, end)
        self.begin(body)
        self.repeat(node.body, again, end)
        self.begin(end)

    def repeat(self, body: list[ast.stmt], again: str, end: str) -> None:
        """The body of a loop, which goes on at `again`."""
        self._loops.append((again, end))
        if not self.statements(body):
            self.jump(again)
        self._loops.pop()

    def count(self, node: ast.For) -> None:
        """`for` over a `range`, evaluated once before the loop."""
        call = node.iter
        if not (
            isinstance(call, ast.Call)
            and isinstance(node.target, ast.Name)
            and self.static(call.func) == (True, range)
            and 1 <= len(call.args) <= 3
        ):
            raise self.refusal(node, "a loop counts over a range")
        step = self.as_int(call.args[2]) if len(call.args) == 3 else "1"
        if not step.removeprefix("-").isdecimal() or step == "0":
            raise self.refusal(node, "the step of a range is a constant")
        first = "0" if len(call.args) == 1 else self.as_int(call.args[0])
        stop = self.as_int(call.args[0 if len(call.args) == 1 else 1])
        counter = self.slot(INT)
        self.store(Value(INT, (first,)), counter)
        again, body, advance, end = self.block(), self.block(), self.block(), self.block()
        self.jump(again)
        self.begin(again)
        now = self.load(counter)
        relation = "sgt" if step.startswith("-") else "slt"
        more = self.emit(f"icmp {relation} i64 {now.operands[0]}, {stop}")
        self.lines.append(f"  br i1 {more}, label %{body}, label %{end}")
        self.begin(body)
        self.assign_name(node.target.id, now, node)
        self.repeat(node.body, advance, end)
        self.begin(advance)
        following = self.emit(f"add i64 {self.load(counter).operands[0]}, {step}")
        self.store(Value(INT, (following,)), counter)
        self.jump(again)
        self.begin(end)

    def give_back(self, node: ast.Return) -> None:
        given = node.value
        nothing = given is None or (isinstance(given, ast.Constant) and given.value is None)
        value = Value(NOTHING, ()) if given is None or nothing else self.value(given)
        value = self.convert(value, self._signature.result, node)
        machines = machine_types(value.kind)
        whole = _returned(machines)
        if len(machines) < 2:
            self.lines.append(f"  ret {' '.join((whole, *value.operands))}")
            return
        result = "undef"
        for n, (machine, operand) in enumerate(zip(machines, value.operands, strict=True)):
            result = self.emit(f"insertvalue {whole} {result}, {machine} {operand}, {n}")
        self.lines.append(f"  ret {whole} {result}")


def _returned(machines: tuple[str, ...]) -> str:
    if not machines:
        return "void"
    return machines[0] if len(machines) == 1 else "{ " + ", ".join(machines) + " }"
