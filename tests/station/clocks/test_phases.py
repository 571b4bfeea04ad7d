"""What each phase has to do, and when it is due."""

import math
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.motion import AxisParameters, Nc, commands
from achse.plc import PlcRuntime, Task
from achse.server import SampleBudget
from achse.station import Station
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.clocks.pacing import Pace
from achse.station.clocks.phases import ChangePhase, NcPhase, NotificationPhase, PlcPhase, upkeep
from achse.station.configuration.station_file import parse
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener
from tests.transport.connections.peers import Loop, Wire

MS = 1_000_000


def test_changes_happen_at_their_time_in_their_order() -> None:
    reports: list[str] = []
    changes = ChangePhase()
    assert changes.due_ns == math.inf
    changes.plan((20, lambda: reports.append("b")), (10, lambda: reports.append("a")))
    changes.plan(*changes.plans, (20, lambda: reports.append("c")))
    assert changes.due_ns == 10
    changes.step(15)
    assert (reports, changes.due_ns) == (["a"], 20)
    changes.step(20)
    assert (reports, changes.due_ns, changes.plans) == (["a", "b", "c"], math.inf, ())


def test_a_change_may_plan_another() -> None:
    changes = ChangePhase()
    changes.plan((10, lambda: changes.plan((5, lambda: None))))
    changes.step(10)
    assert changes.due_ns == 5


def test_the_nc_does_all_cycles_up_to_now() -> None:
    nc = Nc(2 * MS, [AxisParameters(1)])
    phase = NcPhase(nc, lambda: None)
    phase.begin(1)
    assert phase.due_ns == 2 * MS
    phase.step(2 * MS)
    phase.step(13 * MS)
    assert (nc.cycle_count, phase.due_ns) == (6, 14 * MS)


def test_late_cycles_are_those_of_the_pace() -> None:
    nc = Nc(2 * MS, [AxisParameters(1)])
    pace = Pace(2 * MS, 1.0, now=0)
    phase = NcPhase(nc, lambda: pace)
    phase.begin(1)
    assert pace.take(2 * MS + 1)
    phase.step(2 * MS)
    assert nc.late_cycles == 0
    assert pace.take(7 * MS)
    phase.step(4 * MS)
    assert nc.late_cycles == 1


def test_a_plc_is_due_with_its_next_task() -> None:
    plc = PlcRuntime([Task("Fast", 3 * MS), Task("Slow", 5 * MS)])
    phase = PlcPhase(plc)
    assert (phase.place, phase.name, phase.due_ns) == (PhasePlace.PLC, "plc 851", 3 * MS)
    phase.begin(1)
    phase.step(3 * MS)
    assert phase.due_ns == 5 * MS
    plc.stop()
    phase.step(5 * MS)
    assert phase.due_ns == 6 * MS


def _device(due_ns: float, reports: list[Any]) -> Any:
    notifications = SimpleNamespace(due_ns=due_ns, tick=lambda now: reports.append((due_ns, now)))
    return SimpleNamespace(
        notifications=notifications, sweep=lambda now: reports.append(("sweep", now))
    )


def test_notifications_are_due_with_the_first_sample_of_any_device() -> None:
    budget = SampleBudget(1000)
    reports: list[Any] = []
    phase = NotificationPhase([_device(due, reports) for due in (130.0, math.inf, 120.0)], budget)
    assert phase.due_ns == 120
    phase.step(120)
    assert reports == [(120.0, 120)]
    assert NotificationPhase([], budget).due_ns == math.inf


def test_upkeep_is_once_a_second_in_whole_ticks() -> None:
    reports: list[Any] = []
    phase = upkeep([_device(0, reports)], 300 * MS, lambda: 7)
    phase.begin(1)
    assert phase.due_ns == 1200 * MS
    phase.step(1200 * MS)
    assert reports == [("sweep", 7)]


class _Kept(Wire):
    """A wire that keeps what is written."""

    def __init__(self, loop: Any) -> None:
        super().__init__(loop)
        self.written = b""

    def write(self, data: bytes | bytearray | memoryview) -> None:
        super().write(data)
        self.written += data


def _watched(subscriptions: list[tuple[int, int, int, int]]) -> tuple[Station, Loop, list[_Kept]]:
    """Return a station with two axes, and connections of two clients that watch them."""
    axes = [{"id": 1, "name": "A"}, {"id": 2, "name": "B"}]
    station = Station(parse({"axis": axes, "nc": {"code": "machine"}}, ""))
    loop, wires = Loop(), []
    listener: Any = TcpListener(station.router)
    listener.begin(loop)
    for number in (1, 2):
        wire = _Kept(loop)
        wire.peer = Peer(listener)
        wire.peer.begin(wire, f"10.0.0.{number}", 1)
        wires.append(wire)
    for client, axis, offset, cycle_ms in subscriptions:
        body = ADD_NOTIFICATION_BODY.pack(0x4100 + axis, offset, 8, 4, 0, cycle_ms * 10_000)
        target = AmsAddress.of(station.router.net_id, 501)
        source = AmsAddress(f"10.0.0.{client}.1.1:30000")
        frame = Frame(target, source, Command.ADD_NOTIFICATION, data=body)
        wires[client - 1].peer.receive(frame.encode_tcp())
    loop.run(1.0)
    return station, loop, wires


@given(
    st.lists(
        st.tuples(
            st.integers(1, 2),
            st.integers(1, 2),
            st.sampled_from((0x0A, 0x0B, 0x0D, 0x0E, 0x10, 0x1F)),
            st.sampled_from((2, 10)),
        ),
        min_size=1,
        max_size=12,
    ),
    st.lists(st.tuples(st.integers(1, 2), st.floats(-300.0, 300.0)), min_size=1, max_size=3),
    st.lists(st.integers(1, 400), min_size=1, max_size=4),
)
@settings(max_examples=6)
def test_samples_taken_ahead_are_those_of_single_ticks(
    subscriptions: list[tuple[int, int, int, int]],
    moves: list[tuple[int, float]],
    spans: list[int],
) -> None:
    pytest.importorskip("llvmlite")
    single, leaping = _watched(subscriptions), _watched(subscriptions)
    for ticks in spans:
        for station, loop, _ in (single, leaping):
            assert station.nc is not None
            for axis, position in moves:
                station.nc.axis(axis).control_dword = 7
                station.nc.axis(axis).velocity_override = 1_000_000
                commands.start(station.nc.axis(axis), 1, position * ticks, 100.0)
            if station is single[0]:
                for _ in range(ticks):
                    station.step()
            else:
                station.cycle.go_to(station.time_ns + ticks * station.tick_ns)
            loop.run()
        assert single[0].digest() == leaping[0].digest()
        assert [wire.written for wire in single[2]] == [wire.written for wire in leaping[2]]


def test_cycles_and_samples_are_done_together() -> None:
    pytest.importorskip("llvmlite")
    station, _, wires = _watched([(1, 1, 0x0A, 10), (2, 2, 0x0B, 10)])
    steps: list[int] = []
    notify = next(each for each in station.cycle.phases if isinstance(each, NotificationPhase))
    step = notify.step

    def counted(now_ns: int) -> None:
        steps.append(now_ns)
        step(now_ns)

    notify.step = counted  # type: ignore[method-assign]
    station.advance(10.0)
    assert len(steps) <= 15  # the first ones, and those beside the look after clients
    assert station.nc is not None
    assert station.nc.cycle_count == 5000
    station.cycle.add(CyclicPhase(PhasePlace.INPUTS, "other", 10 * MS, lambda now: None))
    steps.clear()
    station.advance(1.0)
    assert len(steps) == 100
    assert wires[0].written
