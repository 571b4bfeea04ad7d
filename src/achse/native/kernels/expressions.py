"""Expressions of a kernel function: what names, operators and calls of the source mean."""

import ast
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from types import FunctionType
from typing import Any

from achse.native.backend.builder import FunctionBuilder, Label, LocalVariable
from achse.native.backend.instructions import Relation, Rounding
from achse.native.backend.types import ADDRESS, F64, I64, U8, Operand
from achse.native.declare import RecordLayout, assign, reset
from achse.native.kernels.arithmetic import LIBRARY, Arithmetic, TranslationUnit, Ways
from achse.native.kernels.kinds import (
    BOOL,
    BYTE,
    INT,
    NOTHING,
    REAL,
    KernelValue,
    RecordReference,
    Row,
    RowTables,
    Scalar,
    Several,
    ValueKind,
    joined,
    machine_types,
)

_INTRINSICS: dict[Callable[..., Any], str] = {math.copysign: "copysign", math.fabs: "fabs"}
_ROUNDINGS: dict[Callable[..., Any], Rounding] = {
    math.ceil: Rounding.UP,
    math.floor: Rounding.DOWN,
    math.trunc: Rounding.TO_ZERO,
    round: Rounding.HALF_TO_EVEN,
}
_INDEX = IndexError, "index {0} of {1} elements"


@dataclass(frozen=True, slots=True)
class NumberLocation:
    """Location of a number in a record or a sequence."""

    kind: Scalar
    address: Operand


@dataclass(frozen=True, slots=True)
class Local:
    """A local name: its variables, one for each of `machine_types(kind)`."""

    kind: ValueKind
    variables: tuple[LocalVariable, ...]


