"""Declaring types and programs in typed Python.

    class ST_Axis(Struct):
        fPos = var(LREAL)
        bReady = var(BOOL, comment="drive is on")

    class MAIN(Program):
        nCounter = var(UDINT, 0)
        stAxis = var(ST_Axis, at="%MB100")
        aValues = var(ARRAY(INT, (1, 10)), retain=True)

        def cycle(self) -> None:
            self.nCounter += 1
            self.stAxis.fPos = 1.0
            self.aValues[3] = 5

Type checkers see `self.nCounter` as int, `self.stAxis` as ST_Axis, `self.aValues[3]` as int.

Source: IEC 61131-3 (2013) tables 11, 13, 40 and 47.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar, overload

from achse.iec.arrays import Array, ArrayType, Bounds
from achse.iec.derived import PointerType, ReferenceType
from achse.iec.enums import Enumeration, EnumType
from achse.iec.errors import DeclarationError
from achse.iec.methods import Method, Parameter
from achse.iec.structs import Record, RecordKind, StaticRecord, StructType
from achse.iec.types import IecType, no_attributes
from achse.iec.variables import Address, Section, Variable

V = TypeVar("V")
R = TypeVar("R", bound=Record)
E = TypeVar("E", bound=Enumeration)
F = TypeVar("F", bound=Callable[..., Any])

Typelike = IecType[Any] | type[Record] | type[Enumeration]
"""Type in a declaration: a type, a class of records or of an enumeration."""


class Program(StaticRecord, kind=RecordKind.UNIT):
    """Base of programs. Class argument `name` if it is not the class name."""

    __slots__ = ()


class GlobalVariables(StaticRecord, kind=RecordKind.UNIT):
    """Base of global variable lists. Class argument `name` if it is not the class name."""

    __slots__ = ()


@overload
def iec_type(declared: type[R] | R) -> StructType[R]: ...
@overload
def iec_type(declared: type[E]) -> EnumType[E]: ...
@overload
def iec_type(declared: IecType[V]) -> IecType[V]: ...
def iec_type(declared: Typelike | Record) -> IecType[Any]:
    """Return the type of a record or enumeration class, or of a record; a type is its own."""
    if isinstance(declared, IecType):
        return declared
    type = getattr(declared, "__iec__", None)
    if not isinstance(type, IecType):
        raise DeclarationError(f"an IEC type or a class declared as one is due, got {declared!r}")
    return type


class _Declare:
    """Declares a variable of a section: `var(type, initial, at=…, retain=…, comment=…)`.

    `at` is an address such as `%MD4`, `%IX0.3` or `%Q*`; `name` is the IEC name where Python
    needs another (`from_ = var(INT, name="from")`).
    """

    def __init__(self, section: Section) -> None:
        self._section = section

    @overload
    def __call__(
        self,
        type: type[R],
        initial: Mapping[str, object] | None = None,
        *,
        name: str = "",
        at: str | Address = "",
        retain: bool = False,
        persistent: bool = False,
        constant: bool = False,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> Variable[R, R | Mapping[str, object]]: ...
    @overload
    def __call__(
        self,
        type: type[E],
        initial: E | int | None = None,
        *,
        name: str = "",
        at: str | Address = "",
        retain: bool = False,
        persistent: bool = False,
        constant: bool = False,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> Variable[E | int, E | int]: ...
    @overload
    def __call__(
        self,
        type: ArrayType[V],
        initial: Sequence[Any] | None = None,
        *,
        name: str = "",
        at: str | Address = "",
        retain: bool = False,
        persistent: bool = False,
        constant: bool = False,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> Variable[Array[V], Array[V] | Sequence[Any]]: ...
    @overload
    def __call__(
        self,
        type: IecType[V],
        initial: V | None = None,
        *,
        name: str = "",
        at: str | Address = "",
        retain: bool = False,
        persistent: bool = False,
        constant: bool = False,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> Variable[V, V]: ...
    def __call__(
        self,
        type: Typelike,
        initial: object = None,
        *,
        name: str = "",
        at: str | Address = "",
        retain: bool = False,
        persistent: bool = False,
        constant: bool = False,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> Variable[Any, Any]:
        return Variable(
            iec_type(type),
            initial,
            name=name,
            section=self._section,
            at=at,
            retain=retain,
            persistent=persistent,
            constant=constant,
            comment=comment,
            attributes=attributes,
        )


var = _Declare(Section.LOCAL)
var_input = _Declare(Section.INPUT)
var_output = _Declare(Section.OUTPUT)


@overload
def ARRAY(element: type[R], *bounds: tuple[int, int]) -> ArrayType[R]: ...
@overload
def ARRAY(element: type[E], *bounds: tuple[int, int]) -> ArrayType[E | int]: ...
@overload
def ARRAY(element: ArrayType[V], *bounds: tuple[int, int]) -> ArrayType[Array[V]]: ...
@overload
def ARRAY(element: IecType[V], *bounds: tuple[int, int]) -> ArrayType[V]: ...
def ARRAY(element: Typelike, *bounds: tuple[int, int]) -> ArrayType[Any]:  # noqa: N802
    """`ARRAY(INT, (1, 10))` is `ARRAY [1..10] OF INT`; one pair of bounds per dimension."""
    for first, last in bounds:
        if last < first:
            raise DeclarationError(f"array bounds {first}..{last} run backwards")
    return ArrayType(iec_type(element), [Bounds(first, last) for first, last in bounds])


def pointer_to(target: Typelike, pointer_size: int = 8) -> PointerType:
    """`POINTER TO target`."""
    return PointerType(iec_type(target), pointer_size)


def reference_to(target: Typelike, pointer_size: int = 8) -> ReferenceType:
    """`REFERENCE TO target`."""
    return ReferenceType(iec_type(target), pointer_size)


def method(
    returns: Typelike | None = None,
    *,
    outputs: Mapping[str, Typelike] | None = None,
    name: str = "",
    comment: str = "",
    **inputs: Typelike,
) -> Callable[[F], F]:
    """Make a Python method callable over ADS: `@method(LREAL, fX=LREAL)`.

    It is called with the inputs by position; it returns the return value, or with outputs a
    tuple of the return value (if any) and the outputs in order.
    """

    def declare(function: F) -> F:
        parameters = [Parameter(key, iec_type(type)) for key, type in inputs.items()]
        parameters += [
            Parameter(key, iec_type(type), is_output=True) for key, type in (outputs or {}).items()
        ]
        function.__iec_method__ = Method(  # type: ignore[attr-defined]
            name or function.__name__,
            tuple(parameters),
            None if returns is None else iec_type(returns),
            comment,
        )
        return function

    return declare


def variables(declared: type[Record] | Record) -> tuple[Variable[Any, Any], ...]:
    """Return the variables of a record class in declared order, inherited ones first."""
    return declared.__iec__.members
