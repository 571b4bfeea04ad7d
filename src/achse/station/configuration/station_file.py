"""station.toml: what a station consists of, validated; errors name file, key and expectation."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from achse.faults.kinds import STATION_FAULTS
from achse.faults.site import StationFault
from achse.motion.machine.record import PARAMETERS as MACHINE_PARAMETERS
from achse.motion.nc import configurable
from achse.motion.record import FIELDS
from achse.motion.tables import HIGHEST_TABLE_ID
from achse.station.configuration.bus import BusConfig, DriveConfig
from achse.station.configuration.camshaft import CamshaftConfig
from achse.station.configuration.fmu import FmuConfig
from achse.station.configuration.group import ChannelConfig, GroupConfig
from achse.station.configuration.http import MetricsConfig, WebConfig
from achse.station.configuration.limits import LimitsConfig
from achse.station.configuration.modbus import ModbusConfig
from achse.station.configuration.network import (
    NetworkConfig,
)
from achse.station.configuration.plc import PlcConfig
from achse.station.configuration.scope import ScopeConfig
from achse.station.configuration.signal import SIGNAL_KINDS, SignalConfig
from achse.station.configuration.terminal import TerminalConfig
from achse.station.configuration.types import (
    LONGEST_UNIT,
    ConfigError,
    ConfigTable,
    DeviceName,
    DurationNs,
    MomentNs,
)
from achse.station.configuration.validation import document_of, validated


class SystemConfig(ConfigTable):
    """[system]: the system service."""

    root: str | None = None
    """Folder that the file services show (relative to the station.toml); without it none."""
    persistent_data: str | None = None
    """A file (relative to the station.toml) in which persistent data of axes and PLCs outlive the
    program; without it they outlive restarts."""
    persistent_data_interval: MomentNs = 100_000_000
    """Interval at which a running station writes changes to a snapshot file beside that file, in
    the computer's time: a station that is killed loses at most the changes of one interval; 0: it
    writes at its end only."""
    restart_time: MomentNs = 500_000_000
    """Duration of a restart, or of a change to CONFIG."""
    programs: Sequence[str] = ()
    """Programs of this computer that clients may start (group 500 of port 10000), with any
    arguments: absolute paths, `*` and `?` for any characters of a name. They run with the rights
    of the station."""

    @model_validator(mode="after")
    def _programs_absolute(self) -> "SystemConfig":
        for program in self.programs:
            if not Path(program).is_absolute() or ".." in Path(program).parts:
                raise ValueError(f"programs: expected absolute paths, got {program!r}")
        return self


class NcConfig(ConfigTable):
    """[nc]: the motion device."""

    cycle: DurationNs = 2_000_000
    code: Literal["auto", "machine", "plain"] = "auto"
    """`machine` needs llvmlite (achse[fast]); `auto` uses machine code where it is cached or
    pays."""


class AxisConfig(BaseModel):
    """[[axis]]: an axis of the NC. Further keys are the parameters of the motion record."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)

    id: int = Field(ge=1, le=255)
    name: DeviceName = Field(min_length=1)
    unit: str = Field(default="mm", max_length=LONGEST_UNIT)
    modulo: bool = False
    """True if the position repeats every `encoder_modulo_factor`."""
    plc: str | tuple[str, ...] = ()
    """The variable of a PLC that is this axis: an AXIS_REF (`"MAIN.Axis1"`), or a structure
    NCTOPLC_… and a structure PLCTONC_… (`["MAIN.fromNc", "MAIN.toNc"]`), which may be named by
    their place too (`["%IB1000", "%QB1000"]`); `"852:MAIN.Axis1"` if several PLCs have it. Without
    it what the solution of the sources (`.tsproj`) links, or an AXIS_REF of the axis' name."""
    encoder_ids: tuple[int, ...] = ()
    controller_ids: tuple[int, ...] = ()
    drive_ids: tuple[int, ...] = ()
    """Encoders, controllers, drives; the first is the standard one. Default: one, the axis' id."""
    element: tuple[dict[str, Any], ...] = ()
    """Parameters of encoder, controller and drive number 1, 2, …"""

    @property
    def parameters(self) -> dict[str, Any]:
        return dict(self.model_extra or {})


def axis_keys() -> list[str]:
    """Return the parameters that a table of an axis may have, beside the keys of `AxisConfig`."""
    return [name for name in {**FIELDS, **MACHINE_PARAMETERS} if configurable(name)]


class TableConfig(ConfigTable):
    """[[table]]: the characteristic of a valve, which drives name by `drive_table_id`; a cam or a
    motion function, which slaves follow."""

    id: int = Field(ge=1, le=HIGHEST_TABLE_ID)
    name: DeviceName = ""
    kind: Literal["characteristic", "cam", "motion_function"] = "characteristic"
    """A motion function comes from a file: its points have laws, velocities and so on besides."""
    type: Literal[
        "equidistant_linear", "equidistant_cyclic", "monotonic_linear", "monotonic_cyclic"
    ] = "monotonic_linear"
    """Distances of the places; cyclic ones, of cams, begin again behind the last."""
    points: Sequence[tuple[FiniteFloat, FiniteFloat]] | None = Field(default=None, min_length=2)
    """Velocity and output, each as a share of the full one, -1..1; of a cam master position and
    slave position. The first number rises."""
    file: str | None = None
    """A file (relative to the station.toml) that has them instead, a line for each: CSV, or text
    with blanks or tabs between; the first line may say how many rows and columns follow."""
    boundary: Literal["by_type", "natural", "slopes", "periodic"] = "by_type"
    """Boundary condition of the spline through a cam: slopes of 0, or where the type is cyclic the
    slopes of the other end; no bend; `begin_slope` and `end_slope`; or the slopes of the other
    end."""
    begin_slope: FiniteFloat = 0.0
    end_slope: FiniteFloat = 0.0

    @property
    def is_motion_function(self) -> bool:
        """True if the points have laws besides their places."""
        return self.kind == "motion_function"

    @model_validator(mode="after")
    def _has_content(self) -> "TableConfig":
        if (self.points is None) == (self.file is None):
            raise ValueError("expected points or file")
        return self


