"""[[camshaft]] in a station.toml: camshaft controllers, their encoders, cams and variables."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from achse.camshaft import CamEncoder, CamInput, CamOutput, CamType
from achse.camshaft.parameters import CAM_PARAMETERS, CAMS, CONTROLLER_PARAMETERS
from achse.iec.nearest import did_you_mean
from achse.station.configuration.types import ConfigTable, DeviceName, DurationNs

_ENCODER = CamEncoder()
_PARTS = {"encoder", "inputs", "outputs", "tracks", *(f"cam{n}" for n in range(1, CAMS + 1))}
"""First parts of the other symbols of a controller."""

_Tenths = Annotated[int, Field(ge=-3599, le=3599)]
_Milliseconds = Annotated[int, Field(ge=0, le=65_535)]
_TenthMs = Annotated[int, Field(ge=0, le=65_535)]
_Rate = Annotated[int, Field(ge=0, le=2000)]
_Mask = Annotated[int, Field(ge=0, le=0xFFFF_FFFF)]
_Degrees = Annotated[int, Field(ge=0, le=359)]


class CamConfig(ConfigTable):
    """[[camshaft.cam]]: a cam, with the numbers of the services (000 §5.5.2.3)."""

    number: int | None = Field(default=None, ge=1, le=CAMS)
    """1..128; the next one unless given."""
    name: DeviceName = ""
    """Its symbols are `<camshaft>.<name>.…` too."""
    type: Literal["way", "time", "brake", "multi_cycle"]
    start: _Degrees = 0
    """Angle at which it goes on, degrees."""
    end: _Degrees = 0
    """Way and multi-cycle cams: angle at which it goes off, degrees."""
    track: int = Field(default=0, ge=0, le=31)
    """The bit of the outputs."""
    dynamic: bool = False
    """True if the cam acts earlier by `dead_time`."""
    dead_time: _TenthMs = 0
    """0.1 ms."""
    count: int = Field(default=1, ge=1, le=65_535)
    """Acts in every n-th stroke; a multi-cycle cam: strokes in which it is off."""
    cycles_on: int = Field(default=2, ge=2, le=65_535)
    """A multi-cycle cam: strokes in which it is on."""
    duration: int = Field(default=1, ge=1, le=65_535)
    """A time cam: 0.1 ms."""
    end_value: _TenthMs = 0
    """A brake cam: 0.1 ms from the end of the enable on."""
    forward: bool = True
    backward: bool = True
    """Directions in which it acts."""
    hysteresis: int = Field(default=0, ge=0, le=8192)
    """Increments of the encoder; 0: none."""

    def values(self) -> dict[str, int]:
        """Return the cam's parameters."""
        known = {each.name for each in CAM_PARAMETERS} - {"type"}
        values = {name: int(getattr(self, name)) for name in known & set(type(self).model_fields)}
        return values | {
            "type": int(CamType[self.type.upper()]),
            "hysteresis_on": int(self.hysteresis > 0),
        }


