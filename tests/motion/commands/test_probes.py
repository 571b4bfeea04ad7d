"""Touch probe commands: units, forms and refusals."""

from math import inf, nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StateBit, commands


@pytest.mark.parametrize(
    "arguments",
    [(0, 0, 1, 1), (5, 0, 1, 1), (1, 2, 1, 1), (1, 0, 0, 1), (1, 0, 3, 1), (1, 0, 1, 5),
     (1, 0, 1, 127), (1, 0, 1, 130)],
)  # fmt: skip
def test_what_is_no_touch_probe(rig: Any, arguments: tuple[int, ...]) -> None:
    rig.refuses(NcError.REQUEST_PARAMETER, commands.activate_touch_probe, *arguments)


def test_an_edge_can_be_waited_for_once_at_a_time(rig: Any) -> None:
    axis = rig.axis
    assert commands.activate_touch_probe(axis, 1, 0, 1, 1) == 0
    rig.refuses(NcError.ENCODER_FUNCTION_ACTIVE, commands.activate_touch_probe, 1, 0, 2, 128)
    assert commands.activate_touch_probe(axis, 1, 1, 1, 1) == 0
    assert commands.activate_touch_probe(axis, 2, 0, 1, 2) == 0
    assert commands.deactivate_touch_probe(axis, 1, 0) == 0
    assert list(axis.encoder.probe_active) == [0, 1, 0, 0, 1, 0, 0, 0]
    assert axis.encoder.latch_active == 1
    assert commands.activate_touch_probe(axis, 1, 0, 2, 0) == 0
    rig.refuses(NcError.REQUEST_PARAMETER, commands.deactivate_touch_probe, 1, 2)


def test_source_0_is_the_input_of_the_probe(rig: Any) -> None:
    commands.activate_touch_probe(rig.axis, 3, 0, 1, 0)
    rig.run(1)
    rig.axis.simulation_drive_inputs = 0b100
    rig.run(1)
    assert rig.axis.encoder.probe_valid[2] == 1


@pytest.mark.parametrize(("falling", "offset"), [(False, 0), (True, 4)])
def test_latches_one_and_four(rig: Any, falling: bool, offset: int) -> None:
    axis = rig.axis
    assert commands.activate_latch(axis, falling=falling) == 0
    assert [i for i, active in enumerate(axis.encoder.probe_active) if active] == [offset]
    rig.refuses(
        NcError.ENCODER_FUNCTION_ACTIVE,
        lambda axis: commands.activate_latch(axis, 1, 1, 1, 1, falling=falling),
    )
    assert commands.activate_latch(axis, 0, 1, 0, 1, falling=falling) == 0
    active = [i for i, flag in enumerate(axis.encoder.probe_active) if flag]
    assert active == [offset, offset + 1, offset + 3]
    commands.deactivate_latch(axis)
    commands.deactivate_latch(axis, 0, 0, 0, 1)
    assert [i for i, flag in enumerate(axis.encoder.probe_active) if flag] == [offset + 1]
    commands.deactivate_latch(axis, 1, 1, 1, 1)
    assert axis.encoder.latch_active == 0


def test_a_latch_event_by_command(rig: Any) -> None:
    axis = rig.axis
    rig.refuses(NcError.ENCODER_EXTERNAL_LATCH, commands.set_latch_event, 1.0)
    commands.set_actual_position(axis, 1, 50.0)
    commands.activate_latch(axis, falling=False)
    for wrong in (nan, -inf, 1e300):
        rig.refuses(NcError.REQUEST_PARAMETER, commands.set_latch_event, wrong)
    assert commands.set_latch_event(axis, 62.5) == 0
    rig.run(1)
    assert rig.has(StateBit.EXTERNAL_LATCH_VALID)
    assert (axis.encoder.probe_active[0], axis.encoder.probe_position[0]) == (0, 62.5)
    assert axis.encoder.latch_position == 62.5
    assert axis.encoder.latch_software_increments == 125_000
    commands.deactivate_latch(axis)
    rig.run(1)
    assert not rig.has(StateBit.EXTERNAL_LATCH_VALID)
    assert axis.encoder.latch_position == 62.5


def test_no_events_for_real_encoders(make_rig: Any) -> None:
    rig = make_rig(encoder_type=19)
    commands.activate_latch(rig.axis, falling=False)
    rig.refuses(NcError.ENCODER_FUNCTION_NOT_SUPPORTED, commands.set_latch_event, 1.0)
