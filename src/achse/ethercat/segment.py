"""A segment: slaves in a line or tree, through which frames go in processing order.

`process` takes a frame as it leaves the master and gives it as it comes back; it knows no clock
but `advance`.

Source: 001 §2.3; ETG.1000.4 §6.1.4 for ports and their order.
"""

import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

from achse.ethercat.clock import Instant
from achse.ethercat.esc import Esc
from achse.ethercat.frame import (
    Addressing,
    DatagramCommand,
    FrameError,
    datagram_offsets,
    payload_offset,
)
from achse.ethercat.frame_plan import (
    WORDS,
    FramePlan,
    FrameStep,
    PlannedDatagram,
    exchange,
    gather_registers,
)
from achse.ethercat.logical import Plan
from achse.ethercat.registers import Register
from achse.ethercat.slave import Slave

_DATAGRAM = struct.Struct("<BBHHHH")
_LOGICAL = struct.Struct("<BBIHH")
_U16 = struct.Struct("<H")

HOP_NS = 300
"""From one slave to the next, by default: cable and physical layer."""

_PORT_ORDER = (3, 1, 2)
"""Order in which a frame leaves a slave after it came in by port 0."""

_FIRST_PORT = 1
_NEVER = 1 << 62
_SYSTEM_TIME = int(Register.SYSTEM_TIME)
"""A number, since each datagram reads it."""
_MAX_PLANS = 256

_COMMANDS = {int(command): command for command in DatagramCommand}
_LRD, _LRW, _BRD = (
    int(each) for each in (DatagramCommand.LRD, DatagramCommand.LRW, DatagramCommand.BRD)
)


@dataclass(slots=True)
class Counters:
    """Counters of the frames in a segment."""

    frames: int = 0
    malformed: int = 0
    foreign: int = 0
    lost: int = 0


@dataclass(slots=True)
class Disturbance:
    """Faults of the wire, wanted for tests.

    The next `lose` frames do not come back; `counter` is added to every working counter of the next
    `counter_frames` frames.
    """

    lose: int = 0
    counter: int = 0
    counter_frames: int = 0


class _Place:
    """Position of a slave in the tree."""

    __slots__ = ("children", "parent", "port", "slave", "whole")

    def __init__(self, slave: Slave, parent: "_Place | None", port: int) -> None:
        self.slave = slave
        self.parent = parent
        self.port = port
        self.children: dict[int, _Place] = {}
        self.whole = True


