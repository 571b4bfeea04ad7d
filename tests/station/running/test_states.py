"""The states of a station: what goes with the parts, what stays, and how changes join."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from achse.ams import AdsState, Command, DeviceError, Frame
from achse.ams.commands import WriteControlRequest
from achse.station import Station
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.station_file import parse


class Watched(NamedTuple):
    """A demo station with clients of its PLC and its system service."""

    station: Station
    plc: Any
    system: Any

    def mode(self) -> tuple[int, int, int]:
        """ADS state, device state and restart index of the state block."""
        return tuple(self.system.get(0xF0, 0, "<HHH"))


@pytest.fixture
def watched(client_of: Callable[..., Any]) -> Watched:
    station = Station.demo()
    return Watched(station, client_of(station.router, 851), client_of(station.router, 10_000))


def _control(client: Any, state: AdsState, device_state: int = 1, data: bytes = b"") -> None:
    client.ask(Command.WRITE_CONTROL, WriteControlRequest(state, device_state, data))


def _router_error(client: Any) -> int:
    """The AMS error that a request of `client` meets, 0 if it was answered."""
    frames = len(client._frames)
    client.router.deliver(Frame(client.target, client.address, Command.READ_STATE))
    return int(client._frames.pop(frames).error)


def test_in_config_plc_and_nc_are_gone_and_a_reset_brings_them_back_again(watched: Watched) -> None:
    station, plc, system = watched
    _control(plc, AdsState.STOP)
    plc.put(0x4020, 0, "<I", 0xAFFE)
    assert watched.mode() == (AdsState.RUN, 1, 0)
    _control(system, AdsState.RECONFIG)
    assert watched.mode() == (AdsState.STOP, 1, 0), "who is answered never finds the old state"
    assert _router_error(plc) == 0, "the answer comes first, the change with the next cycle"
    station.advance(0.01)
    assert _router_error(plc) == 0x6
    assert watched.mode() == (AdsState.STOP, 1, 0)
    station.advance(0.5)
    assert watched.mode() == (AdsState.CONFIG, 1, 0)
    assert station.state is AdsState.CONFIG
    assert station.router.ports[:6] == [1, 30, 100, 110, 200, 10_000]
    station.advance(10.0)
    _control(system, AdsState.RESET)
    station.advance(0.4)
    assert _router_error(plc) == 0x6
    station.advance(0.2)
    assert watched.mode() == (AdsState.RUN, 1, 1)
    assert _router_error(plc) == 0
    assert plc.get(0xF100, 0, "<H") == AdsState.RUN
    assert plc.get(0x4020, 0, "<I") == 0


def test_a_restart_ends_handles_and_notifications_of_the_plc_not_of_the_system_service(
    watched: Watched,
) -> None:
    station, plc, system = watched
    handle = plc.exchange(0xF003, 0, 4, b"MAIN.nCounter")
    plc.subscribe(0xF005, int.from_bytes(handle, "little"), 4)
    system.subscribe(0xF100, 0, 2, cycle_s=0.1)
    station.advance(0.05)
    assert len(plc.samples()) >= 5
    _control(system, AdsState.RESET)
    station.advance(1.0)
    plc.samples()
    heard = [int.from_bytes(data, "little") for _, data in system.samples()]
    assert {AdsState.RUN, AdsState.STOP} == set(heard)
    station.advance(0.2)
    assert plc.samples() == []
    with pytest.raises(DeviceError) as refusal:
        plc.read(0xF005, int.from_bytes(handle, "little"), 4)
    assert refusal.value.code in (0x710, 0x711)
    station.advance(0.2)
    assert len(system.samples()) >= 2


def test_after_a_reset_is_answered_the_state_has_left_run(watched: Watched) -> None:
    _control(watched.system, AdsState.RESET)
    assert watched.mode() == (AdsState.STOP, 1, 0)


def test_many_restarts_leave_nothing_behind(watched: Watched) -> None:
    station = watched.station
    for _ in range(5):
        station.restart()
        station.advance(0.6)
    assert watched.mode() == (AdsState.RUN, 1, 5)
    assert len(station.router._close_listeners) == len(station.devices)
    phases = station.cycle.phases
    assert len({phase.name for phase in phases}) == len(phases)


def test_equal_restarts_give_equal_states() -> None:
    digests = []
    for step in (0.1, 0.7):
        station = Station.demo()
        station.advance(0.3)
        station.restart()
        for _ in range(round(1.4 / step)):
            station.advance(step)
        digests.append(station.digest())
    assert digests[0] == digests[1]


def test_an_added_phase_continues_through_a_restart(watched: Watched) -> None:
    calls: list[int] = []
    watched.station.cycle.add(CyclicPhase(PhasePlace.INPUTS, "mine", 100_000_000, calls.append))
    watched.station.restart()
    watched.station.advance(1.0)
    assert len(calls) == 10


def test_a_later_order_replaces_an_earlier_one(watched: Watched) -> None:
    station = watched.station
    station.configure()
    station.advance(0.1)
    station.restart()
    station.advance(0.6)
    assert watched.mode() == (AdsState.RUN, 1, 1)


def test_a_shutdown_waits_for_its_delay_and_then_nothing_answers(watched: Watched) -> None:
    station, plc, system = watched
    _control(system, AdsState.SHUTDOWN, 0, b"\x02\0\0\0")
    station.advance(1.9)
    assert _router_error(plc) == 0
    station.advance(0.2)
    assert station.ended
    assert (_router_error(plc), _router_error(system)) == (0x6, 0x6)
    station.advance(1.0)


def test_a_shutdown_with_restart_comes_back(watched: Watched) -> None:
    _control(watched.system, AdsState.SHUTDOWN, 1, b"\x01\0\0\0")
    watched.station.advance(1.7)
    assert watched.mode() == (AdsState.RUN, 1, 1)


def test_a_station_that_cannot_start_again_stays_in_config(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    program = tmp_path / "program.py"
    program.write_text("from achse.iec import Program\nclass MAIN(Program): pass\n")
    document = {"plc": [{"task": [{"programs": ["program.py:MAIN"]}]}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    program.write_text("1 / 0\n# another size\n")
    station.restart()
    station.advance(1.0)
    assert station.state is AdsState.CONFIG
    assert "cannot start and stays in CONFIG" in caplog.text
    assert 851 not in station.router.ports
    program.write_text("from achse.iec import Program\nclass MAIN(Program): pass\n")
    station.restart()
    station.advance(1.0)
    assert station.state is AdsState.RUN
