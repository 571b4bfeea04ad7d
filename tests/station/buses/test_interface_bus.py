"""A bus on a network interface, in virtual time: searched, lost, found again, each with its end."""

import struct
from collections import deque
from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Flags, Frame
from achse.codes import AlState, AlStatus, NcError
from achse.codes.axis import StartType
from achse.devices.io import default_net_id
from achse.drive import Drive
from achse.drive.alarms import Alarm
from achse.ethercat import Loopback, Segment, Slave
from achse.ethercat.master import Master
from achse.ethercat.ring_segment import RingSegment
from achse.ethercat.terminals import DigitalTerminal
from achse.motion import commands
from achse.station.buses import interface_bus
from achse.station.buses.frame_link import BusLink
from achse.station.buses.interface_bus import InterfaceBus
from achse.station.buses.interface_pair import BusSocket, InterfacePair
from achse.station.buses.plan import BusPlan
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError
from achse.station.station import Station
from achse.transport.ethernet import LinkError

MS = 1_000_000
AXIS = {"max_velocity": 400.0, "default_acceleration": 2000.0, "default_deceleration": 2000.0,
        "default_jerk": 20_000.0}  # fmt: skip


class Interface:
    """Interfaces of a machine; one has slaves, which answer before the next cycle."""

    def __init__(self, cycle_ns: int, slaves: list[Any]) -> None:
        self.cycle_ns = self.step_ns = cycle_ns
        self.segment = Segment(Slave(each) for each in slaves)
        self.there = self.up = self.allowed = True
        self.now_ns = 0
        self.opened = 0

    def replace(self, slaves: list[Any]) -> None:
        """Other slaves, or the same ones after their process was started again."""
        now = self.segment.time.now_ns
        self.segment = Segment(Slave(each) for each in slaves)
        self.segment.advance(now)

    def open(self, interface: str) -> "Cable":
        if not self.allowed:
            raise LinkError(f"raw Ethernet on {interface} needs CAP_NET_RAW")
        if not self.there:
            raise LinkError(f"no interface {interface}; there are lo")
        self.opened += 1
        return Cable(self)


class Cable:
    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        self.arrived_ns = 0
        self.waiting: deque[bytes] = deque()

    @property
    def gone(self) -> bool:
        return not self.interface.there

    def send(self, frame: bytes) -> bool:
        interface = self.interface
        if not (interface.up and interface.there):
            return False
        interface.segment.advance(interface.now_ns)
        reply = interface.segment.process(frame)
        if reply is not None:
            self.waiting.append(reply)
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        self.arrived_ns = self.interface.now_ns
        return self.waiting.popleft() if self.waiting and self.interface.up else None

    def close(self) -> None:
        self.waiting.clear()


class BothEnds(Interface):
    """Two interfaces, with a line of slaves between them."""

    NAMES = ("veth0", "veth1")

    def __init__(self, cycle_ns: int, slaves: list[Any]) -> None:
        super().__init__(cycle_ns, slaves)
        self.ring = self.segment = RingSegment(map(Slave, slaves))
        self.ends: list[End | None] = [None, None]
        self.plugged = [True, True]

    def plug(self, adapter: int, there: bool) -> None:
        """An interface comes, or goes with all that waits there."""
        self.plugged[adapter] = there
        self.link(adapter, there)

    def link(self, adapter: int, up: bool) -> None:
        """The link of an interface; what waits there is lost with it."""
        self.ring.connect(adapter, up)
        end = self.ends[adapter]
        if end is not None:
            end.up = up
            end.waiting.clear()

    def open(self, interface: str) -> "End":
        adapter = self.NAMES.index(interface)
        if not self.plugged[adapter]:
            raise LinkError(f"no interface {interface}; there are lo")
        self.opened += 1
        self.ends[adapter] = end = End(self, adapter)
        return end


