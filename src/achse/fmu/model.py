"""The station of a unit in its process: values in an image, steps, and a journal of what came."""

import json
import struct
import sys
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from achse.ams import DeviceError
from achse.fmu.errors import ExportError
from achse.fmu.protocol import ROW, ValueSource
from achse.fmu.variables import DIGEST, TIME, UnitVariable, ValueType, find_symbol
from achse.station import Station
from achse.station.configuration.station_file import StationConfig, load

_MAGIC = b"achse unit state 1\n"
_ENTRY = struct.Struct("<QI")
_DOUBLE = struct.Struct("<d")
_LONGEST_JOURNAL = 1 << 30


class ModelError(ValueError):
    """A request that the station of a unit cannot fulfil."""


class UnitFile(NamedTuple):
    """`unit.json` in the resources: the station file and the variables."""

    token: str
    station: str
    """Path of the station.toml in the resources."""
    variables: Sequence[UnitVariable]

    @classmethod
    def read(cls, resources: Path) -> "UnitFile":
        """Read it. Raises OSError, ValueError."""
        document = json.loads((resources / "unit.json").read_text(encoding="utf-8"))
        variables = [UnitVariable.of(each) for each in document["variables"]]
        return cls(document["token"], document["station"], variables)

    def text(self) -> str:
        """Return the file as it is written."""
        document = {
            "token": self.token,
            "station": self.station,
            "variables": [each.document() for each in self.variables],
        }
        return json.dumps(document, ensure_ascii=False, indent=1) + "\n"


def as_unit(config: StationConfig) -> StationConfig:
    """Return the configuration of the station in a unit: it writes no files of its own."""
    system = config.system.model_copy(update={"persistent_data": None, "root": None})
    return config.model_copy(update={"system": system})


class _Binding(NamedTuple):
    """A variable at its symbol."""

    place: slice
    read: Callable[[], bytes]
    write: Callable[[bytes], object]
    symbol: str


