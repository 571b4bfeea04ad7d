"""A camshaft controller: its records, its parameters and its process image."""

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from achse.camshaft.image import INPUTS, OUTPUTS, CamInput, CamOutput
from achse.camshaft.kernel import KERNEL
from achse.camshaft.parameters import (
    CAM_PARAMETERS,
    CAM_SET,
    CAMS,
    CONTROLLER_PARAMETERS,
    CONTROLLER_SET,
    COUNTERS,
    ENCODER_PARAMETERS,
    ENCODER_SET,
    CamParameter,
    CamType,
)
from achse.camshaft.record import CAM, CONTROLLER, LONGEST_WINDOW
from achse.native.declare import RecordLayout, pack, plain_record
from achse.native.memory import Rows, RowView, field_property


class CamEncoder(NamedTuple):
    """Parameters of a controller's encoder."""

    increments: float = 4096.0
    """Of a turn of the shaft, above 0."""
    span: float = 0.0
    """After so many increments it begins again at 0, as a single-turn encoder; 0: it does not."""
    largest_step: float = 0.0
    """More increments in a cycle are an encoder error; 0: half a turn."""
    window_ns: int = 10_000_000
    """Over which the speed is measured: 1 to 64 cycles."""


def _view(layout: RecordLayout[Any]) -> type[RowView]:
    fields = {name: field_property(slot) for name, slot in layout.fields.items()}
    return type("CamRecord", (RowView,), fields)


_ControllerView, _CamView = _view(CONTROLLER), _view(CAM)

_RESETS = {"encoder_error": "", "shaft_error": "still_ns", "rate_error": "deviating_ns"}
"""Flags that a write resets, and the time that begins again with it."""

_OF_A_CAM = {each.name: each for each in CAM_PARAMETERS}

_INPUT_LIMIT = 1 << 53
"""Increments beyond which positions are not exact."""


