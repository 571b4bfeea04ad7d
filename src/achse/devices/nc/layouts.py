"""Layouts of the NC: numbers as they travel, requests, and structures read straight off an axis.

TwinCAT 2 packs structures, TwinCAT 3 aligns each field to a multiple of its size. Both forms are
served: a request is understood by its length, an answer has the form of the requested length.
"""

import re
import struct
from collections import namedtuple
from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial
from operator import attrgetter, itemgetter
from typing import Any

from achse.codes.nc import structures
from achse.codes.nc.row import struct_of
from achse.codes.nc.structures import StructureMember
from achse.motion import Axis
from achse.motion.parts import AxisPart
from achse.motion.record import FIELDS
from achse.native.memory import MemoryCell, gather
from achse.server import Codec, Layout, Repeated


class Integer:
    """A whole number of `size` bytes; one too long for it wraps, as counters do."""

    def __init__(self, size: int, *, signed: bool = False) -> None:
        self.size = size
        self.signed = signed
        self.name = f"{'' if signed else 'U'}INT{8 * size}"
        self._mask = (1 << 8 * size) - 1

    def encode(self, value: int) -> bytes:
        return (value & self._mask).to_bytes(self.size, "little")

    def decode(self, data: bytes) -> int:
        return int.from_bytes(data, "little", signed=self.signed)


REAL64 = Layout("<d")
INT32 = Integer(4, signed=True)
INT64 = Integer(8, signed=True)
UINT8 = Integer(1)
UINT16 = Integer(2)
UINT32 = Integer(4)
UINT64 = Integer(8)


