"""Methods and properties of a PLC, as the Python behind them: calls, getting, setting."""

import inspect
import logging
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.iec import IecDecodeError, IecError, Method, Property, Record
from achse.iec.paths import PathIndex, PathMember, Step
from achse.plc import PlcStateError

if TYPE_CHECKING:
    from achse.plc.bodies import Bodies

log = logging.getLogger("achse.plc")


def caller(
    unit: Record, steps: Sequence[Step], method: Method, bodies: "Bodies | None" = None
) -> Callable[[bytes], bytes]:
    """Return a function that calls what is behind a declared method, on the living object: its
    Structured Text, or the Python method of its name."""

    def call(data: bytes) -> bytes:
        try:
            arguments = method.decode_inputs(data)
        except IecDecodeError as failure:
            raise DeviceError(ReturnCode.INVALID_SIZE, str(failure)) from None
        if bodies is not None:
            try:
                answer = bodies.calls.call_encoded(_living(unit, steps), method, data)
            except Exception as failure:
                raise _stopped(f"method {method.name}", failure) from None
            if answer is not None:
                return answer
        body = _python_method(_living(unit, steps), method)
        answers = len(method.outputs) + (method.returns is not None)
        try:
            result = body(*arguments)
            if answers == 0:
                return b""
            return method.encode_answer((result,) if answers == 1 else result)
        except DeviceError:
            raise
        except Exception as failure:
            raise _failed(f"method {method.name}", failure) from None

    return call


class PropertyAccess(NamedTuple):
    """A property as clients read and write it."""

    read: Callable[[], bytes]
    write: Callable[[bytes], None]


def property_access(
    unit: Record, steps: Sequence[Step], declared: Property, bodies: "Bodies | None" = None
) -> PropertyAccess:
    """GET and SET of a property, on the living object: its Structured Text, or the Python
    property of its name.

    Without a GET (a SET) in the declaration, reading (writing) is refused with 0x704.
    """
    type = declared.type

    def read() -> bytes:
        if not declared.readable:
            raise DeviceError(ReturnCode.INVALID_ACCESS, f"{declared.name} has no GET")
        target = _living(unit, steps)
        if bodies is not None:
            try:
                encoded = bodies.calls.get_encoded(target, declared.name)
            except Exception as failure:
                raise _stopped(f"property {declared.name}", failure) from None
            if encoded is not None:
                return encoded
        getter = _python_property(target, declared).fget
        try:
            return type.encode(getter(target))  # type: ignore[misc]
        except DeviceError:
            raise
        except Exception as failure:
            raise _failed(f"property {declared.name}", failure) from None

    def write(data: bytes) -> None:
        target = _living(unit, steps)
        if not declared.writable:
            raise DeviceError(ReturnCode.INVALID_ACCESS, f"{declared.name} has no SET")
        rest = read()[len(data) :] if declared.readable and len(data) < type.size else b""
        whole = (data + rest).ljust(type.size, b"\0")
        if bodies is not None:
            try:
                if bodies.calls.set_encoded(target, declared.name, whole):
                    return
            except Exception as failure:
                raise _stopped(f"property {declared.name}", failure) from None
        setter = _python_property(target, declared).fset
        if setter is None:
            raise DeviceError(ReturnCode.INVALID_ACCESS, f"{declared.name} has no SET")
        try:
            setter(target, type.decode(whole))
        except DeviceError:
            raise
        except IecError as failure:
            raise DeviceError(ReturnCode.INVALID_DATA, str(failure)) from None
        except Exception as failure:
            raise _failed(f"property {declared.name}", failure) from None

    return PropertyAccess(read, write)


def _living(unit: Record, steps: Sequence[Step]) -> Any:
    """Return the object that steps lead to from a unit."""
    target: Any = unit
    for step in steps:
        if isinstance(step, PathMember):
            target = target[step.name]
        elif isinstance(step, PathIndex):
            target = target[step.indices if len(step.indices) > 1 else step.indices[0]]
    return target


def _stopped(what: str, failure: Exception) -> DeviceError:
    """Return the error of failed Structured Text for the client; the PLC has logged it."""
    code = ReturnCode.DEVICE_ERROR
    if isinstance(failure, PlcStateError):
        code = ReturnCode.INVALID_STATE
    return DeviceError(code, f"{what}: {failure}")


def _failed(what: str, failure: Exception) -> DeviceError:
    log.exception("%s failed", what)
    return DeviceError(ReturnCode.DEVICE_ERROR, f"{what}: {failure}")


def _python_method(target: object, method: Method) -> Callable[..., Any]:
    """Return the Python method declared as `method`, or of its name: case does not matter."""
    wanted = method.name.lower()
    for cls in type(target).__mro__:
        for name, value in vars(cls).items():
            declared = getattr(value, "__iec_method__", None)
            if declared is method or (name.lower() == wanted and inspect.isfunction(value)):
                bound: Callable[..., Any] = getattr(target, name)
                return bound
    raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{method.name} has no body")


def _python_property(target: object, declared: Property) -> property:
    """Return the Python property of the name: case does not matter."""
    wanted = declared.name.lower()
    for cls in type(target).__mro__:
        for name, value in vars(cls).items():
            if name.lower() == wanted and isinstance(value, property):
                return value
    raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{declared.name} has no body")
