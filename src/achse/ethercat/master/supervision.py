"""Watching over a bus: start-up, slaves that leave their state, get lost and come back.

Source: ETG.1020 for the order of a start; ETG.1000.4 §6.1, §6.2 for what is read.
"""

from collections.abc import Callable, Sequence

from achse.codes import AlState, AlStatus
from achse.ethercat.frame import DatagramCommand
from achse.ethercat.master.bring_up import BringUp
from achse.ethercat.master.bus_slave import PORTS, BusSlave, SlaveFacts
from achse.ethercat.master.clocks import (
    ClockDeviation,
    ClockWatch,
    bound_of,
    difference_of,
    measure_clocks,
    settle_drift,
)
from achse.ethercat.master.configuration import BusConfiguration
from achse.ethercat.master.cyclic import CyclicExchange
from achse.ethercat.master.errors import BusError, FrameLost
from achse.ethercat.master.events import BusEventKind
from achse.ethercat.master.inspection import (
    MAX_SLAVES,
    count_slaves,
    inspect,
    match,
    reset_bus,
    same_device,
    scattered_reads,
    set_station,
)
from achse.ethercat.master.redundancy import Redundancy
from achse.ethercat.master.reference_clock import ReferenceClock
from achse.ethercat.master.states import report_of
from achse.ethercat.master.steps import Pause, Steps, broadcast_read, now, write
from achse.ethercat.master.traffic import AcyclicTraffic, BusJob
from achse.ethercat.registers import Register

ReportEvent = Callable[[BusEventKind, BusSlave | None, int, str], None]
"""Reports an event: kind, slave, number, text."""

_LOOK_NS = 100_000_000
"""Period of reading states while the cyclic frames show no fault."""
_COUNTERS_NS = 1_000_000_000
_CLOCKS_NS, _CLOCKS_SOON_NS = 100_000_000, 10_000_000
"""Period of reading clocks, and the shorter one while a clock is far from the reference."""
_RETRY_NS = 100_000_000
_STEADY_NS, _FALLS = 10_000_000_000, 3
"""A slave whose synchronisation is lost so often, each time within so long of Op, has failed."""
_SYNC_CODES = (
    *(AlStatus.SYNCHRONIZATION, AlStatus.FATAL_SYNC, AlStatus.NO_SYNC0),
    *(AlStatus.PLL, AlStatus.DC_IO, AlStatus.DC_TIMEOUT),
)
_RX_SIZE = Register.LOST_LINKS.end - Register.RX_ERRORS
_LOST_AT = Register.LOST_LINKS - Register.RX_ERRORS
_FORWARDED_AT = 8
_CLOSED_END = b"\x0c"
"""Loop control: port 1 is closed."""
_FPRD, _APRD = DatagramCommand.FPRD, DatagramCommand.APRD