class Segment:
    """Slaves in the order in which frames pass them.

    `slaves` form a line; `attach` adds branches. With `cycle_ns` the frames are the clock: each
    frame with process data comes `cycle_ns` after the one before it. Without, time passes by
    `advance` only.
    """

    def __init__(
        self, slaves: Iterable[Slave] = (), *, cycle_ns: int = 0, hop_ns: int = HOP_NS
    ) -> None:
        self.time = Instant()
        self.hop_ns = hop_ns
        """From one slave to the next, each way."""
        self.cycle_ns = cycle_ns
        self.counters = Counters()
        self.disturbance: Disturbance | None = None
        self._places: list[_Place] = []
        self._slaves: list[Slave] = []
        self._order: list[Slave] = []
        self._plans: dict[tuple[int, int, int], Plan] = {}
        self._frame_plans: dict[tuple[int, int], FramePlan] = {}
        """By length, and where the EtherCAT header begins."""
        self._remaps = 0
        """Number of times that plans were dropped."""
        self._stations: dict[int, list[Slave]] = {}
        self._irq = 0
        self._endless = False
        self._clocked: list[Slave] = []
        """The slaves with distributed clocks, in processing order."""
        self._in_step: tuple[int, int, int] | None = None
        """Changes, offset of the reference time, bits, with which no clock differed at last."""
        self.extend(slaves)

    # topology

    @property
    def slaves(self) -> tuple[Slave, ...]:
        """All slaves, reachable or not, in the order in which they were attached."""
        return tuple(self._slaves)

    @property
    def reachable(self) -> tuple[Slave, ...]:
        """The slaves that frames pass now, in processing order."""
        return tuple(self._order)

    @property
    def whole(self) -> bool:
        """True if no cable is cut: a frame passes every slave."""
        return len(self._order) == len(self._slaves)

    def attach(self, slave: Slave, upstream: Slave | None = None, port: int = _FIRST_PORT) -> None:
        """Connect port 0 of `slave` to `port` (1, 2, 3) of `upstream`, by default the last slave.

        ValueError if the slave is already here or the port is taken.
        """
        if any(place.slave is slave for place in self._places):
            raise ValueError("a slave can be attached once")
        parent = self._place(upstream) if upstream else self._places[-1] if self._places else None
        if parent is not None and (port not in _PORT_ORDER or port in parent.children):
            raise ValueError(f"port {port} is not a free port (1, 2 or 3)")
        self._join(slave, parent, port)
        self._route()

    def extend(self, slaves: Iterable[Slave]) -> None:
        """Connect slaves in a line behind the last one. ValueError as with `attach`."""
        present = set(map(id, self._slaves))
        for slave in slaves:
            if id(slave) in present:
                raise ValueError("a slave can be attached once")
            present.add(id(slave))
            parent = self._places[-1] if self._places else None
            if parent is not None and _FIRST_PORT in parent.children:
                raise ValueError(f"port {_FIRST_PORT} is not a free port (1, 2 or 3)")
            self._join(slave, parent, _FIRST_PORT)
        self._route()

    def _join(self, slave: Slave, parent: "_Place | None", port: int) -> None:
        place = _Place(slave, parent, port)
        if parent is not None:
            parent.children[port] = place
        self._places.append(place)
        self._slaves.append(slave)
        slave.join(self.time)
        slave.esc.remapped = self._remapped
        slave.esc.readdressed = self._readdressed
        slave.esc.rerouted = self._route
        slave.esc.irq_changed = self._collect_irq

    def break_link(self, slave: Slave) -> None:
        """Cut the cable at port 0 of `slave`: it and all behind it are out of reach."""
        place = self._place(slave)
        if place.whole:
            place.whole = False
            slave.esc.count(Register.LOST_LINKS)
            if place.parent is not None:
                place.parent.slave.esc.count(Register.LOST_LINKS + place.port)
            self._route()

    def repair_link(self, slave: Slave) -> None:
        """Mend the cable at port 0 of `slave`.

        With the link the ports at both ends of it, and all behind it, open again as after power-up,
        whatever DL control has closed or forced open: no master could reach them to undo that.
        """
        place = self._place(slave)
        place.whole = True
        if place.parent is not None:
            place.parent.slave.esc.open_with_link(place.port)
        for behind in self._behind(place):
            behind.slave.esc.open_with_link()
        self._route()

    def _behind(self, place: _Place) -> Iterable[_Place]:
        waiting = [place]
        while waiting:
            place = waiting.pop()
            yield place
            waiting += place.children.values()

    def _place(self, slave: Slave) -> _Place:
        for place in self._places:
            if place.slave is slave:
                return place
        raise ValueError("the slave is not in this segment")

    def _route(self) -> None:
        """Find the processing order, the state of each port, and when a frame passes it."""
        self._order = []
        self._endless = False
        self._in_step = None
        if self._places and self._places[0].whole:
            self._visit(self._places[0], self.hop_ns)
        self._clocked = clocked_of(self._order)
        reached = {id(slave) for slave in self._order}
        for place in self._places:
            if id(place.slave) not in reached:
                self._show_links(place)
        self._readdressed()
        self._collect_irq()

    def _visit(self, first: _Place, delay_ns: int) -> None:
        """Go through a slave and all behind it, as a frame does that reaches it after `delay_ns`.

        Lines are longer than Python's stack is deep: the way back is kept in a list.
        """
        way: list[tuple[list[int | None], list[bool], Iterator[int], _Place]] = []
        ports: list[int] = []
        place: _Place | None = first
        while place is not None or way:
            if place is not None:
                self._order.append(place.slave)
                delays: list[int | None] = [delay_ns, None, None, None]
                way.append((delays, self._show_links(place), iter(_PORT_ORDER), place))
            place = None
            delays, open_ports, left, here = way[-1]
            for port in () if self._endless else left:
                if open_ports[port]:
                    child = here.children.get(port)
                    if child is None or not child.whole:
                        self._endless = True  # a port held open without link: frames are lost
                        break
                    delay_ns += self.hop_ns
                    ports.append(port)
                    place = child
                    break
            if place is None:
                way.pop()
                clock = here.slave.esc.clock
                clock.port_delays = tuple(delays)
                clock.arrival_ns = delays[0] or 0
                if ports:
                    delay_ns += self.hop_ns
                    way[-1][0][ports.pop()] = delay_ns

    def _show_links(self, place: _Place) -> list[bool]:
        linked = [place.whole, False, False, False]
        for port, child in place.children.items():
            linked[port] = child.whole
        return place.slave.esc.set_links(linked)

    def _remapped(self) -> None:
        self._plans.clear()
        self._frame_plans.clear()
        self._remaps += 1

    def _readdressed(self) -> None:
        self._stations.clear()
        self._remapped()

    def _index_stations(self) -> dict[int, list[Slave]]:
        """Find the slaves of each address, in processing order."""
        for slave in self._order:
            for station in slave.esc.addresses:
                self._stations.setdefault(station, []).append(slave)
        return self._stations

    def _collect_irq(self) -> None:
        self._irq = 0
        for slave in self._order:
            self._irq |= slave.esc.irq

    # time

    def advance(self, now_ns: int) -> None:
        """Let time pass up to `now_ns`; never back."""
        time = self.time
        if time.due_ns <= now_ns:
            time.due_ns = due_ns = _NEVER
            for slave in self._slaves:
                if slave.due_ns <= now_ns:
                    slave.advance(now_ns)
                if slave.due_ns < due_ns:
                    due_ns = slave.due_ns
            time.due_ns = min(time.due_ns, due_ns)
        time.now_ns = max(time.now_ns, now_ns)

    # frames

    def process(self, frame: bytes) -> bytes | None:
        """Return the Ethernet frame as it comes back, or None if it does not.

        A frame of another protocol or with a broken structure comes back as it was; such frames
        are counted.
        """
        start = payload_offset(frame)
        if start is None:
            self.counters.foreign += 1
            destroyed = any(slave.esc.destroys_foreign for slave in self._order)
            return None if destroyed or self._endless or not self._order else frame
        result = self._pass_through(frame, start)
        if result is None:
            return None
        if isinstance(result, bytearray):
            result[6] |= 0x02  # a slave marks the source address as locally administered
        return bytes(result)

    def process_payload(self, payload: bytes) -> bytes | None:
        """Return the same for a UDP payload, which begins with the EtherCAT header."""
        result = self._pass_through(payload, 0)
        return None if result is None else bytes(result)

    def _pass_through(self, frame: bytes, start: int) -> bytes | bytearray | None:
        """Return the frame as it comes back; one that leaves has passed the slaves before."""
        endless = self._endless
        result = self._process(frame, start) if self._order else None
        if not self._order or endless:
            self.counters.lost += 1
            return None
        return result

    def _process(self, frame: bytes, start: int) -> bytes | bytearray | None:
        counters = self.counters
        counters.frames += 1
        planned = self._frame_plans.get((len(frame), start))
        if (
            planned is not None
            and not self._irq
            and self.disturbance is None
            and planned.fits(frame)
        ):
            return self._follow(planned, frame)
        try:
            offsets = datagram_offsets(frame, start)
        except FrameError:
            counters.malformed += 1
            for slave in self._order:
                slave.esc.count(Register.PROCESSING_ERRORS)
            return frame
        cyclic = any(_LRD <= frame[offset] <= _LRW for offset in offsets)
        if self.cycle_ns and cyclic:
            self.advance(self.time.now_ns + self.cycle_ns)
        buffer = bytearray(frame)
        remaps = self._remaps
        for offset in offsets:
            self._pass(offset, frame, buffer)
        if self.disturbance is not None:
            return self._disturb(self.disturbance, buffer, offsets)
        if cyclic and self._remaps == remaps:
            self._plan_frame(frame, start, offsets)
        return buffer

    def _pass(self, offset: int, frame: bytes, buffer: bytearray) -> None:
        """Process one datagram."""
        if _LRD <= frame[offset] <= _LRW:
            self._logical(offset, frame, buffer)
        else:
            self._physical(offset, frame, buffer)
        if self._irq:
            self._interrupt(buffer, offset)

    def _interrupt(self, buffer: bytearray, offset: int) -> None:
        (irq,) = _U16.unpack_from(buffer, offset + 8)
        _U16.pack_into(buffer, offset + 8, irq | self._irq)

    def _follow(self, planned: FramePlan, frame: bytes) -> bytearray:
        """Return a frame by its plan; one datagram after the other once a mapping changes."""
        remaps = self._remaps
        if self.cycle_ns:
            self.advance(self.time.now_ns + self.cycle_ns)
        buffer = bytearray(frame)
        for step, offsets in planned.steps:
            if self._remaps != remaps:
                for offset in offsets:
                    self._pass(offset, frame, buffer)
                continue
            step(frame, buffer)
            if self._irq:
                self._interrupt(buffer, offsets[-1])
        return buffer

    def _plan_frame(self, frame: bytes, start: int, offsets: Sequence[int]) -> None:
        """Plan frames like this one, which has logical datagrams."""
        if len(self._frame_plans) >= _MAX_PLANS:
            self._frame_plans.clear()
        datagrams: list[PlannedDatagram] = []
        steps: list[tuple[FrameStep, tuple[int, ...]]] = []
        together: list[tuple[PlannedDatagram, Plan]] = []
        concerned: set[Esc] = set()

        def close() -> None:
            if together:
                steps.append((exchange(together), tuple(each.offset for each, _ in together)))
                together.clear()
                concerned.clear()

        for offset in offsets:
            number, _, address, length, _ = _LOGICAL.unpack_from(frame, offset)
            length &= 0x7FF
            counted = frame[offset + 10 + length : offset + 12 + length] != b"\0\0"
            if _LRD <= number <= _LRW:
                plan = self._plan(number, address, length)
                if not (plan.exact or counted):
                    datagrams.append(PlannedDatagram(offset, length, True))
                    if not concerned.isdisjoint(plan.escs):
                        close()
                    together.append((datagrams[-1], plan))
                    concerned.update(plan.escs)
                    continue
            close()
            step = None if counted else self._gathered(offset, number, address, length)
            datagrams.append(PlannedDatagram(offset, length, step is not None))
            usual = self._logical if _LRD <= number <= _LRW else self._physical
            steps.append((step or partial(usual, offset), (offset,)))
        close()
        self._frame_plans[len(frame), start] = FramePlan(frame, start, datagrams, steps)

    def _gathered(self, offset: int, number: int, address: int, length: int) -> FrameStep | None:
        """Return a BRD of registers that change by events alone; None for all others."""
        register = address >> 16
        escs = [slave.esc for slave in self._order]
        if number != _BRD or length not in WORDS:
            return None
        if not all(esc.rests(register, length) for esc in escs):
            return None
        datagram = PlannedDatagram(offset, length, True)
        return gather_registers(datagram, escs, register, address & 0xFFFF)

    def _logical(self, offset: int, frame: bytes, buffer: bytearray) -> None:
        command, _, address, length, _ = _LOGICAL.unpack_from(frame, offset)
        length &= 0x7FF
        plan = self._plan(command, address, length)
        begin = offset + 10
        if plan.exact:
            data = buffer[begin : begin + length]
            count = plan.exchange(_COMMANDS[command], data)
            buffer[begin : begin + length] = data
        else:
            whole = frame[begin : begin + length]
            for take, part in plan.takes:
                take(whole[part])
            if plan.gives:
                view = memoryview(buffer)[begin : begin + length]  # keeps its length
                if plan.span is not None:
                    view[plan.span] = b"".join([give() for give, _ in plan.gives])
                else:
                    for give, part in plan.gives:
                        view[part] = give()
            if plan.flags:
                buffer[begin : begin + length] = plan.look(whole)
            count = plan.count
        if count:
            _add(buffer, begin + length, count)

    def _plan(self, command: int, address: int, length: int) -> Plan:
        plan = self._plans.get((command, address, length))
        if plan is not None:
            return plan
        if len(self._plans) >= _MAX_PLANS:
            self._plans.clear()
        escs = [slave.esc for slave in self._order]
        plan = Plan(escs, _COMMANDS[command], address, length)
        self._plans[command, address, length] = plan
        return plan

    def _physical(self, offset: int, _frame: bytes, buffer: bytearray) -> None:
        number, _, adp, ado, length, _ = _DATAGRAM.unpack_from(buffer, offset)
        command = _COMMANDS.get(number)
        if command is None or command is DatagramCommand.NOP:
            return
        begin = offset + 10
        end = begin + (length & 0x7FF)
        order = self._order
        addressed: Sequence[Slave]
        if command.addressing is Addressing.STATION:
            addressed = (self._stations or self._index_stations()).get(adp, ())
        else:
            _U16.pack_into(buffer, offset + 2, adp + len(order) & 0xFFFF)
            if command.addressing is Addressing.BROADCAST:
                addressed = order
            else:
                position = -adp & 0xFFFF
                addressed = order[position : position + 1]
        if begin == end:
            return  # no byte is read or written
        count = 0
        if command.multiple and ado == _SYSTEM_TIME:
            count = self._pass_time(addressed, buffer, begin, end)
        elif command.multiple:
            for slave in order:
                if slave in addressed:
                    count += _read(slave, buffer, ado, begin, end)
                else:
                    count += slave.esc.write(ado, buffer[begin:end])
        elif not command.writes:
            merge = command is DatagramCommand.BRD
            for slave in addressed:
                count += _read(slave, buffer, ado, begin, end, merge)
        elif not command.reads:
            data = bytes(buffer[begin:end])
            for slave in addressed:
                count += slave.esc.write(ado, data)
        else:
            merge = command is DatagramCommand.BRW
            for slave in addressed:
                data = bytes(buffer[begin:end])
                count += _read(slave, buffer, ado, begin, end, merge)
                count += 2 * slave.esc.write(ado, data)
        if count:
            _add(buffer, end, count)

    def _pass_time(
        self, addressed: Sequence[Slave], buffer: bytearray, begin: int, end: int
    ) -> int:
        """The reference clock's time goes to all others (ARMW, FRMW to 0x0910, every cycle).

        While no clock differs from it or drifts, nothing is compared.
        """
        clocked, place = self._clocked, slice(begin, min(end, begin + 8))
        bits = 8 * (place.stop - begin)
        if self._in_step is not None and [*addressed] == clocked[:1]:
            _read(clocked[0], buffer, _SYSTEM_TIME, begin, end)
            offset_ns = int.from_bytes(buffer[place], "little") - self.time.now_ns
            if self._in_step == (self.time.changes, offset_ns, bits):
                return len(self._order)
        for slave in addressed:
            if not slave.esc.has_clock:
                _read(slave, buffer, _SYSTEM_TIME, begin, end)
        time = int.from_bytes(buffer[place], "little")
        differs = False
        for slave in clocked:
            if slave in addressed:
                _read(slave, buffer, _SYSTEM_TIME, begin, end)
                time = int.from_bytes(buffer[place], "little")
            elif slave.esc.clock.compare(time, bits):
                differs = True
        self._in_step = None
        if not differs and [*addressed] == clocked[:1]:
            self._in_step = self.time.changes, time - self.time.now_ns, bits
        return len(self._order)

    def _disturb(
        self, disturbance: Disturbance, buffer: bytearray, offsets: Iterable[int]
    ) -> bytearray | None:
        if disturbance.counter_frames > 0:
            disturbance.counter_frames -= 1
            for offset in offsets:
                (length,) = _U16.unpack_from(buffer, offset + 6)
                _add(buffer, offset + 10 + (length & 0x7FF), disturbance.counter)
        if disturbance.lose > 0:
            disturbance.lose -= 1
            self.counters.lost += 1
            return None
        return buffer


def clocked_of(slaves: Iterable[Slave]) -> list[Slave]:
    """Return the slaves that have distributed clocks."""
    return [slave for slave in slaves if slave.esc.has_clock]


def _read(
    slave: Slave, buffer: bytearray, address: int, begin: int, end: int, merge: bool = False
) -> bool:
    """Read a slave's memory into the datagram, or OR it in."""
    data = slave.esc.read(address, end - begin)
    if data is None:
        return False
    if merge:
        both = int.from_bytes(buffer[begin:end], "little") | int.from_bytes(data, "little")
        data = both.to_bytes(end - begin, "little")
    buffer[begin:end] = data
    return True


def _add(buffer: bytearray, offset: int, count: int) -> None:
    (counter,) = _U16.unpack_from(buffer, offset)
    _U16.pack_into(buffer, offset, counter + count & 0xFFFF)