class Model:
    """A station whose variables are bytes of an image, inputs and parameters first.

    Raises ConfigError, OSError, ExportError.
    """

    def __init__(self, resources: Path, unit: UnitFile) -> None:
        self.unit = unit
        self._resources = resources
        file = resources / unit.station
        self.station = Station(as_unit(load(file)), base=file.parent)
        self._journal: list[tuple[int, bytes]] = []
        """Station time of each step with other inputs than before, and of the last one."""
        self.rows: list[bytes] = []
        self._settable: list[_Binding] = []
        self._outputs: list[_Binding] = []
        self._digest = slice(0, 0)
        offset = 0
        ordered = sorted(enumerate(unit.variables), key=lambda each: not each[1].is_settable)
        rows: dict[int, bytes] = {}
        self.input_size = 0
        for reference, variable in ordered:
            offset = -(-offset // 8) * 8
            place = slice(offset, offset + variable.size)
            rows[reference] = ROW.pack(
                *(variable.type, variable.is_settable, _source(variable), 0),
                *(variable.count, offset, variable.size),
            )
            offset += variable.size
            self._bind(variable, place)
            if variable.is_settable:
                self.input_size = offset
        self.rows = [rows[reference] for reference in range(len(rows))]
        self.image = bytearray(offset)
        for binding in (*self._settable, *self._outputs):
            self.image[binding.place] = binding.read()
        self._inputs = bytes(self.image[: self.input_size])

    def _bind(self, variable: UnitVariable, place: slice) -> None:
        source = _source(variable)
        if source is ValueSource.REQUEST:
            self._digest = place
        elif source is ValueSource.IMAGE:
            symbol: Any = find_symbol(self.station, variable.symbol)
            read, write = symbol.read, symbol.write
            if variable.type is ValueType.STRING:
                read, write = _text_access(symbol, variable.size)
            elif symbol.size != variable.size:
                raise ExportError(
                    f"{variable.symbol}: expected {variable.size} bytes, got {symbol.size}:"
                    " export the unit again"
                )
            binding = _Binding(place, read, write, variable.symbol)
            (self._settable if variable.is_settable else self._outputs).append(binding)

    def values(self) -> list[bytes]:
        """Return the bytes of each variable, in the order of the references."""
        places = [ROW.unpack(row)[-2:] for row in self.rows]
        return [bytes(self.image[offset : offset + size]) for offset, size in places]

    def apply(self, inputs: bytes) -> None:
        """Write the inputs that have changed. Raises ModelError.

        A value that the station refuses stays as it was, and the others are written.
        """
        if not inputs:
            return
        if len(inputs) != self.input_size:
            raise ModelError(f"inputs: expected {self.input_size} bytes, got {len(inputs)}")
        if inputs == self._inputs:
            return
        before = self._inputs
        taken = bytearray(inputs)
        refusals: list[str] = []
        for place, _, write, symbol in self._settable:
            if inputs[place] != before[place]:
                try:
                    write(inputs[place])
                except (DeviceError, ValueError) as refusal:
                    taken[place] = before[place]
                    refusals.append(f"{symbol}: {refusal}")
        self._inputs = bytes(taken)
        self.image[: self.input_size] = taken
        self._journal.append((self.station.time_ns, self._inputs))
        if refusals:
            raise ModelError("; ".join(refusals))

    def go_to(self, time_ns: int) -> None:
        """Let the station run its cycles up to a time, as far as they are whole."""
        station = self.station
        whole = time_ns - time_ns % station.tick_ns
        if whole > station.time_ns:
            station.cycle.go_to(whole)
        self.refresh()

    def refresh(self) -> None:
        """Put the values of the station into the image."""
        image = self.image
        for place, read, *_ in self._outputs:
            image[place] = read()

    def show_digest(self) -> None:
        """Put the digest of the station into the image."""
        place = self._digest
        self.image[place] = self.station.digest().encode().ljust(place.stop - place.start, b"\0")

    def pack(self, elapsed: float) -> bytes:
        """Return the state as bytes: all inputs and when they came, and the digest as a proof."""
        entries = [*self._journal, (self.station.time_ns, b"")]
        journal = b"".join(_ENTRY.pack(at, len(inputs)) + inputs for at, inputs in entries)
        head = f"{self.unit.token}\n{self.station.digest()}\n".encode()
        return _MAGIC + head + _DOUBLE.pack(elapsed) + zlib.compress(journal)

    @classmethod
    def unpack(cls, resources: Path, unit: UnitFile, data: bytes) -> "tuple[Model, float]":
        """Return a station that went through the history of a packed state, and its time (s).

        Raises ModelError, ConfigError, OSError, DeviceError.
        """
        if not data.startswith(_MAGIC):
            raise ModelError("state: expected bytes of a serialised state of this unit")
        token, digest, rest = (*data[len(_MAGIC) :].split(b"\n", 2), b"", b"")[:3]
        if token.decode(errors="replace") != unit.token or len(rest) < _DOUBLE.size:
            raise ModelError("state: expected a state of this unit, got one of another unit")
        (elapsed,) = _DOUBLE.unpack_from(rest)
        try:
            inflate = zlib.decompressobj()
            journal = inflate.decompress(rest[_DOUBLE.size :], _LONGEST_JOURNAL)
        except zlib.error as failure:
            raise ModelError(f"state: damaged ({failure})") from None
        model = cls(resources, unit)
        at = 0
        while at + _ENTRY.size <= len(journal):
            time_ns, size = _ENTRY.unpack_from(journal, at)
            at += _ENTRY.size
            model.go_to(time_ns)
            model.apply(journal[at : at + size])
            at += size
        if model.station.digest() != digest.decode(errors="replace"):
            raise ModelError(
                f"state: expected digest {digest.decode(errors='replace')} after its history,"
                f" got {model.station.digest()}: another version of achse or of the station"
            )
        return model, elapsed


def _source(variable: UnitVariable) -> ValueSource:
    if variable.symbol:
        return ValueSource.IMAGE
    return {TIME.name: ValueSource.TIME, DIGEST.name: ValueSource.REQUEST}[variable.name]


def _text_access(symbol: Any, size: int) -> tuple[Callable[[], bytes], Callable[[bytes], object]]:
    """Read and write a STRING as UTF-8 with zeros behind it."""
    type = symbol.type

    def read() -> bytes:
        text: str = type.decode(symbol.read())
        return text.encode("utf-8", "replace")[: size - 1].ljust(size, b"\0")

    def write(data: bytes) -> None:
        text = data.partition(b"\0")[0].decode("utf-8", "replace")
        symbol.write(type.encode(text))

    return read, write


if sys.byteorder != "little":  # pragma: no cover
    raise ImportError("units need a little-endian computer")
