"""The memory areas of a PLC as index groups: bytes, single bits, sizes, clearing."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from achse.ams import DeviceError
from achse.codes import PlcGroup, ReservedGroup, ReturnCode
from achse.native.memory import MemoryCell
from achse.plc import Area, Memory, MemoryRangeError, Region
from achse.server import BYTES, READ, WRITE, AreaGroup, Group, IndexGroup, Layout, Service

_UINT32 = Layout("<I")


@dataclass(frozen=True, slots=True)
class AreaGroups:
    """The index groups of one area; None where the area has no such service."""

    area: Area
    title: str
    bytes: int
    bits: int
    size: int
    clear: int | None = None
    base: int = 0
    """First byte offset according to 002 and 003, their bit offsets begin at eight times that;
    000 begins at 0. Both are served, unless the area is so large that they overlap: then from 0
    only."""
    source: str = "000, 002"


AREA_GROUPS = {
    groups.area: groups
    for groups in (
        AreaGroups(
            Area.FLAG, "flag memory %M", PlcGroup.FLAGS, PlcGroup.FLAG_BITS, PlcGroup.FLAGS_SIZE
        ),
        # 0x4031 and 0x4041 are in no manual: bits of BIT variables need an address as well.
        AreaGroups(
            Area.RETAIN, "retain data", PlcGroup.RETAIN, PlcGroup.RETAIN_BITS, PlcGroup.RETAIN_SIZE
        ),
        AreaGroups(Area.DATA, "data", PlcGroup.DATA, PlcGroup.DATA_BITS, PlcGroup.DATA_SIZE),
        AreaGroups(
            Area.INPUT,
            "inputs %I",
            ReservedGroup.INPUTS,
            ReservedGroup.INPUT_BITS,
            ReservedGroup.INPUTS_SIZE,
            ReservedGroup.CLEAR_INPUTS,
            0x1_F400,
            "000, 002, 003",
        ),
        AreaGroups(
            Area.OUTPUT,
            "outputs %Q",
            ReservedGroup.OUTPUTS,
            ReservedGroup.OUTPUT_BITS,
            ReservedGroup.OUTPUTS_SIZE,
            ReservedGroup.CLEAR_OUTPUTS,
            0x3_E800,
            "000, 002, 003",
        ),
    )
}
"""The areas of a PLC on the wire (002: READ_M, READ_MX, PLCADS_IGR_RWDB, READ_I, READ_IX …)."""


def area_groups(memory: Memory) -> Iterator[IndexGroup]:
    """Yield the rows of all areas, bound to `memory`.

    An access that begins outside the area is answered 0x703, one that ends outside 0x705; nothing
    is read or written then.
    """
    for groups in AREA_GROUPS.values():
        region = memory[groups.area]
        read, write = _based(_counted(groups.base, region), region.read, region.write)
        yield AreaGroup(
            groups.bytes,
            read,
            write,
            watch=_places(_counted(groups.base, region), region),
            name=groups.title,
            description=f"Bytes of {groups.title}; offset in bytes{_from(groups.base)}.",
            source=groups.source,
        )
        read, write = _based(_counted(groups.base, region, 8), region.read_bits, region.write_bits)
        yield AreaGroup(
            groups.bits,
            read,
            write,
            name=f"bits of {groups.title}",
            description=(
                f"Bits of {groups.title}, one per byte of data;"
                f" offset = byte * 8 + bit{_from(groups.base * 8)}."
            ),
            source=groups.source,
        )
        yield Group(
            groups.size,
            (
                Service(
                    0,
                    f"size of {groups.title}",
                    READ,
                    _UINT32,
                    "Size of the area.",
                    "bytes",
                    read=len,
                    source=groups.source,
                ),
            ),
            region,
        )
        if groups.clear is not None:
            yield Group(
                groups.clear,
                (
                    Service(
                        0,
                        f"clear {groups.title}",
                        WRITE,
                        BYTES,
                        "Sets all bytes to zero; data is not looked at.",
                        write=_clear,
                        source=groups.source,
                    ),
                ),
                region,
            )


def _from(base: int) -> str:
    return f", counted from 0 or from 0x{base:X}" if base else ""


def _clear(region: Region, _: bytes) -> None:
    region.clear()


def _counted(base: int, region: Region, unit: int = 1) -> Callable[[int], int]:
    """Return the function that converts a client's offset to the offset in an area.

    Offsets count from 0, and from `base` too unless the area, which may grow, reaches so far.
    `unit` is 8 for bits."""
    base *= unit
    return lambda offset: offset if offset < base or len(region) * unit > base else offset - base


def _based(
    counted: Callable[[int], int],
    read: Callable[[int, int], bytes],
    write: Callable[[int, bytes], None],
) -> tuple[Callable[[int, int], bytes], Callable[[int, bytes], None]]:
    """Return the same functions with offsets as clients count them, and errors with their code."""

    def based_read(offset: int, length: int) -> bytes:
        try:
            return read(counted(offset), length)
        except MemoryRangeError as failure:
            raise _refusal(failure) from None

    def based_write(offset: int, data: bytes) -> None:
        try:
            write(counted(offset), data)
        except MemoryRangeError as failure:
            raise _refusal(failure) from None

    return based_read, based_write


def _places(counted: Callable[[int], int], region: Region) -> Callable[[int, int], MemoryCell]:
    """Return the function that finds the memory cell of an offset and a length."""
    return lambda offset, length: MemoryCell(region.data, counted(offset), length)


def _refusal(failure: MemoryRangeError) -> DeviceError:
    code = ReturnCode.INVALID_OFFSET if failure.outside else ReturnCode.INVALID_SIZE
    return DeviceError(code, str(failure))
