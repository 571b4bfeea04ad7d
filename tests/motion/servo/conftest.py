"""A bench of axes on virtual drives: their process data are copied, no bus is between."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from achse.codes import AlState, AlStatus
from achse.codes.nc.choices import DriveType, EncoderType
from achse.drive import Drive
from achse.drive.machine import Encoder, Mechanics, Switches
from achse.motion import Axis, AxisParameters, Nc
from achse.motion.servo import (
    INPUT_OBJECTS,
    OUTPUT_OBJECTS,
    ProcessEntry,
    ServoLink,
    ServoMode,
    ServoOptions,
    Servos,
)
from achse.motion.servo.optional import ALL_PARTS, DriveParts

OUTPUTS = (0x6040, 0x6060, 0x6071, 0x607A, 0x60B8, 0x60FF)
INPUTS = (0x6041, 0x6061, 0x6064, 0x6077, 0x60B9, 0x60BA, 0x60BB, 0x60FD)
FEED = 10.0
RESOLUTION = 131_072


def entries(objects: Sequence[int], known: Any, first: int) -> list[ProcessEntry]:
    result, at = [], first
    for index in objects:
        result.append(ProcessEntry(index, at, known[index].size))
        at += known[index].size
    return result


class Bench:
    """Axes on drives, all alike; `cycle_ns` is that of NC and drives."""

    def __init__(
        self,
        count: int = 1,
        *,
        mode: ServoMode = ServoMode.CSP,
        compiled: bool | None = None,
        cycle_ns: int = 2_000_000,
        resolution: int = RESOLUTION,
        feed: float = FEED,
        inverted: bool = False,
        switches: Switches | None = None,
        home_offset: int = 0,
        homing_method: int = 0,
        outputs: Sequence[int] = OUTPUTS,
        inputs: Sequence[int] = INPUTS,
        parts: DriveParts = ALL_PARTS,
        cleared: int = 0,
        **values: float,
    ) -> None:
        scaling = feed / resolution
        presets = {
            "encoder_type": EncoderType.MDP_513,
            "drive_type": DriveType.MDP_742,
            "encoder_scaling_factor": scaling,
            "encoder_count_direction": int(inverted),
            "drive_motor_polarity": int(inverted),
            "drive_acceleration_scaling": min(1.0 / scaling, 1e8),
            "simulation_ideal": int(mode is ServoMode.CSP),
            "homed_by_drive": int(homing_method != 0),
            "max_velocity": 40.0 * feed,
            "default_acceleration": 200.0 * feed,
            "default_deceleration": 200.0 * feed,
            "default_jerk": 2000.0 * feed,
            "control_dword": 7,
            "velocity_override": 1_000_000,
        }
        self.cycle_ns = cycle_ns
        self.nc = Nc(
            cycle_ns,
            [AxisParameters(n + 1, values=presets | values) for n in range(count)],
            compiled=compiled,
        )
        machine = Mechanics(encoder=Encoder(resolution=resolution), switches=switches or Switches())
        mapping = {
            0x1600: [index << 16 | 8 * OUTPUT_OBJECTS[index].size for index in outputs],
            0x1A00: [index << 16 | 8 * INPUT_OBJECTS[index].size for index in inputs],
        }
        self.drives = [Drive(machine, mapping=mapping) for _ in range(count)]
        self.up(self.drives)
        for drive in self.drives:
            drive.set(0x607C, home_offset)
            drive.set(0x6098, homing_method)
        weight = 1.0 / self.drives[0].record.acceleration_gain
        turn = math.tau * 0.03 / (cycle_ns * 1e-9)
        options = ServoOptions(
            mode,
            home_offset=home_offset,
            dead_time=None if mode is ServoMode.CSP else 2.5e-9 * cycle_ns,
            velocity_gain=weight * turn,
            velocity_reset_time=4.0 / turn,
            torque_per_acceleration=weight,
            parts=parts,
        )
        self.status_at = sum(INPUT_OBJECTS[index].size for index in inputs[: inputs.index(0x6041)])
        self.kept_bits = 0xFFFF & ~cleared
        """Bits of 6041h that the drives have."""
        read = sum(INPUT_OBJECTS[index].size for index in inputs)
        written = sum(OUTPUT_OBJECTS[index].size for index in outputs)
        self.read, self.written = read, written
        links = [
            ServoLink(
                n + 1,
                entries(inputs, INPUT_OBJECTS, n * read),
                entries(outputs, OUTPUT_OBJECTS, n * written),
                options,
            )
            for n in range(count)
        ]
        self.servos = Servos(self.nc, links, count * read, count * written)
        self.cut: set[int] = set()
        """Drives whose data do not come through."""
        self.absent = False
        """The bus says that it has not found them."""
        self.nc.connect(self._before, self._after)
        self._collect()

    @property
    def axis(self) -> Axis:
        return self.nc.axis(1)

    @property
    def drive(self) -> Drive:
        return self.drives[0]

    def up(self, drives: Sequence[Drive]) -> None:
        """Lead drives to Op."""
        for drive in drives:
            for state in (AlState.PREOP, AlState.SAFEOP, AlState.OP):
                if state > drive.state:
                    assert drive.enter(state, self.cycle_ns, AlStatus.NO_ERROR) is AlStatus.NO_ERROR

    def _collect(self) -> None:
        for n, drive in enumerate(self.drives):
            if n not in self.cut:
                data = bytearray(drive.read_inputs())
                word = int.from_bytes(data[self.status_at : self.status_at + 2], "little")
                data[self.status_at : self.status_at + 2] = (word & self.kept_bits).to_bytes(
                    2, "little"
                )
                self.servos.inputs[n * self.read : (n + 1) * self.read] = data

    def _before(self) -> None:
        for n, (servo, drive) in enumerate(zip(self.servos.servos, self.drives, strict=True)):
            valid = n not in self.cut and drive.state is AlState.OP
            self.servos.connect(servo, valid, self.absent and not valid)
        self.servos.take()

    def _after(self) -> None:
        self.servos.send()
        for n, drive in enumerate(self.drives):
            if n not in self.cut and drive.state is AlState.OP:
                drive.write_outputs(
                    bytes(self.servos.outputs[n * self.written : (n + 1) * self.written])
                )
        self._collect()
        for drive in self.drives:
            drive.step(self.cycle_ns)

    def run(self, seconds: float) -> None:
        self.nc.cycle(round(seconds * 1e9 / self.cycle_ns))

    def until(self, condition: Callable[[Axis], Any], seconds: float = 30.0) -> float:
        """Seconds until the condition holds; fails when it never does."""
        for cycle in range(1, round(seconds * 1e9 / self.cycle_ns) + 1):
            self.nc.cycle(1)
            if condition(self.axis):
                return cycle * self.cycle_ns * 1e-9
        raise AssertionError(f"not within {seconds} s: {self.axis!r}, {self.drive!r}")

    def ready(self) -> None:
        """Until all loops are closed."""
        self.until(lambda _: all(axis.loop_closed for axis in self.nc), 1.0)


@pytest.fixture(scope="session")
def make_bench() -> type[Bench]:
    return Bench
