"""[[bus]] and [[drive]] of station.toml: fieldbuses, and the drives that axes have on them."""

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from achse.motion.servo import INPUT_OBJECTS, OUTPUT_OBJECTS, ServoMode
from achse.motion.servo.optional import (
    FOLLOWING_BIT,
    INTERPOLATION_TIME,
    MODE_DISPLAY,
    REACHED_BIT,
    REMOTE_BIT,
    VOLTAGE_BIT,
)
from achse.station.configuration.types import ConfigTable, DeviceName, DurationNs

_LONGEST_PDO = 8
"""Objects in a PDO, as the drives of 001 have it."""

_Positive = Annotated[FiniteFloat, Field(gt=0)]


class BusConfig(ConfigTable):
    """[[bus]]: an EtherCAT bus of drives, of terminals, or of both."""

    name: DeviceName = Field(default="EtherCAT", min_length=1)
    interface: str | None = Field(default=None, min_length=1, max_length=15)
    """The network interface where the slaves are (`eth1`); without it they are virtual ones within
    this process, one for each [[drive]] and [[terminal]]."""
    redundant: bool | Annotated[str, Field(min_length=1, max_length=15)] = False
    """The line of slaves comes back to the master: whichever cable is cut, all go on. The second
    interface (`eth2`); true for virtual slaves within this process."""
    real_time: bool = True
    """On an interface: the station runs before other programs, where the system allows it (root,
    CAP_SYS_NICE) and these do not starve."""
    synchronous: bool = True
    """Drives take their set values with SYNC0 of the distributed clocks."""
    pace: Literal["bus", "computer"] = "bus"
    """On an interface: the cycles of the station follow the clock of the first drive, so that
    frames keep their place between the SYNC0 of the drives; or that of the computer. Of several
    buses the first one leads."""
    clock_window: DurationNs = Field(default=10_000, ge=100)
    """Largest distance of a slave's clock from the reference; beyond it 0x1000 is in the state of
    the bus, and an event."""
    cycle: DurationNs = Field(default=2_000_000, ge=100_000)
    """Of a bus of terminals alone; with drives the cycle is that of the NC."""

    @model_validator(mode="after")
    def _has_both_ends(self) -> "BusConfig":
        first, second = self.interface, self.redundant
        if first is None and isinstance(second, str):
            raise ValueError(f"redundant: expected an interface beside the second one, {second}")
        if first is not None and second is True:
            raise ValueError("redundant: expected the name of the second interface, got true")
        if first is not None and first == second:
            raise ValueError(f"redundant: expected another interface than {first}, got the same")
        return self

    @property
    def interfaces(self) -> tuple[str, ...]:
        """The interfaces it has: none, one, or two."""
        both = (self.interface, self.redundant)
        return tuple(each for each in both if isinstance(each, str))


class StartCommandConfig(ConfigTable):
    """[[drive.start]]: an object that is written on the way from PreOp to SafeOp."""

    index: int = Field(ge=0x1000, le=0xFFFF)
    subindex: int = Field(default=0, ge=0, le=255)
    value: int
    size: Literal[1, 2, 4] = 4
    """Bytes of the object."""


class DriveHomingConfig(ConfigTable):
    """[drive.homing]: the drive homes the axis by itself (mode hm); velocities in axis units."""

    method: int = Field(ge=-128, le=127)
    """6098h."""
    search_velocity: _Positive = 50.0
    """6099h:01, towards the switch, in units a second."""
    index_velocity: _Positive = 5.0
    """6099h:02, towards the index pulse, in units a second."""
    acceleration: _Positive = 500.0
    """609Ah, in units a second²."""
    offset: FiniteFloat = 0.0
    """607Ch: what the drive counts at its reference, in units; the axis is at the position that
    MC_Home was given."""


class DriveMachineConfig(ConfigTable):
    """[drive.machine]: what a virtual drive moves; places in axis units from where it starts."""

    kind: Literal["ac", "direct", "linear"] = "ac"
    encoder: Literal["incremental", "single_turn", "multi_turn"] = "incremental"
    home: tuple[FiniteFloat, FiniteFloat] | None = None
    """Positions between which the home switch is on."""
    probe: tuple[FiniteFloat, FiniteFloat] | None = None
    """Positions between which the input of touch probe 1 is on."""
    negative_limit: FiniteFloat | None = None
    positive_limit: FiniteFloat | None = None
    """Positions of the limit switches."""


