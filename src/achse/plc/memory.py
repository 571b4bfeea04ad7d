"""PLC memory: the process image and the flag, retain and data areas, each one run of bytes."""

import hashlib
import mmap
from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from typing import Any, TypeAlias, cast

from achse.iec import Buffer, Place, Record, Variable


class Area(Enum):
    """The memory areas of a PLC; the value is the prefix of direct addresses, or a name."""

    INPUT = "%I"
    OUTPUT = "%Q"
    FLAG = "%M"
    RETAIN = "retain"
    DATA = "data"
    STACK = "stack"
    """Frames of running calls, as far as their variables need an address."""
    HEAP = "heap"
    """Memory that `__NEW` allocates."""


_AREAS = tuple(Area)

DEFAULT_SIZES = {
    Area.INPUT: 0x1_0000,
    Area.OUTPUT: 0x1_0000,
    Area.FLAG: 0x1_0000,
    Area.RETAIN: 0x1_0000,
    Area.DATA: 0x1_0000,
    Area.STACK: 0,
    Area.HEAP: 0,
}
"""Bytes per area at the start (64 KiB is the documented range of %M offsets). Retain and data grow
with what is allocated in them, process image and flags where declarations say how far."""

_GROWTH = 0x1_0000
_HEADROOM = 1024
"""Memory behind the last variable: clients read a STRING by its address with 1024 bytes."""

ADDRESS_BITS = 29
"""Each area has a range of 512 MiB in the address space of pointers, the first one above NULL."""

SPARSE = 1 << 22
"""An area made this large takes memory only where something is in it: the symbol files of real
targets put all areas into one range of addresses."""

_SPARSE_LATER = 1 << 20
"""The same for an area that is empty at first: stack and heap, of which programs use little."""

_CHUNK = 1 << 16
_ZEROS = bytes(_CHUNK)

_GROWING = (Area.RETAIN, Area.DATA)
_OF_CALLS = (Area.STACK, Area.HEAP)


class AreaFullError(ValueError):
    """A variable does not fit into the process image or the flag memory."""


class MemoryRangeError(IndexError):
    """An access begins or ends outside its area; nothing was read or written.

    `outside` is True if even the first byte is not in the area.
    """

    def __init__(self, area: Area, offset: int, length: int, size: int) -> None:
        self.outside = not 0 <= offset < size
        super().__init__(
            f"{area.value}: bytes {offset}..{offset + length - 1} asked for,"
            f" the area has {size} bytes"
        )


Invoke: TypeAlias = Callable[[Record, str, tuple[Any, ...]], Any]
"""Runs the Structured Text of a record: its body (no name) or the method of that name."""


class Bytes(bytearray):
    """The memory of an area. It has the places of the VAR_STAT variables of its PLC, and the
    function that runs the Structured Text of the blocks in it."""

    __slots__ = ("invoke", "statics")

    statics: dict[Variable[Any, Any], Place]
    invoke: Invoke


class _SparseBytes(mmap.mmap):
    """The same for an area whose pages come from the system when they are first written to."""

    statics: dict[Variable[Any, Any], Place]
    invoke: Invoke


def _zeros(size: int) -> Bytes:
    return Bytes(size) if size < SPARSE else _sparse_zeros(size)


def _sparse_zeros(size: int) -> Bytes:
    # Private pages: those only read are one page of zeros. Elsewhere mmap knows no such flag.
    private = getattr(mmap, "MAP_PRIVATE", 0) | getattr(mmap, "MAP_ANONYMOUS", 0)
    zeros = _SparseBytes(-1, size, private) if private else _SparseBytes(-1, size)
    if hasattr(mmap, "MADV_NOHUGEPAGE"):
        zeros.madvise(mmap.MADV_NOHUGEPAGE)  # else each byte written takes 2 MiB
    return cast("Bytes", zeros)


def _pieces(data: Buffer) -> Iterator[tuple[int, bytes]]:
    """Yield the chunks that are not zero, with their offsets."""
    for start in range(0, len(data), _CHUNK):
        piece = bytes(data[start : start + _CHUNK])
        if piece != _ZEROS[: len(piece)]:
            yield start, piece


def _fill(data: Buffer, content: Mapping[int, bytes]) -> None:
    """Make `content` all there is; pages that are right already are not touched."""
    for start in range(0, len(data), _CHUNK):
        now = bytes(data[start : start + _CHUNK])
        wanted = content.get(start, b"").ljust(len(now), b"\0")
        if now != wanted:
            data[start : start + len(now)] = wanted