class FaultConfig(BaseModel):
    """[[fault]]: a fault at a given time. Further keys are the fields of its kind."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)

    kind: str
    at: MomentNs = 0
    lasting: MomentNs | None = None
    by: MomentNs | None = None

    @model_validator(mode="after")
    def _is_one(self) -> "FaultConfig":
        self.fault()
        return self

    def fault(self) -> StationFault:
        """Return the fault; raises FaultError."""
        seconds = {
            name: value / 1e9
            for name in ("at", "lasting", "by")
            if (value := getattr(self, name)) is not None
        }
        return STATION_FAULTS.of({"kind": self.kind, **seconds, **(self.model_extra or {})})


class StationConfig(NetworkConfig):
    """A whole station."""

    system: SystemConfig = SystemConfig.model_construct()
    web: WebConfig = WebConfig.model_construct()
    metrics: MetricsConfig = MetricsConfig.model_construct()
    nc: NcConfig = NcConfig.model_construct()
    plc: Sequence[PlcConfig] = ()
    table: Sequence[TableConfig] = ()
    axis: Sequence[AxisConfig] = ()
    bus: Sequence[BusConfig] = ()
    drive: Sequence[DriveConfig] = ()
    terminal: Sequence[TerminalConfig] = ()
    channel: Sequence[ChannelConfig] = ()
    group: Sequence[GroupConfig] = ()
    fault: Sequence[FaultConfig] = ()
    signal: Sequence[SignalConfig] = ()
    fmu: Sequence[FmuConfig] = ()
    scope: ScopeConfig = ScopeConfig.model_construct()
    modbus: ModbusConfig | None = None
    camshaft: Sequence[CamshaftConfig] = Field(default=(), max_length=4)
    limits: LimitsConfig = LimitsConfig.model_construct()

    def _unique_keys(self) -> dict[str, list[Any]]:
        return {
            "plc.port": [port for plc in self.plc for port in (plc.port, *plc.also)],
            "table.id": [table.id for table in self.table],
            "axis.id": [axis.id for axis in self.axis],
            "channel.id": [channel.id for channel in self.channel],
            "group.id": [group.id for group in self.group],
            "axis.name": [axis.name for axis in self.axis],
            "fmu.name": [unit.name for unit in self.fmu],
            "bus.name": [bus.name for bus in self.bus],
            "bus.interface": [each for bus in self.bus for each in bus.interfaces],
            **super()._unique_keys(),
        }


def parse(document: dict[str, Any], source: str) -> StationConfig:
    """Validate a parsed document; `source` names it in errors. Raises ConfigError."""
    return validated(StationConfig, document, source, {"signal": SIGNAL_KINDS})


def load(
    path: Path,
    *,
    net_id: str | None = None,
    host: str | None = None,
    interfaces: Mapping[str, str] | None = None,
    redundant: Mapping[str, str] | None = None,
) -> StationConfig:
    """Read a station.toml, a solution, a PLC project, or a folder of one.

    `net_id` and `host` replace those in there, `interfaces` and `redundant` (the second ones) those
    of buses by name ("" for the only bus). Raises ConfigError; OSError if the file cannot be read.
    """
    document = document_of(path) if path.suffix.lower() == ".toml" else _other_document(path)
    for key, value in (("net_id", net_id), ("host", host)):
        if value is not None and isinstance(document.setdefault("router", {}), dict):
            document["router"][key] = value
    for key, wanted in (("interface", interfaces), ("redundant", redundant)):
        if wanted:
            _put_on_interfaces(document, key, wanted, str(path))
    return parse(document, str(path))


def _other_document(path: Path) -> dict[str, Any]:
    from achse.station.configuration.solution import is_project, project_document

    return project_document(path) if is_project(path) else document_of(path)


def _put_on_interfaces(
    document: dict[str, Any], key: str, interfaces: Mapping[str, str], source: str
) -> None:
    """Write interfaces into the tables of buses."""
    tables = document.get("bus", [])
    if not isinstance(tables, list) or not all(isinstance(each, dict) for each in tables):
        return  # the file is wrong, and that is reported
    names = [str(table.get("name", BusConfig.model_fields["name"].default)) for table in tables]
    listed = ", ".join(names) or "none"
    wanted = dict(interfaces)
    if "" in wanted:
        if len(names) != 1:
            raise ConfigError(f"{source}: which bus? Expected BUS=INTERFACE; buses: {listed}")
        wanted[names[0]] = wanted.pop("")
    for name in wanted.keys() - set(names):
        raise ConfigError(f"{source}: no bus {name!r}; buses: {listed}")
    for name, table in zip(names, tables, strict=True):
        if name in wanted:
            table[key] = wanted[name]
