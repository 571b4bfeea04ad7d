"""Parameters of encoder, controller and cams: offsets, sizes, ranges (000 §5.5.2).

Decision 0048 has the choices that the manual leaves open: numbers of the encoder are INT32, and
the complete sets have the layouts of `CAM_SET`, `CONTROLLER_SET` and `ENCODER_SET`.
"""

import struct
from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import NamedTuple

CAMS = 128
"""Cams of a controller, numbered from 1."""
TRACKS = 32
COUNTERS = 5
HIGHEST_RATE = 2000
"""Strokes per minute that can be set; more is measured, if it turns so fast."""

_DWORD = 0xFFFF_FFFF
_LONG = 65_535


class CamType(IntEnum):
    """Kinds of cams. The range of the row ends at 3, its text at 4: the text counts."""

    NONE = 0
    WAY = 1
    """On between two angles."""
    TIME = 2
    """On for a time from an angle on."""
    BRAKE = 3
    """On from an angle on, as long as the brake is enabled."""
    MULTI_CYCLE = 4
    """As WAY, in some of the strokes."""


class CamParameter(NamedTuple):
    """A value: `code` is its `struct` letter, `least` … `most` what may be written."""

    name: str
    offset: int
    code: str
    least: int
    most: int
    unit: str
    text: str
    writable: bool = True

    def check(self, value: int) -> int:
        """Return the value, if it is one. Raises CamParameterError."""
        if not self.least <= value <= self.most:
            raise CamParameterError(
                f"{self.name} = {value}, expected {self.least}..{self.most} {self.unit}".rstrip()
            )
        return value


class CamParameterError(ValueError):
    """A value is outside its range."""


_P = CamParameter

ENCODER_PARAMETERS: Sequence[CamParameter] = (
    _P("zero_point", 0x201, "i", -3599, 3599, "0.1 degree", "Zero point compensation"),
    _P("position_offset", 0x202, "i", -3599, 3599, "0.1 degree", "Dynamic position offset"),
    _P("box_address", 0x210, "B", 1, 2, "", "Box address of the encoder; without effect"),
)

CONTROLLER_PARAMETERS: Sequence[CamParameter] = (
    _P("configured_cams", 0x1, "I", 0, CAMS, "", "Number of cams that have a type", False),
    _P("active", 0x2, "B", 0, 1, "", "Calculation of cams on"),
    _P("reversed", 0x10, "B", 0, 1, "", "Direction of rotation reversed"),
    _P("encoder_monitoring", 0x11, "B", 0, 1, "", "Monitoring of the encoder on"),
    _P("shaft_monitoring", 0x12, "B", 0, 1, "", "Monitoring of shaft breaks on"),
    _P("rate_monitoring", 0x13, "B", 0, 1, "", "Monitoring of the stroke rate on"),
    _P("coupled", 0x14, "B", 0, 1, "", "State of the coupling: engaged"),
    _P("encoder_error", 0x20, "B", 0, 1, "", "Encoder error; a write resets it"),
    _P("shaft_error", 0x21, "B", 0, 1, "", "Shaft break; a write resets it"),
    _P("rate_error", 0x22, "B", 0, 1, "", "Rotation error; a write resets it"),
    _P(
        "rate_tolerance",
        0x31,
        "I",
        0,
        HIGHEST_RATE,
        "1/min",
        "Deviation of the rate that is tolerated",
    ),
    _P("rate_time", 0x32, "I", 0, _LONG, "ms", "How long it is tolerated"),
    # R/W in the manual: a write is taken, the next calculation replaces it
    _P("actual_rate", 0x33, "I", 0, HIGHEST_RATE, "1/min", "Actual stroke rate"),
    _P("set_rate", 0x34, "I", 0, HIGHEST_RATE, "1/min", "Set stroke rate"),
    _P("shaft_time", 0x35, "I", 0, _LONG, "ms", "Standstill until a shaft break is an error"),
    _P("or_mask", 0x100, "I", 0, _DWORD, "", "A 1 forces the track on"),
    _P("and_mask", 0x101, "I", 0, _DWORD, "", "A 0 forces the track off"),
    *(
        _P(f"counter_{n}", 0x300 + n, "I", 0, _DWORD, "", f"Value of counter {n}")
        for n in range(1, COUNTERS + 1)
    ),
)

