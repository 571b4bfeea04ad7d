"""The process image of a bus by names: what its slaves exchange, and how they and the bus are.

`Inputs.DevState`, `InfoData.CfgSlaveCount`, `<box>.<PDO>.<entry>`, `<box>.WcState.WcState`,
`<box>.InfoData.State`. The bus has its variables first, then each box its own.

Source: variables of the vendor's project files and manuals (EtherCAT system, InfoData); 000 §5.5.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from achse.codes import DataType, ReservedGroup
from achse.devices.io.served import ServedBus
from achse.ethercat.master import BusSlave
from achse.ethercat.master.process_image import EntryPlace
from achse.iec import (
    ARRAY,
    BOOL,
    DINT,
    INT,
    LINT,
    LREAL,
    REAL,
    SINT,
    UDINT,
    UINT,
    ULINT,
    USINT,
    IecType,
)

INPUT_BASE, OUTPUT_BASE = 0x1F400, 0x3E800
"""Byte offsets of the inputs and outputs in their index groups."""

NET_ID, ADDRESS = ARRAY(USINT, (0, 5)), ARRAY(USINT, (0, 7))
_TYPES: dict[int, IecType[Any]] = {
    DataType.BOOL: BOOL,
    DataType.I8: SINT,
    DataType.I16: INT,
    DataType.I32: DINT,
    DataType.I64: LINT,
    DataType.U8: USINT,
    DataType.U16: UINT,
    DataType.U32: UDINT,
    DataType.U64: ULINT,
    DataType.F32: REAL,
    DataType.F64: LREAL,
}
_BY_BITS: dict[int, IecType[Any]] = {1: BOOL, 8: USINT, 16: UINT, 32: UDINT, 64: ULINT}


@dataclass(frozen=True)
class ImageVariable:
    """One variable. `bit` counts from the begin of the inputs or `output`s; `read` gives the value
    in the bytes of its type."""

    name: str
    type: IecType[Any]
    output: bool
    bit: int
    bits: int
    read: Callable[[], bytes]
    comment: str = ""

    @property
    def place(self) -> tuple[int, int]:
        """Index group and offset: bytes, or for what is within a byte bits."""
        base = OUTPUT_BASE if self.output else INPUT_BASE
        if self.bit & 7 or self.bits & 7:
            group = ReservedGroup.OUTPUT_BITS if self.output else ReservedGroup.INPUT_BITS
            return group, 8 * base + self.bit
        return ReservedGroup.OUTPUTS if self.output else ReservedGroup.INPUTS, base + self.bit // 8


class BusImage:
    """The variables of one bus, in order."""

    def __init__(self, bus: ServedBus) -> None:
        self.bus = bus
        self._end = {False: 0, True: 0}
        """Bits of each direction so far."""
        self.variables = tuple(self._all())

    def size(self, output: bool) -> int:
        """Return bytes of one direction."""
        return self._end[output] + 7 >> 3

    def contents(self, output: bool) -> bytes:
        """Return all bytes of one direction as they are now."""
        image = 0
        for each in self.variables:
            if each.output == output:
                image |= int.from_bytes(each.read(), "little") << each.bit
        return image.to_bytes(self.size(output), "little")

    def _all(self) -> Iterator[ImageVariable]:
        yield from self._of_bus()
        for slave in self.bus.master.slaves:
            yield from self._of_box(slave)

    def _word(
        self,
        name: str,
        type: IecType[Any],
        read: Callable[[], int],
        output: bool = False,
        comment: str = "",
    ) -> ImageVariable:
        size = type.size
        mask = (1 << 8 * size) - 1
        return self._bytes(
            name, type, lambda: (read() & mask).to_bytes(size, "little"), output, comment
        )

    def _bytes(
        self,
        name: str,
        type: IecType[Any],
        read: Callable[[], bytes],
        output: bool = False,
        comment: str = "",
    ) -> ImageVariable:
        begin = self._whole(output)
        self._end[output] = begin + 8 * type.size
        return ImageVariable(name, type, output, begin, 8 * type.size, read, comment)

    def _whole(self, output: bool) -> int:
        return self._end[output] + 7 & ~7

    def _of_bus(self) -> Iterator[ImageVariable]:
        bus, word = self.bus, self._word
        cyclic, watch = bus.master.cyclic, bus.master.supervision
        for number in range(len(cyclic.frame_states)):

            def wrong(number: int = number) -> int:
                return cyclic.frame_states[number]

            yield word(
                f"Inputs.Frm{number}State",
                UINT,
                lambda: 0,
                comment="Bit k: command k + 1 was left out",
            )
            yield word(
                f"Inputs.Frm{number}WcState",
                UINT,
                wrong,
                comment="Bit k: command k + 1 has a wrong working counter; bit 15: frame missing",
            )
            yield word(
                f"Inputs.Frm{number}InputToggle",
                UINT,
                lambda: cyclic.counters.sent - cyclic.counters.lost & 1,
            )
        yield word("Inputs.SlaveCount", UINT, lambda: bus.counts[0], comment="Slaves found")
        yield word("Inputs.DevState", UINT, lambda: bus.dev_state, comment="0: all is well")
        if bus.master.redundancy is not None:
            second = "At the second adapter"
            yield word("Inputs.SlaveCount2", UINT, lambda: bus.counts[1], comment=second)
            yield word("Inputs.DevState2", UINT, lambda: bus.second_dev_state, comment=second)
        yield word("InfoData.ChangeCount", UINT, lambda: watch.changes)
        yield word("InfoData.DevId", UINT, lambda: bus.number)
        yield self._bytes("InfoData.AmsNetId", NET_ID, lambda: bytes(bus.net_id))
        yield word("InfoData.CfgSlaveCount", UINT, lambda: len(bus.master.slaves))

    def _of_box(self, slave: BusSlave) -> Iterator[ImageVariable]:
        names = {
            pdo.index: pdo.name or f"{pdo.index:04X}"
            for pdo in (*slave.configuration.outputs, *slave.configuration.inputs)
        }
        for output, entries, memory in (
            (True, slave.output_entries, slave.outputs),
            (False, slave.input_entries, slave.inputs),
        ):
            begin = self._whole(output)
            self._end[output] = begin + 8 * len(memory)
            for each in entries.values():
                yield _entry(f"{slave.name}.{names[each.pdo]}", each, output, begin, memory)
        begin = self._whole(False)
        self._end[False] = begin + 8
        for bit, name, comment, read in (
            (0, "WcState", "FALSE: valid in the last cycle", lambda: not slave.working),
            (1, "InputToggle", "Changes with each valid telegram", lambda: slave.input_toggle),
        ):

            def state(read: Callable[[], bool] = read) -> bytes:
                return bytes((read(),))

            path = f"{slave.name}.WcState.{name}"
            yield ImageVariable(path, BOOL, False, begin + bit, 1, state, comment)
        info = f"{slave.name}.InfoData"
        yield self._bytes(f"{info}.State", UINT, lambda: self.bus.state_bytes(slave))
        yield self._bytes(f"{info}.AdsAddr", ADDRESS, lambda: bytes(self.bus.address(slave)))
        if slave.configuration.clock is not None:
            cycle = self.bus.master.bus.cycle_ns
            yield self._word(
                f"{info}.DcOutputShift", DINT, lambda: slave.output_shift_ns, comment="ns"
            )
            yield self._word(
                f"{info}.DcInputShift",
                DINT,
                lambda: slave.output_shift_ns - cycle if slave.output_shift_ns else 0,
                comment="ns",
            )


def _entry(
    path: str, place: EntryPlace, output: bool, begin: int, memory: memoryview
) -> ImageVariable:
    """Return the variable of an entry; bits beyond a simple type are a number without sign."""
    type = _type_of(place)
    shift, size = place.bit & 7, type.size
    part = slice(place.byte, place.byte + (shift + place.bits + 7 >> 3))
    mask = (1 << place.bits) - 1

    def read() -> bytes:
        value = int.from_bytes(memory[part], "little") >> shift & mask
        return value.to_bytes(size, "little")

    name = place.name or f"{place.index:04X}:{place.subindex:02X}"
    return ImageVariable(f"{path}.{name}", type, output, begin + place.bit, place.bits, read)


def _type_of(place: EntryPlace) -> IecType[Any]:
    type = _TYPES.get(place.data_type)
    if type is not None and place.bits == (1 if type is BOOL else 8 * type.size):
        return type
    if place.bits == 1:
        return BOOL
    for bits, fitting in _BY_BITS.items():
        if bits >= 8 and bits >= place.bits:
            return fitting
    return ARRAY(USINT, (1, -(-place.bits // 8)))


def distinct(variables: Sequence[ImageVariable]) -> Iterator[tuple[str, ImageVariable]]:
    """Yield each variable with a name of its own: a name that is there gets a number."""
    seen: dict[str, int] = {}
    for each in variables:
        count = seen[each.name] = seen.get(each.name, 0) + 1
        yield each.name if count == 1 else f"{each.name}_{count}", each
