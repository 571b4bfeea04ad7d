"""Channels: the entries of a device's PDOs by name, and their values as numbers.

A channel is named by its PDO and its entry as in the ESI file, `Channel 1.Input`; by the entry
alone where no other has that name; and by its object, `6000:01`.

Source: ETG.2000, entries of RxPdo and TxPdo.
"""

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from achse.codes import DataType
from achse.ethercat.description import Pdo

Value = bool | int | float | bytes
_SIGNED = (DataType.I8, DataType.I16, DataType.I32, DataType.I64)
_TEXTS = (DataType.VISIBLE_STRING, DataType.OCTET_STRING)


@dataclass(frozen=True, slots=True)
class PdoChannel:
    """An entry of a PDO."""

    name: str
    output: bool
    index: int
    subindex: int
    bits: int
    data_type: int

    @property
    def place(self) -> tuple[int, int]:
        """Index and subindex of its object."""
        return self.index, self.subindex


def channels_of(outputs: Iterable[Pdo], inputs: Iterable[Pdo]) -> Mapping[str, PdoChannel]:
    """Return the channels by each of their names; whole names win over short ones."""
    whole: dict[str, PdoChannel] = {}
    objects: dict[str, PdoChannel] = {}
    short: dict[str, list[PdoChannel]] = {}
    for output, pdos in ((True, outputs), (False, inputs)):
        for pdo in pdos:
            for entry in pdo.entries:
                if not entry.index:
                    continue
                title = entry.name or f"{entry.index:04X}:{entry.subindex:02X}"
                name = f"{pdo.name}.{title}" if pdo.name else title
                channel = PdoChannel(
                    name, output, entry.index, entry.subindex, entry.bits, entry.data_type
                )
                whole.setdefault(name, channel)
                objects.setdefault(f"{entry.index:04X}:{entry.subindex:02X}", channel)
                short.setdefault(title, []).append(channel)
    single = {
        name: channels[0]
        for name, channels in short.items()
        if len({each.place for each in channels}) == 1
    }
    return {**single, **objects, **whole}


def encode_value(channel: PdoChannel, value: Value) -> int:
    """Return the bits of a value as a number; ValueError or TypeError if the channel cannot have
    it."""
    kind, bits = channel.data_type, channel.bits
    if isinstance(value, bytes):
        if len(value) > bits + 7 >> 3:
            raise ValueError(f"{channel.name}: {bits} bits, got {len(value)} bytes")
        return int.from_bytes(value, "little") & (1 << bits) - 1
    if kind in (DataType.F32, DataType.F64) and bits == DataType(kind).bits:
        try:
            return int.from_bytes(struct.pack(DataType(kind).form, float(value)), "little")
        except OverflowError:
            raise ValueError(f"{channel.name}: {value} is beyond REAL") from None
    if isinstance(value, float) and not value.is_integer():
        raise ValueError(f"{channel.name}: expected a whole number, got {value}")
    number = int(value)
    low = -(1 << bits - 1) if kind in _SIGNED and bits else 0
    high = (1 << bits - (kind in _SIGNED)) - 1
    if not low <= number <= high:
        raise ValueError(f"{channel.name}: expected {low} to {high}, got {number}")
    return number & (1 << bits) - 1


def decode_value(channel: PdoChannel, raw: int) -> Value:
    """Return the value of the bits `raw`: bool, number, or bytes for a text."""
    kind, bits = channel.data_type, channel.bits
    if kind == DataType.BOOL:
        return bool(raw)
    if kind in _TEXTS:
        return raw.to_bytes(bits + 7 >> 3, "little")
    if kind in (DataType.F32, DataType.F64) and bits == DataType(kind).bits:
        (real,) = struct.unpack(DataType(kind).form, raw.to_bytes(bits >> 3, "little"))
        return float(real)
    if kind in _SIGNED and bits and raw >> bits - 1:
        return raw - (1 << bits)
    return raw