class End(Cable):
    interface: BothEnds

    def __init__(self, interface: BothEnds, adapter: int) -> None:
        super().__init__(interface)
        self.adapter, self.up = adapter, True

    @property
    def gone(self) -> bool:
        return not self.interface.plugged[self.adapter]

    def send(self, frame: bytes) -> bool:
        interface = self.interface
        if not self.up:
            return False
        interface.segment.advance(interface.now_ns)
        came = interface.ring.process_from(self.adapter, frame)
        if came is not None:
            there = interface.ends[came[1]]
            if there is not None and there.up:
                there.waiting.append(came[0])
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        self.arrived_ns = self.interface.now_ns
        return self.waiting.popleft() if self.waiting else None


class BusRig:
    """A station whose bus is on `interface`."""

    def __init__(
        self,
        monkeypatch: pytest.MonkeyPatch,
        interface: Interface,
        drives: int,
        terminals: int = 0,
        **document: Any,
    ) -> None:
        self.interface = interface

        def clock() -> int:
            return interface.now_ns

        def way(master: Master, socket: BusSocket) -> BusLink:
            return BusLink(master, socket, clock=clock, now=clock)

        class Clocked(InterfaceBus):
            """Each cycle of the bus is a cycle of the interface's time."""

            def __init__(self, plan: BusPlan, name: str) -> None:
                super().__init__(plan, name, open_link=interface.open, make_way=way, clock=clock)

            def _open(self) -> BusSocket:
                socket = super()._open()
                if isinstance(socket, InterfacePair):
                    socket.clock = clock
                return socket

            def exchange(self) -> None:
                interface.now_ns += interface.step_ns
                super().exchange()

        monkeypatch.setattr("achse.station.building.bus_parts.InterfaceBus", Clocked)
        ends = isinstance(interface, BothEnds)
        whole: dict[str, Any] = {
            "nc": {"cycle": f"{interface.cycle_ns // 1000}us", "code": "plain"},
            "bus": [{"interface": "veth0"} | ({"redundant": "veth1"} if ends else {})],
            "axis": [{"id": n, "name": f"A{n}", **AXIS} for n in range(1, drives + 1)],
            "drive": [{"axis": n} for n in range(1, drives + 1)],
            "terminal": [{"name": f"T{n}"} for n in range(1, terminals + 1)],
        }
        self.station = Station(parse(whole | document, "test"))
        (bus,) = self.station.fieldbuses.values()
        assert isinstance(bus, InterfaceBus)
        self.bus = bus

    @property
    def axes(self) -> list[Any]:
        assert self.station.nc is not None
        return list(self.station.nc)

    def until(self, condition: Any, seconds: float = 30.0) -> None:
        """Station time passes until a condition holds."""
        for _ in range(round(seconds / 0.02)):
            if condition():
                return
            self.station.advance(0.02)
        assert condition(), (self.bus.trouble, [vars(each) for each in self.bus.master.slaves])

    def operational(self) -> bool:
        return self.bus.trouble == "" and self.bus.master.operational

    def enable(self) -> None:
        for axis in self.axes:
            axis.control_dword, axis.velocity_override = 7, 1_000_000
        self.until(lambda: all(axis.loop_closed for axis in self.axes))

    def go(self, target: float, velocity: float = 50.0) -> None:
        for axis in self.axes:
            assert commands.start(axis, StartType.ABSOLUTE, target, velocity) == 0

    def errors(self) -> set[NcError | None]:
        return {NcError.of(axis.error_code) if axis.error_code else None for axis in self.axes}

    def recovers(self) -> None:
        """What the how-to says: mend it, wait for Op, MC_Reset, go on."""
        self.until(self.operational)
        for axis in self.axes:
            assert commands.reset(axis) == 0
        self.until(lambda: all(axis.loop_closed for axis in self.axes))
        self.go(10.0, 100.0)
        self.until(lambda: all(abs(axis.actual_position - 10.0) < 0.02 for axis in self.axes))
        assert self.errors() == {None}