class Supervision:
    """Keeps each slave in the state that it shall have. `cyclic_on`: process data are sent."""

    def __init__(
        self,
        bus: BusConfiguration,
        slaves: Sequence[BusSlave],
        cyclic: CyclicExchange,
        traffic: AcyclicTraffic,
        bring_up: BringUp,
        report: ReportEvent,
        redundancy: Redundancy | None = None,
    ) -> None:
        self.bus = bus
        self.slaves = slaves
        self.cyclic_on = False
        self.link = False
        """True if frames come back and pass a slave."""
        self.slave_count = 0
        """Slaves that frames pass, configured or not."""
        self.strangers: list[tuple[int, int, int, int]] = []
        """Identities of slaves found that are not in the configuration."""
        self.searched = False
        """True after a search for slaves, even if it found none."""
        self.changes = 0
        """Number of times that slaves came or went."""
        self._cyclic = cyclic
        self._traffic = traffic
        self._bring_up = bring_up
        self._report = report
        self._redundancy = redundancy
        self._clock = ReferenceClock(slaves, cyclic, bus.cycle_ns, report, redundancy)
        self._ring: tuple[int | None, bool, bool] = None, False, False
        """Position at which the ring is open; per adapter, True if its copies are missing."""
        self._opening = ""
        self.deviation = ClockDeviation()
        self._clocks = ClockWatch(bus.clock_window_ns)
        self._bring_ups: dict[int, BusJob[None]] = {}
        self._failed_positions: set[int] = set()
        self._falls: dict[int, tuple[int, int]] = {}
        """Of slaves that lost synchronisation: how often in a row, until when it is in a row."""
        self._now_ns = 0
        self._collecting: set[int] = set()
        self._look_due = 0
        self._clocks_due = 0
        self._counters_due = 0
        self._urgent = False
        self._checked_state = (0, 0, 0)
        self._lost_before = 0

    @property
    def reference(self) -> int | None:
        """Station of the reference clock, None for none."""
        return self._clock.station

    @property
    def quiet_until_ns(self) -> int:
        """Time until which nothing is checked, if the cyclic frames stay unchanged, ns; 0: at
        once."""
        cyclic = self._cyclic
        seen = (cyclic.present, cyclic.al_states, cyclic.counters.wrong)
        if (
            (
                *(self._urgent, self._bring_ups, self._collecting, seen != self._checked_state),
                *(cyclic.counters.lost > self._lost_before, any(cyclic.mailbox_bits)),
                cyclic.reference_lost,
            )
            != (False, {}, set(), False, False, False, False)
            or self._opening
            or self.opening
        ):
            return 0
        due = min(self._look_due, self._counters_due)
        return due if self.reference is None else min(due, self._clocks_due)

    def retry(self, slave: BusSlave) -> None:
        """Clear the failures of a slave, so that a requested state is tried again."""
        self._falls.pop(slave.position, None)
        self._failed_positions.discard(slave.position)
        self._urgent = True

    def restart(self, slave: BusSlave) -> None:
        """Lead a slave by way of Init; one that does not answer comes up when it is back."""
        self.retry(slave)
        job = self._bring_ups.pop(slave.position, None)
        if job is not None:
            job.cancel()
        if slave.present:
            self._start_bring_up(slave, fresh=True)

    def look_soon(self) -> None:
        """Look at the states and for newcomers with the next cycle."""
        self._urgent = True

    def run(self) -> Steps[None]:
        """For ever: start the bus, then watch over it."""
        started = False
        while True:
            try:
                if not started:
                    try:
                        yield from self._start_up()
                    finally:
                        self.searched = True
                    started = True
                yield from self._watch()
            except FrameLost as trouble:
                self._link_lost(str(trouble))
            except BusError as trouble:
                self._report(BusEventKind.STATE_FAILED, None, 0, str(trouble))
            yield Pause(_RETRY_NS)
            if started:
                yield from self._wait_for_link()

    def _link_lost(self, text: str) -> None:
        if self.link:
            self.link = False
            self._report(BusEventKind.LINK_LOST, None, 0, text)
        for slave in self.slaves:
            self._lose(slave)

    def _wait_for_link(self) -> Steps[None]:
        while not self.link:
            try:
                self.slave_count = yield from count_slaves()
                self.link = self.slave_count > 0
            except FrameLost:
                pass
            if not self.link:
                yield Pause(_RETRY_NS)
            else:
                self._report(
                    BusEventKind.LINK_BACK,
                    None,
                    self.slave_count,
                    f"{self.slave_count} slaves answer",
                )
                self._urgent = True

    # start

    def _start_up(self) -> Steps[None]:
        count = yield from count_slaves()
        if count == 0:
            raise FrameLost("no slave answers")
        yield from reset_bus()
        spare = self.bus.spare_stations(MAX_SLAVES)
        for position in range(count):  # addresses that no configured slave has
            yield from set_station(position, spare + position)
        facts: list[SlaveFacts] = []
        for position in range(count):
            slave_facts = yield from inspect(spare + position)
            facts.append(slave_facts)
        identities = [each.identity for each in facts]
        configured = [each.configuration for each in self.slaves]
        places = match(configured, identities, self.bus.strict_revision)
        self.strangers = []
        for position, place in enumerate(places):
            if place is None:
                self.strangers.append(identities[position])
                self._wrong(position, identities[position])
            else:
                slave = self.slaves[place]
                yield from set_station(position, slave.station)
                self._set_present(slave, facts[position])
        self.slave_count = count
        self.link = True
        self._report(BusEventKind.LINK_BACK, None, count, f"{count} slaves found")
        present = [each for each in self.slaves if each.present]
        reference = yield from self._measure(present)
        if reference is not None and any(each.configuration.clock for each in present):
            yield from settle_drift(reference, self.bus.drift_telegrams)
        self._clock.appoint(reference)
        self.cyclic_on = True
        self._urgent = True

    def _measure(self, present: Sequence[BusSlave]) -> Steps[int | None]:
        """Find the reference clock and the delays from it; its station, None without clocks."""
        ring = self._redundancy
        if ring is None or ring.open or not present:
            return (yield from measure_clocks(present))
        # frames have to come back the way they went: the last slave turns them round
        last = present[-1].station
        ring.turned = True
        try:
            yield from write(last, Register.DL_CONTROL + 1, _CLOSED_END)
            reference = yield from measure_clocks(present)
            yield from write(last, Register.DL_CONTROL + 1, b"\0")
        finally:
            ring.turned = False
        return reference

    def _set_present(self, slave: BusSlave, facts: SlaveFacts) -> None:
        facts.delay_ns = slave.facts.delay_ns
        slave.facts = facts
        slave.present = True
        slave.mismatch = False
        slave.state = AlState.INIT
        self.changes += 1

    def _wrong(self, position: int, identity: tuple[int, int, int, int]) -> None:
        text = ":".join(f"{each:08X}" for each in identity[:3])
        wanted = self.slaves[position] if position < len(self.slaves) else None
        if wanted is not None:
            wanted.mismatch = True
        self._report(
            BusEventKind.WRONG_SLAVE,
            wanted,
            position,
            f"position {position}: found {text}, configured {wanted.name if wanted else 'nothing'}",
        )

    # supervision

    def _watch(self) -> Steps[None]:
        while True:
            time = self._now_ns = yield from now()
            cyclic = self._cyclic
            seen = (cyclic.present, cyclic.al_states, cyclic.counters.wrong)
            lost = cyclic.counters.lost
            if (
                self._urgent
                or seen != self._checked_state
                or lost > self._lost_before
                or cyclic.reference_lost
                or time >= self._look_due
            ):
                self._urgent = False
                self._checked_state = seen
                self._lost_before = lost
                self._look_due = time + _LOOK_NS
                yield from self._look()
            if time >= self._clocks_due and self.reference is not None:
                yield from self._watch_clocks()
                calm = self._clocks.calm and not self._clock.doubted
                self._clocks_due = time + (_CLOCKS_NS if calm else _CLOCKS_SOON_NS)
            if time >= self._counters_due:
                self._counters_due = time + _COUNTERS_NS
                yield from self._read_counters()
            self._collect_messages()
            if self._redundancy is not None:
                yield from self._watch_ring(self._redundancy)
            yield Pause(self.bus.cycle_ns // 2)  # cycles of a real clock are not equally long

    def _look(self) -> Steps[None]:
        """Read the state of each slave, act on what has changed."""
        self._poll_mailboxes()
        stations = [each.station for each in self.slaves]
        reports = yield from scattered_reads(stations, Register.AL_STATUS, 6, _FPRD)
        for slave, data in zip(self.slaves, reports, strict=True):
            if data is None:
                self._lose(slave)
            elif slave.present and slave.position not in self._bring_ups:
                self._evaluate(slave, data)
        yield from self._clock.update()
        _, self.slave_count = yield from broadcast_read(Register.AL_STATUS, 2)
        answering = sum(data is not None for data in reports)
        if self.slave_count > answering + len(self.strangers) or any(
            data is not None and not slave.present
            for slave, data in zip(self.slaves, reports, strict=True)
        ):
            yield from self._admit()

    def _watch_clocks(self) -> Steps[None]:
        """Read how far clocks are from the reference: of all at once, of each if one is far."""
        far = yield from self._clock.watch()
        if self._clocks.calm and bound_of(far) <= self._clocks.limit_ns:
            return
        yield from self._read_clocks()
        for slave in self.slaves:
            if slave.configuration.clock is None or slave.state < AlState.SAFEOP:
                if slave.position not in self._bring_ups:
                    self._clocks.forget(slave.position)
                continue
            apart = self._clocks.take(slave.position, slave.clock_difference_ns)
            if apart is not None:
                kind = BusEventKind.CLOCK if apart else BusEventKind.CLOCK_BACK
                text = f"{slave.name}: clock is {slave.clock_difference_ns} ns from the reference"
                self._report(kind, slave, slave.clock_difference_ns, text)

    def _read_clocks(self) -> Steps[None]:
        """Read the deviation of each clock from the reference."""
        clocks = [each for each in self.slaves if each.present and each.facts.has_clock]
        differences = yield from scattered_reads(
            [each.station for each in clocks],
            Register.SYSTEM_TIME_DIFFERENCE,
            Register.SYSTEM_TIME_DIFFERENCE.size,
            _FPRD,
        )
        for slave, data in zip(clocks, differences, strict=True):
            if data is not None:
                slave.clock_difference_ns = difference_of(int.from_bytes(data, "little"))

    def _evaluate(self, slave: BusSlave, data: bytes) -> None:
        report = report_of(data)
        before, failed = slave.state, slave.error
        slave.state, slave.error, slave.al_code = report
        left = report.state != before and report.state != slave.requested_state
        if left or (report.error and not failed):
            slave.abnormal_changes += left
            code = AlStatus.of(report.code)
            self._report(
                BusEventKind.STATE_LEFT if left else BusEventKind.AL_ERROR,
                slave,
                report.code,
                f"{slave.name}: state {before}, now {report.state}:"
                f" 0x{report.code:04X} {code.text if code else ''}".rstrip(),
            )
            if left and code in _SYNC_CODES:
                self._count_fall(slave)
        if (
            report.error or report.state != slave.requested_state
        ) and slave.position not in self._failed_positions:
            self._start_bring_up(slave)

    def _count_fall(self, slave: BusSlave) -> None:
        """Leave a slave in its state that loses its synchronisation again and again."""
        falls, until = self._falls.get(slave.position, (0, 0))
        falls = falls + 1 if self._now_ns <= until else 1
        self._falls[slave.position] = falls, self._now_ns + _STEADY_NS
        if falls >= _FALLS:
            self._fail(slave, f"synchronization was lost {falls} times")

    def _fail(self, slave: BusSlave, trouble: str) -> None:
        self._failed_positions.add(slave.position)
        slave.last_trouble = trouble
        text = f"{slave.name}: {slave.requested_state.name} not reached: {trouble}"
        self._report(BusEventKind.STATE_FAILED, slave, slave.al_code, text)

    def _start_bring_up(self, slave: BusSlave, fresh: bool = False) -> None:
        if slave.position in self._bring_ups:
            return

        def finished(job: BusJob[None]) -> None:
            self._bring_ups.pop(slave.position, None)
            if job.error is not None:
                self._fail(slave, str(job.error))

        self._bring_ups[slave.position] = self._traffic.start(
            self._bring_up.run(slave, fresh), finished
        )

    def _lose(self, slave: BusSlave) -> None:
        if not slave.present:
            return
        slave.present = False
        slave.state = 0
        slave.error = False
        slave.losses += 1
        self.changes += 1
        job = self._bring_ups.pop(slave.position, None)
        if job is not None:
            job.cancel()
        self._report(BusEventKind.SLAVE_LOST, slave, 0, f"{slave.name} does not answer")

    # the ring of a redundant bus

    @property
    def slaves_before_opening(self) -> int | None:
        """So many of the slaves there are between the first adapter and where the ring is open.

        None while it is closed, and without a ring.
        """
        redundancy = self._redundancy
        if redundancy is None or not redundancy.open:
            return None
        there = sum(each.present for each in self.slaves)
        if redundancy.cut_off[0]:
            return 0
        return there if redundancy.split is None else min(redundancy.split, there)

    @property
    def opening(self) -> str:
        """Between which two the ring of a redundant bus is open; empty if it is closed."""
        place = self.slaves_before_opening
        if place is None:
            return ""
        present = [each.name for each in self.slaves if each.present]
        line = ["the first adapter", *present, "the second adapter"]
        return "between {} and {}".format(*line[place : place + 2])

    def _watch_ring(self, redundancy: Redundancy) -> Steps[None]:
        """Report where the ring is open, and give the clocks behind the cut one of their own."""
        ring = redundancy.split, *redundancy.cut_off
        if ring == self._ring:
            return
        self._ring = ring
        opening = self.opening
        if not opening:
            self._report(BusEventKind.RING_CLOSED, None, 0, "frames go round the ring again")
        elif opening != self._opening:
            self._report(BusEventKind.RING_OPEN, None, ring[0] or 0, opening)
        self._opening = opening
        yield from self._clock.divide()

    # slaves that come

    def _admit(self) -> Steps[None]:
        """Find the slaves that came: give them their addresses, lead them to their state."""
        count = min(self.slave_count, MAX_SLAVES)
        stations = yield from scattered_reads(
            [-position for position in range(count)], Register.STATION_ADDRESS, 2, _APRD
        )
        known = {each.station: each for each in self.slaves}
        missing = [each for each in self.slaves if not each.present]
        newcomers: set[int] = set()
        self.strangers = []
        for position, data in enumerate(stations):
            slave = known.get(int.from_bytes(data or b"", "little"))
            if slave is not None and slave.present:
                continue
            slave = yield from self._identify(position, missing)
            if slave is not None:
                missing.remove(slave)
                newcomers.add(slave.station)
        if not newcomers:
            return
        present = [each for each in self.slaves if each.present]
        for each in present:
            dl_status = yield from scattered_reads(
                [each.station], Register.DL_STATUS, Register.DL_STATUS.size, _FPRD
            )
            if dl_status[0] is not None:
                each.facts.dl_status = int.from_bytes(dl_status[0], "little")
        yield from self._clock.admit(present, newcomers)
        for each in present:
            if each.station in newcomers:
                self._report(BusEventKind.SLAVE_BACK, each, each.position, f"{each.name} is back")
                self._failed_positions.discard(each.position)
                self._start_bring_up(each, fresh=True)

    def _identify(self, position: int, missing: Sequence[BusSlave]) -> Steps[BusSlave | None]:
        """Return the missing slave that is at a position, and set its address."""
        spare = self.bus.spare_stations(MAX_SLAVES) + position
        yield from set_station(position, spare)
        facts = yield from inspect(spare)
        for slave in missing:
            if same_device(slave.configuration, facts.identity, self.bus.strict_revision):
                yield from set_station(position, slave.station)
                self._set_present(slave, facts)
                return slave
        self.strangers.append(facts.identity)
        return None

    # counters and messages

    def _read_counters(self) -> Steps[None]:
        """Take error counters over and clear them; read how far the clocks are apart."""
        present = [each for each in self.slaves if each.present]
        stations = [each.station for each in present]
        counters = yield from scattered_reads(stations, Register.RX_ERRORS, _RX_SIZE, _FPRD)
        for slave, data in zip(present, counters, strict=True):
            if data is not None and any(data):
                _add_counters(slave, data)
                for register in (Register.RX_ERRORS, Register.LOST_LINKS):
                    yield from write(slave.station, register, bytes(register.size))
        yield from self._read_clocks()
        for slave in present:
            if slave.facts.has_clock:
                self.deviation.add(slave.clock_difference_ns)

    def _collect_messages(self) -> None:
        """Fetch messages that slaves put up by themselves: emergencies."""
        bits = self._cyclic.take_mailbox_bits()
        if not any(bits):
            return
        for number, position in enumerate(self._cyclic.image.mailboxes):
            if number >> 3 < len(bits) and bits[number >> 3] >> (number & 7) & 1:
                slave = self.slaves[position]
                if slave.reads_mailbox_bit:
                    self._collect(slave)

    def _poll_mailboxes(self) -> None:
        """Look into the mailboxes whose state is not in the cyclic frames."""
        for slave in self.slaves:
            if not slave.reads_mailbox_bit:
                self._collect(slave)

    def _collect(self, slave: BusSlave) -> None:
        mailbox, position = slave.mailbox, slave.position
        if (
            mailbox is None
            or not mailbox.idle
            or not slave.present
            or slave.state < AlState.PREOP
            or slave.state == AlState.BOOT
            or position in self._collecting
        ):
            return
        self._collecting.add(position)
        self._traffic.start(mailbox.collect(), lambda job: self._collecting.discard(position))


def _add_counters(slave: BusSlave, data: bytes) -> None:
    counters = slave.counters
    for port in range(PORTS):
        counters.errors[port] += data[2 * port] + data[2 * port + 1]
        counters.forwarded[port] += data[_FORWARDED_AT + port]
        counters.lost_links[port] += data[_LOST_AT + port]