class CamshaftConfig(ConfigTable):
    """[[camshaft]]: a controller, at most four. Its angle comes from `axis`, from the variable
    `encoder`, or from the input word `encoder` of its process image."""

    name: DeviceName = ""
    """Prefix of its symbols; `Camshaft 1` and so on unless given."""
    cycle: DurationNs | None = None
    """Cycle time of its calculation; the NC's cycle with `axis`, else 1 ms, unless given."""
    axis: str | None = None
    """Name of the NC axis that turns the shaft."""
    units_per_turn: FiniteFloat | None = Field(default=None, gt=0)
    """Of the axis; the modulo factor of its encoder unless given."""
    encoder: str | None = None
    """A variable of the PLC with the position in increments."""
    plc: int | None = Field(default=None, ge=1, le=65535)
    """AMS port of the PLC of all variables; the first one unless given."""
    increments: FiniteFloat = Field(default=_ENCODER.increments, gt=0, le=1e12)
    """Increments of the encoder in a turn."""
    encoder_range: FiniteFloat = Field(default=0.0, ge=0, le=1e12)
    """After so many increments the encoder begins again at 0: a single-turn encoder has
    `increments`; 0 for one that does not."""
    largest_step: FiniteFloat = Field(default=0.0, ge=0, le=1e12)
    """More increments in a cycle are an encoder error; 0 for half a turn."""
    speed_window: DurationNs = _ENCODER.window_ns
    """Over which the speed is measured, 1 to 64 cycles: longer is smoother and later."""
    zero_point: _Tenths = 0
    position_offset: _Tenths = 0
    """0.1 degree, added to the angle."""
    active: bool = True
    reversed: bool = False
    coupled: bool = False
    encoder_monitoring: bool = False
    shaft_monitoring: bool = False
    rate_monitoring: bool = False
    set_rate: _Rate = 0
    rate_tolerance: _Rate = 0
    """Strokes per minute."""
    rate_time: _Milliseconds = 0
    shaft_time: _Milliseconds = 0
    """Milliseconds."""
    or_mask: _Mask = 0
    and_mask: _Mask = 0xFFFF_FFFF
    and_mask_input: bool = False
    """True if an AND mask of 0 in the process image switches all tracks off; it does if `input` or
    `input_image` sets it."""
    input: Mapping[str, str] = {}
    """Words of the process image that PLC variables set: word = "variable"."""
    output: Mapping[str, str] = {}
    """Words of the process image that go to PLC variables."""
    input_image: str | None = None
    """A PLC variable of 72 bytes with all inputs."""
    output_image: str | None = None
    """A PLC variable of 68 bytes for all outputs."""
    cam: Sequence[CamConfig] = Field(default=(), max_length=CAMS)

    @model_validator(mode="after")
    def _can_be(self) -> "CamshaftConfig":
        if self.axis is not None and self.encoder is not None:
            raise ValueError("either axis or encoder, not both")
        if self.units_per_turn is not None and self.axis is None:
            raise ValueError("units_per_turn goes with axis")
        if self.axis is not None and self.encoder_range:
            raise ValueError("encoder_range goes with encoder: an axis does not begin again at 0")
        for key, words, value in (
            ("input", [word.name.lower() for word in CamInput], self.input),
            ("output", [word.name.lower() for word in CamOutput], self.output),
        ):
            for name in value:
                if name not in words:
                    near = did_you_mean(name, words)
                    raise ValueError(f"{key}: the process image has no word {name!r}{near}")
        numbers = [number for number, _ in self.numbered()]
        if len(set(numbers)) < len(numbers) or any(number > CAMS for number in numbers):
            raise ValueError(f"cam.number: expected each of 1..{CAMS} once, got {numbers}")
        self._check_names()
        return self

    def _check_names(self) -> None:
        """Check that each name leads to one symbol. Raises ValueError."""
        names = [cam.name for cam in self.cam if cam.name]
        for name in (self.name, *names):
            if name != name.strip() or "." in name:
                raise ValueError(f"name: expected no dots and no blanks around it, got {name!r}")
        folded = [name.casefold() for name in names]
        if len(set(folded)) < len(folded):
            raise ValueError(f"cam.name: expected each once, got {names}")
        for name in folded:
            if name in _PARTS:
                raise ValueError(f"cam.name: {name!r} is what the controller has already")

    def numbered(self) -> list[tuple[int, CamConfig]]:
        """Return the cams with their numbers."""
        cams: list[tuple[int, CamConfig]] = []
        for cam in self.cam:
            last = cams[-1][0] if cams else 0
            cams.append((last + 1 if cam.number is None else cam.number, cam))
        return cams

    def parameters(self) -> dict[str, int]:
        """Parameters of controller and encoder by name."""
        names = {each.name for each in CONTROLLER_PARAMETERS} | {"zero_point", "position_offset"}
        return {name: int(getattr(self, name)) for name in names & set(type(self).model_fields)}

    def what_encoder(self) -> CamEncoder:
        """Return the parameters of the encoder."""
        return CamEncoder(
            *(self.increments, self.encoder_range, self.largest_step, self.speed_window)
        )
