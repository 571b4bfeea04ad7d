"""Arguments of a call: what goes into which parameter, and what comes out of it."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import AliasType, ReferenceType, resolved
from achse.iec.elementary import DINT
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.st.check.anytype import any_record
from achse.st.check.kinds import is_one_type_twice, same_shape
from achse.st.check.meanings import (
    PropertyUse,
)
from achse.st.check.operands import TypedOperand, read
from achse.st.check.parameter_places import place_beside, place_of, place_of_variable
from achse.st.check.signatures import (
    DeclaredParameter,
    Signature,
    by_position,
    parameters_by_name,
)
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Argument, Expression
from achse.st.typed.expressions import (
    Known,
    Read,
    Stored,
    TypedValue,
)
from achse.st.typed.places import (
    CalleeBase,
    Storage,
    flat,
)
from achse.st.typed.project import RoutineKind
from achse.st.typed.statements import Do

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_ANY = ("any", "any_bit", "any_date", "any_int", "any_num", "any_real", "any_string")


class ArgumentBinder:
    """Binds the arguments of the calls of one routine."""

    def __init__(self, body: "RoutineBody") -> None:
        self._body = body

    def bound(
        self,
        signature: Signature | None,
        parameters: Sequence[DeclaredParameter],
        base: CalleeBase | None,
        arguments: Sequence[Argument],
        at: int,
    ) -> tuple[tuple[Stored, ...], tuple[Stored, ...]]:
        """ArgumentBinder as stores into parameters, and outputs as stores from them."""
        if signature is not None and parameters is signature.parameters:
            by_name = signature.by_name
        else:
            by_name = parameters_by_name(parameters)
        in_order: Sequence[DeclaredParameter] | None = None
        unit = signature.entry.name if base is None and signature is not None else ""
        expressions, converter = self._body.expressions, self._body.converter
        inputs: list[Stored] = []
        outputs: list[Stored] = []
        assigned: set[str] = set()
        for position, argument in enumerate(arguments):
            key = argument.name.lower()
            if key:
                parameter = by_name.get(key)
                if parameter is None:
                    result = None if signature is None else signature.result
                    if result is None or not argument.is_output or result.name.lower() != key:
                        raise self._no_parameter(signature, argument, parameters)
                    if argument.value is not None:  # `F(a := x, F => y)` stores the result.
                        place = place_of_variable(result, argument.at)
                        outputs.append(self._output(result, place, argument.value))
                    continue
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
            if key in assigned:
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
            assigned.add(key)
            if argument.value is None:
                continue
            place = place_of(parameter, argument.at, unit)
            is_output = parameter.section == "VAR_OUTPUT"
            if is_output or argument.is_output:
                outputs.append(self._output(parameter.variable, place, argument.value))
                continue
            operand = expressions.operand(argument.value)
            value_at = argument.value.at
            if _is_plain(parameter):
                value = converter.implicit(operand, parameter.variable.type, value_at)
                inputs.append(Stored(place, value, place.type, value_at))
            else:
                inputs += self.input(parameter, place, operand, value_at)
        if len(assigned) < len(by_name):
            self._check_missing(signature, by_name, assigned, at)
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
        assigned: set[str],
        at: int,
    ) -> None:
        if signature is None or signature.kind in (
            RoutineKind.PROGRAM,
            RoutineKind.ACTION,
        ):
            return
        for key, parameter in by_name.items():
            if key in assigned:
                continue
            name = parameter.variable.name
            if parameter.section == "VAR_IN_OUT":
                self._body.missing_in_out(signature, name, at)
            elif parameter.section == "VAR_INPUT" and not parameter.has_initial:
                self._body.warn(
                    at, f"{signature.name} is called without {name}", Code.MISSING_INPUT
                )

    def input(
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
        elif _is_any(declared) and not _is_any(operand.type):
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
        if _is_any(wanted) and not _is_any(operand.type):
            record = any_record(body, operand, flat(wanted), at)
            operand = TypedOperand(record, wanted)
        elif storage is None or (parameter.is_constant and operand.is_constant):
            text = _whole_text(operand, wanted)
            value = body.converter.implicit(operand, text, at)
            operand = TypedOperand(value, text)
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
        """Return the address of the first element, and the bounds."""
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

    def _output(self, variable: Variable[Any, Any], place: Storage, target: Expression) -> Stored:
        """`nOut => x`: read after the call."""
        body = self._body
        at = target.at
        meaning = body.expressions.meaning(target)
        if isinstance(meaning, PropertyUse) and body.calls.has_set(meaning):
            return self._output_to_property(variable, place, meaning, at)
        into = body.expressions.as_operand(meaning, at)
        if into.storage is None:
            raise Unexpected(at, f"{variable.name} => takes a variable", Code.OUTPUT_TARGET)
        body.check_writable(into, at)
        output = read(place, variable.type, at)
        value = body.converter.implicit(output, into.type, at)
        return Stored(into.storage, value, into.storage.type, at)

    def _output_to_property(
        self, variable: Variable[Any, Any], place: Storage, use: PropertyUse, at: int
    ) -> Stored:
        """`nOut => Property`: kept after the call, and set behind the statement."""
        frame, calls = self._body.frame, self._body.calls
        type = flat(variable.type)
        temporary = frame.storage(frame.temporary(type), at)
        operand = TypedOperand(Read(temporary, type, at), variable.type, temporary)
        calls.after.append(Do(calls.write_property(use, operand, at), at))
        return Stored(temporary, Read(place, type, at), type, at)


def _is_any(type: IecType[Any]) -> bool:
    """Return True if a parameter accepts arguments of any type (or of any of a kind)."""
    return isinstance(type, AliasType) and type.name.lower().removeprefix("__system.") in _ANY


def _is_plain(parameter: DeclaredParameter) -> bool:
    """Return True if an argument is converted and stored, and nothing besides."""
    if parameter.is_plain is None:
        type = parameter.variable.type
        is_reference = isinstance(resolved(type), ReferenceType)
        parameter.is_plain = not (
            is_reference or _is_any(type) or parameter.section == "VAR_IN_OUT"
        )
    return parameter.is_plain


def _whole_text(operand: TypedOperand, wanted: IecType[Any]) -> IecType[Any]:
    """Return the type that a value behind VAR_IN_OUT CONSTANT has: a text is not cut."""
    have, want = operand.flat, flat(wanted)
    if not (isinstance(have, StringType) and isinstance(want, StringType)):
        return wanted
    is_longer = have.unit == want.unit and have.length > want.length
    return have if is_longer else wanted
