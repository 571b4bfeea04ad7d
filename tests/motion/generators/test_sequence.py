"""What sequences have in common."""

from typing import Any

import pytest

from achse.motion import CommandState, MotionPhase, commands
from achse.motion.generators.sequence import finish, override_share


@pytest.mark.parametrize(("override", "share"), [(0, 0.0), (250_000, 0.25), (2_000_000, 1.0)])
def test_the_override_is_a_share_of_one_at_most(rig: Any, override: int, share: float) -> None:
    rig.axis.velocity_override = override
    assert override_share(rig.axis) == share
    assert rig.axis.profile.override == override


@pytest.mark.parametrize("velocity", [0.0, 1e-7, -20.0])
def test_a_sequence_that_ends_in_motion_brakes(rig: Any, velocity: float) -> None:
    assert commands.start_velocity_steps(rig.axis, 1, 50.0, -50.0, 1.0, 0.0, 1) == 0
    rig.run(5)
    rig.axis.set_velocity = velocity
    finish(rig.axis)
    assert rig.axis.set_command_state == CommandState.DONE
    moves = abs(velocity) > 1e-6
    assert rig.axis.set_motion_phase == (MotionPhase.STOPPING if moves else MotionPhase.NONE)
    rig.until_rest()
    assert rig.axis.set_velocity == 0.0
