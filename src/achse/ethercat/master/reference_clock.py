"""The reference clock of a bus: which slave's time goes to all others, and what if it fails.

Frames carry the time of the first slave with a clock. When that slave does not answer, they carry
none from the next cycle on, until the next slave with a clock is the reference: its time is that of
the bus already. A slave in front of the reference would get no time, so that the first one is the
reference again when it is back.

A reference whose time jumps takes its SYNC0 along at once, and all others by 1 µs in each cycle.
Its time is compared with that of the station; a jump is taken out of its offset.

Source: ETG.1000.4 §6.8; "the first slave with DC is the reference" as open masters have it.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from achse.ethercat.frame import Datagram, DatagramCommand
from achse.ethercat.master.bus_slave import BusSlave
from achse.ethercat.master.clocks import measure_clocks, restart_loop, shift_clock, write_delay
from achse.ethercat.master.cyclic import CyclicExchange
from achse.ethercat.master.errors import BusError
from achse.ethercat.master.events import BusEventKind
from achse.ethercat.master.redundancy import Redundancy
from achse.ethercat.master.steps import Steps, Trip
from achse.ethercat.registers import Register

_MISSES = 3
"""A slave that answers, but so often not with its time, is not the reference any more: once may be
a frame of a redundant bus of which one copy is missing."""
_JUMP = 2
"""A difference above this part of the cycle is a jump: late frames and drift are less."""


class _Reading(NamedTuple):
    reference_ns: int
    now_ns: int


class ReferenceClock:
    """Appoints the reference of each part of a bus and watches its time."""

    def __init__(
        self,
        slaves: Sequence[BusSlave],
        cyclic: CyclicExchange,
        cycle_ns: int,
        report: Callable[[BusEventKind, BusSlave | None, int, str], None],
        redundancy: Redundancy | None,
    ) -> None:
        self.station: int | None = None
        """Station of the reference, None for none."""
        self._slaves = slaves
        self._cyclic = cyclic
        self._limit_ns = cycle_ns // _JUMP
        self._report = report
        self._redundancy = redundancy
        self._silent: set[int] = set()
        """Stations that answered, but not with their time."""
        self._misses = 0
        self._before: _Reading | None = None
        self._doubted = False

    def appoint(self, station: int | None) -> None:
        """Let the clock of a station be the reference, None for none."""
        self.station = station
        self._cyclic.set_reference(station)
        self._before = None

    def admit(self, present: Sequence[BusSlave], newcomers: set[int]) -> Steps[None]:
        """Set the clocks of slaves that came (stations), of `present` that frames pass."""
        self._silent -= newcomers
        clocks = [slave for slave in present if slave.facts.has_clock]
        known = next((slave for slave in clocks if slave.station not in newcomers), None)
        is_before = bool(clocks) and clocks[0].station in newcomers
        if is_before:  # it would follow frames that do not have the time yet
            self._cyclic.set_reference(None)
        try:
            reference = yield from measure_clocks(present, newcomers, self.station)
            if known is not None and is_before:
                yield from self._align(clocks[0], known)
        except BusError:
            self._cyclic.set_reference(self.station)
            raise
        self.appoint(reference)

    def update(self) -> Steps[None]:
        """Replace a reference that is lost, or does not answer."""
        if self.station is None:
            return
        lost = self._slave(self.station)
        if lost.present:
            if not self._cyclic.reference_lost:
                return
            self._misses += 1
            if self._misses < _MISSES:
                self._cyclic.set_reference(self.station)
                yield from self._restart_loops()
                return
            self._silent.add(self.station)
        self._misses = 0
        yield from self.divide()
        yield from self._restart_loops()
        if self.station is None:
            text = f"{lost.name} does not answer with its time: no other slave has a clock"
            self._report(BusEventKind.REFERENCE, None, 0, text)
        else:
            slave = self._slave(self.station)
            text = f"{lost.name} does not answer with its time: {slave.name} is the reference now"
            self._report(BusEventKind.REFERENCE, slave, self.station, text)

    def _restart_loops(self) -> Steps[None]:
        """Let all loops forget what they learned of a wrong time."""
        for slave in self._slaves:
            if slave.present and slave.facts.has_clock:
                yield from restart_loop(slave.station)

    def _slave(self, station: int) -> BusSlave:
        return next(each for each in self._slaves if each.station == station)

    def divide(self) -> Steps[None]:
        """Let the first clock of each part of the bus be the reference of that part."""
        redundancy = self._redundancy
        present = [each for each in self._slaves if each.present]
        split = None if redundancy is None else redundancy.split
        first = len(present) if split is None else split
        parts = present[:first], present[first:]
        references = [next(filter(self._can_be_reference, part), None) for part in parts]
        bus_reference = references[0] or references[1]
        self.appoint(None if bus_reference is None else bus_reference.station)
        if redundancy is not None:
            second = references[1]
            redundancy.reference = None if second is None else second.station
        for part, reference in zip(parts, references, strict=True):
            for slave in part:
                if reference is not None and slave.facts.has_clock:
                    delay = max(slave.facts.delay_ns - reference.facts.delay_ns, 0)
                    yield from write_delay(slave.station, delay)

    def _can_be_reference(self, slave: BusSlave) -> bool:
        return slave.facts.has_clock and slave.station not in self._silent

    def watch(self) -> Steps[bytes]:
        """Read all time differences by OR, and the time of the reference: a jump is taken out."""
        differences = Register.SYSTEM_TIME_DIFFERENCE
        assert self.station is not None
        self._misses = 0
        back = yield Trip(
            (
                Datagram.at(DatagramCommand.BRD, 0, differences, bytes(differences.size)),
                Datagram.at(DatagramCommand.FPRD, self.station, Register.SYSTEM_TIME, bytes(8)),
            )
        )
        far, time = back.datagrams
        if time.counter:
            yield from self._compare(_Reading(int.from_bytes(time.data, "little"), back.now_ns))
        return far.data

    def _compare(self, reading: _Reading) -> Steps[None]:
        before = self._before
        if before is None:
            self._before, self._doubted = reading, False
            return
        passed = reading.now_ns - before.now_ns
        jump = _signed(reading.reference_ns - before.reference_ns - passed)
        if abs(jump) <= self._limit_ns:
            self._before, self._doubted = reading, False
        elif not self._doubted:  # one frame that was late looks the same
            self._doubted = True
        else:
            yield from self._take_out(jump)

    def _take_out(self, jump_ns: int) -> Steps[None]:
        self._before = None
        assert self.station is not None
        reference = self._slave(self.station)
        yield from shift_clock(reference, -jump_ns)
        for slave in self._slaves:
            if slave is not reference and slave.present and slave.facts.has_clock:
                yield from self._align(slave, reference)
        yield from self._restart_loops()
        text = (
            f"{reference.name}: its time, that of the reference, jumped by {jump_ns} ns: set back"
        )
        self._report(BusEventKind.REFERENCE, reference, jump_ns, text)

    def _align(self, slave: BusSlave, reference: BusSlave) -> Steps[None]:
        """Bring a clock to the time of another at once, however far it is away."""
        time = Register.SYSTEM_TIME
        stations = reference.station, slave.station
        back = yield Trip(
            tuple(Datagram.at(DatagramCommand.FPRD, each, time, bytes(8)) for each in stations)
        )
        if all(each.counter for each in back.datagrams):
            first, second = (int.from_bytes(each.data, "little") for each in back.datagrams)
            on_the_way = slave.facts.delay_ns - reference.facts.delay_ns
            yield from shift_clock(slave, -_signed(second - first - on_the_way))

    @property
    def doubted(self) -> bool:
        """True if the next reading has to confirm the last one."""
        return self._doubted


def _signed(number: int) -> int:
    """Return the difference of two times of 64 bits."""
    return (number + (1 << 63)) % (1 << 64) - (1 << 63)