class Region:
    """One area: its bytes, how far they are allocated, and what they are after a reset.

    `data` is the memory itself; programs and services read and write it in place. It is the same
    object for ever, but may get longer while variables are being allocated. Only an empty area
    that becomes a large one gets another.
    """

    __slots__ = ("_grows", "_initial", "_retained_slices", "_used", "area", "data")

    def __init__(self, area: Area, size: int) -> None:
        self.area = area
        self.data = _zeros(size)
        self._grows = area in _GROWING
        self._initial: Mapping[int, bytes] = {}
        self._retained_slices: list[slice] = []
        self._used = 0

    def __len__(self) -> int:
        return len(self.data)

    # allocation ------------------------------------------------------------------------------

    def allocate(self, size: int, alignment: int = 1) -> int:
        """Return the byte offset of `size` new bytes, a multiple of `alignment`.

        Raises AreaFullError if a process image or the flag memory is full.
        """
        offset = -(-self._used // alignment) * alignment
        self.place(offset, size)
        return offset

    def place(self, offset: int, size: int) -> None:
        """Take the bytes at a fixed offset; they may overlap others, as on a real PLC."""
        end = offset + size
        if end > 1 << ADDRESS_BITS:
            raise AreaFullError(
                f"{self.area.value} has at most {1 << ADDRESS_BITS} bytes, bytes"
                f" {offset}..{end - 1} do not fit"
            )
        if end + _HEADROOM * self._grows > len(self.data):
            if not self._grows:
                raise AreaFullError(
                    f"{self.area.value} has {len(self.data)} bytes, bytes {offset}..{end - 1}"
                    " do not fit"
                )
            self.grow(-(-(end + _HEADROOM) // _GROWTH) * _GROWTH)
        self._used = max(self._used, end)

    def grow(self, size: int) -> None:
        """Grow to at least `size` bytes. AreaFullError if the system cannot do that in place."""
        if size <= len(self.data):
            return
        try:
            if not self.data and size >= _SPARSE_LATER:
                self._begin_sparse(size)
            elif isinstance(self.data, Bytes):
                self.data.extend(bytes(size - len(self.data)))
            else:
                self.data.resize(size)
        except (BufferError, MemoryError, OSError, SystemError, ValueError):
            raise AreaFullError(
                f"{self.area.value} has {len(self.data)} bytes and cannot grow to {size} here"
            ) from None

    def _begin_sparse(self, size: int) -> None:
        """Allocate memory whose pages come as they are used; the area has none before."""
        empty, self.data = self.data, _sparse_zeros(size)
        for name in Bytes.__slots__:
            if hasattr(empty, name):
                setattr(self.data, name, getattr(empty, name))

    def keep(self, offset: int, size: int) -> None:
        """Let a reset spare these bytes (retain and persistent variables)."""
        self._retained_slices.append(slice(offset, offset + size))

    def hold_initial(self) -> None:
        """Take the present content as what `reset` restores; stack and heap begin with zeros."""
        self._initial = {} if self.area in _OF_CALLS else dict(_pieces(self.data))

    def initial(self, offset: int, length: int) -> bytes:
        """Return the start values of these bytes after a reset. MemoryRangeError unless all of them
        exist."""
        self._check(offset, length)
        content = bytearray(length)
        for start in range(offset // _CHUNK * _CHUNK, offset + length, _CHUNK):
            piece = self._initial.get(start, b"")
            first, end = max(offset, start), min(offset + length, start + len(piece))
            if end > first:
                content[first - offset : end - offset] = piece[first - start : end - start]
        return bytes(content)

    def reset(self, *, origin: bool = False) -> None:
        """Restore the initial values: all (`origin`), or all that is not kept (cold)."""
        retained = [] if origin else [(part, self.data[part]) for part in self._retained_slices]
        _fill(self.data, self._initial)
        for part, content in retained:
            self.data[part] = content

    def begin_again(self) -> None:
        """Forget all variables: zeros, nothing allocated, nothing kept. The size stays."""
        self.clear()
        self._initial = {}
        self._retained_slices.clear()
        self._used = 0

    # access ----------------------------------------------------------------------------------

    def read(self, offset: int, length: int) -> bytes:
        """`length` bytes from `offset`. Raises MemoryRangeError unless all of them exist."""
        self._check(offset, length)
        return bytes(self.data[offset : offset + length])

    def write(self, offset: int, content: bytes | memoryview) -> None:
        """Put `content` at `offset`. Raises MemoryRangeError unless all of it fits."""
        self._check(offset, len(content))
        self.data[offset : offset + len(content)] = content

    def put_initial(self, offset: int, variable: Variable[Any, Any]) -> None:
        """Put the initial value of `variable` at `offset`. Raises MemoryRangeError unless all of
        it fits, and DeclarationError."""
        self._check(offset, variable.type.size)
        variable.put_initial(self.data, offset)

    def read_bits(self, number: int, count: int) -> bytes:
        """`count` bits from bit `number` (byte · 8 + bit), one byte 0 or 1 for each."""
        self._check_bits(number, count)
        data = self.data
        return bytes(data[bit >> 3] >> (bit & 7) & 1 for bit in range(number, number + count))

    def write_bits(self, number: int, values: bytes) -> None:
        """Set the bits from `number` on: one byte for each, zero or not."""
        self._check_bits(number, len(values))
        for bit, value in enumerate(values, number):
            mask = 1 << (bit & 7)
            if value:
                self.data[bit >> 3] |= mask
            else:
                self.data[bit >> 3] &= ~mask

    def clear(self) -> None:
        """Set all bytes to zero."""
        _fill(self.data, {})

    def snapshot(self) -> Buffer:
        """Return a copy of the content."""
        copy = _zeros(len(self.data))
        _fill(copy, dict(_pieces(self.data)))
        return copy

    def restore(self, content: Buffer) -> None:
        """Put the content of an earlier `snapshot` over this; what has grown since stays."""
        for start in range(0, len(content), _CHUNK):
            then = content[start : start + _CHUNK]
            if self.data[start : start + len(then)] != then:
                self.data[start : start + len(then)] = then

    def digest(self) -> bytes:
        """Return a hash of the content, 16 bytes."""
        state = hashlib.blake2b(len(self.data).to_bytes(8, "little"), digest_size=16)
        for start, piece in _pieces(self.data):
            state.update(start.to_bytes(8, "little"))
            state.update(piece)
        return state.digest()

    def _check(self, offset: int, length: int) -> None:
        if offset < 0 or offset + length > len(self.data):
            raise MemoryRangeError(self.area, offset, length, len(self.data))

    def _check_bits(self, number: int, count: int) -> None:
        first = number >> 3
        self._check(first, ((number + count + 7) >> 3) - first)


class Memory:
    """The areas of one PLC: `memory[Area.FLAG].read(4, 2)`.

    `sizes` overrides DEFAULT_SIZES by area, in bytes.
    """

    def __init__(self, sizes: dict[Area, int] | None = None) -> None:
        for area, size in (sizes or {}).items():
            if size < 0:
                raise ValueError(f"the size of {area.value} is 0 bytes or more, got {size}")
        chosen = DEFAULT_SIZES | (sizes or {})
        self.sizes = chosen
        self.regions = {area: Region(area, chosen[area]) for area in Area}
        self.statics: dict[Variable[Any, Any], Place] = {}
        for region in self.regions.values():
            region.data.statics = self.statics

    def __getitem__(self, area: Area) -> Region:
        return self.regions[area]

    def grow(self, sizes: Mapping[Area, int]) -> None:
        """Grow to at least these sizes in bytes. Raises `AreaFullError` where the system cannot."""
        for area, size in sizes.items():
            self[area].grow(size)
            self.sizes[area] = max(size, self.sizes[area])

    def begin_again(self) -> None:
        """Forget all variables, as before the first was placed."""
        for region in self.regions.values():
            region.begin_again()
        self.statics.clear()

    def address(self, area: Area, offset: int) -> int:
        """Return the value of a pointer to that byte: never 0, and within 32 bits."""
        return (_AREAS.index(area) + 1 << ADDRESS_BITS) + offset

    def at(self, address: int) -> tuple[Region, int] | None:
        """Return the target of a pointer; None if it is not an address of a byte in any area."""
        number, offset = divmod(address, 1 << ADDRESS_BITS)
        if not 1 <= number <= len(_AREAS):
            return None
        region = self.regions[_AREAS[number - 1]]
        return (region, offset) if offset < len(region) else None

    def address_of(self, buffer: Buffer, offset: int) -> int:
        """Return the value of a pointer to a byte of an area, by the area's memory. KeyError."""
        for area, region in self.regions.items():
            if region.data is buffer:
                return self.address(area, offset)
        raise KeyError("not memory of this PLC")

    def let_invoke(self, invoke: Invoke) -> None:
        """Set the function that runs the Structured Text of the blocks in this memory."""
        for region in self.regions.values():
            region.data.invoke = invoke

    def hold_initial(self) -> None:
        """Take the present content of all areas as what `reset` restores."""
        for region in self.regions.values():
            region.hold_initial()

    def reset(self, *, origin: bool = False) -> None:
        """Initialise all variables again; retain and persistent ones only if `origin`."""
        for region in self.regions.values():
            region.reset(origin=origin)

    def digest(self) -> bytes:
        """Return a hash of the whole content, 16 bytes: equal memories have equal digests."""
        state = hashlib.blake2b(digest_size=16)
        for region in self.regions.values():
            state.update(region.digest())
        return state.digest()
