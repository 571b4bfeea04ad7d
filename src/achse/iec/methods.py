"""Methods and properties: their declaration, and the arguments of methods as bytes.

A call carries all inputs in order without gaps; the answer carries the return value, then all
outputs in order without gaps.

Source: IEC 61131-3 (2013) tables 48 and 50; arguments as bytes: recorded traffic of TwinCAT 3.1
targets and the code of public clients; no manual prints it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from achse.iec.errors import IecDecodeError, IecValueError
from achse.iec.types import IecType


@dataclass(frozen=True)
class Parameter:
    """A parameter of a method; an output if it is not an input."""

    name: str
    type: IecType[Any]
    is_output: bool = False
    by_reference: bool = False
    comment: str = ""
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Property:
    """A property that clients reach by name (attribute `monitoring` = `call`)."""

    name: str
    type: IecType[Any]
    readable: bool = True
    """True if it has a GET."""
    writable: bool = True
    """True if it has a SET."""
    comment: str = ""
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Method:
    """A method that can be called over ADS (attribute `TcRpcEnable`)."""

    name: str
    parameters: tuple[Parameter, ...] = ()
    returns: IecType[Any] | None = None
    comment: str = ""
    attributes: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def inputs(self) -> tuple[Parameter, ...]:
        return tuple(item for item in self.parameters if not item.is_output)

    @cached_property
    def outputs(self) -> tuple[Parameter, ...]:
        return tuple(item for item in self.parameters if item.is_output)

    @cached_property
    def _answers(self) -> tuple[IecType[Any], ...]:
        returned = () if self.returns is None else (self.returns,)
        return (*returned, *(item.type for item in self.outputs))

    @cached_property
    def answer_size(self) -> int:
        """Bytes of return value and outputs."""
        return sum(type.size for type in self._answers)

    def encode_inputs(self, values: Mapping[str, object]) -> bytes:
        """Return the data of a call. Raises `IecValueError` if an input is missing or unknown."""
        remaining = {name.lower(): value for name, value in values.items()}
        parts = []
        for item in self.inputs:
            if item.name.lower() not in remaining:
                raise IecValueError(self.name, f"the input {item.name}", dict(values))
            parts.append(item.type.encode(remaining.pop(item.name.lower())))
        if remaining:
            names = ", ".join(item.name for item in self.inputs) or "no inputs"
            raise IecValueError(self.name, names, next(iter(remaining)))
        return b"".join(parts)

    def decode_inputs(self, data: bytes) -> tuple[Any, ...]:
        """Return the inputs of a call, in order. Raises `IecDecodeError` if the length does not
        fit."""
        return _split(self.name, tuple(item.type for item in self.inputs), data)

    def encode_answer(self, values: Sequence[object]) -> bytes:
        """Return the data of an answer: the return value, if there is one, then the outputs."""
        if len(values) != len(self._answers):
            raise IecValueError(self.name, f"{len(self._answers)} results", values)
        pairs = zip(self._answers, values, strict=True)
        return b"".join(type.encode(value) for type, value in pairs)

    def decode_answer(self, data: bytes) -> tuple[Any, ...]:
        """Return the return value, if there is one, then the outputs."""
        return _split(self.name, self._answers, data)


def _split(name: str, types: tuple[IecType[Any], ...], data: bytes) -> tuple[Any, ...]:
    size = sum(type.size for type in types)
    if len(data) != size:
        raise IecDecodeError(f"{name} has {size} bytes of arguments, got {len(data)}")
    values = []
    position = 0
    for type in types:
        values.append(type.decode(data[position : position + type.size]))
        position += type.size
    return tuple(values)