class Text:
    """A text of at most `size` - 1 characters of cp1252, padded with NUL."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.name = f"STRING[{size}]"

    def encode(self, value: str) -> bytes:
        return value.encode("cp1252", "replace")[: self.size - 1].ljust(self.size, b"\0")

    def decode(self, data: bytes) -> str:
        return data.split(b"\0", 1)[0].decode("cp1252", "replace")


class OfAxis:
    """A layout of a value that `read` takes off the axis: for rows whose layouts show different."""

    def __init__(self, codec: Codec, read: Callable[[Any], Any]) -> None:
        self.size = codec.size
        self.name = getattr(codec, "name", str(codec))
        self._codec = codec
        self._read = read

    def encode(self, axis: Axis | AxisPart) -> bytes:
        return self._codec.encode(self._read(axis))

    def decode(self, data: bytes) -> Any:
        return self._codec.decode(data)


class LineText:
    """A text of any length, with NUL at its end, in cp1252."""

    name = "STRING[n]"
    size: int | None = None

    def encode(self, value: str) -> bytes:
        return value.encode("cp1252", "replace") + b"\0"

    def decode(self, data: bytes) -> str:
        return data.split(b"\0", 1)[0].decode("cp1252", "replace")


class _NoData:
    """Functions without data; some clients send a byte all the same, which is passed over."""

    name = "VOID"
    size: int | None = None

    def encode(self, value: Any) -> bytes:
        return b""

    def decode(self, data: bytes) -> tuple[()]:
        return ()


NO_DATA = _NoData()


class _Nothing(_NoData):
    """A function called without data, beside longer forms: the length selects the form."""

    size = 0


NOTHING = _Nothing()


_CODECS: dict[str, Codec] = {
    "REAL64": REAL64,
    "STRING[n]": LineText(),
    **{codec.name: codec for codec in (INT32, INT64, UINT8, UINT16, UINT32, UINT64)},
}


@cache
def codec_of(layout: str) -> Codec:
    """Return the codec of one layout of a row; structures with named fields are named tuples.

    Raises ValueError for a layout that only a codec of its own can have.
    """
    known = _CODECS.get(layout)
    if known is not None:
        return known
    if layout.endswith("[n]"):
        return Repeated(codec_of(layout.removesuffix("[n]")))
    form, names = struct_of(layout)
    if layout.startswith("STRING["):
        return Text(struct.calcsize(form))
    return Layout(form, namedtuple("Request", names) if names else None)


def codecs_of(layouts: Sequence[str]) -> Codec | tuple[Codec, ...]:
    """Return the codec of a value, or one for each of its layouts."""
    if len(layouts) == 1:
        return NO_DATA if layouts[0] == "VOID" else codec_of(layouts[0])
    return tuple(NOTHING if each == "VOID" else codec_of(each) for each in layouts)


_MEMBER_CODES = {"DWORD": "I", "UDINT": "I", "DINT": "i", "LREAL": "d", "UINT": "H"}
_MEMBER_SIZES = {"BOOL": 1, "BYTE": 1, "USINT": 1, "UINT": 2, "LREAL": 8}


def fields_of(members: Iterable[StructureMember]) -> tuple[tuple[str, str], ...]:
    """`struct` code and record field of each member; bytes without value for those without."""
    return tuple(
        (
            _MEMBER_CODES[member.type]
            if member.field
            else f"{_MEMBER_SIZES.get(member.type, 4) * member.elements}x",
            member.field,
        )
        for member in members
    )


def _aligned(codes: Sequence[str]) -> str:
    """`struct` codes with the gaps that put each field on a multiple of its size."""
    end = 0
    placed = ""
    for code in codes:
        width = struct.calcsize("<" + code)
        gap = 0 if code.endswith("x") else -end % width
        placed += f"{gap}x" * bool(gap) + code
        end += gap + width
    return placed


class AxisStructure:
    """A structure of `size` bytes whose fields are fields of the axis record.

    `fields` is a sequence of (`struct` code, record field); codes of "x" leave zeros and name no
    field, as do the bytes up to `size`.
    """

    def __init__(
        self, name: str, fields: tuple[tuple[str, str], ...], *, aligned: bool, size: int
    ) -> None:
        codes = [code for code, _ in fields]
        form = "<" + (_aligned(codes) if aligned else "".join(codes))
        rest = size - struct.calcsize(form)
        if rest < 0:
            raise ValueError(f"{name}: fields take {size - rest} bytes, the structure has {size}")
        form += f"{rest}x" * bool(rest)
        self.name = f"{name} ({size} bytes)"
        self.size = size
        shown = [(code, field) for code, field in fields if field]
        layout = struct.Struct(form)
        self._pack, self._unpack = layout.pack, layout.unpack
        self._fields = tuple(field for _, field in shown)
        self._values = attrgetter(*self._fields)
        self._pack_unsigned = struct.Struct(form.replace("i", "I")).pack
        self._form = form
        self._codes = tuple(code for code, _ in shown)
        self._masks = [
            None if code == "d" else (1 << 8 * struct.calcsize("<" + code)) - 1 for code, _ in shown
        ]

    def encode(self, axis: Axis) -> bytes:
        values = self._values(axis)
        try:
            return self._pack(*values)
        except struct.error:  # a count beyond its field wraps
            pairs = zip(values, self._masks, strict=True)
            return self._pack_unsigned(*(v if mask is None else v & mask for v, mask in pairs))

    def of(self, axis: Axis) -> Callable[[], bytes]:
        """Return the same for one axis, again and again: what is in memory is copied from there."""
        all_places = (
            axis.place_of(field, struct.calcsize("<" + code)) if field in FIELDS else None
            for code, field in zip(self._codes, self._fields, strict=True)
        )
        places = [place if isinstance(place, MemoryCell) else None for place in all_places]
        computed = [n for n, place in enumerate(places) if place is None]
        if len(computed) == len(places) or len(computed) < _SEVERAL:
            return partial(self.encode, axis)
        read = gather(place for place in places if place is not None)
        get = attrgetter(*(self._fields[n] for n in computed))
        codes = iter(places)
        form = re.sub(r"[a-wyzA-Z]", lambda code: _copied(code[0], next(codes)), self._form)
        in_memory = [n for n, place in enumerate(places) if place is not None]
        order = sorted(range(len(places)), key=[*in_memory, *computed].__getitem__)
        pick, put = itemgetter(*order), struct.Struct(form).pack

        def encode() -> bytes:
            try:
                return put(*pick(read() + get(axis)))
            except struct.error:  # a count beyond its field wraps
                return self.encode(axis)

        return encode

    def decode(self, data: bytes) -> dict[str, Any]:
        """Return the values by record field; for clients, as no row takes a structure in."""
        return dict(zip(self._fields, self._unpack(data), strict=True))


_SEVERAL = 2
"""So many values an `attrgetter` answers as a tuple."""


def _copied(code: str, place: MemoryCell | None) -> str:
    """Return the `struct` code of bytes that are copied, or of a number."""
    return code if place is None else f"{struct.calcsize('<' + code)}s"


_NAME = "NCAXISSTATE_ONLINESTRUCT"
ONLINE_TC2 = AxisStructure(_NAME, fields_of(structures.ONLINE_TC2), aligned=False, size=112)
ONLINE_TC3 = AxisStructure(_NAME, fields_of(structures.ONLINE_TC3), aligned=True, size=256)
