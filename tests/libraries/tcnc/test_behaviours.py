"""What the manual says of signals and motions, seen by a program of TcNC (004 §3, §4.1.1, §6.1).

The diagrams of §4.1.1 are the sequences of flags below: positioning without and with windows, a
stop, an error on the way.
"""

from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.axis import StateBit
from achse.codes.nc.choices import AxisType, ControllerType, DriveType

FLAGS = {
    "J": StateBit.HAS_JOB,
    "M": StateBit.POSITIVE_DIRECTION | StateBit.NEGATIVE_DIRECTION,
    "N": StateBit.NOT_MOVING,
    "S": StateBit.HAS_BEEN_STOPPED,
    "P": StateBit.IN_POSITION_AREA,
    "T": StateBit.IN_TARGET_POSITION,
    "E": StateBit.ERROR,
}


def _flags(on: Any, of: str) -> str:
    word = on.main["fromNc1"]["nStateDWord"]
    return "".join(letter for letter in of if word & FLAGS[letter])


def _sequence(on: Any, of: str, count: int) -> list[str]:
    """The flags in each of the next calls; what repeats itself is one."""
    seen: list[str] = []
    for _ in range(count):
        on.call()
        now = _flags(on, of)
        if not seen or seen[-1] != now:
            seen.append(now)
    return seen


def _start(on: Any, mode: int = 1, target: float = 50.0, velocity: float = 100.0) -> None:
    on.set("a", AXID=1, MODE=mode, TARGPOS=target, VELOCITY=velocity, START=True)


WINDOWS = {
    "position_range_monitoring_enable": 1, "position_range_window": 5.0,
    "target_position_monitoring_enable": 1, "target_position_window": 0.5,
    "target_position_monitoring_time": 0.05,
}  # fmt: skip


@pytest.mark.parametrize(
    ("windows", "flags", "sequence"),
    [
        ((), "JMNSE", ["N", "JM", "N"]),
        (("position",), "JMNP", ["NP", "JM", "JMP", "NP"]),
        (("target",), "JMNT", ["NT", "JM", "JMT", "NT"]),
    ],
)
def test_positioning(bench: Any, windows: tuple[str, ...], flags: str, sequence: list[str]) -> None:
    """Job and motion by set values; the windows by the actual position, target ones for a time."""
    axis = {
        name: value
        for name, value in WINDOWS.items()
        if any(name.startswith(window) for window in windows)
    }
    on = bench(a="AXACT", axis=axis)
    on.call(10)
    assert _flags(on, flags) == sequence[0]
    _start(on)
    seen = _sequence(on, flags, 300)
    assert [each for each in seen if each != "JN"] == sequence[seen[0] != sequence[0] :]


def test_a_stop_brings_the_axis_to_rest(bench: Any) -> None:
    on = bench(a="AXACT")
    _start(on, target=500.0)
    on.call(50)
    on.set("a", STOP=True)
    assert _sequence(on, "JMNS", 200) == ["JM", "JMS", "NS"]
    speed = on.axis().set_velocity
    assert speed == 0.0
    on.set("a", START=False, STOP=False)
    on.call()
    _start(on, mode=2, target=5.0)
    assert "S" not in _sequence(on, "JMNS", 100)[-1]  # gone with the next command


def test_an_error_drops_the_velocity(bench: Any) -> None:
    """By the ramp of an emergency stop, here as steep as it gets (docs/coverage/nc-choices.md)."""
    steep = {"fast_axis_stop_deceleration": 1e6, "fast_axis_stop_jerk": 1e9}
    on = bench(a="AXACT", f="AXFNC", axis=steep)
    _start(on, target=500.0)
    on.call(50)
    assert on.axis().set_velocity == 100.0
    here = on.axis().set_position
    on.main["toNc1"]["nDeCtrlDWord"] = 0  # the enable is withdrawn
    on.call(3)
    assert on.axis().set_velocity == 0.0
    assert on.axis().set_position == pytest.approx(here, abs=5.0)
    assert _flags(on, "JMNE") == "NE"
    assert on.main["fromNc1"]["nErrorCode"] == on.axis().error_code != 0
    on.main["toNc1"]["nDeCtrlDWord"] = 7
    on.set("a", START=False)
    on.call()
    on.set("a", START=True)
    on.call(3)
    assert on.shown("a")[1]  # first a reset
    on.set("f", AXID=1, RESET=True)
    on.call(3)
    assert (on.shown("f"), _flags(on, "E")) == ((False, False, 0), "")


def test_override_0_has_a_job_and_moves_without_velocity(bench: Any) -> None:
    on = bench(a="AXACT")
    _start(on, target=500.0)
    on.call(30)
    on.main["toNc1"]["nOverride"] = 0
    on.call(100)
    assert (_flags(on, "JMN"), on.axis().set_velocity) == ("JM", 0.0)
    assert on.main["fromNc1"]["nAxisState"] == 2
    on.main["toNc1"]["nOverride"] = 1_000_000
    on.call(1000)
    assert (_flags(on, "JMN"), on.axis().set_position) == ("N", 500.0)


def test_a_new_target_shows_until_a_restart_or_reset(bench: Any) -> None:
    on = bench(a="AXACT", f="AXFNC")

    def shown() -> bool:
        return bool(on.main["fromNc1"]["nStateDWord"] & StateBit.NEW_TARGET_POSITION)

    for ends in ("restart", "reset"):
        on.set("a", START=False)
        on.set("f", SETTARG=False, RESET=False)
        on.call()
        _start(on, mode=2, target=100.0)
        on.call(20)
        assert not shown()
        on.set("f", AXID=1, MODE=2, VAL=120.0, SETTARG=True)
        on.call(3)
        assert shown()
        on.call(300)
        if ends == "restart":
            on.set("a", START=False)
            on.call()
            _start(on, mode=2, target=1.0)
        else:
            on.set("f", RESET=True)
        on.call(5)
        assert not shown()
        on.call(100)


