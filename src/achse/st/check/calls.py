"""Calls: which routine, block or property is called."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from achse.iec.derived import ReferenceType, resolved
from achse.iec.elementary import BOOL
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Section
from achse.st.check.meanings import (
    BaseInstance,
    BuiltinName,
    Callee,
    Meaning,
    PropertyUse,
    SpaceName,
    TypeName,
    UnitName,
)
from achse.st.check.operands import TypedOperand, followed_value
from achse.st.check.parameter_places import place_of, place_of_variable
from achse.st.check.signatures import (
    DeclaredParameter,
    Signature,
)
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Argument, Call
from achse.st.syntax.units import FunctionBlock, Program
from achse.st.typed.expressions import (
    DirectTarget,
    Invocation,
    Stored,
    TableTarget,
    TypedValue,
)
from achse.st.typed.places import (
    CalleeBase,
    Storage,
    flat,
)
from achse.st.typed.project import RoutineKind
from achse.st.typed.statements import TypedStatement

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_SECTIONS = {
    Section.INPUT: "VAR_INPUT",
    Section.OUTPUT: "VAR_OUTPUT",
    Section.IN_OUT: "VAR_IN_OUT",
}


class CallChecker:
    """Binds the calls of one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body
        self.after: list[TypedStatement] = []
        """Statements that follow the statement being checked: SETs of `=> property`."""

    def call(self, tree: Call) -> TypedOperand:
        """`of(arguments)`. Raises `Unexpected` and `Failed`."""
        body = self._body
        target = body.expressions.callee(tree.of)
        at = tree.at or tree.of.at
        match target:
            case BuiltinName(name):
                return body.builtins.call(name, tree.arguments, tree.of.at)
            case Callee():
                return self.invoke(target, tree.arguments, tree.of.at)
            case UnitName():
                return self.program(target, tree.arguments, tree.of.at)
            case BaseInstance(entry):
                signature = body.checking.routines.of_body(entry)
                address = body.names.this_address(at)
                callee = Callee(signature, address, True, at)
                return self.invoke(callee, tree.arguments, tree.of.at)
            case TypedOperand():
                return self.block(target, tree.arguments, tree.of.at)
            case PropertyUse():
                return self.block(self.read_property(target), tree.arguments, tree.of.at)
            case TypeName(name=name):
                raise Unexpected(
                    tree.of.at, f"{name} is a type and cannot be called", Code.NOT_CALLABLE
                )
            case SpaceName(name, place):
                raise self._unknown(name, place)

    def _unknown(self, name: str, at: int) -> Unexpected:
        last = name.rpartition(".")[2]
        fault = self._body.names.unknown(last, at)
        near = fault.message.partition(";")[2]
        near = f";{near}" if near else ""
        return Unexpected(
            at, f"no function or instance is named '{name[:80]}'{near}", Code.UNKNOWN_CALL
        )

    def statement(self, meaning: Meaning, at: int) -> TypedOperand:
        """Return a call without parentheses that stands alone: of an action, program or
        instance."""
        match meaning:
            case Callee():
                return self.invoke(meaning, (), at)
            case UnitName(entry=entry) if entry is not None and isinstance(entry.tree, Program):
                return self.program(meaning, (), at)
            case BuiltinName(name):
                return self._body.builtins.call(name, (), at)
            case BaseInstance():
                raise Unexpected(
                    at, "SUPER^ is called with parentheses: SUPER^()", Code.NOT_CALLABLE
                )
            case SpaceName(name, place):
                raise self._unknown(name, place)
            case TypedOperand():
                raise Unexpected(
                    at, "expected an assignment or a call, got a value", Code.NOT_A_STATEMENT
                )
            case _:
                raise Unexpected(at, "expected an assignment or a call", Code.NOT_A_STATEMENT)

    # routines --------------------------------------------------------------------------------

    def invoke(self, callee: Callee, arguments: Sequence[Argument], at: int) -> TypedOperand:
        """Return a function, method, action or body with arguments as written."""
        signature = callee.signature
        parameters = signature.parameters
        base = None if isinstance(signature.entry.tree, Program) else CalleeBase()
        if signature.kind in (RoutineKind.FUNCTION, RoutineKind.METHOD):
            base = CalleeBase()
        if signature.kind is RoutineKind.ACTION and arguments:
            # An action takes the parameters of its block, and leaves in them what it leaves out.
            owner = self._body.checking.routines.of_body(signature.entry)
            parameters = owner.parameters
        inputs, outputs = self._body.arguments.bound(signature, parameters, base, arguments, at)
        return self._invocation(callee, inputs, outputs, at)

    def invoke_values(self, callee: Callee, values: Sequence[TypedValue], at: int) -> TypedValue:
        """Return a function with values that fit its first parameters."""
        inputs = tuple(
            Stored(place_of(parameter, at), value, flat(parameter.variable.type), at)
            for parameter, value in zip(callee.signature.parameters, values, strict=False)
        )
        return self._invocation(callee, inputs, (), at).value

    def _invocation(
        self, callee: Callee, inputs: tuple[Stored, ...], outputs: tuple[Stored, ...], at: int
    ) -> TypedOperand:
        signature = callee.signature
        checking = self._body.checking
        checking.require(signature)
        if callee.is_exact and signature.is_abstract and signature.kind is not RoutineKind.BODY:
            raise Unexpected(
                at, f"{signature.name} is abstract: it has no body to call", Code.ABSTRACT_CALL
            )
        name = _table_name(signature)
        instance = callee.instance
        if instance is None or callee.is_exact:
            target: DirectTarget | TableTarget = DirectTarget(signature.key)
        else:
            target = TableTarget(name, signature.key)
        result = signature.result
        if result is None:
            value = Invocation(target, instance, inputs, outputs, None, None, at)
            return TypedOperand(value, _NOTHING)
        type = flat(result.type)
        place = Storage(CalleeBase(), result.offset, type, name=result.name, at=at)
        value = Invocation(target, instance, inputs, outputs, place, type, at)
        real = resolved(result.type)
        if isinstance(real, ReferenceType):
            return followed_value(value, real, at)
        return TypedOperand(value, result.type)

    def valued(self, operand: TypedOperand, at: int) -> TypedOperand:
        """Return a call of a function that gives nothing, where a value is needed: a BOOL,
        FALSE."""
        call = operand.value
        signature = None
        if isinstance(call, Invocation) and isinstance(call.target, DirectTarget):
            signature = self._body.checking.routines.known(call.target.routine)
        if signature is None or signature.kind not in (RoutineKind.FUNCTION, RoutineKind.METHOD):
            raise Unexpected(at, "this call gives no value", Code.NOT_A_VALUE)
        assert isinstance(call, Invocation)
        self._body.warn(at, f"{signature.name} gives no value: FALSE is taken", Code.NO_RESULT)
        if signature.nothing is None:
            signature.nothing = signature.frame.hidden("__nothing", BOOL)
        result = place_of_variable(signature.nothing, at)
        return TypedOperand(replace(call, result=result, type=BOOL), BOOL)

    def block(self, operand: TypedOperand, arguments: Sequence[Argument], at: int) -> TypedOperand:
        """Return a function block instance."""
        type = operand.flat
        if not isinstance(type, StructType) or type.kind is not RecordKind.FUNCTION_BLOCK:
            raise Unexpected(at, f"a {operand.type.name} cannot be called", Code.NOT_CALLABLE)
        body = self._body
        entry = body.checking.names.entry_of(type)
        storage = body.paths.storage(operand, at)
        address = body.paths.address(operand, body.checking.pointer_to(type), at)
        is_exact = body.paths.is_exact(storage)
        if entry is None:
            return self._block_without_source(type, address, arguments, at)
        tree = entry.tree
        assert isinstance(tree, FunctionBlock)
        if "no_explicit_call" in {name.lower() for name, _ in tree.note.attributes}:
            raise Unexpected(at, f"{entry.name} is not called: its methods are", Code.NOT_CALLABLE)
        signature = body.checking.routines.of_body(entry)
        return self.invoke(Callee(signature, address, is_exact, at), arguments, at)

    def _block_without_source(
        self, type: StructType[Any], address: TypedValue, arguments: Sequence[Argument], at: int
    ) -> TypedOperand:
        """Return a block of which only the variables are known: a Python class may be its body."""
        parameters = [
            DeclaredParameter(
                member,
                _SECTIONS[member.section],
                _target_of(member.type) if member.section is Section.IN_OUT else member.type,
                has_initial=True,
            )
            for member in type.members
            if member.section in _SECTIONS
        ]
        self._body.checking.without_source(type.name)
        if self._body.checking.names.blocks_do_nothing:
            text = f"no source of {type.name} is here: its calls do nothing"
            self._body.warn(at, text, Code.SOURCE_MISSING)
        inputs, outputs = self._body.arguments.bound(None, parameters, CalleeBase(), arguments, at)
        key = type.name.lower()
        value = Invocation(DirectTarget(key), address, inputs, outputs, None, None, at)
        return TypedOperand(value, _NOTHING)

    def program(self, unit: UnitName, arguments: Sequence[Argument], at: int) -> TypedOperand:
        """Return a program that another calls."""
        entry = unit.entry
        if entry is None or not isinstance(entry.tree, Program):
            raise Unexpected(
                at, f"{unit.name} is a list of variables and cannot be called", Code.NOT_CALLABLE
            )
        signature = self._body.checking.routines.of_body(entry)
        self._body.checking.unit(entry, at)
        return self.invoke(Callee(signature, None, True, at), arguments, at)

    # properties ------------------------------------------------------------------------------

    def read_property(self, use: PropertyUse) -> TypedOperand:
        """Read a property by a call of its GET."""
        signature = self._accessor(use, get=True)
        if signature is None:
            raise Unexpected(
                use.at,
                f"property {use.tree.name} has no GET: it cannot be read",
                Code.PROPERTY_ACCESS,
            )
        callee = Callee(signature, use.instance, use.is_exact, use.at)
        return self._invocation(callee, (), (), use.at)

    def write_property(self, use: PropertyUse, operand: TypedOperand, at: int) -> TypedValue:
        """Write a property by a call of its SET."""
        signature = self._accessor(use, get=False)
        if signature is None:
            raise Unexpected(
                use.at,
                f"property {use.tree.name} has no SET: it cannot be written",
                Code.PROPERTY_ACCESS,
            )
        parameter = signature.parameters[0]
        stored = next(self._body.arguments.input(parameter, place_of(parameter, at), operand, at))
        callee = Callee(signature, use.instance, use.is_exact, use.at)
        return self._invocation(callee, (stored,), (), at).value

    def has_set(self, use: PropertyUse) -> bool:
        """Return True if a property can be written."""
        blocks = self._body.checking.blocks
        return blocks.accessor(use.entry, use.tree, get=False)[1].set is not None

    def _accessor(self, use: PropertyUse, *, get: bool) -> Signature | None:
        checking = self._body.checking
        entry, tree = checking.blocks.accessor(use.entry, use.tree, get=get)
        return checking.routines.of_accessor(entry, tree, get=get)


def _table_name(signature: Signature) -> str:
    """Return the name of a routine in the table of its block."""
    if signature.kind is RoutineKind.BODY:
        return ""
    return signature.key.rpartition(".")[2]


def _target_of(type: IecType[Any]) -> IecType[Any]:
    real = resolved(type)
    return real.target if isinstance(real, ReferenceType) else type


_NOTHING: IecType[Any] = IecType("nothing", 0, 1, 0)
