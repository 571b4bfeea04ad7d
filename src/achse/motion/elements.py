"""Control loops: which of its encoders, controllers and drives an axis works with."""

from achse.motion.axis import Axis
from achse.motion.features import TRANSIENT
from achse.motion.kernel import adapt


def control_loop_count(axis: Axis) -> int:
    """Loops of the axis: as many as the part has that it has most of."""
    return max(map(len, axis.parts().values()))


def choose_control_loop(axis: Axis, loop: int) -> None:
    """Work with encoder, controller and drive number `loop` from now on; as many as there are.

    Parts of which there are fewer stay. Where the axis is then is what its new encoder says; the
    set position is left to the caller. IndexError if there is no such loop.
    """
    if not 0 <= loop < control_loop_count(axis):
        raise IndexError(f"control loop {loop}, expected 0..{control_loop_count(axis) - 1}")
    axis.active_control_loop = loop
    present = {"encoder": axis.encoder, "controller": axis.controller, "drive": axis.drive}
    others = {part: own[loop] for part, own in axis.parts().items() if loop < len(own)}
    if present | others == present:
        return
    axis.encoder.in_use = axis.drive.io.ctrl1 = 0
    for part, other in others.items():
        axis.link(part, other)
    axis.encoder.in_use = 1
    axis.machine.driver = axis.drive.amplifier.number
    adapt(axis, axis.cycle_ns * 1e-9)
    axis.features |= TRANSIENT  # the other parts have their own
    axis.wake(adapts=True)
