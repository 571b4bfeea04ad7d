"""The NC: axes by id, their parameters, cycle and state hash."""

import sys
from collections.abc import Callable
from typing import Any

import pytest

from achse.motion import AxisParameters, AxisParametersError, Nc, commands
from achse.motion.compiled import KERNEL
from achse.motion.kernel import cycles
from achse.motion.nc import STORED_VELOCITIES
from achse.native.compiled import Kernel


def test_axes_are_found_by_id_in_any_order() -> None:
    nc = Nc(1_000_000, [AxisParameters(9, "C", "deg"), AxisParameters(2, "X")], compiled=False)
    assert [axis.axis_id for axis in nc] == [2, 9]
    assert len(nc) == 2
    assert (nc.axis(9).name, nc.axis(9).unit) == ("C", "deg")
    assert nc.cycle_seconds == 0.001
    with pytest.raises(KeyError):
        nc.axis(1)


def test_an_axis_without_name_is_called_by_its_id() -> None:
    assert Nc(1_000_000, [AxisParameters(7)], compiled=False).axis(7).name == "Axis 7"


@pytest.mark.parametrize(
    ("axis_id", "values", "message"),
    [
        (0, {}, "axis id 0: expected 1..255"),
        (256, {}, "axis id 256: expected 1..255"),
        (1, {"speed": 1.0}, "axis 1: no parameter 'speed'"),
        (1, {"set_position": 1.0}, "axis 1: no parameter 'set_position'"),
        (1, {"max_velocity": 0.0}, "max_velocity = 0.0, expected 0.001..1e+20"),
        (1, {"max_velocity": float("nan")}, "max_velocity = nan"),
        (1, {"override_type": 1.5}, "override_type = 1.5, expected a whole number"),
        (1, {"drive_motor_polarity": 2}, "expected 0..1"),
        (1, {"axis_type": 4}, "axis_type = 4 is not an AxisType"),
        (1, {"encoder_reference_mode": 8}, "encoder_reference_mode = 8 is not a ReferenceMode"),
    ],
)
def test_bad_parameters_are_refused(axis_id: int, values: dict[str, float], message: str) -> None:
    with pytest.raises(AxisParametersError) as caught:
        AxisParameters(axis_id, values=values)
    assert message in str(caught.value)


def test_ids_are_unique() -> None:
    with pytest.raises(AxisParametersError, match="given twice"):
        Nc(1_000_000, [AxisParameters(1), AxisParameters(1)], compiled=False)


def test_the_cycle_takes_time() -> None:
    with pytest.raises(AxisParametersError, match="expected more than 0"):
        Nc(0, [])


def test_the_reference_velocity_follows_the_maximum() -> None:
    options = {"max_velocity": 100.0, "drive_reference_velocity": 500.0}
    nc = Nc(
        1_000_000,
        [AxisParameters(1, values={"max_velocity": 100.0}), AxisParameters(2, values=options)],
        compiled=False,
    )
    assert nc.axis(1).drive.reference_velocity == pytest.approx(110.0)
    assert nc.axis(2).drive.reference_velocity == 500.0


def test_an_nc_without_axes_cycles() -> None:
    nc = Nc(1_000_000, [])
    nc.cycle()
    assert nc.cycle_count == 1
    assert len(nc.digest()) == 16


def test_the_hash_sees_every_change(make_rig: Any) -> None:
    rig = make_rig(count=3)
    first = rig.nc.digest()
    assert rig.nc.digest() == first
    rig.nc.axis(3).profile.jerk[11] = 1e-300
    second = rig.nc.digest()
    assert second != first
    rig.run(1)
    assert rig.nc.digest() != second


def test_axes_are_independent(make_rig: Any) -> None:
    rig = make_rig(count=3)
    commands.start(rig.nc.axis(2), 1, 50.0, 100.0)
    rig.seconds(3.0)
    assert [axis.set_position for axis in rig.nc] == [0.0, 50.0, 0.0]


def test_two_runs_end_in_the_same_state(make_rig: Any) -> None:
    digests = []
    for _ in range(2):
        rig = make_rig(count=2)
        commands.start(rig.nc.axis(2), 1, 50.0, 100.0)
        rig.seconds(1.0)
        digests.append(rig.nc.digest())
    assert digests[0] == digests[1]