CAM_PARAMETERS: Sequence[CamParameter] = (
    _P("type", 0x1, "B", 0, max(CamType), "", "Type of the cam; set by the complete set", False),
    _P("start", 0x2, "I", 0, 359, "degree", "First angle that is on"),
    _P("end", 0x3, "I", 0, 359, "degree", "First angle that is off again"),
    _P("track", 0x4, "I", 0, TRACKS - 1, "", "Track: the output's bit"),
    _P("dead_time", 0x5, "I", 0, _LONG, "0.1 ms", "How much earlier a dynamic cam acts"),
    _P("count", 0x6, "I", 1, _LONG, "", "Acts in every n-th stroke; multi-cycle: strokes off"),
    _P(
        "hysteresis", 0x7, "I", 0, 8192, "increments", "A way back up to this is not yet a reversal"
    ),
    _P("duration", 0x8, "I", 1, _LONG, "0.1 ms", "Duration of a time cam"),
    _P("end_value", 0x9, "I", 0, _LONG, "0.1 ms", "Brake cam: time after the end of the enable"),
    _P("forward", 0x10, "B", 0, 1, "", "Acts in forward direction"),
    _P("backward", 0x11, "B", 0, 1, "", "Acts in backward direction"),
    _P("dynamic", 0x12, "B", 0, 1, "", "Acts earlier by the dead time"),
    _P("load", 0x13, "B", 0, 1, "", "Begins to count strokes again; 0 when that is done"),
    _P("hysteresis_on", 0x14, "B", 0, 1, "", "Hysteresis on"),
    _P("brake_enabled", 0x15, "B", 0, 1, "", "State of the external brake enable", False),
    _P("force", 0x16, "B", 0, 1, "", "Brake cam: on, whatever the angle"),
    _P("cycles_on", 0x17, "I", 2, _LONG, "", "Multi-cycle cam: strokes on"),
)


class CamSet:
    """A complete set: values one behind the other. Values that only show are not taken."""

    def __init__(
        self,
        parameters: Sequence[CamParameter],
        order: Sequence[str],
        pad: int = 0,
        also: str = "",
        shown: str = "",
    ) -> None:
        """Arrange parameters by `order`, with `pad` unused bytes at the end; `also` is set too,
        though its own row does not, `shown` is not, though its own row does."""
        by_name = {each.name: each for each in parameters}
        self.parameters = tuple(by_name[name] for name in order)
        self._writable_names = {each.name for each in parameters if each.writable} - {shown} | {
            also
        }
        self.form = struct.Struct("<" + "".join(each.code for each in self.parameters) + f"{pad}x")

    @property
    def size(self) -> int:
        """Bytes."""
        return self.form.size

    def encode(self, values: Mapping[str, int]) -> bytes:
        """Return the bytes of values by name."""
        return self.form.pack(*(values[each.name] for each in self.parameters))

    def decode(self, data: bytes) -> dict[str, int]:
        """Return the values to be set, all within their ranges.

        Raises CamParameterError; `struct.error` unless there are `size` bytes.
        """
        return {
            each.name: each.check(value)
            for each, value in zip(self.parameters, self.form.unpack(data), strict=True)
            if each.name in self._writable_names
        }


ENCODER_SET = CamSet(ENCODER_PARAMETERS, [each.name for each in ENCODER_PARAMETERS], 3)
CONTROLLER_SET = CamSet(
    CONTROLLER_PARAMETERS,
    [each.name for each in CONTROLLER_PARAMETERS],
    shown="actual_rate",  # it may be above what can be set
)
CAM_SET = CamSet(
    CAM_PARAMETERS,
    (
        *("type", "forward", "backward", "dynamic", "load", "hysteresis_on"),
        *("brake_enabled", "force", "start", "end", "track", "dead_time", "count"),
        *("hysteresis", "duration", "end_value", "cycles_on"),
    ),
    also="type",
)
