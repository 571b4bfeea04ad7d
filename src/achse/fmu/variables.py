"""The variables of a unit: process image, axes, and the symbols that were chosen."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from enum import IntEnum
from fnmatch import fnmatchcase
from itertools import product
from math import prod
from typing import Any, Literal

from achse.ams import DeviceError
from achse.devices.nc import NcDevice
from achse.devices.plc import PlcDevice
from achse.fmu.errors import ExportError
from achse.iec import EnumType, IecType, resolved
from achse.iec.arrays import ArrayType
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.nearest import did_you_mean
from achse.iec.strings import StringType, WStringType
from achse.iec.structs import StructType
from achse.iec.times import TimeType
from achse.plc import PlacedVariable
from achse.plc.memory import Area
from achse.server import ResolvedSymbol
from achse.station import Station

Causality = Literal["independent", "parameter", "input", "output", "local"]

_MOST_VARIABLES = 20_000
_MOST_VALUES = 1 << 22
_NC_PORT = 500


class ValueType(IntEnum):
    """Type of a value in the image, by its name in FMI 3.0."""

    BOOLEAN = 0
    INT8 = 1
    UINT8 = 2
    INT16 = 3
    UINT16 = 4
    INT32 = 5
    UINT32 = 6
    INT64 = 7
    UINT64 = 8
    FLOAT32 = 9
    FLOAT64 = 10
    STRING = 11

    @property
    def element(self) -> str:
        """Name of the element in modelDescription.xml."""
        return _ELEMENTS[self]

    @property
    def is_real(self) -> bool:
        return self in (ValueType.FLOAT32, ValueType.FLOAT64)


_ELEMENTS = {each: each.name.capitalize().replace("Uint", "UInt") for each in ValueType}


@dataclass(frozen=True, slots=True)
class UnitVariable:
    """A variable of a unit; its place in the list is its value reference."""

    name: str
    symbol: str
    """`851:MAIN.bGo`; empty for a variable of the unit itself."""
    type: ValueType
    causality: Causality
    size: int
    """Bytes in the image."""
    dimensions: tuple[int, ...] = ()
    unit: str = ""
    description: str = ""

    @property
    def count(self) -> int:
        """Number of values."""
        return prod(self.dimensions)

    @property
    def is_settable(self) -> bool:
        return self.causality in ("input", "parameter")

    def document(self) -> dict[str, Any]:
        """Return the variable for JSON."""
        return asdict(self) | {"type": self.type.name, "dimensions": list(self.dimensions)}

    @classmethod
    def of(cls, document: dict[str, Any]) -> "UnitVariable":
        """Return the variable of a JSON document."""
        return cls(
            **document
            | {
                "type": ValueType[document["type"]],
                "dimensions": tuple(document["dimensions"]),
            }
        )


TIME = UnitVariable("time", "", ValueType.FLOAT64, "independent", 8, (), "s", "Simulation time.")
DIGEST = UnitVariable(
    *("station.digest", "", ValueType.STRING, "local", 64),
    description="Hash of the station's whole state: equal histories have equal digests.",
)


@dataclass(frozen=True, slots=True)
class VariableChoice:
    """Symbols that become variables beside process image and axes: names or patterns with `*`,
    `port:name` where several PLCs have it."""

    inputs: Sequence[str] = ()
    parameters: Sequence[str] = ()
    outputs: Sequence[str] = ()
    locals: Sequence[str] = ()
    process_image: bool = True
    axes: bool = True


_AXIS_VALUES = (
    ("SetPos", ""),
    ("SetVelo", "/s"),
    ("SetAcc", "/s2"),
    ("ActPos", ""),
    ("ActVelo", "/s"),
    ("ActAcc", "/s2"),
    ("PosDiff", ""),
    ("ErrState", None),
)
"""Symbols of an axis that are outputs, with the unit behind the one of the axis."""

_LINKED = ("AXIS_REF", "NCTOPLC_", "PLCTONC_")
"""Beginnings of the names of types that the station itself fills."""

_UNIT_OF_TIME = {"TIME": "ms", "TOD": "ms", "LTIME": "ns", "LTOD": "ns", "LDT": "ns", "LDATE": "ns"}

_PLAIN_NAME = re.compile(r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?", re.ASCII)


class _Leaf:
    """A value that can be a variable of a unit."""

    __slots__ = ("name", "type")

    def __init__(self, name: str, type: IecType[Any]) -> None:
        self.name = name
        self.type = type


def value_type(type: IecType[Any]) -> ValueType | None:
    """Return the type of the values of an elementary type; None for any other type."""
    real = resolved(type)
    if isinstance(real, EnumType):
        real = resolved(real.base)
    if isinstance(real, BoolType):
        return ValueType.BOOLEAN
    if isinstance(real, RealType):
        return ValueType.FLOAT32 if real.size == 4 else ValueType.FLOAT64
    if isinstance(real, IntegerType):
        return ValueType[f"{'INT' if real.low < 0 else 'UINT'}{8 * real.size}"]
    if isinstance(real, TimeType):
        return ValueType[f"UINT{8 * real.size}"]
    if isinstance(real, StringType) and not isinstance(real, WStringType):
        return ValueType.STRING
    return None


def _leaves(name: str, type: IecType[Any], scalars: bool = False) -> Iterator[_Leaf]:
    """Yield the values within a variable: arrays of numbers whole unless only `scalars` may be."""
    real = resolved(type)
    if real.name.rpartition(".")[2].upper().startswith(_LINKED):
        return
    if value_type(real) is not None:
        yield _Leaf(name, type)
    elif isinstance(real, ArrayType):
        element = value_type(real.element)
        if element not in (None, ValueType.STRING) and not scalars:
            yield _Leaf(name, type)
            return
        for indices in _indices(real):
            index = ",".join(map(str, indices))
            yield from _leaves(f"{name}[{index}]", real.element, scalars)
    elif isinstance(real, StructType):
        for member in real.shown:
            if member.in_memory:
                yield from _leaves(f"{name}.{member.name}", member.type, scalars)


def _indices(array: ArrayType[Any]) -> Iterator[tuple[int, ...]]:
    return product(*(range(bounds.first, bounds.last + 1) for bounds in array.dimensions))


def find_symbol(station: Station, name: str) -> ResolvedSymbol:
    """Return the symbol `851:MAIN.bGo` of a station. Raises ExportError."""
    port, _, path = name.partition(":")
    for device in station.devices:
        if device.symbols is None or int(port) not in {each.port for each in device.addresses}:
            continue
        try:
            symbol = device.symbols.source.resolve(path)
        except DeviceError as refusal:
            raise ExportError(f"{name}: {refusal.context or refusal}") from None
        if symbol is not None and symbol.call is None:
            return symbol
    raise ExportError(f"{name}: expected a symbol of the station, there is none of this name")


def chosen_variables(
    station: Station, choice: VariableChoice, *, scalars: bool = False
) -> list[UnitVariable]:
    """Return the variables of a unit, inputs and parameters first; of arrays the elements if only
    `scalars` may be. Raises ExportError."""
    table = _Table(station, scalars)
    if choice.process_image:
        table.add_process_image()
    if choice.axes:
        table.add_axes()
    for causality, patterns in (
        ("input", choice.inputs),
        ("parameter", choice.parameters),
        ("output", choice.outputs),
        ("local", choice.locals),
    ):
        for pattern in patterns:
            table.choose(pattern, causality)
    settable = [each for each in table.variables.values() if each.is_settable]
    others = [each for each in table.variables.values() if not each.is_settable]
    variables = [TIME, *settable, *others, DIGEST]
    if len(variables) > _MOST_VARIABLES or sum(each.size for each in variables) > _MOST_VALUES:
        raise ExportError(
            f"variables: expected at most {_MOST_VARIABLES} with {_MOST_VALUES} bytes,"
            f" got {len(variables)} with {sum(each.size for each in variables)}"
        )
    return variables


class _Table:
    """The variables so far, by symbol."""

    def __init__(self, station: Station, scalars: bool) -> None:
        self._scalars = scalars
        self.variables: dict[str, UnitVariable] = {}
        self._station = station
        self._plcs = {
            next(iter(each.addresses)).port: each
            for each in station.devices
            if isinstance(each, PlcDevice)
        }
        self._units: dict[str, str] = {}
        """Units of NC symbols by name in small letters."""
        self._nc_names: list[str] = []
        nc = next((each for each in station.devices if isinstance(each, NcDevice)), None)
        if nc is not None and station.nc is not None:
            for axis in station.nc:
                for name, behind in _AXIS_VALUES:
                    symbol = f"Axes.{axis.name}.{name}"
                    if behind is not None:
                        self._units[f"{_NC_PORT}:{symbol}".lower()] = f"{axis.unit}{behind}"
            self._nc_names = [
                each.name
                for each in nc.symbols.source.all_symbols()  # type: ignore[union-attr]
                if value_type(each.type) is not None
            ]

    def add_process_image(self) -> None:
        """Add located variables: %I are inputs unless a terminal writes them, %Q are outputs."""
        for port, device in self._plcs.items():
            taken = self._written_bytes(port)
            linked, written = self._linked(), self._written_names()
            for placed in device.plc.variables:
                if placed.area not in (Area.INPUT, Area.OUTPUT) or placed.variable.hidden:
                    continue
                if placed.name.lower() in linked:
                    continue
                is_input = (
                    placed.area is Area.INPUT
                    and not taken & _bytes_of(placed)
                    and placed.name.lower() not in written
                )
                for leaf in _leaves(placed.name, placed.variable.type, self._scalars):
                    self._add(f"{port}:{leaf.name}", "input" if is_input else "output")

    def add_axes(self) -> None:
        """Set and actual values of each axis."""
        if self._station.nc is None:
            return
        for axis in self._station.nc:
            for name, _ in _AXIS_VALUES:
                self._add(f"{_NC_PORT}:Axes.{axis.name}.{name}", "output")

    def choose(self, pattern: str, causality: Any) -> None:
        """Choose the symbols that a name or a pattern with `*` means. Raises ExportError."""
        ports, name = self._ports_of(pattern)
        symbols = [
            f"{port}:{each}"
            for port in ports
            for each in self._names(port)
            if fnmatchcase(each.lower(), name.lower().replace("[", "[[]"))
        ]
        if not symbols and "*" not in name:
            symbols = self._parts(ports, name)
        if not symbols:
            known = [each for port in ports for each in self._names(port)]
            raise ExportError(
                f"{pattern}: expected a symbol of the station{did_you_mean(name, known)}"
            )
        for symbol in symbols:
            self._add(symbol, causality, explicit="*" not in name)

    def _parts(self, ports: Iterable[int], name: str) -> list[str]:
        """Values within the symbol of that name; an element of an array, for example."""
        for port in ports:
            try:
                symbol = find_symbol(self._station, f"{port}:{name}")
            except ExportError:
                continue
            named: Any = symbol
            return [
                f"{port}:{each.name}" for each in _leaves(named.name, named.type, self._scalars)
            ]
        return []

    def _ports_of(self, pattern: str) -> tuple[list[int], str]:
        head, colon, rest = pattern.partition(":")
        every = [*self._plcs, _NC_PORT]
        if not colon:
            return every, pattern
        if not head.isdecimal() or int(head) not in every:
            expected = ", ".join(map(str, every))
            raise ExportError(f"{pattern}: expected one of the ports {expected}, got {head}")
        return [int(head)], rest

    def _names(self, port: int) -> list[str]:
        if port == _NC_PORT:
            return self._nc_names
        plc = self._plcs[port].plc
        return [
            leaf.name
            for placed in plc.variables
            if not placed.variable.hidden
            for leaf in _leaves(placed.name, placed.variable.type, self._scalars)
        ]

    def _add(self, symbol: str, causality: Causality, explicit: bool = False) -> None:
        present = self.variables.get(symbol.lower())
        if present is not None and not explicit:
            return
        target: Any = find_symbol(self._station, symbol)
        if causality in ("input", "parameter") and target.read_only:
            raise ExportError(f"{symbol}: expected a variable that can be written for {causality}")
        type = resolved(target.type)
        element = type.element if isinstance(type, ArrayType) else type
        kind = value_type(element)
        assert kind is not None
        dimensions = tuple(type.counts) if isinstance(type, ArrayType) else ()
        size = target.size if kind is not ValueType.STRING else 2 * type.size  # UTF-8 of cp1252
        unit = self._units.get(symbol.lower(), _UNIT_OF_TIME.get(resolved(element).name, ""))
        port, _, path = symbol.partition(":")
        several = len(self._plcs) > 1 and int(port) in self._plcs
        self.variables[symbol.lower()] = UnitVariable(
            _structured(f"PLC{port}.{path}" if several else path),
            symbol,
            kind,
            causality,
            size,
            dimensions,
            unit,
            getattr(target, "comment", ""),
        )

    def _written_bytes(self, port: int) -> set[int]:
        """Return bytes of %I that terminals write."""
        first = next(iter(self._plcs))
        written: set[int] = set()
        for terminal in self._station.config.terminal:
            if terminal.input_address is not None and (terminal.plc or first) == port:
                bits = terminal.input_count * (1 if terminal.is_digital else 16)
                begin = terminal.input_address
                written |= set(range(begin, begin + -(-bits // 8)))
        return written

    def _written_names(self) -> set[str]:
        """Return names of variables that plants and signals write."""
        config = self._station.config
        names = [target for unit in config.fmu for target in unit.outputs]
        names += [signal.symbol for signal in config.signal]
        return {each.rpartition(":")[2].lower() for each in names}

    def _linked(self) -> set[str]:
        """Return names of variables that axes are linked to."""
        names = [
            each
            for axis in self._station.config.axis
            for each in ((axis.plc,) if isinstance(axis.plc, str) else axis.plc)
        ]
        return {each.rpartition(":")[2].lower() for each in names}


def _bytes_of(placed: PlacedVariable) -> set[int]:
    return set(range(placed.offset, placed.offset + max(1, placed.variable.type.size)))


def _structured(path: str) -> str:
    """Return the name in the notation of FMI: other parts than identifiers are in quotes."""
    parts = path.split(".")
    return ".".join(
        part
        if _PLAIN_NAME.fullmatch(part)
        else "'" + part.replace("\\", "\\\\").replace("'", "\\'") + "'"
        for part in parts
    )