@pytest.mark.parametrize("compiled", [False, True])
def test_several_cycles_at_once_are_as_many_one_by_one(make_rig: Any, compiled: bool) -> None:
    digests = []
    for at_once in (1, 7):
        rig = make_rig(count=2, compiled=compiled)
        commands.start(rig.nc.axis(2), 1, 50.0, 100.0)
        for _ in range(21 // at_once):
            rig.nc.cycle(at_once)
        digests.append((rig.nc.cycle_count, rig.nc.digest()))
    assert digests[0] == digests[1]


class _Uncached(Kernel):
    """The kernel of this run, as if it was not in the cache until it is bound."""

    cached = False

    def bind(self, *arguments: float) -> Callable[..., Any]:
        self.cached = True
        return KERNEL.bind(*arguments)


def test_few_axes_take_machine_code_only_if_it_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.motion.nc.KERNEL", _Uncached("nc", cycles, KERNEL.layouts))
    few, many = [AxisParameters(1)], [AxisParameters(n) for n in range(1, 101)]
    assert Nc(2_000_000, few).compiled is False
    assert Nc(2_000_000, many).compiled is True
    assert Nc(2_000_000, few).compiled is True
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    monkeypatch.setattr("achse.motion.nc.KERNEL", Kernel("nc", cycles, KERNEL.layouts))
    assert Nc(2_000_000, many).compiled is False


def test_ids_are_as_configured() -> None:
    nc = Nc(
        2_000_000,
        [
            AxisParameters(5, encoder_ids=(7, 3, 200), drive_ids=(9,)),
            AxisParameters(2, controller_ids=(40, 41)),
        ],
        compiled=False,
    )
    assert [axis.axis_id for axis in nc] == [2, 5]
    assert nc.ids("encoder") == [2, 7, 3, 200]
    assert nc.ids("controller") == [40, 41, 5]
    assert nc.ids("drive") == [2, 9]
    assert nc.element("encoder", 7) is nc.axis(5).encoder
    assert nc.element("encoder", 200) is nc.axis(5).encoders[2]
    assert nc.element("encoder", 200).owner is nc.axis(5)
    assert [len(own) for own in nc.axis(5).parts().values()] == [3, 1, 1]
    with pytest.raises(KeyError):
        nc.element("drive", 7)


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ([{"encoder_ids": tuple(range(1, 11))}], "at most 9"),
        ([{"drive_ids": (0,)}], "of 1..255"),
        ([{"encoder_ids": (1, 1)}], "encoder id 1 is given twice"),
        ([{"elements": [{}]}], "1 elements described, there are 0"),
        ([{"encoder_ids": (1, 2), "elements": [{"max_velocity": 1.0}]}], "no parameter"),
        ([{"encoder_ids": (1, 2), "elements": [{"encoder_mask": 0}]}], "encoder_mask = 0"),
        ([{"values": {"encoder_history": 1.0}}], "no parameter"),
    ],
)
def test_elements_that_cannot_be(axes: list[dict[str, Any]], message: str) -> None:
    with pytest.raises(AxisParametersError, match=message):
        Nc(2_000_000, [AxisParameters(n, **axis) for n, axis in enumerate(axes, 1)], compiled=False)


def test_late_cycles_are_counted_and_cleared() -> None:
    nc = Nc(2_000_000, [AxisParameters(1)], compiled=False)
    nc.late_cycles = nc.late_io_cycles = 3
    nc.clear_cycle_time_errors()
    assert (nc.late_cycles, nc.late_io_cycles) == (0, 0)


@pytest.mark.parametrize("compiled", [False, True])
def test_persistent_data_survive_a_restart(compiled: bool) -> None:
    def nc(persistent: int) -> Nc:
        values = {
            "control_dword": 7,
            "velocity_override": 1_000_000,
            "persistent_data_enable": persistent,
        }
        return Nc(2_000_000, [AxisParameters(1, values=values)], compiled=compiled)

    before = nc(1)
    axis = before.axis(1)
    commands.set_homed_flag(axis, 1)
    commands.start(axis, 1, 70.0, 200.0)
    for _ in range(1500):
        before.cycle()
    for persistent in (0, 1):
        after = nc(persistent)
        after.inherit(before.retained_state())
        axis = after.axis(1)
        for _ in range(10):
            after.cycle()
        assert axis.actual_position == pytest.approx(70.0 * persistent, abs=1e-3)
        assert axis.set_position == pytest.approx(axis.actual_position, abs=1e-3)
        assert axis.homed == persistent
        # the machine stands where it stood: its cam, 50 mm below the first zero, lies 120 mm away
        assert axis.sensor.zero * axis.encoder.scaling_factor == pytest.approx(-70.0)
        assert commands.start(axis, 2, 5.0, 200.0) == 0
        for _ in range(500):
            after.cycle()
        assert axis.actual_position == pytest.approx(70.0 * persistent + 5.0, abs=1e-2)


def test_stored_velocities_are_at_most_that_of_the_axis_unless_given() -> None:
    values = {"max_velocity": 20.0, "jog_velocity_fast": 15.0, "rapid_traverse_velocity": 40.0}
    axis = Nc(1_000_000, [AxisParameters(1, values=values)], compiled=False).axis(1)
    stored = {name: getattr(axis, name) for name in STORED_VELOCITIES}
    assert stored == {
        "jog_velocity_slow": 20.0,
        "jog_velocity_fast": 15.0,
        "rapid_traverse_velocity": 40.0,
        "homing_velocity_towards_cam": 20.0,
        "homing_velocity_off_cam": 20.0,
    }