class DriveConfig(ConfigTable):
    """[[drive]]: a servo drive with profile CiA 402 on a bus, and the axis it moves."""

    axis: int | str
    """Id or name of the axis."""
    bus: str | None = None
    """Name of the bus; not needed if there is one."""
    position: int | None = Field(default=None, ge=1, le=255)
    """Place along the cable, the first is 1; without it the next free one."""
    sync_unit: str | None = Field(default=None, min_length=1, max_length=60)
    """Drives with the same word share a datagram: shorter frames, but where one of them fails the
    data of all are invalid. Default: each has its own."""
    mode: Literal["csp", "csv", "cst"] = "csp"
    """Set points sent to the drive: positions, velocities, or torques of a velocity loop in the
    station."""
    resolution: int = Field(default=131_072, ge=1, le=0xFFFF_FFFF)
    """Increments of a motor turn (of a metre of a linear motor)."""
    gear: tuple[_Positive, _Positive] = (1.0, 1.0)
    """So many turns of the motor are so many turns of the load."""
    feed: _Positive = 10.0
    """Axis units of a turn of the load (of a metre). The axis' own scaling counts if it has one."""
    inverted: bool = False
    """True if the motor turns the other way round: encoder and set values."""
    outputs: Sequence[int] = Field(default=(), max_length=_LONGEST_PDO)
    """Objects that go to the drive (0x1600), in their order; default: what the mode needs."""
    inputs: Sequence[int] = Field(default=(), max_length=_LONGEST_PDO)
    """Objects that come from it (0x1A00)."""
    identity: Literal["achse", "manual"] = "achse"
    """Vendor id and product code of a virtual drive (1018h): of no maker, or of the manual."""
    voltage_bit: bool = VOLTAGE_BIT.default
    """Bit 4 of 6041h says that main power is on, as in CiA 402: `axis enable` names it."""
    remote_bit: bool = REMOTE_BIT.default
    """Bit 9 of 6041h says that the drive obeys the bus: `axis enable` names it."""
    reached_bit: bool = REACHED_BIT.default
    """Bit 10 of 6041h ends a homing by the drive; without it the standstill does."""
    following_bit: bool = FOLLOWING_BIT.default
    """Bit 12 of 6041h says that the drive follows; without it each enabled drive does."""
    mode_display: bool = MODE_DISPLAY.default
    """6061h shows the mode; without it a mode is active 50 ms after it was sent."""
    interpolation_time: bool = INTERPOLATION_TIME.default
    """60C2h takes the cycle of the set values; without it nothing is written there."""
    own_mapping: bool = False
    """True to keep the drive's own process data: write neither mapping nor assignment."""
    start: Sequence[StartCommandConfig] = ()
    homing: DriveHomingConfig | None = None
    machine: DriveMachineConfig = DriveMachineConfig.model_construct()
    dead_time: DurationNs | None = None
    """From a set value to the actual value that shows it. By default it is measured (csp), or two
    and a half cycles."""
    velocity_bandwidth: _Positive | None = None
    """cst: bandwidth of the velocity loop, Hz; default 3 % of the frequency of the cycle."""
    velocity_reset_time: DurationNs | None = None
    """cst: reset time of its I-part; default 4 / (2π · bandwidth)."""
    torque_per_acceleration: _Positive | None = None
    """cst: thousandths of the rated torque for a unit a second²; without it that of the machine in
    [drive.machine]."""
    torque_limit: float = Field(default=3000.0, gt=0, le=32_767)
    """cst: thousandths of the rated torque."""

    @model_validator(mode="after")
    def _is_whole(self) -> "DriveConfig":
        for way, objects, known in (
            ("outputs", self.outputs, OUTPUT_OBJECTS),
            ("inputs", self.inputs, INPUT_OBJECTS),
        ):
            for index in objects:
                if index not in known:
                    listed = ", ".join(f"0x{each:04X}" for each in known)
                    raise ValueError(f"{way}: expected some of {listed}; got 0x{index:04X}")
            if len(set(objects)) < len(objects):
                raise ValueError(f"{way}: expected each object once")
        if self.own_mapping and (self.outputs or self.inputs):
            raise ValueError("own_mapping: expected neither outputs nor inputs beside it")
        return self

    @property
    def interface(self) -> ServoMode:
        """The mode as a number of 6060h."""
        return ServoMode[self.mode.upper()]

    @property
    def scaling(self) -> float:
        """Axis units of one increment."""
        motor, load = self.gear
        return self.feed * load / (self.resolution * motor)
