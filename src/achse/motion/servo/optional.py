"""Optional parts of a CiA 402 drive, and the condition that keeps an axis from being ready.

Source: CiA 402-2 (bits of 6041h, optional objects); 001 §3.2 for the bits of the manual's drive.
"""

from dataclasses import dataclass, fields

from achse.motion.port import CONTROL_ENABLE, CONTROL_WISH
from achse.motion.servo.power import ENABLED, REACTION
from achse.motion.servo.record import Servo


@dataclass(frozen=True, slots=True)
class OptionalPart:
    """A bit of 6041h or an object that not every drive has.

    `key` names it in `[[drive]]`, with `default` as its value. `bit` is None for a whole object.
    """

    key: str
    index: int
    bit: int | None
    meaning: str
    without: str
    default: bool = True

    @property
    def mask(self) -> int:
        """The bit as a number; 0 for a whole object."""
        return 0 if self.bit is None else 1 << self.bit

    @property
    def place(self) -> str:
        """The object, with its bit."""
        where = f"{self.index:04X}h"
        return where if self.bit is None else f"bit {self.bit} of {where}"


VOLTAGE_BIT = OptionalPart(
    *("voltage_bit", 0x6041, 4, "main power is on"),
    "main power is not named as a missing condition; the manual's drive has the bit the other way",
    default=False,
)
REMOTE_BIT = OptionalPart(
    *("remote_bit", 0x6041, 9, "the drive obeys 6040h"),
    "local control is not named as a missing condition",
)
REACHED_BIT = OptionalPart(
    *("reached_bit", 0x6041, 10, "the target is reached"),
    "a homing by the drive is done when bit 12 is 1 and the motor is at standstill",
)
FOLLOWING_BIT = OptionalPart(
    *("following_bit", 0x6041, 12, "the drive follows its set values"),
    "an enabled drive is taken to follow (csp, csv, cst)",
)
MODE_DISPLAY = OptionalPart(
    *("mode_display", 0x6061, None, "the drive shows its mode of operation"),
    "a mode counts as active 50 ms after it was sent",
)
INTERPOLATION_TIME = OptionalPart(
    *("interpolation_time", 0x60C2, None, "the drive takes the cycle of its set values"),
    "the object is not written on the way to Op",
)

OPTIONAL_PARTS = (
    VOLTAGE_BIT,
    REMOTE_BIT,
    REACHED_BIT,
    FOLLOWING_BIT,
    MODE_DISPLAY,
    INTERPOLATION_TIME,
)
"""All that a drive may leave out."""


@dataclass(frozen=True, slots=True)
class DriveParts:
    """Optional parts that a drive has, by the keys of the table."""

    voltage_bit: bool = VOLTAGE_BIT.default
    remote_bit: bool = REMOTE_BIT.default
    reached_bit: bool = REACHED_BIT.default
    following_bit: bool = FOLLOWING_BIT.default
    mode_display: bool = MODE_DISPLAY.default
    interpolation_time: bool = INTERPOLATION_TIME.default

    @classmethod
    def of(cls, config: object) -> "DriveParts":
        """Return the parts that the attributes of a configuration name."""
        return cls(*(bool(getattr(config, each.name)) for each in fields(cls)))

    def has(self, part: OptionalPart) -> bool:
        """True if the drive has it."""
        return bool(getattr(self, part.key))


ALL_PARTS = DriveParts()
"""The parts of a drive whose table names none."""


_STATES = (
    "not ready to switch on",
    "switch on disabled",
    "ready to switch on",
    "switched on",
    "operation enabled",
    "quick stop active",
    "fault reaction active",
    "fault",
)
"""States of the power drive system by the numbers of `achse.motion.servo.power`."""


def missing_condition(servo: Servo, parts: DriveParts) -> str:
    """Return what keeps the drive of an axis from following, empty if nothing does.

    The data of the drive have to be valid.
    """
    if servo.following:
        return ""
    word = servo.statusword
    if servo.power != ENABLED:
        return _not_enabled(servo, parts)
    if servo.has_mode and servo.mode != servo.mode_display:
        return (
            f"its drive is enabled in another mode: expected {servo.mode} in 6061h, got"
            f" {servo.mode_display}; {_advice(MODE_DISPLAY)}"
        )
    if parts.following_bit and not word & FOLLOWING_BIT.mask:
        return (
            f"its drive is enabled, {FOLLOWING_BIT.place} is 0 ({FOLLOWING_BIT.meaning}):"
            f" 6041h is 0x{word:04X}; {_advice(FOLLOWING_BIT)}"
        )
    return ""


def _not_enabled(servo: Servo, parts: DriveParts) -> str:
    word = servo.statusword
    state = f'its drive is in "{_STATES[servo.power]}", 6041h is 0x{word:04X}'
    if servo.power >= REACTION:
        return f"{state}, 603Fh is 0x{servo.drive_alarm & 0xFFFF:04X}"
    if not servo.drive.ctrl1 & (CONTROL_ENABLE | CONTROL_WISH):
        return f"{state}: the axis requests no higher state"
    missing = [
        f"{each.place} is 0 ({each.meaning})"
        for each in (VOLTAGE_BIT, REMOTE_BIT)
        if parts.has(each) and not word & each.mask
    ]
    return f"{state}: {', '.join(missing)}" if missing else state


def _advice(part: OptionalPart) -> str:
    return f"a drive without it needs {part.key} = false in its [[drive]]"
