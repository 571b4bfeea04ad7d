"""Statements of a kernel function, and the function around them."""

import ast
from types import FunctionType

from achse.native.backend.builder import FunctionBuilder, Label
from achse.native.backend.instructions import Relation
from achse.native.backend.types import I64
from achse.native.kernels.arithmetic import KernelSignature, TranslationUnit
from achse.native.kernels.expressions import ExpressionCompiler
from achse.native.kernels.kinds import (
    INT,
    NOTHING,
    KernelValue,
    RecordReference,
    Row,
    Several,
    ValueKind,
    joined,
    machine_types,
)


class _Changed(Exception):
    """A local name turned out to hold a wider kind than was thought; begin again."""


class FunctionCompiler(ExpressionCompiler):
    """One function of the kernel."""

    def __init__(
        self,
        unit: TranslationUnit,
        function: FunctionType,
        callee: KernelSignature,
        source: ast.FunctionDef,
        code: FunctionBuilder,
    ) -> None:
        stored = {
            node.id
            for node in ast.walk(source)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        super().__init__(unit, function, code, frozenset(stored | set(callee.names)))
        self.ways = {name: way for name, way in callee.ways if name not in stored}
        self._callee = callee
        self._source = source
        self._wide: dict[str, ValueKind] = {}
        self._loops: list[tuple[Label, Label]] = []
        """Of each loop around: where `continue` and `break` lead."""

    def write(self) -> None:
        """Fill the function's code."""
        while True:
            try:
                return self._write()
            except _Changed:
                continue

    def _write(self) -> None:
        self.code.clear()
        self.names, self.rows, self._loops = {}, {}, []
        self._kinds.clear()
        first = 0
        for name, kind in zip(self._callee.names, self._callee.kinds, strict=True):
            size = len(machine_types(kind))
            value = KernelValue(kind, self.code.parameters[first : first + size])
            self.assign_name(name, value, self._source)
            first += size
        self.statements(self._source.body)
        if self.own_records and isinstance(self._callee.result, RecordReference):
            raise self.refusal(self._source, "a record of its own cannot be returned")

    # -- statements --------------------------------------------------------------------------

    def statements(self, body: list[ast.stmt]) -> bool:
        """Return a sequence of statements; whether control never comes to its end."""
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
                self.code.jump(self._loops[-1][isinstance(node, ast.Break)])
                return True
            case _:
                raise self.refusal(
                    node, f"{type(node).__name__} is not part of the kernel's language"
                )
        return False

    def assign(self, target: ast.expr, value: KernelValue) -> None:
        match target:
            case ast.Name():
                self.assign_name(target.id, value, target)
            case ast.Attribute():
                self.put(self.field(target), value, target)
            case ast.Subscript():
                owner = self.value(target.value)
                if not isinstance(owner.kind, Row):
                    raise self.refusal(target, f"{ast.unparse(target.value)} is not a sequence")
                self.put(self.element(owner, target), value, target)
            case ast.Tuple():
                members = self.parts(value) if isinstance(value.kind, Several) else []
                if len(members) != len(target.elts):
                    raise self.refusal(target, f"{len(target.elts)} values expected")
                for part, member in zip(target.elts, members, strict=True):
                    self.assign(part, member)
            case _:
                raise self.refusal(target, f"cannot assign to {ast.unparse(target)}")

    def assign_name(self, name: str, value: KernelValue, node: ast.AST) -> None:
        """Assign a local name, which has the widest of its kinds in the whole function."""
        known = self._wide.get(name)
        kind = value.kind if known is None else joined(known, value.kind)
        if kind is None:
            raise self.refusal(node, f"{name} holds values of different kinds")
        self._wide[name] = kind
        if known is not None and kind != known and name in self.names:
            raise _Changed
        if name not in self.names:
            self.names[name] = self.local(kind)
        self.set(self.names[name], self.convert(value, kind, node))

    def condition(self, node: ast.If) -> bool:
        yes, no, end = self.code.label(), self.code.label(), self.code.label()
        self.branch(node.test, yes, no if node.orelse else end)
        self.code.begin(yes)
        ended = self.statements(node.body)
        if not ended:
            self.code.jump(end)
        if node.orelse:
            self.code.begin(no)
            if not self.statements(node.orelse):
                self.code.jump(end)
                ended = False
        else:
            ended = False
        if not ended:
            self.code.begin(end)
        return ended

    def loop(self, node: ast.While) -> None:
        again, body, end = self.code.label(), self.code.label(), self.code.label()
        self.code.jump(again)
        self.code.begin(again)
        self.branch(node.test, body, end)
        self.code.begin(body)
        self.repeat(node.body, again, end)
        self.code.begin(end)

    def repeat(self, body: list[ast.stmt], again: Label, end: Label) -> None:
        """Write the body of a loop, which continues at `again`."""
        self._loops.append((again, end))
        if not self.statements(body):
            self.code.jump(again)
        self._loops.pop()

    def each(self, node: ast.For, rows: tuple[object, ...]) -> None:
        """Write `for` over the rows of a table of the module: the body once for each row."""
        if not isinstance(node.target, ast.Name):
            raise self.refusal(node, "a loop over a table has one name")
        end = self.code.label()
        for row in rows:
            self.rows[node.target.id] = row
            self._kinds.clear()
            following = self.code.label()
            self.repeat(node.body, following, end)
            self.code.begin(following)
        self.rows.pop(node.target.id, None)
        self._kinds.clear()
        self.code.jump(end)
        self.code.begin(end)

    def count(self, node: ast.For) -> None:
        """Write `for` over a `range`, evaluated once before the loop, or over a table of rows."""
        call = node.iter
        known, rows = self.static(call) if isinstance(call, ast.Name) else (False, None)
        if known and isinstance(rows, tuple):
            self.each(node, rows)
            return
        if not (
            isinstance(call, ast.Call)
            and isinstance(node.target, ast.Name)
            and self.static(call.func) == (True, range)
            and 1 <= len(call.args) <= 3
        ):
            raise self.refusal(node, "a loop counts over a range or goes through a table")
        code = self.code
        step = self.as_int(call.args[2]) if len(call.args) == 3 else code.constant(I64, 1)
        if not step.is_constant or step.text == "0":
            raise self.refusal(node, "the step of a range is a constant")
        first = code.constant(I64, 0) if len(call.args) == 1 else self.as_int(call.args[0])
        stop = self.as_int(call.args[0 if len(call.args) == 1 else 1])
        counter = code.variable(I64)
        code.set(counter, first)
        again, body, advance, end = code.label(), code.label(), code.label(), code.label()
        code.begin(again)
        now = code.get(counter)
        relation = Relation.GREATER if step.text.startswith("-") else Relation.LESS
        code.branch(code.compare(relation, now, stop), body, end)
        code.begin(body)
        self.assign_name(node.target.id, KernelValue(INT, (now,)), node)
        self.repeat(node.body, advance, end)
        code.begin(advance)
        code.set(counter, code.add(code.get(counter), step))
        code.jump(again)
        code.begin(end)

    def give_back(self, node: ast.Return) -> None:
        returned = node.value
        nothing = returned is None or (
            isinstance(returned, ast.Constant) and returned.value is None
        )
        value = KernelValue(NOTHING, ()) if returned is None or nothing else self.value(returned)
        value = self.convert(value, self._callee.result, node)
        self.code.return_(*value.operands)
