"""Calls: which routine is called, and what goes into which parameter."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import AliasType, ReferenceType, resolved
from achse.iec.elementary import BOOL, DINT
from achse.iec.strings import StringType
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.iec.variables import Section
from achse.st.check.anytype import any_record
from achse.st.check.kinds import is_one_type_twice, same_shape
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
from achse.st.check.operands import TypedOperand, followed_value, read
from achse.st.check.parameter_places import place_beside, place_of, place_of_variable
from achse.st.check.signatures import (
    DeclaredParameter,
    Signature,
    by_position,
    parameters_by_name,
)
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Argument, Call, Expression
from achse.st.syntax.units import FunctionBlock, Program
from achse.st.typed.expressions import (
    DirectTarget,
    Invocation,
    Known,
    Read,
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
from achse.st.typed.statements import Do, TypedStatement

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

__all__ = ["CallChecker", "is_any"]

_ANY = ("any", "any_bit", "any_date", "any_int", "any_num", "any_real", "any_string")
_SECTIONS = {
    Section.INPUT: "VAR_INPUT",
    Section.OUTPUT: "VAR_OUTPUT",
    Section.IN_OUT: "VAR_IN_OUT",
}


def is_any(type: IecType[Any]) -> bool:
    """Return True if a parameter accepts arguments of any type (or of any of a kind)."""
    return isinstance(type, AliasType) and type.name.lower().removeprefix("__system.") in _ANY


class CallChecker:
    """Binds the calls of one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body
        self.after: list[TypedStatement] = []
        """Statements that follow the statement being checked: SETs of `=> property`."""

    def call(self, tree: Call) -> TypedOperand:
        """`of(arguments)`. Raises `Unexpected` and `Failed`."""
        body = self._body
        found = body.expressions.callee(tree.of)
        at = tree.at or tree.of.at
        match found:
            case BuiltinName(name):
                return body.builtins.call(name, tree.arguments, tree.of.at)
            case Callee():
                return self.invoke(found, tree.arguments, tree.of.at)
            case UnitName():
                return self.program(found, tree.arguments, tree.of.at)
            case BaseInstance(entry):
                signature = body.checking.routines.of_body(entry)
                address = body.names.this_address(at)
                callee = Callee(signature, address, True, at)
                return self.invoke(callee, tree.arguments, tree.of.at)
            case TypedOperand():
                return self.block(found, tree.arguments, tree.of.at)
            case PropertyUse():
                return self.block(self.read_property(found), tree.arguments, tree.of.at)
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

    def statement(self, found: Meaning, at: int) -> TypedOperand:
        """A call without parentheses that stands alone: of an action, program or instance."""
        match found:
            case Callee():
                return self.invoke(found, (), at)
            case UnitName(entry=entry) if entry is not None and isinstance(entry.tree, Program):
                return self.program(found, (), at)
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
        """A function, method, action or body with arguments as written."""
        signature = callee.signature
        parameters = signature.parameters
        base = None if isinstance(signature.entry.tree, Program) else CalleeBase()
        if signature.kind in (RoutineKind.FUNCTION, RoutineKind.METHOD):
            base = CalleeBase()
        if signature.kind is RoutineKind.ACTION and arguments:
            # An action takes the parameters of its block, and leaves in them what it leaves out.
            owner = self._body.checking.routines.of_body(signature.entry)
            parameters = owner.parameters
        inputs, outputs = self.bound(signature, parameters, base, arguments, at)
        return self._invocation(callee, inputs, outputs, at)

    def invoke_values(self, callee: Callee, values: Sequence[TypedValue], at: int) -> TypedValue:
        """A function with values that fit its first parameters."""
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
        """A call of a function that gives nothing, where a value is needed: a BOOL, FALSE."""
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
        """A function block instance."""
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
        """A block of which only the variables are known: a Python class may be its body."""
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
        inputs, outputs = self.bound(None, parameters, CalleeBase(), arguments, at)
        key = type.name.lower()
        value = Invocation(DirectTarget(key), address, inputs, outputs, None, None, at)
        return TypedOperand(value, _NOTHING)

    def program(self, unit: UnitName, arguments: Sequence[Argument], at: int) -> TypedOperand:
        """A program that another calls."""
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
        """The value of a property: its GET is called."""
        signature = self._body.checking.routines.of_accessor(use.entry, use.tree, get=True)
        if signature is None:
            raise Unexpected(
                use.at,
                f"property {use.tree.name} has no GET: it cannot be read",
                Code.PROPERTY_ACCESS,
            )
        callee = Callee(signature, use.instance, use.is_exact, use.at)
        return self._invocation(callee, (), (), use.at)

    def write_property(self, use: PropertyUse, operand: TypedOperand, at: int) -> TypedValue:
        """An assignment to a property: its SET is called."""
        routines = self._body.checking.routines
        signature = routines.of_accessor(use.entry, use.tree, get=False)
        if signature is None:
            raise Unexpected(
                use.at,
                f"property {use.tree.name} has no SET: it cannot be written",
                Code.PROPERTY_ACCESS,
            )
        parameter = signature.parameters[0]
        stored = next(self._input(parameter, place_of(parameter, at), operand, at))
        callee = Callee(signature, use.instance, use.is_exact, use.at)
        return self._invocation(callee, (stored,), (), at).value

    def has_set(self, use: PropertyUse) -> bool:
        """Return True if a property can be written."""
        return use.tree.set is not None

    # arguments -------------------------------------------------------------------------------

    def bound(
        self,
        signature: Signature | None,
        parameters: Sequence[DeclaredParameter],
        base: CalleeBase | None,
        arguments: Sequence[Argument],
        at: int,
    ) -> tuple[tuple[Stored, ...], tuple[Stored, ...]]:
        """Arguments as stores into parameters, and outputs as stores from them."""
        if signature is not None and parameters is signature.parameters:
            by_name = signature.by_name
        else:
            by_name = parameters_by_name(parameters)
        in_order: Sequence[DeclaredParameter] | None = None
        unit = signature.entry.name if base is None and signature is not None else ""
        expressions, converter = self._body.expressions, self._body.converter
        inputs: list[Stored] = []
        outputs: list[Stored] = []
        given: set[str] = set()
        for position, argument in enumerate(arguments):
            key = argument.name.lower()
            if key:
                parameter = by_name.get(key)
                if parameter is None:
                    raise self._no_parameter(signature, argument, parameters)
            else:
                if in_order is None:
                    in_order = by_position(signature, parameters)
                if position >= len(in_order):
                    count = len(in_order)
                    name = "the call" if signature is None else signature.name
                    raise Unexpected(
                        argument.at or at,
                        f"{name} takes {count} arguments, got more",
                        Code.ARGUMENT_COUNT,
                    )
                parameter = in_order[position]
                key = parameter.variable.name.lower()
            if argument.name and signature is not None:
                self._body.note_use(argument, signature, None)
            if key in given:
                if not (argument.name and arguments[0].name):
                    raise Unexpected(
                        argument.at,
                        f"{parameter.variable.name} is given twice",
                        Code.DUPLICATE_ARGUMENT,
                    )
                self._body.warn(
                    argument.at,
                    f"{parameter.variable.name} is given twice",
                    Code.DUPLICATE_ARGUMENT,
                )
                name = parameter.variable.name
                inputs = [item for item in inputs if item.storage.name != name]
            given.add(key)
            if argument.value is None:
                continue
            place = place_of(parameter, argument.at, unit)
            is_output = parameter.section == "VAR_OUTPUT"
            if is_output or argument.is_output:
                outputs.append(self._output(parameter, place, argument.value))
                continue
            operand = expressions.operand(argument.value)
            value_at = argument.value.at
            if _is_plain(parameter):
                value = converter.implicit(operand, parameter.variable.type, value_at)
                inputs.append(Stored(place, value, place.type, value_at))
            else:
                inputs += self._input(parameter, place, operand, value_at)
        if len(given) < len(by_name):
            self._check_missing(signature, by_name, given, at)
        return tuple(inputs), tuple(outputs)

    def _no_parameter(
        self,
        signature: Signature | None,
        argument: Argument,
        parameters: Sequence[DeclaredParameter],
    ) -> Unexpected:
        name = "the block" if signature is None else signature.name
        known = ", ".join(item.variable.name for item in parameters[:12]) or "none"
        return Unexpected(
            argument.at,
            f"{name} has no parameter '{argument.name[:80]}'; it has {known}",
            Code.UNKNOWN_PARAMETER,
        )

    def _check_missing(
        self,
        signature: Signature | None,
        by_name: Mapping[str, DeclaredParameter],
        given: set[str],
        at: int,
    ) -> None:
        if signature is None or signature.kind in (
            RoutineKind.PROGRAM,
            RoutineKind.ACTION,
        ):
            return
        for key, parameter in by_name.items():
            if key in given:
                continue
            name = parameter.variable.name
            if parameter.section == "VAR_IN_OUT":
                self._body.missing_in_out(signature, name, at)
            elif parameter.section == "VAR_INPUT" and not parameter.has_initial:
                self._body.warn(
                    at, f"{signature.name} is called without {name}", Code.MISSING_INPUT
                )

    def _input(
        self, parameter: DeclaredParameter, place: Storage, operand: TypedOperand, at: int
    ) -> Iterator[Stored]:
        """One argument; an ARRAY [*] takes its bounds along."""
        body = self._body
        declared = parameter.variable.type
        if parameter.section == "VAR_IN_OUT":
            yield from self._in_out(parameter, place, operand, at)
            return
        real = resolved(declared)
        if isinstance(real, ReferenceType):
            if operand.is_constant and operand.constant == 0:
                value: TypedValue = Known(0, real, at)
            else:
                value = body.paths.address(operand, real, at)
        elif is_any(declared) and not is_any(operand.type):
            value = any_record(body, operand, flat(declared), at)
        else:
            value = body.converter.implicit(operand, declared, at)
        yield Stored(place, value, place.type, at)

    def _in_out(
        self, parameter: DeclaredParameter, place: Storage, operand: TypedOperand, at: int
    ) -> Iterator[Stored]:
        body = self._body
        storage = operand.storage
        name = parameter.variable.name
        if not parameter.is_constant:
            if storage is None:
                raise Unexpected(
                    at,
                    f"{name} is a VAR_IN_OUT: it takes a variable, got a value",
                    Code.IN_OUT_ARGUMENT,
                )
            if storage.is_constant:
                body.warn(
                    at,
                    f"{name} is a VAR_IN_OUT and gets a constant, which it may change",
                    Code.IN_OUT_TYPE,
                )
            if storage.bit is not None:
                raise Unexpected(
                    at, f"{name} is a VAR_IN_OUT: a bit has no address", Code.IN_OUT_ARGUMENT
                )
        wanted = parameter.type
        if parameter.bounds:
            yield from self._open_array(parameter, place, operand, at)
            return
        if is_any(wanted) and not is_any(operand.type):
            record = any_record(body, operand, flat(wanted), at)
            operand = TypedOperand(record, wanted)
        elif storage is None or (parameter.is_constant and operand.is_constant):
            value = body.converter.implicit(operand, wanted, at)
            operand = TypedOperand(value, wanted)
        else:
            self._check_in_out(name, wanted, operand, at)
        address = body.paths.address(operand, resolved(parameter.variable.type), at)
        yield Stored(place, address, place.type, at)

    def _check_in_out(
        self, name: str, wanted: IecType[Any], operand: TypedOperand, at: int
    ) -> None:
        have, want = operand.flat, flat(wanted)
        if same_shape(have, want):
            return
        if isinstance(have, StringType) and isinstance(want, StringType) and have.unit == want.unit:
            if have.length < want.length:
                self._body.warn(
                    at, f"{name} is a {want.name}: a {have.name} is shorter", Code.IN_OUT_TYPE
                )
            return
        if is_one_type_twice(operand.type, wanted):
            return
        if have.size == want.size and not isinstance(have, StructType | ArrayType):
            self._body.warn(
                at, f"{name} is a {wanted.name}, got a {operand.type.name}", Code.IN_OUT_TYPE
            )
            return
        raise Unexpected(
            at,
            f"{name} is a VAR_IN_OUT {wanted.name}, got a {operand.type.name}",
            Code.IN_OUT_ARGUMENT,
        )

    def _open_array(
        self, parameter: DeclaredParameter, place: Storage, operand: TypedOperand, at: int
    ) -> Iterator[Stored]:
        """The address of the first element, and the bounds."""
        body = self._body
        count = len(parameter.bounds) // 2
        name = parameter.variable.name
        type = operand.flat
        values: tuple[TypedValue, ...]
        if operand.bounds:
            values = operand.bounds
        elif isinstance(type, ArrayType):
            values = tuple(
                Known(number, DINT, at) for bounds in type.dimensions for number in bounds
            )
        else:
            raise Unexpected(
                at, f"{name} takes an array, got a {operand.type.name}", Code.ARGUMENT_TYPE
            )
        if len(values) != len(parameter.bounds):
            raise Unexpected(at, f"{name} takes an array of {count} dimensions", Code.BAD_INDEX)
        element = type.element if isinstance(type, ArrayType) else operand.type
        if not same_shape(flat(element), flat(parameter.type)):
            wanted = parameter.type.name
            raise Unexpected(
                at,
                f"{name} takes an array of {wanted}, got one of {element.name}",
                Code.ARGUMENT_TYPE,
            )
        address = body.paths.address(operand, resolved(parameter.variable.type), at)
        yield Stored(place, address, place.type, at)
        for variable, value in zip(parameter.bounds, values, strict=True):
            bound = place_beside(place, variable)
            yield Stored(bound, value, DINT, at)

    def _output(self, parameter: DeclaredParameter, place: Storage, target: Expression) -> Stored:
        """`nOut => x`: read after the call."""
        body = self._body
        at = target.at
        meaning = body.expressions.meaning(target)
        if isinstance(meaning, PropertyUse) and self.has_set(meaning):
            return self._output_to_property(parameter, place, meaning, at)
        into = body.expressions.as_operand(meaning, at)
        if into.storage is None:
            raise Unexpected(
                at, f"{parameter.variable.name} => takes a variable", Code.OUTPUT_TARGET
            )
        body.check_writable(into, at)
        found = read(place, parameter.variable.type, at)
        value = body.converter.implicit(found, into.type, at)
        return Stored(into.storage, value, into.storage.type, at)

    def _output_to_property(
        self, parameter: DeclaredParameter, place: Storage, use: PropertyUse, at: int
    ) -> Stored:
        """`nOut => Property`: kept after the call, and set behind the statement."""
        frame = self._body.frame
        type = flat(parameter.variable.type)
        kept = frame.storage(frame.temporary(type), at)
        operand = TypedOperand(Read(kept, type, at), parameter.variable.type, kept)
        self.after.append(Do(self.write_property(use, operand, at), at))
        return Stored(kept, Read(place, type, at), type, at)


def _table_name(signature: Signature) -> str:
    """The name of a routine in the table of its block."""
    if signature.kind is RoutineKind.BODY:
        return ""
    return signature.key.rpartition(".")[2]


def _is_plain(parameter: DeclaredParameter) -> bool:
    """Return True if an argument is converted and stored, and nothing besides."""
    if parameter.is_plain is None:
        type = parameter.variable.type
        is_reference = isinstance(resolved(type), ReferenceType)
        parameter.is_plain = not (is_reference or is_any(type) or parameter.section == "VAR_IN_OUT")
    return parameter.is_plain


def _target_of(type: IecType[Any]) -> IecType[Any]:
    real = resolved(type)
    return real.target if isinstance(real, ReferenceType) else type


_NOTHING: IecType[Any] = IecType("nothing", 0, 1, 0)