class ExpressionCompiler(Arithmetic):
    """Writes the instructions that compute expressions; `local_names` are the function's own."""

    def __init__(
        self,
        unit: TranslationUnit,
        function: FunctionType,
        code: FunctionBuilder,
        local_names: frozenset[str],
    ) -> None:
        super().__init__(unit, function, code)
        self.local_names = local_names
        self.names: dict[str, Local] = {}
        self.ways: dict[str, bool] = {}
        """Parameters that are True or False in this copy of the function."""
        self.rows: dict[str, object] = {}
        """Of each loop over a table around, the row that its name stands for."""
        self._kinds: dict[ast.expr, ValueKind] = {}
        self.own_records = False
        """True once the function has made a record, which ends with it."""

    # -- kinds -------------------------------------------------------------------------------

    def kind_of(self, node: ast.expr) -> ValueKind:
        """Return the kind of an expression, without leaving instructions behind."""
        kind = self._kinds.get(node)
        if kind is None:
            with self.code.draft():
                kind = self._kinds[node] = self.value(node).kind
        return kind

    def common(self, node: ast.AST, parts: Sequence[ast.expr]) -> ValueKind:
        """Return the kind that holds the values of all parts."""
        kind = self.kind_of(parts[0])
        for part in parts[1:]:
            both = joined(kind, self.kind_of(part))
            if both is None:
                raise self.refusal(node, f"values of different kinds in {ast.unparse(node)}")
            kind = both
        return kind

    def number(self, node: ast.expr) -> KernelValue:
        value = self.value(node)
        if not isinstance(value.kind, Scalar):
            raise self.refusal(node, f"{ast.unparse(node)} is not a number")
        return value

    def as_real(self, node: ast.expr) -> Operand:
        return self.convert(self.number(node), REAL, node).operands[0]

    def as_int(self, node: ast.expr) -> Operand:
        return self.convert(self.number(node), INT, node).operands[0]

    # -- expressions -------------------------------------------------------------------------

    def value(self, node: ast.expr) -> KernelValue:
        """Return the value of an expression."""
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
                return self.get(self.names[node.id])
            case ast.Attribute():
                return self.read(self.field(node))
            case ast.Subscript():
                return self.item(node)
            case ast.BinOp():
                return self.arithmetic(node)
            case ast.UnaryOp():
                return self.unary(node)
            case ast.Compare() if len(node.ops) == 1:
                return KernelValue(
                    BOOL, (self.compare(node.ops[0], node.left, node.comparators[0]),)
                )
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
        """Return True and the value of a name outside the function, or False and None."""
        if isinstance(node, ast.Name):
            if node.id in self.rows:
                return True, self.rows[node.id]
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

    def constant(self, thing: object, node: ast.AST) -> KernelValue:
        match thing:
            case Enum() if not isinstance(thing, int | float):
                return self.constant(thing.value, node)
            case bool():
                return KernelValue(BOOL, (self.code.constant(BOOL.machine, thing),))
            case int() if I64.least <= thing <= I64.most:
                return KernelValue(INT, (self.code.constant(I64, int(thing)),))
            case float():
                return KernelValue(REAL, (self.code.constant(F64, thing),))
            case tuple():
                return self.several([self.constant(part, node) for part in thing])
        raise self.refusal(node, f"{thing!r} is not a number of 64 bits")

    # -- places ------------------------------------------------------------------------------

    def local(self, kind: ValueKind) -> Local:
        """Variables for a value of this kind."""
        return Local(kind, tuple(self.code.variable(each) for each in machine_types(kind)))

    def get(self, local: Local) -> KernelValue:
        return KernelValue(local.kind, tuple(self.code.get(each) for each in local.variables))

    def set(self, local: Local, value: KernelValue) -> None:
        for variable, operand in zip(local.variables, value.operands, strict=True):
            self.code.set(variable, operand)

    def read(self, place: NumberLocation | KernelValue) -> KernelValue:
        """Return the number there; records and sequences are what they are."""
        if isinstance(place, KernelValue):
            return place
        number = self.code.load(place.kind.machine, place.address, aligned=True)
        if place.kind is BYTE:
            return KernelValue(INT, (self.code.convert(number, I64),))
        return KernelValue(place.kind, (number,))

    def put(self, place: NumberLocation | KernelValue, value: KernelValue, node: ast.AST) -> None:
        """Store a number there."""
        if isinstance(place, KernelValue):
            raise self.refusal(node, "only numbers can be stored in a record")
        if place.kind is BYTE:
            (word,) = self.convert(value, INT, node).operands
            byte = self.code.convert(word, U8)
            if self.unit.checked:
                same = self.code.compare(Relation.EQUAL, self.code.convert(byte, I64), word)
                self.check((ValueError, "{0} is not a byte"), node, same, word)
            value = KernelValue(BYTE, (byte,))
        (operand,) = self.convert(value, place.kind, node).operands
        self.code.store(operand, place.address, aligned=True)

    def field(self, node: ast.Attribute) -> NumberLocation | KernelValue:
        """Return a field of a record, the record that it refers to or holds, or one of the
        tables."""
        owner = self.value(node.value)
        if isinstance(owner.kind, RowTables):
            return self._table(owner, node)
        if not isinstance(owner.kind, RecordReference):
            raise self.refusal(node, f"{ast.unparse(node.value)} is not a record")
        slot = owner.kind.layout.fields.get(node.attr)
        if slot is None:
            raise self.refusal(node, f"{owner.kind.layout.name} has no field {node.attr}")
        address = self.code.address(owner.operands[0], 8 * slot.offset)
        if slot.refers is not None:
            target = self.code.load(ADDRESS, address, aligned=True, lasting=True)
            if self.unit.checked:
                somewhere = self.code.convert(target, BOOL.machine)
                self.check((AttributeError, f"{node.attr} leads nowhere"), node, somewhere)
            return KernelValue(RecordReference(slot.refers), (target,))
        if slot.holds is not None:
            reference = RecordReference(slot.holds)
            if slot.length:
                return KernelValue(Row(reference), (address, self.code.constant(I64, slot.length)))
            return KernelValue(reference, (address,))
        kind = REAL if slot.is_real else INT
        if slot.length:
            return KernelValue(Row(kind), (address, self.code.constant(I64, slot.length)))
        return NumberLocation(kind, address)

    def _table(self, owner: KernelValue, node: ast.Attribute) -> KernelValue:
        assert isinstance(owner.kind, RowTables)
        first = 0
        for name, kind in owner.kind.rows:
            size = len(machine_types(kind))
            if name == node.attr:
                return KernelValue(kind, owner.operands[first : first + size])
            first += size
        raise self.refusal(node, f"{owner.kind.name} has no rows {node.attr}")

    def item(self, node: ast.Subscript) -> KernelValue:
        known, thing = self.static(node.value)
        if known and isinstance(thing, tuple) and not isinstance(node.slice, ast.Constant):
            kind = REAL if any(isinstance(number, float) for number in thing) else INT
            length = self.code.constant(I64, len(thing))
            return self.read(
                self.element(KernelValue(Row(kind), (self.unit.table(thing, kind), length)), node)
            )
        owner = self.value(node.value)
        if isinstance(owner.kind, Row):
            return self.read(self.element(owner, node))
        if isinstance(owner.kind, Several) and isinstance(node.slice, ast.Constant):
            index = node.slice.value
            if isinstance(index, int) and 0 <= index < len(owner.kind.kinds):
                return self.parts(owner)[index]
        raise self.refusal(node, f"no element {ast.unparse(node)}")

    def element(self, row: KernelValue, node: ast.Subscript) -> NumberLocation | KernelValue:
        """Return an element; an index below 0 counts from the end."""
        assert isinstance(row.kind, Row)
        code, of = self.code, row.kind.of
        address, length = row.operands
        index = subscript = self.as_int(node.slice)
        if not index.is_constant or index.text.startswith("-"):
            below = code.compare(Relation.LESS, index, code.constant(I64, 0))
            index = code.select(below, code.add(index, length), index)
        if self.unit.checked:
            low = code.compare(Relation.GREATER_EQUAL, index, code.constant(I64, 0))
            high = code.compare(Relation.LESS, index, length)
            self.check(_INDEX, node, code.bit_and(low, high), subscript, length)
        size = 8 * of.layout.words if isinstance(of, RecordReference) else of.machine.size
        place = code.address(address, index, size)
        return (
            KernelValue(of, (place,))
            if isinstance(of, RecordReference)
            else NumberLocation(of, place)
        )

    # -- numbers -----------------------------------------------------------------------------

    def arithmetic(self, node: ast.BinOp) -> KernelValue:
        return self.combine(node.op, self.number(node.left), self.number(node.right), node)

    def unary(self, node: ast.UnaryOp) -> KernelValue:
        if isinstance(node.op, ast.Not):
            operand = self.truth(self.value(node.operand), node)
            return KernelValue(BOOL, (self.code.bit_not(operand),))
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
            return self.constant(-node.operand.value, node)  # type: ignore[operator]
        value = self.number(node.operand)
        if value.kind is BOOL:
            value = self.convert(value, INT, node)
        if isinstance(node.op, ast.UAdd):
            return value
        if isinstance(node.op, ast.USub):
            return self.negated(value, node)
        if value.kind is REAL:
            raise self.refusal(node, "no ~ of a float")
        return KernelValue(INT, (self.code.bit_not(value.operands[0]),))

    def compare(self, op: ast.cmpop, left: ast.expr, right: ast.expr) -> Operand:
        """One comparison."""
        if isinstance(op, ast.In | ast.NotIn):
            return self.contained(left, right, isinstance(op, ast.In))
        return self.relation(op, self.number(left), self.number(right), left)

    def contained(self, left: ast.expr, right: ast.expr, inside: bool) -> Operand:
        """Return a bool that is true if a number is one of a tuple."""
        value, among = self.number(left), self.value(right)
        if not isinstance(among.kind, Several):
            raise self.refusal(right, f"{ast.unparse(right)} is not a tuple")
        contained = self.code.constant(BOOL.machine, False)
        for member in self.parts(among):
            contained = self.code.bit_or(contained, self.relation(ast.Eq(), value, member, right))
        return contained if inside else self.code.bit_not(contained)

    # -- choices -----------------------------------------------------------------------------

    def branch(self, test: ast.expr, yes: Label, no: Label) -> None:
        """Go on at `yes` if the test holds, else at `no`; evaluates no more than needed."""
        match test:
            case ast.BoolOp():
                for part in test.values[:-1]:
                    go_on = self.code.label()
                    if isinstance(test.op, ast.And):
                        self.branch(part, go_on, no)
                    else:
                        self.branch(part, yes, go_on)
                    self.code.begin(go_on)
                self.branch(test.values[-1], yes, no)
            case ast.UnaryOp(op=ast.Not()):
                self.branch(test.operand, no, yes)
            case ast.Compare() if len(test.ops) > 1:
                left = self.number(test.left)
                for n, (op, node) in enumerate(zip(test.ops, test.comparators, strict=True)):
                    right = self.number(node)
                    holds = self.relation(op, left, right, test)
                    go_on = yes if n == len(test.ops) - 1 else self.code.label()
                    self.code.branch(holds, go_on, no)
                    if go_on != yes:
                        self.code.begin(go_on)
                    left = right
            case _:
                holds = self.truth(self.value(test), test)
                self.code.branch(holds, yes, no)

    def choice(
        self, node: ast.AST, kind: ValueKind, test: ast.expr, body: ast.expr, orelse: ast.expr
    ) -> KernelValue:
        """One value or the other."""
        slot, yes, no, end = (
            self.local(kind),
            self.code.label(),
            self.code.label(),
            self.code.label(),
        )
        self.branch(test, yes, no)
        for label, branch in ((yes, body), (no, orelse)):
            self.code.begin(label)
            self.set(slot, self.convert(self.value(branch), kind, node))
            self.code.jump(end)
        self.code.begin(end)
        return self.get(slot)

    def logical(self, node: ast.BoolOp) -> KernelValue:
        """`and` and `or` as values: the operand that decides."""
        kind = self.common(node, node.values)
        slot, end = self.local(kind), self.code.label()
        for part in node.values[:-1]:
            value = self.value(part)
            self.set(slot, self.convert(value, kind, part))
            holds, go_on = self.truth(value, part), self.code.label()
            ways = (go_on, end) if isinstance(node.op, ast.And) else (end, go_on)
            self.code.branch(holds, *ways)
            self.code.begin(go_on)
        last = node.values[-1]
        self.set(slot, self.convert(self.value(last), kind, last))
        self.code.jump(end)
        self.code.begin(end)
        return self.get(slot)

    # -- calls -------------------------------------------------------------------------------

    def call(self, node: ast.Call) -> KernelValue:
        known, callee = self.static(node.func)
        if not known:
            raise self.refusal(node, f"{ast.unparse(node.func)} is not a function of a module")
        if callee in (assign, reset):
            return self.copy_record(node, callee is reset)
        if isinstance(callee, FunctionType):
            return self.call_kernel(node, callee)
        if isinstance(callee, type) and isinstance(
            layout := getattr(callee, "layout", None), RecordLayout
        ):
            return self.new_record(node, layout)
        if node.keywords or not node.args:
            raise self.refusal(node, f"arguments of {ast.unparse(node)}")
        first, count = node.args[0], len(node.args)
        if callee in LIBRARY:
            operands = map(self.as_real, node.args)
            return KernelValue(REAL, (self.library(LIBRARY[callee], node, *operands),))
        if callee in _INTRINSICS:
            operands = map(self.as_real, node.args)
            return KernelValue(REAL, (self.code.intrinsic(_INTRINSICS[callee], *operands),))
        if callee in (min, max) and count > 1:
            return self.extreme(node, ast.Lt() if callee is min else ast.Gt())
        if count != 1:
            raise self.refusal(node, f"arguments of {ast.unparse(node)}")
        if callee is len:
            row = self.value(first)
            if isinstance(row.kind, Row):
                return KernelValue(INT, (row.operands[1],))
        elif callee is math.sqrt:
            return KernelValue(REAL, (self.root(self.as_real(first), node),))
        elif callee in (math.isfinite, math.isinf, math.isnan):
            return KernelValue(BOOL, (self.classify(callee, self.as_real(first)),))
        elif callee is bool:
            return KernelValue(BOOL, (self.truth(self.value(first), first),))
        elif callee is float:
            return self.convert(self.number(first), REAL, first)
        elif callee is abs:
            return self.magnitude(self.number(first), node)
        elif callee is int or callee in _ROUNDINGS:
            number = self.number(first)
            if number.kind is not REAL:
                return self.convert(number, INT, first)
            (operand,) = number.operands
            if callee is not int:
                operand = self.code.round(operand, _ROUNDINGS[callee])
            return KernelValue(INT, (self.whole(operand, node),))
        raise self.refusal(node, f"{ast.unparse(node.func)} is not part of the kernel's language")

    def copy_record(self, node: ast.Call, resets: bool) -> KernelValue:
        """`assign` and `reset`: all values of a record at once."""
        records = [self.value(argument) for argument in node.args]
        kinds = [record.kind for record in records]
        target = kinds[0] if kinds else None
        if node.keywords or len(records) != (1 if resets else 2):
            raise self.refusal(node, f"arguments of {ast.unparse(node)}")
        if not isinstance(target, RecordReference) or any(kind != target for kind in kinds):
            raise self.refusal(node, f"{ast.unparse(node)} is not of records of one layout")
        layout = target.layout
        if not layout.is_value:
            raise self.refusal(node, f"a {layout.name} refers to other records")
        source = self.unit.fresh(layout) if resets else records[1].operands[0]
        self.code.copy(records[0].operands[0], source, layout.form.size)
        return KernelValue(NOTHING, ())

    def new_record(self, node: ast.Call, layout: RecordLayout[Any]) -> KernelValue:
        """Return a record of the function's own, with the values of a fresh one."""
        if node.args or node.keywords or not layout.is_value:
            raise self.refusal(node, f"arguments or references of {ast.unparse(node)}")
        self.own_records = True
        size = layout.form.size
        place = self.code.buffer(size)
        self.code.copy(place, self.unit.fresh(layout), size)
        return KernelValue(RecordReference(layout), (place,))

    def call_kernel(self, node: ast.Call, function: FunctionType) -> KernelValue:
        """Return a call of another function of the kernel."""
        callee = self.unit.callee(function, self._ways_of(node, function))
        arguments: dict[str, KernelValue] = {}
        for name, argument in zip(callee.names, node.args, strict=False):
            arguments[name] = self.value(argument)
        for keyword in node.keywords:
            if keyword.arg is None or keyword.arg in arguments or keyword.arg not in callee.names:
                raise self.refusal(node, f"argument {keyword.arg}")
            arguments[keyword.arg] = self.value(keyword.value)
        for name, default in callee.defaults.items():
            if name not in arguments:
                arguments[name] = self.constant(default, node)
        if len(arguments) != len(callee.names) or len(node.args) > len(callee.names):
            raise self.refusal(node, f"{function.__name__} takes {', '.join(callee.names)}")
        operands: list[Operand] = []
        for name, kind in zip(callee.names, callee.kinds, strict=True):
            operands += self.convert(arguments[name], kind, node).operands
        return KernelValue(callee.result, self.code.call(callee.machine, *operands))

    def _ways_of(self, node: ast.Call, function: FunctionType) -> Ways:
        """Return the parameters that the call gives as True or False, or by one that is given so
        here."""
        names = function.__code__.co_varnames
        written = [*zip(names, node.args, strict=False), *((k.arg, k.value) for k in node.keywords)]
        ways = {}
        for name, argument in written:
            if isinstance(argument, ast.Name):
                constant: object = self.ways.get(argument.id)
            else:
                constant = argument.value if isinstance(argument, ast.Constant) else None
            if name and isinstance(constant, bool):
                ways[name] = constant
        return tuple(sorted(ways.items()))

    def extreme(self, node: ast.Call, op: ast.cmpop) -> KernelValue:
        """`min` and `max`: a later number only if it is really beyond."""
        kind = self.common(node, node.args)
        best = self.convert(self.number(node.args[0]), kind, node)
        for argument in node.args[1:]:
            other = self.convert(self.number(argument), kind, node)
            beyond = self.relation(op, other, best, node)
            best = KernelValue(
                kind, (self.code.select(beyond, other.operands[0], best.operands[0]),)
            )
        return best
