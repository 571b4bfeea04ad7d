"""An axis is enabled, moved and stopped; whatever ends a move is told as what it is."""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import AdsError, ConnectionLost
from achse.client.nc import (
    AxisAborted,
    AxisDisabled,
    AxisError,
    AxisFailed,
    AxisRefused,
    AxisTimeout,
    PlcOpenState,
    UnknownAxis,
)
from achse.codes.axis import ControlBit, StateBit
from achse.testing import LiveStation

Bench = Any
On = Callable[..., Any]


def test_moves(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x = bench.axis
        assert (await x.move_to(100, velocity=200)).status.set_position == 100.0
        assert (await x.move_by(-30, velocity=200)).status.set_position == 70.0
        cruise = await x.move_velocity(-80)
        assert cruise.status.set_velocity == -80.0
        assert await x.state() is PlcOpenState.CONTINUOUS_MOTION
        halt = await x.halt(deceleration=1000, jerk=10_000)
        assert halt.status.standstill
        await x.move_velocity(80)
        assert (await x.stop()).status.standstill
        await x.move_velocity(80)
        assert (await x.stop(deceleration=1000, jerk=10_000)).status.standstill
        assert await x.move_to(0, velocity=50, acceleration=500, deceleration=400, jerk=3000)

    on_bench(test)


def test_a_stop_that_locks(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        await bench.axis.move_velocity(80)
        await bench.axis.stop(lock=True)
        assert await bench.axis.state() is PlcOpenState.STOPPING
        with pytest.raises(AxisRefused):
            await bench.axis.move_to(0, velocity=10)
        await bench.axis.release()
        await bench.axis.move_to(0, velocity=100)

    on_bench(test)


def test_modulo_moves_know_their_way(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        c = bench.client.nc.axis("C")
        await c.enable()
        for way, position in (("shortest", -10.0), ("+", 350.0), ("-", 350.0)):
            move = await c.move_to(350, velocity=360, modulo=way)
            assert move.status.set_position == pytest.approx(position)
            await c.move_to(0, velocity=360) if way == "shortest" else None
        assert (await c.status()).modulo_position == pytest.approx(350.0, abs=1)

    on_bench(test)


def test_blended_moves(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x = bench.axis
        first = await x.move_to(150, velocity=100, wait=False)
        second = await x.move_to(350, velocity=50, buffer="blending low", wait=False)
        third = await x.move_to(400, velocity=50, buffer="buffered", wait=False)
        passed = await first.finished()
        assert passed.set_position == pytest.approx(150, abs=1)
        assert passed.set_velocity == pytest.approx(50, abs=1)
        assert (await second.finished()).set_position == pytest.approx(350, abs=1)
        assert (await third.finished()).set_position == 400.0
        assert await third.finished() is third.status

    on_bench(test)


def test_jog(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x = bench.axis
        await x.parameters["jog velocity slow"].write(60)
        await x.jog("+", duration=0.5)
        there = await x.position()
        assert 5 < there < 60
        assert await x.state() is PlcOpenState.STANDSTILL
        await x.jog("-", speed="fast")
        await x.wait_for("constant velocity")
        assert await x.velocity() < 0
        await x.halt()
        for wrong in ({"direction": "up"}, {"direction": "+", "speed": "warp"}):
            with pytest.raises(ValueError, match="expected '"):
                await x.jog(**wrong)
        with pytest.raises(ValueError, match="duration"):
            await x.jog("+", duration=-1)
        assert await x.state() is PlcOpenState.STANDSTILL

    on_bench(test)


def test_positions_and_homing(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x = bench.axis
        await x.set_position(500)
        assert await x.position() == pytest.approx(500, abs=0.01)
        await x.set_position(-100, relative=True)
        assert await x.position() == pytest.approx(400, abs=0.01)
        move = await x.move_to(450, velocity=50, wait=False)
        bench.advance(0.3)
        await x.set_position(1000, relative=True, moving=True)
        with pytest.raises(AxisAborted):  # it does not end at 450 any more
            await move.finished()
        await x.set_homed(False)
        assert not (await x.status()).homed
        await x.set_homed()
        await x.wait_for("homed")

    on_bench(test)


def test_homing() -> None:
    slide = {
        "id": 1, "name": "Slide", "homing_velocity_towards_cam": 60.0,
        "homing_velocity_off_cam": 20.0, "encoder_reference_mode": 2,
        "encoder_reference_position": 12.5, "simulation_cam_end": -40.0,
    }  # fmt: skip
    with LiveStation({"axis": [slide]}, time="virtual") as live, live.connect() as client:
        axis = client.nc.axis("Slide")
        axis.enable()
        assert axis.home().status is not None
        assert axis.status().homed
        assert 12.5 < axis.position() < 20


# switches --------------------------------------------------------------------------------------


def test_enable_and_disable(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x = bench.axis
        await x.enable(negative=False, override=50)
        assert (await x.status()).enabled
        assert await x.override() == 50.0
        assert await x.state() is PlcOpenState.STANDSTILL
        with pytest.raises(AxisRefused, match="0x4223"):
            await x.move_to(-1, velocity=10)
        await x.enable(override=None)
        assert await x.override() == 50.0
        await x.disable()
        assert await x.state() is PlcOpenState.DISABLED
        with pytest.raises(AxisRefused, match="0x4260"):
            await x.move_to(1, velocity=10)

    on_bench(test, enabled=False)


def test_other_bits_of_the_control_word_stay(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        record = bench.station.nc.axis(1)
        record.control_dword = int(ControlBit.ACCEPT_BLOCKED_DRIVE)
        await bench.axis.enable()
        await bench.axis.disable()
        assert record.control_dword == ControlBit.ACCEPT_BLOCKED_DRIVE

    on_bench(test, enabled=False)


def test_a_plc_that_writes_the_enables_is_reported(on_bench: On) -> None:
    """A linked PLC writes ControlDWord in each of its cycles."""

    async def test(bench: Bench) -> None:
        def plc(time: float) -> None:
            bench.station.nc.axis(1).control_dword = 0

        bench.hooks.append(plc)
        with pytest.raises(AxisDisabled, match="MC_Power"):
            await bench.axis.enable()

    on_bench(test, enabled=False)


@pytest.mark.parametrize("method", ["enable", "disable", "reset", "home", "stop"])
def test_a_wrong_time_limit_switches_nothing(on_bench: On, method: str) -> None:
    async def test(bench: Bench) -> None:
        before = await bench.axis.status(), await bench.axis.override()
        with pytest.raises(ValueError, match="within: expected"):
            await getattr(bench.axis, method)(within=-1.0)
        assert (await bench.axis.status(), await bench.axis.override()) == before

    on_bench(test, enabled=False)


def test_an_axis_that_does_not_get_ready(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        bench.station.nc.axis(1).drive_output_disabled = 1
        bench.station.nc.axis(1).axis_disabled = 1
        with pytest.raises(AxisError, match=r"not ready|0x"):
            await bench.axis.enable(within=2.0)

    on_bench(test, enabled=False)


def test_reset(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x = bench.axis
        await x.call("set external axis error", 0x4655)
        bench.advance(0.1)
        assert isinstance(await x.error(), AxisFailed)
        with pytest.raises(AxisError, match="0x4655"):
            await x.move_to(10, velocity=10)
        with pytest.raises(AxisFailed, match="0x4655"):
            await x.enable()
        await x.reset()
        assert await x.error() is None

    on_bench(test)


# what ends a move ------------------------------------------------------------------------------


def _at(bench: Bench, moment: float, act: Callable[[], Any]) -> None:
    """Do something once, so many seconds from now, while something else waits."""
    begin = bench.station.time_ns / 1e9
    done = False

    def hook(time: float) -> None:
        nonlocal done
        if not done and time >= begin + moment:
            done = True
            act()

    bench.hooks.append(hook)


def test_an_error_while_it_moves(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        _at(bench, 0.5, lambda: setattr(bench.station.nc.axis(1), "control_dword", 0))
        with pytest.raises(AxisFailed, match="0x4260") as caught:
            await bench.axis.move_to(500, velocity=100)
        assert (caught.value.code, caught.value.axis) == (0x4260, "X")
        with pytest.raises(AxisRefused, match="0x4260"):
            await bench.axis.move_to(0, velocity=100)

    on_bench(test)


@pytest.mark.parametrize("command", ["move_to", "halt", "stop", "clear", "new_end_position"])
def test_another_client_takes_over(on_bench: On, command: str) -> None:
    async def test(bench: Bench) -> None:
        async with bench.connect() as other:
            theirs = other.nc.axis("X")
            move = asyncio.ensure_future(bench.axis.move_to(500, velocity=100))
            await theirs.wait_for(lambda status: status.set_position > 50)
            if command == "move_to":
                await theirs.move_to(0, velocity=100, wait=False)
            elif command == "new_end_position":
                await theirs.call(command, 1, 100.0)
            elif command == "clear":
                await theirs.call(command)
            else:
                await getattr(theirs, command)(wait=False)
            with pytest.raises(AxisAborted) as caught:
                await move
            assert caught.value.axis == "X"

    on_bench(test)


def test_two_clients_take_turns_in_the_buffer(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        async with bench.connect() as other:
            theirs = other.nc.axis(1)
            first, second = await asyncio.gather(
                bench.axis.move_to(50, velocity=100),
                theirs.move_to(80, velocity=100, buffer="buffered"),
            )
            assert second.status.set_position == 80.0
            assert first.number != second.number

    on_bench(test)


def test_the_connection_is_lost_while_it_moves(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        _at(bench, 0.5, lambda: bench.client.session.link.abort())
        with pytest.raises(ConnectionLost):
            await bench.axis.move_to(500, velocity=100)
        assert await bench.axis.position() > 0  # connected again, and the axis went on

    on_bench(test)


def test_the_station_is_restarted_while_it_moves() -> None:
    with LiveStation() as live, live.connect() as client:
        axis = client.nc.axis("X")
        axis.enable()
        move = axis.move_to(5000, velocity=100, wait=False)
        axis.wait_for("moving")
        live.restart()
        with pytest.raises(AdsError):
            move.finished(patience=60)
        with pytest.raises(AxisRefused, match="0x4260"):
            axis.move_to(10, velocity=10)


@pytest.mark.parametrize(
    "fault",
    [
        {"kind": "restart"},
        {"kind": "config"},
        {"kind": "drop"},
        {"kind": "cut"},
        {"kind": "truncate"},
        {"kind": "error", "code": 0x706},
        {"kind": "router_error", "code": 7},
    ],
    ids=lambda fault: fault["kind"],
)
def test_whatever_happens_on_the_wire_is_reported(fault: dict[str, Any]) -> None:
    with (
        LiveStation(time="virtual") as live,
        live.connect() as client,
        live.connect() as impatient,
    ):
        impatient._client.timeout = 0.2
        client.nc.axis("X").enable()
        client.nc.axis("X").move_by(100, velocity=100, wait=False)
        live.advance(0.3)
        fields = dict(fault)
        live.fault(fields.pop("kind"), **fields)
        with pytest.raises(AdsError):
            impatient.nc.axis("X").wait_for("in target", patience=30)


def test_a_link_lost_before_the_wait_is_reported_or_the_wait_is_whole() -> None:
    """Which of the two depends on who is first: the next request or the news of the loss."""
    with LiveStation(time="virtual") as live, live.connect() as client:
        axis = client.nc.axis("X")
        axis.enable()
        axis.move_by(100, velocity=100, wait=False)
        live.advance(0.3)
        live.fault("drop_link")
        with contextlib.suppress(ConnectionLost):
            axis.wait_for("in target", patience=600)
        axis.wait_for("in target", patience=600)
        assert axis.position() == pytest.approx(100, abs=0.1)


def test_a_name_is_looked_up_again_when_the_station_was_restarted_behind_its_router() -> None:
    with LiveStation(time="virtual") as live, live.connect() as client:
        axis = client.nc.axis("X")
        axis.enable()
        move = axis.move_to(1000, velocity=100, wait=False)
        live.fault("restart")
        with pytest.raises(AdsError):
            move.finished(patience=30)
        while (nc := live.run(lambda: live.station.nc)) is None:
            live.advance(0.05)  # the restart is not over
        live.run(lambda: setattr(nc.axis(1), "name", "Z"))
        with pytest.raises(UnknownAxis):
            axis.position()


def test_an_override_of_zero_is_not_waited_for_without_end(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        await bench.axis.set_override(0)
        with pytest.raises(AxisTimeout, match="its override is 0 %"):
            await bench.axis.move_to(10, velocity=10)
        with pytest.raises(AxisTimeout, match="waited 2 s"):
            await bench.axis.move_by(10, velocity=10, within=2)

    on_bench(test)


def test_a_cancelled_wait_leaves_the_axis_alone(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        move = await bench.axis.move_to(5000, velocity=10, wait=False)
        waiting = asyncio.ensure_future(move.finished())
        bench.hooks.append(lambda now: waiting.cancel() and None)
        with pytest.raises(asyncio.CancelledError):
            await waiting
        bench.hooks.clear()
        status = await bench.axis.status()
        assert status.has(StateBit.HAS_JOB)
        await bench.axis.halt()

    on_bench(test)


# what is not sent ------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), "1", None, 10**400])
@pytest.mark.parametrize(
    "name",
    [
        "position", "velocity", "acceleration", "deceleration", "jerk",
        "blending_position", "start_velocity", "end_velocity",
    ],
)  # fmt: skip
def test_what_is_not_a_number_is_not_sent(on_bench: On, name: str, value: Any) -> None:
    async def test(bench: Bench) -> None:
        arguments = {"position": 1.0, "velocity": 10.0} | {name: value}
        with pytest.raises(ValueError, match=f"{name}: expected a finite number"):
            await bench.axis.move_to(arguments.pop("position"), **arguments)
        assert (await bench.axis.status()).command_number == 0

    on_bench(test)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"position": 1e300, "velocity": 10.0}, 0x4232),
        ({"position": 1.0, "velocity": 0.0}, 0x4221),
        ({"position": 1.0, "velocity": -10.0}, 0x4221),
        ({"position": 1.0, "velocity": 1e300}, 0x4221),
        ({"position": 1.0, "velocity": 10.0, "acceleration": -1.0}, None),
        ({"position": 1.0, "velocity": 10.0, "jerk": -1.0}, None),
    ],
)
def test_numbers_that_the_nc_refuses(
    on_bench: On, arguments: dict[str, float], code: int | None
) -> None:
    async def test(bench: Bench) -> None:
        with pytest.raises(AxisRefused) as caught:
            await bench.axis.move_to(**arguments)
        assert code in (None, caught.value.code)
        assert caught.value.axis == "X"

    on_bench(test)


@pytest.mark.parametrize(
    "wrong", [{"within": -1}, {"patience": float("nan")}, {"buffer": "soon"}, {"modulo": "left"}]
)
def test_wrong_options_move_nothing(on_bench: On, wrong: dict[str, Any]) -> None:
    async def test(bench: Bench) -> None:
        with pytest.raises(ValueError, match="expected"):
            await bench.axis.move_to(10, velocity=10, **wrong)
        assert (await bench.axis.status()).command_number == 0

    on_bench(test)


def test_an_endless_move_has_a_direction(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        with pytest.raises(ValueError, match="`halt` brings the axis to rest"):
            await bench.axis.move_velocity(0)

    on_bench(test)
