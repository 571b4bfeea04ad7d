"""Cyclic image of each axis for its PLC, made by machine code for all linked axes in one call.

The image is the structure of TwinCAT 3, byte for byte (`achse.devices.nc.axes.structures.TO_PLC`,
from which the plain form comes; a test compares the two). A record has words of 64 bits, so values
of 32 and 16 bits share one. Machine code only: from Python, a call per value costs more than the
work.
"""

import sys
from collections.abc import Callable, Sequence
from math import floor, fmod
from typing import TYPE_CHECKING

from achse.motion.control.signals import probe_counts, probe_inputs, probe_status
from achse.motion.record import ENCODER, LAYOUT, AxisFields, EncoderFields
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out, reference
from achse.native.memory import Rows, RowView

if TYPE_CHECKING:
    from achse.motion.axis import Axis

IMAGE_BYTES = 256

_TWO_32 = 4294967296.0
_SAFE = 2.0**62
"""Below it a number without a fraction fits into a word; above, every number is one."""
_SIGN, _LOW, _COUNTS = 1 << 31, (1 << 32) - 1, (1 << 16) - 1


class CyclicImage:
    """The words of the structure, and behind them what they are made from."""

    state_and_error: int = 0
    motion_and_mode: int = 0
    homing_and_coupling: int = 0
    entries: int = 0
    id_and_mode: int = 0
    actual_position: float = 0.0
    actual_modulo: float = 0.0
    loops_and_turns: int = 0
    actual_velocity: float = 0.0
    following_error: float = 0.0
    set_position: float = 0.0
    set_velocity: float = 0.0
    set_acceleration: float = 0.0
    target_position: float = 0.0
    set_modulo: float = 0.0
    turns_and_command: int = 0
    set_jerk: float = 0.0
    set_torque: float = 0.0
    actual_torque: float = 0.0
    inputs: int = 0
    probes: int = 0
    cam_states: int = 0
    cam_tables: list[int] = [0] * 2
    actual_torque_rate: float = 0.0
    set_torque_rate: float = 0.0
    phasing: float = 0.0
    torque_offset: float = 0.0
    uncorrected: float = 0.0
    actual_acceleration: float = 0.0
    time_stamp: int = 0
    user_data: float = 0.0
    axis: AxisFields = reference(LAYOUT)
    cycle_ns: int = 0


IMAGE = lay_out("CyclicImage", [CyclicImage], Slot)


def _pair(low: int, high: int) -> int:
    """Two double words in one word; what is beyond 32 bits is cut, as counters wrap."""
    return (((high & _LOW) ^ _SIGN) - _SIGN) * (1 << 32) | low & _LOW


def _turns(position: float, period: float) -> float:
    """Periods below the position, without a fraction."""
    quotient = position / period
    return float(floor(quotient)) if abs(quotient) < _SAFE else quotient


def modulo_of(position: float, period: float) -> float:
    """Return the position within its period, as `achse.motion.readout.shown.modulo_place` has
    it."""
    part = position - _turns(position, period) * period
    return part if 0.0 <= part < period else 0.0


def modulo_turns_of(position: float, period: float) -> int:
    """Return the low bits of the number of that period."""
    turns = _turns(position, period)
    part = position - turns * period
    if not 0.0 <= part < period:
        turns = _turns(position / period + 0.5, 1.0)
    return int(fmod(turns, _TWO_32)) if abs(turns) < 1e308 else 0


def _user_data(ax: AxisFields) -> float:
    """Return the state that the axis's parameter chooses."""
    encoder = ax.encoder
    drive = ax.drive
    chosen = ax.user_data_state_offset
    if chosen == 0x1_0012:
        return encoder.actual_position_unfiltered - encoder.position_correction
    if chosen == 0x1_0014:
        scaling = drive.velocity_scaling
        return drive.io.data_in3 / (scaling if scaling != 0.0 else 1.0)
    if chosen == 0x1_0017:
        return encoder.set_position_offset
    return 0.0


def _show(image: CyclicImage, ax: AxisFields, encoder: EncoderFields) -> None:
    drive = ax.drive
    cycles = ax.set_cycle_counter
    loop = ax.active_control_loop & _COUNTS
    command = ax.set_command_number & _COUNTS | (ax.set_command_state & _COUNTS) << 16
    period = encoder.modulo_factor
    image.state_and_error = _pair(ax.state_dword, ax.error_code)
    image.motion_and_mode = _pair(ax.motion_state, ax.operation_mode_feedback)
    image.homing_and_coupling = _pair(ax.homing.state, ax.coupling_state)
    image.entries = _pair(0, ax.buffer.count)
    image.id_and_mode = _pair(ax.axis_id, ax.operation_mode_state_dword | (cycles & 0xFF) << 24)
    image.actual_position = encoder.actual_position
    image.actual_modulo = modulo_of(encoder.actual_position, period)
    image.loops_and_turns = _pair(
        loop | loop << 16, modulo_turns_of(encoder.actual_position, period)
    )
    image.actual_velocity = encoder.actual_velocity
    image.following_error = ax.controller.following_error
    image.set_position = ax.set.position
    image.set_velocity = ax.set.velocity
    image.set_acceleration = ax.set.acceleration
    image.target_position = ax.target_position
    image.set_modulo = modulo_of(ax.set.position, period)
    image.turns_and_command = _pair(modulo_turns_of(ax.set.position, period), command)
    image.set_jerk = ax.set.jerk
    image.set_torque = ax.set_torque
    image.actual_torque = drive.actual_torque
    image.inputs = _pair(0, probe_inputs(ax))
    image.probes = _pair(probe_status(encoder), probe_counts(encoder))
    image.actual_torque_rate = drive.actual_torque_derivative
    image.set_torque_rate = ax.set_torque_derivative
    image.phasing = ax.phasing.position
    image.torque_offset = ax.set_torque_offset
    image.uncorrected = encoder.actual_position - encoder.position_correction
    image.actual_acceleration = encoder.actual_acceleration
    image.time_stamp = (cycles & _LOW) * image.cycle_ns & _LOW
    image.user_data = _user_data(ax)


def show_axes(images: Sequence[CyclicImage]) -> None:
    """Make the images of all axes."""
    for n in range(len(images)):
        ax = images[n].axis
        _show(images[n], ax, ax.encoder)


KERNEL = Kernel(
    "cyclic-images", show_axes, {CyclicImage: IMAGE, AxisFields: LAYOUT, EncoderFields: ENCODER}
)
"""Called with address and number of the images."""


class AxisImages:
    """Images of these axes (`images_of` each is true); the same axis may be there twice.

    `views[n]` is the image of axis n as of the last `show()`, 256 bytes.
    """

    def __init__(self, axes: "Sequence[Axis]") -> None:
        rows = Rows(IMAGE, len(axes))
        self._axes = tuple(axes)  # whose memory must stay
        self.views: list[memoryview] = []
        for n, axis in enumerate(axes):
            if not isinstance(axis, RowView):
                raise TypeError(f"axis {axis.name}: its record is not in memory")
            image = RowView(rows, n)
            image.refer(IMAGE.fields["axis"], axis)
            image.ints[IMAGE.fields["cycle_ns"].offset] = axis.cycle_ns
            self.views.append(image.row[:IMAGE_BYTES])
        self.show: Callable[[], object] = KERNEL.bind(rows.address, len(axes))
        """Make all images again."""


def images_of(axis: "Axis") -> bool:
    """Return True if machine code can make the image of the axis: its record is in memory."""
    return isinstance(axis, RowView) and sys.byteorder == "little" and KERNEL.available
