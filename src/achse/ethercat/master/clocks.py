"""Distributed clocks: delays and offsets of all slaves, SYNC signals of each.

The system time is that of the bus: what the station hands in when the frames go out.

Source: ETG.1000.4 §6.8, tables 60 and 61.
"""

import struct
from collections.abc import Collection, Sequence
from dataclasses import replace

from achse.ethercat.frame import Datagram, DatagramCommand
from achse.ethercat.master.bus_slave import BusSlave
from achse.ethercat.master.configuration import ClockConfiguration
from achse.ethercat.master.errors import BusError, FrameLost
from achse.ethercat.master.steps import Pause, Steps, Trip, read, read_number, write
from achse.ethercat.master.topology import build_tree, propagation_delays
from achse.ethercat.registers import Register

_LEAD_NS = 100_000_000
"""SYNC0 begins that long after it is set, rounded up to the cycle."""
_TRIES = 3
_BURST, _BURST_NS = 20, 1_000_000
"""Telegrams with the time in a frame, and how long to the next."""
_READINGS = 3
_U64 = 0xFFFF_FFFF_FFFF_FFFF
_SIGN = 0x8000_0000
_TIMES = struct.Struct("<4I8xQ")
"""From register 0x0900: four ports; the processing unit's time is 0x18 behind."""

_REACH = Register.RECEIVE_TIME_UNIT.end - Register.RECEIVE_TIME_PORT_0


_CLASSES_US = (1, 2, 5, 10, 20, 50, 100, 200, 500)
"""Ends of the classes of a deviation, in µs; the last class has none."""


class ClockDeviation:
    """Histogram of the clocks' deviation from the reference; counts while `active`."""

    def __init__(self) -> None:
        self.active = False
        self.clear()

    def clear(self) -> None:
        """Count from 0."""
        self._ahead = [0] * (len(_CLASSES_US) + 1)
        self._behind = list(self._ahead)
        self._largest = 0

    def add(self, difference_ns: int) -> None:
        """Count one reading."""
        if not self.active:
            return
        size = abs(difference_ns)
        self._largest = max(self._largest, size)
        place = sum(size >= 1000 * end for end in _CLASSES_US)
        (self._behind if difference_ns < 0 else self._ahead)[place] += 1

    def figures(self) -> list[int]:
        """Count, those ahead, those behind, the largest in ns, ten classes each."""
        ahead, behind = sum(self._ahead), sum(self._behind)
        return [ahead + behind, ahead, behind, self._largest, *self._ahead, *self._behind]


class ClockWatch:
    """Detection of clocks further than `limit_ns` from the reference.

    A clock is apart after three readings in a row beyond the limit, until a reading within it.
    """

    def __init__(self, limit_ns: int) -> None:
        self.limit_ns = limit_ns
        self._beyond: dict[int, int] = {}
        """Readings in a row, by position."""

    @property
    def calm(self) -> bool:
        """True if no clock was beyond the limit at its last reading."""
        return not self._beyond

    def take(self, position: int, difference_ns: int) -> bool | None:
        """Take a reading: True if the slave's clock is apart from now on, False: no longer."""
        before = self._beyond.get(position, 0)
        if abs(difference_ns) > self.limit_ns:
            self._beyond[position] = before + 1
            return True if before + 1 == _READINGS else None
        self._beyond.pop(position, None)
        return False if before >= _READINGS else None

    def forget(self, position: int) -> None:
        """Note that the slave is gone, or set up again."""
        self._beyond.pop(position, None)


def measure_clocks(
    slaves: Sequence[BusSlave],
    newcomers: Collection[int] | None = None,
    before: int | None = None,
) -> Steps[int | None]:
    """Set delay and offset of each slave with a clock; the station of the reference, None: none.

    `slaves` are all that frames pass, in their order. With `newcomers` (stations) only these are
    set, to the time that the others have now: the clocks of the others run on. Their delays change
    only if the reference is another one than `before`.
    """
    clocks = [slave for slave in slaves if slave.facts.has_clock]
    if not clocks:
        return None
    reference = clocks[0].station
    latch = Datagram.at(DatagramCommand.BWR, 0, Register.RECEIVE_TIME_PORT_0, bytes(4))
    settled = [] if newcomers is None else [s for s in clocks if s.station not in newcomers]
    keeper = settled[0] if settled else clocks[0]
    time = Datagram.at(DatagramCommand.FPRD, keeper.station, Register.SYSTEM_TIME, bytes(8))
    latched = yield Trip((latch, time), tries=1)
    if latched.datagrams[0].counter < len(clocks):
        raise FrameLost(
            f"receive times: {latched.datagrams[0].counter} slaves latched,"
            f" {len(clocks)} have clocks"
        )
    times: list[Sequence[int] | None] = [None] * len(slaves)
    unit: dict[int, int] = {}
    for number, slave in enumerate(slaves):
        if slave.facts.has_clock:
            data = yield from read(slave.station, Register.RECEIVE_TIME_PORT_0, _REACH)
            *ports, unit[slave.station] = _TIMES.unpack(data)
            times[number] = ports
    delays = propagation_delays(build_tree([each.facts.dl_status for each in slaves]), times)
    first = delays[slaves.index(clocks[0])]
    start = latched.now_ns
    if settled:  # the frame passes the keeper later than the reference
        start = int.from_bytes(latched.datagrams[1].data, "little")
        start -= max(delays[slaves.index(keeper)] - first, 0)
    base = clocks[0].facts.delay_ns if settled and reference == before else 0
    for number, slave in enumerate(slaves):
        if not slave.facts.has_clock:
            continue
        delay = max(delays[number] - first, 0)
        if slave not in settled:
            yield from _set_clock(slave, start + delay - unit[slave.station], delay)
        elif reference == before:
            continue
        else:
            yield from write_delay(slave.station, delay)
        slave.facts.delay_ns = base + delay
    return reference


