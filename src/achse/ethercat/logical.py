"""Logical datagrams: which bytes of a datagram go to and come from which slave, planned once.

A plan holds for one command, address and length until a slave reports that its mapping changed.

Source: ETG.1000.4 §6.6; working counters 001 table 2.3.1.1.
"""

from collections.abc import Callable, Iterable
from functools import partial
from itertools import pairwise

from achse.ethercat.esc import Esc
from achse.ethercat.fmmu import Transfer
from achse.ethercat.frame import DatagramCommand
from achse.ethercat.registers import RAM_BASE, SM_BASE

_STATUS_BIT = 8 * 5 + 3
"""Of the registers of a SyncManager: "mailbox full" in its status."""

_Take = tuple[Callable[[bytes], None], slice]
_Give = tuple[Callable[[], bytes], slice]
_Flag = tuple[Callable[[], bool], int]
_Parts = tuple[Esc, list[Transfer], list[Transfer]]


class Plan:
    """Effect of a logical datagram on all slaves of a segment.

    Whole buffers are exchanged by `takes` (outputs) and `gives` (inputs): function and part of the
    data. Then the working counter increases by `count`, whatever the buffers contain. `flags` are
    bits of mailboxes that are full, which masters read together: function and bit as a number. If
    anything else is mapped (bits, parts of buffers, mailboxes), or a slave takes the data of a
    slave before it, `exact` is True and `exchange` processes the datagram slave by slave.
    """

    __slots__ = ("_foreign_bits", "_parts", "count", "exact", "flags", "gives", "span", "takes")

    def __init__(
        self, escs: Iterable[Esc], command: DatagramCommand, address: int, length: int
    ) -> None:
        self.takes: list[_Take] = []
        self.gives: list[_Give] = []
        self.flags: list[_Flag] = []
        self.count = 0
        self.exact = False
        self._parts: list[_Parts] = []
        filled: list[slice] = []
        for esc in escs:
            writes = _transfers(esc, address, length, writes=True) if command.writes else []
            reads = _transfers(esc, address, length, writes=False) if command.reads else []
            if not (writes or reads):
                continue
            self._parts.append((esc, writes, reads))
            takes = [_take(esc, transfer) for transfer in writes]
            flags = [flag for transfer in reads if (flag := _flag(esc, transfer)) is not None]
            gives = [_give(esc, each) for each in reads] if not flags else []
            self.flags += flags
            if flags and len(flags) < len(reads):
                self.exact = True
            for take in takes:
                if take is None or any(_overlap(take[1], part) for part in filled):
                    self.exact = True
                else:
                    self.takes.append(take)
            for give in gives:
                if give is None:
                    self.exact = True
                else:
                    self.gives.append(give)
                    filled.append(give[1])
            self.count += _increment(command, bool(reads), bool(writes))
        bits = [bit for _, bit in self.flags]
        if bits and (self.takes or self.gives or len(set(bits)) < len(bits)):
            self.exact = True
        self._foreign_bits = ~sum(set(bits))
        self.span = _span([part for _, part in self.gives])
        """The part of the data that `gives` fill one after the other without gap, if they do."""

    def look(self, data: bytes) -> bytes:
        """`data` with the `flags` as they are now."""
        value = int.from_bytes(data, "little") & self._foreign_bits
        for full, bit in self.flags:
            if full():
                value |= bit
        return value.to_bytes(len(data), "little")

    @property
    def escs(self) -> list[Esc]:
        """The slaves that it concerns."""
        return [esc for esc, _, _ in self._parts]

    def exchange(self, command: DatagramCommand, data: bytearray) -> int:
        """Exchange `data` with each slave in turn, bit by bit; the increment of the counter."""
        count = 0
        for esc, writes, reads in self._parts:
            wrote = read = False
            for datagram_bit, memory_bit, bits in writes:
                value = int.from_bytes(data, "little") >> datagram_bit
                wrote |= esc.write_bits(memory_bit, bits, value)
            for datagram_bit, memory_bit, bits in reads:
                read_value = esc.read_bits(memory_bit, bits)
                if read_value is not None:
                    mask = (1 << bits) - 1 << datagram_bit
                    value = int.from_bytes(data, "little") & ~mask | read_value << datagram_bit
                    data[:] = value.to_bytes(len(data), "little")
                    read = True
            count += _increment(command, read, wrote)
        return count


def _increment(command: DatagramCommand, read: bool, wrote: bool) -> int:
    """Return the working counter increment by one slave (001 table 2.3.2.1)."""
    return read + wrote * (2 if command.reads else 1)


def _transfers(esc: Esc, address: int, length: int, *, writes: bool) -> list[Transfer]:
    return [
        transfer
        for fmmu in esc.fmmus
        if (fmmu.writes if writes else fmmu.reads)
        and (transfer := fmmu.transfer(address, length)) is not None
    ]


def _span(parts: list[slice]) -> slice | None:
    if any(one.stop != other.start for one, other in pairwise(parts)):
        return None
    return slice(parts[0].start, parts[-1].stop) if parts else None


def _overlap(one: slice, other: slice) -> bool:
    return bool(one.start < other.stop and other.start < one.stop)


def _bytes(transfer: Transfer) -> tuple[int, int, int] | None:
    """Position in the data, address and number of bytes, if the transfer is of whole bytes."""
    if not transfer.in_bytes:
        return None
    return transfer.datagram_bit >> 3, transfer.memory_bit >> 3, transfer.bits >> 3


def _take(esc: Esc, transfer: Transfer) -> _Take | None:
    if (place := _bytes(transfer)) is None:
        return None
    position, address, length = place
    for each in esc.sync_managers:
        if each.works and (each.start, each.length) == (address, length):
            if each.buffered and each.to_application:
                return each.sink or each.complete, slice(position, position + length)
            return None
    return None


def _give(esc: Esc, transfer: Transfer) -> _Give | None:
    if (place := _bytes(transfer)) is None:
        return None
    position, address, length = place
    if address + length <= RAM_BASE:
        return partial(_registers, esc, address, length), slice(position, position + length)
    for each in esc.sync_managers:
        if each.works and (each.start, each.length) == (address, length):
            if each.buffered and not each.to_application and each.source is not None:
                return each.source, slice(position, position + length)
            return None
    return None


def _flag(esc: Esc, transfer: Transfer) -> _Flag | None:
    """Bit "mailbox full" of the status of a SyncManager."""
    number, bit = divmod(transfer.memory_bit - 8 * SM_BASE - _STATUS_BIT, 64)
    if transfer.bits != 1 or bit or not 0 <= number < len(esc.sync_managers):
        return None
    return partial(esc.holds_message, number), 1 << transfer.datagram_bit


def _registers(esc: Esc, address: int, length: int) -> bytes:
    return esc.read(address, length) or bytes(length)
