"""A coupled axis has no motion of its own."""

from typing import Any

from achse.codes.nc.choices import MotionPhase
from achse.motion.generators.coupled import step


def test_without_a_coupling_it_rests(rig: Any) -> None:
    rig.axis.set_motion_phase = MotionPhase.COUPLED
    step(rig.axis, 0.002)
    assert rig.axis.set_motion_phase == MotionPhase.NONE
    rig.axis.set_motion_phase, rig.axis.coupling.law = MotionPhase.COUPLED, 1
    step(rig.axis, 0.002)
    assert rig.axis.set_motion_phase == MotionPhase.COUPLED
