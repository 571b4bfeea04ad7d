"""Groups and masters: what a single axis answers."""

from typing import Any

from achse.codes import NcError
from achse.motion import StateBit, commands


def test_a_single_axis_is_in_its_own_group(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(1.0)
    assert commands.return_to_ptp_group(rig.axis) == 0
    rig.run(1)
    assert rig.has(StateBit.PTP_MODE)
    assert rig.axis.set_velocity == 100.0


def test_only_a_slave_can_be_uncoupled(rig: Any) -> None:
    rig.refuses(NcError.DECOUPLING_NOT_POSSIBLE, commands.decouple_and_start, 1, 10.0, 100.0)
