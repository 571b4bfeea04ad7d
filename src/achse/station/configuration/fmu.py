"""[[fmu]] of station.toml: co-simulation units as the plant behind axes and PLCs."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from achse.motion.servo import ServoMode
from achse.station.configuration.types import ConfigTable, DurationNs

_Positive = Annotated[FiniteFloat, Field(gt=0)]
_Factor = Annotated[FiniteFloat, Field(gt=-1e12, lt=1e12)]
_NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"

_MODES = {"position": ServoMode.CSP, "velocity": ServoMode.CSV, "torque": ServoMode.CST}


class FmuAxisConfig(ConfigTable):
    """[[fmu.axis]]: an axis that the unit moves. The unit is behind the hardware port, as a
    drive on a bus is."""

    axis: int | str
    """Id or name of the axis."""
    mode: Literal["position", "velocity", "torque"] = "velocity"
    """Set value that goes to the unit; for torque the station closes the velocity loop."""
    command: str = Field(min_length=1)
    """Variable of the unit that takes the set value: in units of its own, see `scale`; a torque in
    those of `rated_torque`."""
    position: str = Field(min_length=1)
    """Variable of the unit that is the actual position."""
    velocity: str | None = None
    """Variable of the unit that is the actual velocity; without it, from the positions."""
    enable: str | None = None
    """Variable of the unit that is true (1) while the drive is enabled."""
    scale: _Factor = 1.0
    """Axis units of one unit of the unit's position: 1000 from m to mm, 5 / (2 π) from rad to mm
    with a feed of 5 mm a turn."""
    offset: FiniteFloat = 0.0
    """Position of the axis at position 0 of the unit, in axis units."""
    increment: _Positive = 1e-5
    """Axis units of one increment of the encoder."""
    rated_torque: _Positive = 1.0
    """Torque of 1000 ‰, in the unit's torque."""
    torque_limit: float = Field(default=3000.0, gt=0, le=32_767)
    """torque: thousandths of the rated torque."""
    torque_per_acceleration: _Positive | None = None
    """torque: thousandths of the rated torque for a unit a second² of the axis, which feed-forward
    and velocity loop need."""
    velocity_bandwidth: _Positive | None = None
    """torque: bandwidth of the velocity loop, Hz; default 3 % of the frequency of the cycle."""
    velocity_reset_time: DurationNs | None = None
    """torque: reset time of its I-part; default 4 / (2π · bandwidth)."""
    dead_time: DurationNs | None = None
    """From a set value to the actual value that shows it. By default it is measured (position), or
    one and a half cycles."""

    @model_validator(mode="after")
    def _is_whole(self) -> "FmuAxisConfig":
        if self.scale == 0.0:
            raise ValueError("scale: expected a number other than 0")
        if self.mode == "torque" and self.torque_per_acceleration is None:
            raise ValueError("torque_per_acceleration: expected beside mode = 'torque'")
        return self

    @property
    def interface(self) -> ServoMode:
        """The mode as a number of 6060h."""
        return _MODES[self.mode]

    @property
    def scaling(self) -> float:
        """Axis units of one increment."""
        return self.increment

    @property
    def inverted(self) -> bool:
        """False: a negative `scale` says it."""
        return False

    @property
    def homing(self) -> None:
        """Return None: the unit does not home the axis by itself."""
        return None


class FmuConfig(ConfigTable):
    """[[fmu]]: a co-simulation unit (FMI 2.0 or 3.0) that runs with the station. It is native code:
    it runs in a process of its own, with the rights of the station."""

    name: str = Field(pattern=_NAME, max_length=30)
    file: str = Field(min_length=1)
    """The unit (relative to the station.toml)."""
    step: DurationNs | None = None
    """Communication step. With axes the cycle of the NC or a whole part of it, which is the
    default; else any time, by default the cycle of the first PLC."""
    timeout: DurationNs = 10_000_000_000
    """Longest time of an answer, in the computer's time: then its process is ended, and the unit
    has failed."""
    plc: int | None = Field(default=None, ge=1, le=65535)
    """Port of the PLC that the names of variables belong to; the first one unless given."""
    start: Mapping[str, bool | int | FiniteFloat | str] = {}
    """Values of parameters and inputs before the first step, by the unit's names."""
    inputs: Mapping[str, str] = {}
    """Input of the unit = where its value comes from: a variable of the PLC (`MAIN.fValve`), of the
    NC (`500:Axes.X.SetVelo`), or an output of another unit (`fmu:NAME:variable`)."""
    outputs: Mapping[str, str] = {}
    """Variable of the PLC = output of the unit that it gets."""
    failed: str | None = None
    """Variable of the PLC, a BOOL, that is true when the unit has failed."""
    axis: Sequence[FmuAxisConfig] = ()