class CamController:
    """A controller of up to 128 cams; `cycle` does what is due every `cycle_ns`.

    `compiled`: machine code, which needs llvmlite; what it does is the same. `and_mask_linked`:
    whether an AND mask of 0 in the process image counts, or means that no program sets it.
    """

    def __init__(
        self,
        number: int = 1,
        *,
        cycle_ns: int = 1_000_000,
        encoder: CamEncoder | None = None,
        and_mask_linked: bool = False,
        compiled: bool = False,
    ) -> None:
        encoder = encoder or CamEncoder()
        if cycle_ns <= 0 or not 0 < encoder.increments < _INPUT_LIMIT:
            raise ValueError(f"cycle of {cycle_ns} ns, {encoder.increments} increments a turn")
        self.number = number
        self.compiled = compiled
        self.record: Any
        """The controller's fields (`CamControllerFields`)."""
        self.cams: Sequence[Any]
        """Cam number n is at n - 1 (`CamStateFields`)."""
        self._run: Callable[[], int]
        if compiled:
            rows, cams = Rows(CONTROLLER, 1), Rows(CAM, CAMS)
            self.record = _ControllerView(rows, 0)
            self.cams = [_CamView(cams, n) for n in range(CAMS)]
            for layout, records in ((CONTROLLER, [self.record]), (CAM, self.cams)):
                fresh = layout.form.pack(*_defaults(layout))
                for record in records:
                    record.row[:] = fresh
            self._memory = rows, cams
            self._run = KERNEL.bind(rows.address, 1, cams.address, CAMS)
        else:
            self.record = plain_record(CONTROLLER)()
            self.cams = [plain_record(CAM)() for _ in range(CAMS)]
            self._used: list[Any] = []
            self._run = partial(KERNEL.plain, [self.record], self._used)
        record = self.record
        record.cycle_ns = cycle_ns
        record.increments = float(encoder.increments)
        record.span = float(encoder.span)
        record.largest_step = float(encoder.largest_step or encoder.increments / 2)
        record.window = min(max(round(encoder.window_ns / cycle_ns), 1), LONGEST_WINDOW)
        record.and_mask_linked = int(and_mask_linked)

    # the cycle -----------------------------------------------------------------------------------

    def take_position(self, position: float | None) -> None:
        """Apply the encoder's position in increments; None or infinity is an encoder error."""
        if position is None or not math.isfinite(position) or abs(position) > _INPUT_LIMIT:
            self.record.valid = 0
            return
        self.record.valid = 1
        self.record.position = float(position)

    def cycle(self) -> int:
        """Calculate; the bits of the tracks."""
        return self._run()

    @property
    def works(self) -> bool:
        """True if anything depends on its cycles: a cam has a type, or something is monitored."""
        record = self.record
        return bool(
            self.configured_cams
            or record.encoder_monitoring
            or record.shaft_monitoring
            or record.rate_monitoring
            or any(record.inputs)
        )

    @property
    def configured_cams(self) -> int:
        """Number of cams that have a type."""
        return sum(cam.type != CamType.NONE for cam in self.cams)

    def digest(self) -> bytes:
        """Return a hash of all its state, the same with and without machine code."""
        digest = hashlib.sha256(pack(CONTROLLER, self.record))
        for cam in self.cams:
            digest.update(pack(CAM, cam))
        return digest.digest()

    # parameters ----------------------------------------------------------------------------------

    def value(self, parameter: CamParameter) -> int:
        """Return a parameter of the controller or of its encoder."""
        name = parameter.name
        if name == "configured_cams":
            return self.configured_cams
        if name.startswith("counter_"):
            return int(self.record.counters[int(name[-1]) - 1])
        return int(getattr(self.record, name))

    def set_value(self, parameter: CamParameter, value: int) -> None:
        """Set one; writing an error flag resets it. Raises CamParameterError."""
        name = parameter.name
        parameter.check(value)
        if name in _RESETS:
            setattr(self.record, name, 0)
            if _RESETS[name]:
                setattr(self.record, _RESETS[name], 0)
        elif name.startswith("counter_"):
            self.record.counters[int(name[-1]) - 1] = value
        elif name != "configured_cams":
            setattr(self.record, name, value)

    def set_cam(self, number: int, values: Mapping[str, int]) -> None:
        """Set parameters of cam 1..128 by name. Raises CamParameterError, KeyError."""
        checked = {name: _OF_A_CAM[name].check(value) for name, value in values.items()}
        cam = self.cams[number - 1]
        if "type" in checked and checked["type"] != cam.type:
            self._forget(cam)
        for name, value in checked.items():
            if name != "brake_enabled":
                setattr(cam, name, value)
        if "type" in checked and not self.compiled:
            # the plain kernel sees those that do something, in their order
            self._used[:] = [each for each in self.cams if each.type != CamType.NONE]

    def _forget(self, cam: Any) -> None:
        """Clear the state that another type of the cam left."""
        for name in ("known", "stroke", "latched", "remaining_ns", "on", "brake_enabled"):
            setattr(cam, name, 0)

    # complete sets -------------------------------------------------------------------------------

    def encoder_set(self) -> bytes:
        """Return the encoder's set."""
        return ENCODER_SET.encode({each.name: self.value(each) for each in ENCODER_PARAMETERS})

    def write_encoder_set(self, data: bytes) -> None:
        """Take the encoder's set. Raises CamParameterError; nothing is set then."""
        values = ENCODER_SET.decode(data)
        for each in ENCODER_PARAMETERS:
            self.set_value(each, values[each.name])

    def controller_set(self) -> bytes:
        """Return the controller's set."""
        values = {each.name: self.value(each) for each in CONTROLLER_PARAMETERS}
        return CONTROLLER_SET.encode(values)

    def write_controller_set(self, data: bytes) -> None:
        """Take the controller's set: error flags are reset. Raises CamParameterError."""
        values = CONTROLLER_SET.decode(data)
        for each in CONTROLLER_PARAMETERS:
            if each.name in values:
                self.set_value(each, values[each.name])

    def cam_set(self, number: int) -> bytes:
        cam = self.cams[number - 1]
        return CAM_SET.encode({each.name: getattr(cam, each.name) for each in CAM_PARAMETERS})

    def write_cam_set(self, number: int, data: bytes) -> None:
        """Take the set of a cam, with its type. Raises CamParameterError; nothing is set then."""
        self.set_cam(number, CAM_SET.decode(data))

    # process image -------------------------------------------------------------------------------

    def inputs(self) -> bytes:
        """Return the words of `CamInput`."""
        return INPUTS.pack(*self.record.inputs)

    def write_inputs(self, offset: int, data: bytes) -> None:
        """Write bytes of the inputs. Raises ValueError outside."""
        if offset < 0 or offset + len(data) > INPUTS.size:
            raise ValueError(f"{len(data)} bytes from 0x{offset:X}, expected 0..{INPUTS.size}")
        image = bytearray(self.inputs())
        image[offset : offset + len(data)] = data
        inputs = self.record.inputs
        for n, word in enumerate(INPUTS.unpack(image)):
            inputs[n] = word

    def set_input(self, word: CamInput, value: int) -> None:
        """Set one word, 0..0xFFFFFFFF; of others the low bits."""
        self.record.inputs[word] = value & 0xFFFF_FFFF

    def outputs(self) -> bytes:
        """Return the words of `CamOutput`."""
        return OUTPUTS.pack(*self.output_words())

    def output_words(self) -> list[int]:
        """Return the outputs, in the order of `CamOutput`."""
        record = self.record
        words = [0] * len(CamOutput)
        words[CamOutput.RAW] = record.raw
        words[CamOutput.ANGLE] = int(record.angle)
        words[CamOutput.ACTUAL_RATE] = record.actual_rate
        words[CamOutput.CONFIGURED_CAMS] = self.configured_cams
        words[CamOutput.IO_ERRORS] = record.io_errors
        words[CamOutput.ENCODER_ERROR] = record.encoder_error
        words[CamOutput.SHAFT_ERROR] = record.shaft_error
        words[CamOutput.RATE_ERROR] = record.rate_error
        words[CamOutput.COUNTER_1 : CamOutput.COUNTER_1 + COUNTERS] = list(record.counters)
        words[CamOutput.CAMS] = record.outputs
        return words


def _defaults(layout: RecordLayout[Any]) -> list[float]:
    values: list[float] = []
    for slot in layout.fields.values():
        values += [slot.default] * (slot.length or 1)
    return values