def write_delay(station: int, delay_ns: int) -> Steps[None]:
    """Set the propagation delay from the reference to a slave."""
    yield from write(station, Register.SYSTEM_TIME_DELAY, delay_ns.to_bytes(4, "little"))


def settle_drift(reference: int, telegrams: int) -> Steps[None]:
    """Send the reference's time to all so often in bursts, before anything has to be on time.

    So the loops of the slaves learn how fast their clocks run (static drift compensation).
    """
    time = Datagram.at(DatagramCommand.FRMW, reference, Register.SYSTEM_TIME, bytes(8))
    while telegrams > 0:
        burst = min(telegrams, _BURST)
        yield Trip(tuple(replace(time) for _ in range(burst)), tries=1)
        telegrams -= burst
        yield Pause(_BURST_NS)


def _set_clock(slave: BusSlave, offset_ns: int, delay_ns: int) -> Steps[None]:
    offset = (offset_ns & _U64).to_bytes(8, "little")
    yield from write(slave.station, Register.SYSTEM_TIME_OFFSET, offset)
    yield from write_delay(slave.station, delay_ns)
    yield from restart_loop(slave.station)


def restart_loop(station: int) -> Steps[None]:
    """Let the time loop of a slave forget how fast its clock runs."""
    speed = Register.SPEED_COUNTER_START
    yield from write(station, speed, speed.default.to_bytes(2, "little"))


def correct_offset(slave: BusSlave) -> Steps[None]:
    """Take `slave.clock_difference_ns` out of the offset: the time loop alone takes minutes."""
    yield from shift_clock(slave, -slave.clock_difference_ns)
    yield from restart_loop(slave.station)


def shift_clock(slave: BusSlave, by_ns: int) -> Steps[None]:
    """Add to the offset of a clock: its time is another at once."""
    offset = yield from read_number(slave.station, Register.SYSTEM_TIME_OFFSET)
    offset = offset + by_ns & _U64
    yield from write(slave.station, Register.SYSTEM_TIME_OFFSET, offset.to_bytes(8, "little"))


def difference_of(number: int) -> int:
    """Register 0x092C in ns: positive where the slave is ahead of the reference."""
    return -(number & ~_SIGN) if number & _SIGN else number


def bound_of(data: bytes) -> int:
    """Return the upper bound of the clocks' deviation, ns, from register 0x092C of all slaves by
    OR."""
    return int.from_bytes(data, "little") & ~_SIGN


def stop_sync(station: int) -> Steps[None]:
    """No SYNC signals."""
    yield from write(station, Register.CYCLIC_UNIT_CONTROL, bytes(2))


def start_sync(slave: BusSlave, clock: ClockConfiguration, cycle_ns: int) -> Steps[None]:
    """Set the SYNC signals up: they begin some 100 ms from now, on the grid of the bus cycle."""
    station = slave.station
    cycle0 = clock.cycle0_ns or cycle_ns
    shift = cycle0 // 2 if clock.shift_ns is None else clock.shift_ns
    for _ in range(_TRIES):
        yield from stop_sync(station)
        time = yield from read_number(station, Register.SYSTEM_TIME)
        grid = max(cycle0, cycle_ns)
        start = ((time + _LEAD_NS) // grid + 1) * grid + shift
        yield from write(station, Register.START_TIME, (start & _U64).to_bytes(8, "little"))
        yield from write(station, Register.SYNC0_CYCLE, struct.pack("<II", cycle0, clock.cycle1_ns))
        yield from write(
            station, Register.CYCLIC_UNIT_CONTROL, clock.assign_activate.to_bytes(2, "little")
        )
        # a start that has passed meanwhile never fires
        if (yield from read_number(station, Register.SYSTEM_TIME)) < start:
            slave.output_shift_ns = shift
            break
    else:
        raise BusError(f"station {station}: SYNC0 was set {_TRIES} times and always too late")
    yield Pause(max(start - time, 0))