def drives(count: int) -> list[Drive]:
    return [Drive() for _ in range(count)]


def test_the_slaves_are_searched_while_the_station_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = BusRig(monkeypatch, Interface(2 * MS, drives(2)), 2)
    assert rig.bus.trouble == "veth0 is not open yet"
    rig.until(rig.operational)
    rig.enable()
    rig.go(30.0)
    rig.until(lambda: all(abs(axis.actual_position - 30.0) < 0.01 for axis in rig.axes))
    assert rig.bus.searches == 1
    assert rig.bus.round_trips.count > 100
    assert rig.bus.master.cyclic.counters.lost == 0
    (figures,) = rig.station.statistics()["buses"]
    assert (figures["interface"], figures["slaves_operational"]) == ("veth0", 2)


@pytest.mark.parametrize(
    ("trouble", "message"),
    [
        ("there", "no interface veth0; there are lo"),
        ("allowed", "raw Ethernet on veth0 needs CAP_NET_RAW"),
        ("up", "veth0: command 7 to 0 at 0x0130: sent 3 times, nothing came back"),
    ],
)
def test_an_interface_that_does_not_serve_is_reported_and_tried_again(
    trouble: str, message: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    interface = Interface(2 * MS, drives(1))
    setattr(interface, trouble, False)
    rig = BusRig(monkeypatch, interface, 1)
    rig.station.advance(0.02)
    assert rig.errors() == {None}, "it has not been looked for"
    rig.axes[0].control_dword = 7
    rig.until(lambda: rig.bus.trouble == message)
    rig.station.advance(2.0)
    assert rig.errors() == {NcError.DRIVE_IO_INVALID}
    assert [record.getMessage() for record in caplog.records].count(f"EtherCAT: {message}") == 1
    assert commands.reset(rig.axes[0]) == 0
    rig.station.advance(0.2)
    assert rig.errors() == {NcError.DRIVE_IO_INVALID}, "it is still not there"
    rig.axes[0].velocity_override = 1_000_000
    setattr(interface, trouble, True)
    rig.recovers()


def test_an_axis_that_is_not_enabled_waits_for_its_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    interface = Interface(2 * MS, drives(1))
    interface.up = False
    rig = BusRig(monkeypatch, interface, 1)
    rig.until(lambda: "nothing came back" in rig.bus.trouble)
    rig.station.advance(1.0)
    assert rig.errors() == {None}
    interface.up = True
    rig.until(rig.operational)
    rig.enable()


def test_an_enabled_axis_waits_for_a_bus_that_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = BusRig(monkeypatch, Interface(2 * MS, drives(2)), 2)
    rig.enable()
    assert rig.errors() == {None}


def test_too_few_slaves_are_reported_and_the_others_work(monkeypatch: pytest.MonkeyPatch) -> None:
    interface = Interface(2 * MS, drives(1))
    rig = BusRig(monkeypatch, interface, 2)
    rig.until(lambda: "Drive 2 (axis 2) missing" in rig.bus.trouble)
    rig.until(lambda: rig.bus.slaves[0].operational)
    assert not rig.bus.slaves[1].present
    interface.replace(drives(2))
    rig.until(lambda: rig.bus.master.operational)
    rig.enable()


def test_another_slave_than_a_drive_is_reported_until_it_is_changed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    interface = Interface(2 * MS, [DigitalTerminal(8, 8, "EL"), Drive()])
    rig = BusRig(monkeypatch, interface, 2, drive=[{"axis": 1, "own_mapping": True}, {"axis": 2}])
    text = "cannot be Drive 1 (axis 1): 6040h is not in its outputs"
    rig.until(lambda: text in rig.bus.trouble)
    rig.until(lambda: rig.bus.slaves[1].operational)
    interface.replace(drives(2))
    rig.until(rig.operational)


def test_slaves_that_are_not_in_the_tables_are_let_be(monkeypatch: pytest.MonkeyPatch) -> None:
    line = [Loopback(4), Drive(), Loopback(2)]
    rig = BusRig(monkeypatch, Interface(2 * MS, line), 1, drive=[{"axis": 1, "position": 2}])
    rig.until(rig.operational)
    assert [slave.state for slave in rig.bus.master.slaves] == [AlState.OP] * 3
    rig.enable()


def test_a_bus_has_one_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    import asyncio

    rig = BusRig(monkeypatch, Interface(2 * MS, drives(1)), 1)

    async def run() -> None:
        async with rig.station.running(tcp_port=0, udp_port=None, speed=2.0):
            raise AssertionError("not refused")

    with pytest.raises(ConfigError, match="slaves on veth0 need speed 1, got 2"):
        asyncio.run(run())


def test_closing_leaves_the_slaves_in_init(monkeypatch: pytest.MonkeyPatch) -> None:
    interface = Interface(2 * MS, drives(1))
    rig = BusRig(monkeypatch, interface, 1)
    rig.until(rig.operational)
    rig.bus.close()
    interface.segment.advance(interface.now_ns + 20 * MS)
    assert interface.segment.slaves[0].state is AlState.INIT
    rig.until(lambda: interface.opened == 2 and rig.operational())


def test_the_socket_is_a_raw_one(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []

    def link(interface: str, *, alone: bool) -> BusSocket:
        opened.append((interface, alone))
        return Cable(Interface(MS, []))

    monkeypatch.setattr(interface_bus, "EthernetLink", link)
    interface_bus.open_interface("eth7")
    assert opened == [("eth7", True)]


@settings(max_examples=5, deadline=None)
@given(st.data())
def test_whatever_happens_to_the_bus_ends_in_its_error_and_recovers(data: st.DataObject) -> None:
    """All parameters drawn: axes, terminals, cycle, what fails, when and for how long."""
    draw = data.draw
    count = draw(st.integers(1, 3), "drives")
    terminals = draw(st.integers(0, 2), "terminals")
    cycle_ns = draw(st.sampled_from([1, 2, 4]), "cycle in ms") * MS
    moved = drives(count)
    line = [*moved, *(DigitalTerminal(16, 16, f"T{n}") for n in range(terminals))]
    interface = Interface(cycle_ns, line)
    with pytest.MonkeyPatch.context() as patch:
        rig = BusRig(patch, interface, count, terminals)
        rig.until(rig.operational)
        rig.enable()
        rig.go(300.0, draw(st.floats(10.0, 100.0), "velocity"))
        rig.station.advance(draw(st.floats(0.0, 1.0), "when"))
        hit = draw(st.integers(0, count - 1), "drive")
        fault = draw(
            st.sampled_from(["cable", "killed", "safeop", "alarm", "interface"]), "what happens"
        )
        expected = NcError.DRIVE_IO_INVALID
        slave = interface.segment.slaves[hit]
        if fault == "cable":
            interface.up = False
        elif fault == "interface":
            interface.there = False
        elif fault == "safeop":
            slave.hang()
            slave.fail(AlStatus.WATCHDOG)
        elif fault == "alarm":
            moved[hit].faults.alarm(Alarm.OVER_VOLTAGE, lasting=False)
            expected = NcError.DRIVE_NOT_READY
        else:
            interface.replace([*drives(count), *line[count:]])
        everybody = fault in ("cable", "interface", "killed")
        wanted = {expected} if everybody or count == 1 else {expected, None}
        rig.until(lambda: rig.errors() == wanted)
        rig.station.advance(draw(st.floats(0.0, 2.0), "for how long"))
        interface.up = interface.there = True
        slave.hang(False)
        if fault == "safeop":  # given up after some tries, as the how-to says
            rig.bus.master.request(AlState.OP, rig.bus.slaves[hit])
        rig.recovers()


class Asking:
    """A client at the router of a station; answers are data, or the AMS or ADS error."""

    def __init__(self, station: Station) -> None:
        self.station = station
        self.answers: list[Frame] = []
        self.address = station.router.register(0, self)
        self.bus = default_net_id(station.router.net_id, 1)

    def deliver(self, frame: Frame) -> bool:
        """Take an answer."""
        self.answers.append(frame)
        return True

    def ask(self, target: AmsAddress, command: Command, payload: bytes) -> bytes | int:
        self.answers.clear()
        frame = Frame(target, self.address, command, Flags.ADS_COMMAND, 7, data=payload)
        self.station.router.deliver(frame)
        for _ in range(500):
            if self.answers:
                break
            self.station.advance(0.01)
        (answer,) = self.answers
        result = answer.error or int.from_bytes(answer.data[:4], "little")
        return result or answer.data[8:]

    def read(self, port: int, group: int, offset: int, length: int = 1024) -> bytes | int:
        payload = struct.pack("<III", group, offset, length)
        return self.ask(AmsAddress.of(self.bus, port), Command.READ, payload)

    def symbol(self, name: str) -> bytes | int:
        """The value of a variable of the bus image."""
        image = AmsAddress.of(self.station.router.net_id, 27905)
        payload = struct.pack("<IIII", 0xF004, 0, 1024, len(name)) + name.encode()
        return self.ask(image, Command.READ_WRITE, payload)


@settings(max_examples=6, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(st.data())
def test_slaves_that_no_table_names_have_their_ports(data: st.DataObject) -> None:
    """All parameters drawn: slaves, which of them a table names, and how many come later."""
    draw = data.draw
    axes = draw(st.integers(0, 1), "drives")
    before = draw(st.integers(1 - axes, 3), "slaves without a table")
    after = before + draw(st.integers(0, 2), "slaves that come")
    size = draw(st.integers(1, 8), "bytes of their process data")
    interface = Interface(2 * MS, [])
    with pytest.MonkeyPatch.context() as patch:
        interface.replace([*drives(axes), *boxes(before, size)])
        rig = BusRig(patch, interface, axes)
        client = Asking(rig.station)
        for number in (before, after):
            count = axes + number
            if number > before:
                interface.replace([*drives(axes), *boxes(number, size)])
            rig.until(lambda count=count: len(rig.bus.master.slaves) == count)
            rig.until(lambda: rig.operational() and all(s.present for s in rig.bus.master.slaves))
            stations = range(1001, 1001 + count)
            assert client.read(0xFFFF, 0x07, 0) == struct.pack(f"<{count}H", *stations)
            for slave in rig.bus.master.slaves[axes:]:
                station = slave.station
                text = f"box {station - 1001 - axes}".encode()
                assert client.read(station, 0xF302, 0x1008_0000) == text
                assert client.read(0xFFFF, 0x09, station) == b"\x08\0"
                own = AmsAddress.of(client.bus, station)
                assert client.symbol(f"{slave.name}.InfoData.AdsAddr") == bytes(own)
            assert client.read(1001 + count, 0xF302, 0x1008_0000) == 6
            assert len(set(map(id, rig.station.devices))) == len(rig.station.devices)


def boxes(count: int, size: int) -> list[Loopback]:
    return [Loopback(size, f"box {number}", serial_number=number) for number in range(count)]


def test_a_line_between_two_interfaces_is_one_bus(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = BusRig(monkeypatch, BothEnds(2 * MS, drives(3)), 3)
    assert rig.bus.trouble == "veth0 and veth1 is not open yet"
    rig.until(rig.operational)
    rig.enable()
    rig.go(20.0)
    rig.until(lambda: all(abs(axis.actual_position - 20.0) < 0.01 for axis in rig.axes))
    assert rig.bus.master.cyclic.counters.lost == 0
    assert rig.bus.master.traffic.lost_frames == 0
    (figures,) = rig.station.statistics()["buses"]
    facts = [figures[name] for name in ("interface", "second_interface", "ring_open", "trouble")]
    assert facts == ["veth0", "veth1", "", ""]


@pytest.mark.parametrize("adapter", [0, 1])
def test_one_interface_that_is_missing_is_reported_and_the_other_serves(
    adapter: int, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    interface = BothEnds(2 * MS, drives(2))
    interface.plug(adapter, False)
    rig = BusRig(monkeypatch, interface, 2)
    rig.until(lambda: rig.bus.master.operational)
    text = f"no interface veth{adapter}; there are lo"
    rig.until(lambda: rig.bus.trouble == text)
    rig.enable()
    interface.plug(adapter, True)
    rig.until(lambda: rig.bus.trouble == "")
    rig.until(lambda: not rig.bus.master.supervision.opening)
    interface.plug(adapter, False)
    rig.until(lambda: rig.bus.trouble == f"veth{adapter} is gone")
    rig.go(10.0)
    rig.until(lambda: all(abs(axis.actual_position - 10.0) < 0.01 for axis in rig.axes))
    assert rig.bus.searches == 1
    assert [each.getMessage() for each in caplog.records].count(f"EtherCAT: {text}") == 1


def test_two_missing_interfaces_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    interface = BothEnds(2 * MS, drives(1))
    interface.plugged = [False, False]
    rig = BusRig(monkeypatch, interface, 1)
    text = "no interface veth0; there are lo; no interface veth1; there are lo"
    rig.until(lambda: rig.bus.trouble == text)
    interface.plugged = [True, True]
    rig.until(rig.operational)
    rig.bus.close()
    interface.segment.advance(interface.now_ns + 20 * MS)
    assert interface.ring.slaves[0].state is AlState.INIT


@settings(max_examples=5, deadline=None)
@given(st.data())
def test_one_cut_at_a_time_stops_no_axis_and_two_are_an_error(data: st.DataObject) -> None:
    """Drawn: drives, cycle, which cables and links are cut, in which order, when, for how long."""
    draw = data.draw
    count = draw(st.integers(1, 4), "drives")
    cycle_ns = draw(st.sampled_from([1, 2, 4]), "cycle in ms") * MS
    interface = BothEnds(cycle_ns, drives(count))
    ring = interface.ring

    def hurt(what: str, place: int, well: bool) -> None:
        if what == "cable":
            (ring.mend if well else ring.cut)(place % (count + 1))
        elif what == "link":
            interface.link(place % 2, well)
        else:
            interface.plug(place % 2, well)

    with pytest.MonkeyPatch.context() as patch:
        rig = BusRig(patch, interface, count)
        rig.until(rig.operational)
        rig.enable()
        rig.go(60.0, 30.0)
        counters, master = rig.bus.master.cyclic.counters, rig.bus.master
        lost = counters.lost + counters.wrong
        cuts = draw(
            st.lists(
                st.tuples(st.sampled_from(["cable", "link", "interface"]), st.integers(0, 4)),
                max_size=4,
            ),
            "cut in this order",
        )
        for what, place in cuts:
            rig.station.advance(draw(st.floats(0.0, 0.3), "whole for"))
            hurt(what, place, False)
            rig.station.advance(draw(st.floats(0.05, 0.4), "cut for"))
            assert master.supervision.opening
            hurt(what, place, True)
            rig.until(lambda: not master.supervision.opening)
        assert rig.errors() == {None}
        # what was under way at the cut; and until an interface that comes is opened
        opened = 1 + 5 * MS // cycle_ns
        allowed = sum(1 + opened * (what == "interface") for what, _ in cuts)
        assert counters.lost + counters.wrong - lost <= allowed
        for adapter in (0, 1):
            interface.link(adapter, False)
        rig.until(lambda: rig.errors() == {NcError.DRIVE_IO_INVALID})
        for adapter in draw(st.permutations((0, 1)), "back in this order"):
            rig.station.advance(draw(st.floats(0.0, 0.5), "both cut for"))
            interface.link(adapter, True)
        rig.recovers()
