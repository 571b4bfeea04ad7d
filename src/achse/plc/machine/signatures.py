"""Signatures of routines in machine code, and the block of words that Python calls them with.

A scalar is a value in a register, a text two (where it is, how many bytes), a record or array one.
The result, if it is a scalar, is a result; a text or record is written where the caller says, and
of a text the length is the result. Outputs are written where the caller says: a scalar into 8
bytes, a text into its own bytes and 8 for the length.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Any

from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.native.backend import ADDRESS, I64, U64, MachineType
from achse.plc.lowering.calls import WITH_PARAMETERS, outputs_of, parameters_of
from achse.plc.machine.values import is_packed, machine_type
from achse.st.typed.places import flat
from achse.st.typed.project import Routine


class PartKind(Enum):
    """Form in which a value is passed."""

    NUMBER = "number"
    TEXT = "text"
    PACKED = "packed"


@dataclass(frozen=True, slots=True)
class SignaturePart:
    """A parameter, result or output."""

    name: str
    type: IecType[Any]
    """Flat."""
    offset: int
    """Offset in the frame."""

    @property
    def kind(self) -> PartKind:
        if isinstance(self.type, StringType):
            return PartKind.TEXT
        return PartKind.PACKED if is_packed(self.type) else PartKind.NUMBER

    @property
    def room(self) -> int:
        """Bytes of a text without its NUL, or of a record."""
        if isinstance(self.type, StringType):
            return self.type.length * self.type.unit
        return self.type.size


@dataclass(frozen=True, slots=True)
class RoutineSignature:
    """Parameters and results of a routine."""

    has_instance: bool
    inputs: tuple[SignaturePart, ...]
    result: SignaturePart | None
    outputs: tuple[SignaturePart, ...]

    @property
    def is_simple(self) -> bool:
        """True if the instance is the only parameter, and nothing is returned."""
        return not self.inputs and self.result is None and not self.outputs

    @property
    def parameters(self) -> list[MachineType]:
        """Parameters of the machine function."""
        types: list[MachineType] = [U64] if self.has_instance else []
        for part in self.inputs:
            match part.kind:
                case PartKind.NUMBER:
                    types.append(machine_type(part.type))
                case PartKind.TEXT:
                    types += [ADDRESS, I64]
                case PartKind.PACKED:
                    types.append(ADDRESS)
        if self.result is not None and self.result.kind is not PartKind.NUMBER:
            types.append(ADDRESS)
        for part in self.outputs:
            types += [ADDRESS, ADDRESS] if part.kind is PartKind.TEXT else [ADDRESS]
        return types

    @property
    def results(self) -> list[MachineType]:
        """Results of the machine function."""
        if self.result is None or self.result.kind is PartKind.PACKED:
            return []
        return [I64 if self.result.kind is PartKind.TEXT else machine_type(self.result.type)]

    @property
    def like(self) -> tuple[object, ...]:
        """Equal for routines that can stand for each other in a table."""
        rooms = [part.room for part in (*self.outputs, *([self.result] if self.result else []))]
        return (tuple(self.parameters), tuple(self.results), tuple(rooms))


def signature_of(routine: Routine, *, dispatched: bool = False) -> RoutineSignature:
    """Return the signature of a routine; of what is called through a table always with an
    instance."""
    has_instance = dispatched or routine.this is not None
    if routine.kind not in WITH_PARAMETERS:
        return RoutineSignature(has_instance, (), None, ())

    def parts(variables: list[Any]) -> tuple[SignaturePart, ...]:
        return tuple(SignaturePart(one.name, flat(one.type), one.offset) for one in variables)

    return RoutineSignature(
        has_instance,
        parts(parameters_of(routine)),
        parts([routine.result])[0] if routine.result is not None else None,
        parts(outputs_of(routine)),
    )