def test_new_targets_at_rest_are_an_error(bench: Any) -> None:
    on = bench(n="FB_AxisNewTargPosAndVelo", f="AXFNC")
    on.set("n", iAxisId=1, eCmdType=1, eTargPosType=1, fTargPos=5.0, bExecute=True)
    on.set("f", AXID=1, MODE=1, VAL=5.0, SETTARG=True)
    on.call(2)
    code = on.main["n"]["iErrId"]
    assert (on.main["n"]["bErr"], on.shown("f")) == (True, (False, True, code))
    assert NcError.of(code) == code


def test_a_coupled_slave_takes_no_motion_commands(bench: Any) -> None:
    """Unless the axis parameter allows them; uncoupled on the way it goes on without an end."""
    on = bench(c="AXCPL", a="AXACT", m="AXACT")
    on.set("c", AXID=1, MASTERID=2, CPLMODE=1, CPLPAR1=1.0, CPLON=True)
    on.call(3)
    assert on.main["fromNc1"]["nCoupleState"] == 3
    assert on.main["fromNc2"]["nCoupleState"] == 1
    _start(on)
    on.call(2)
    assert on.shown("a")[2] in (0x4266, 0x4267)
    on.set("m", AXID=2, MODE=3, VELOCITY=60.0, START=True)
    on.call(150)
    on.set("c", CPLON=False, CPLOFF=True)
    on.call(50)
    assert on.main["fromNc1"]["nCoupleState"] == 0
    assert on.axis().set_velocity == 60.0
    assert on.main["fromNc1"]["nStateDWord"] & StateBit.CONTINUOUS_MOTION
    on.set("a", STOP=True)
    on.call(100)
    assert on.axis().set_velocity == 0.0


def test_manual_travel_ends_with_its_edge_or_a_stop(bench: Any) -> None:
    """VAL counts with the edge only; soft limits hold."""
    on = bench(f="AXFNC", a="AXACT", axis={"encoder_soft_limit_max_enable": 1,
                                           "encoder_soft_limit_max": 150.0})  # fmt: skip
    on.set("f", AXID=1, VAL=40.0, MANFW=True)
    on.call(60)
    assert on.axis().set_velocity == 40.0
    on.set("f", VAL=5.0)
    on.call(10)
    assert on.axis().set_velocity == 40.0
    on.set("f", MANFW=False)
    on.call(60)
    assert on.axis().set_velocity == 0.0
    on.set("f", VAL=40.0, MANFW=True)
    on.call(60)
    on.set("a", AXID=1, STOP=True)
    on.call(60)
    assert on.axis().set_velocity == 0.0
    on.set("f", MANFW=False)
    on.call(3)
    on.set("f", MANFW=True)
    on.call(600)
    assert on.axis().set_position <= 150.0 + 1e-9
    assert on.axis().set_velocity == 0.0


def test_direct_output_needs_the_controller_enable(bench: Any) -> None:
    on = bench(f="AXFNC")
    on.set("f", AXID=1, MODE=2, VAL=20.0, SETDRIVE=True)
    on.call(60)
    assert on.axis().actual_velocity == pytest.approx(20.0, rel=0.01)
    on.main["toNc1"]["nDeCtrlDWord"] = 6
    on.call(100)
    assert on.axis().actual_velocity == pytest.approx(0.0, abs=0.01)


TWO_SPEEDS = {
    "axis_type": AxisType.DISCRETE_RAPID_CREEP.value, "drive_type": DriveType.RAPID_CREEP.value,
    "controller_type": ControllerType.RAPID_CREEP_POSITION.value,
    "creep_distance_positive": 10.0, "brake_distance_positive": 5.0,
}  # fmt: skip


def test_a_two_speed_axis_starts_only_beyond_its_braking_distance(bench: Any) -> None:
    on = bench(a="AXACT", axis=TWO_SPEEDS)
    _start(on, mode=2, target=4.0)
    on.call(100)
    assert on.axis().actual_position == pytest.approx(0.0, abs=1e-6)
    on.set("a", START=False)
    on.call()
    _start(on, mode=2, target=60.0)
    on.call(1000)
    assert 50.0 < on.axis().actual_position < 62.0


def test_servo_modes_are_none_of_a_two_speed_axis(bench: Any) -> None:
    on = bench(a="AXACT", axis=TWO_SPEEDS)
    for mode in (272, 785, 1312):
        _start(on, mode=mode)
        on.call(2)
        assert on.shown("a")[1], mode
        on.set("a", START=False)
        on.call()


def test_cyclic_gear_ratio_from_the_structure(bench: Any) -> None:
    """Types 15 and 18 take it from fAxisModeLReal in each cycle."""
    on = bench(c="AXCPL", a="AXACT")
    on.main["toNc1"]["fAxisModeLReal"] = 2.0
    on.set("c", AXID=1, MASTERID=2, CPLMODE=15, CPLPAR1=10.0, CPLON=True)
    on.call(3)
    assert on.shown("c") == (False, False, 0)
    on.set("a", AXID=2, MODE=3, VELOCITY=20.0, START=True)
    on.call(150)
    assert on.axis().set_velocity == pytest.approx(40.0)
    on.main["toNc1"]["fAxisModeLReal"] = -0.5
    on.call(150)
    assert on.axis().set_velocity == pytest.approx(-10.0)
