"""station.toml: what a station consists of, validated; errors name file, key and expectation."""

from collections.abc import Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    FiniteFloat,
    PlainSerializer,
    ValidationError,
    model_validator,
)

from achse.ams import NetId
from achse.faults.kinds import STATION_FAULTS
from achse.faults.site import StationFault
from achse.motion.tables import HIGHEST_TABLE_ID
from achse.router.access import PasswordHash
from achse.router.routes import Route
from achse.server import ClientLimits
from achse.station.documents import check_depth, parse_toml
from achse.transport.held import DEFAULT_MAX_HELD

__all__ = [
    "AxisConfig",
    "ConfigError",
    "FaultConfig",
    "LimitsConfig",
    "NcConfig",
    "PlcConfig",
    "RouteConfig",
    "RouterConfig",
    "StationConfig",
    "SystemConfig",
    "TableConfig",
    "TaskConfig",
    "load",
    "parse",
]


class ConfigError(ValueError):
    """A configuration cannot be used. One line per fault: file, key, expectation, what came."""


_LONGEST_NS = 3_600_000_000_000
"""An hour: no cycle is longer."""

_UNITS_NS = {"ns": 1, "us": 1_000, "µs": 1_000, "ms": 1_000_000, "s": 1_000_000_000}


def _duration_ns(value: object) -> object:
    """`"2ms"` and the like as integer nanoseconds."""
    if isinstance(value, str):
        for unit in sorted(_UNITS_NS, key=len, reverse=True):
            number = value.strip().removesuffix(unit)
            if number != value.strip():
                try:
                    nanoseconds = Decimal(number.strip()) * _UNITS_NS[unit]
                    if nanoseconds <= _LONGEST_NS and nanoseconds == int(nanoseconds):
                        return int(nanoseconds)
                except (ArithmeticError, ValueError):  # no number, or none that is finite
                    pass
                break
    raise ValueError('a duration such as "2ms", "250us" or "1s", whole nanoseconds, up to 3600s')


def _net_id(value: object) -> object:
    if isinstance(value, NetId):
        return value
    if isinstance(value, str):
        return NetId(value)
    raise ValueError("a NetId is six numbers 0..255 with dots")


DurationNs = Annotated[int, BeforeValidator(_duration_ns), Field(gt=0)]
MomentNs = Annotated[int, BeforeValidator(_duration_ns), Field(ge=0)]
ConfiguredNetId = Annotated[NetId, BeforeValidator(_net_id), PlainSerializer(str, return_type=str)]


def _password_hash(value: object) -> object:
    if isinstance(value, str):
        return PasswordHash.parse(value)
    return value


ConfiguredHash = Annotated[
    PasswordHash, BeforeValidator(_password_hash), PlainSerializer(str, return_type=str)
]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class RouterConfig(_Section):
    """[router]: the address others see."""

    net_id: ConfiguredNetId = NetId("127.0.0.1.1.1")
    host: str = Field(default="127.0.0.1", min_length=1)
    tcp_port: int = Field(default=48898, ge=0, le=65535)
    strict: bool = False
    """As the original does it: one TCP connection per remote host, and clients need a route."""
    max_connections: int = Field(default=4096, ge=1)
    max_connections_per_host: int = Field(default=2048, ge=1)
    """Of these, those of one host; further ones are refused with 0x508."""
    max_length: int = Field(default=64 * 1024 * 1024, ge=64)
    """Longest packet taken, bytes."""
    udp_port: int | None = Field(default=None, ge=0, le=65535)
    """Where searches are answered; 0 takes a free one. Without this key 48899 if it is free, and
    none if the TCP port is not 48898."""
    static_routes: str | None = None
    """A StaticRoutes.xml (relative to the station.toml): read at the start, kept up to date."""
    users: Mapping[str, ConfiguredHash] = {}
    """Who may change routes by a UDP request with a password: name = "hash as `achse
    hash-password` prints it"."""
    routes_over_ads: bool = False
    """Let port 10000 change routes (groups 801 and 802). These requests carry no password: any
    client may."""
    let_everybody_in: bool = False
    """Listen beyond this computer without `strict`: any client may do anything."""


class RouteConfig(_Section):
    """[[route]]: where the router of another NetId is."""

    name: str
    net_id: ConfiguredNetId
    host: str
    """Name or IP address, with `:port` if it is not 48898."""
    one_way: bool = False
    """Requests from there are refused."""
    nat: ConfiguredNetId | None = None
    """The NetId it has itself, if `net_id` is only ours for it."""
    timeout: DurationNs = 5_000_000_000
    max_fragment: int = Field(default=0, ge=0, le=0xFFFF_FFFF)
    """Longest AMS packet, bytes; 0 for any."""

    @model_validator(mode="after")
    def _can_be(self) -> "RouteConfig":
        self.route()
        return self

    def route(self) -> Route:
        """The entry of the router's table; raises RouteError."""
        return Route(
            name=self.name,
            net_id=self.net_id,
            host=self.host,
            one_way=self.one_way,
            nat_net_id=self.nat,
            timeout=self.timeout / 1e9,
            max_fragment=self.max_fragment,
        )


class SystemConfig(_Section):
    """[system]: the system service."""

    root: str | None = None
    """Folder that the file services show (relative to the station.toml); without it none."""
    persistent_data: str | None = None
    """A file (relative to the station.toml) in which persistent data of axes outlive the program;
    without it they outlive restarts."""
    restart_time: MomentNs = 500_000_000
    """How long a restart takes, or a change to CONFIG."""


class TaskConfig(_Section):
    """[[plc.task]]: programs called in order, once per cycle."""

    name: str = "PlcTask"
    cycle: DurationNs = 10_000_000
    priority: int = Field(default=20, ge=0, le=255)
    programs: Sequence[str] = ()
    """Each the name of a declared program, or `module:Class` or `file.py:Class` (relative to the
    station.toml)."""


class PlcConfig(_Section):
    """[[plc]]: one PLC device. Its variables come from `sources`, from `symbols`, or from Python.

    Without `[[plc.task]]` the tasks are those of the project or symbol file.
    """

    port: int = Field(default=851, ge=1, le=65535)
    also: Sequence[Annotated[int, Field(ge=1, le=65535)]] = ()
    """Further ports that answer for the same device, for example 801."""
    sources: str | None = None
    """A folder of Structured Text (`.TcPOU`, `.TcGVL`, `.TcDUT`, `.st` …), or one such file."""
    libraries: Sequence[str] = ()
    """Sources of libraries, folders or files like `sources`, or `.tmc` files with their types; of
    them only what is named counts."""
    execute: bool = True
    """Whether the programs of `sources` run; if not, they are declared only."""
    floating_point_exceptions: bool = True
    """The task option of that name: a REAL divided by 0, the root of -1 stop the program; if off
    they are infinity and NaN."""
    symbols: str | None = None
    """A symbol file, `.tmc` or `.tpy`."""
    behaviour: Sequence[str] = ()
    """Python classes for declared programs and function blocks, `module:Class` or
    `file.py:Class`; each is for the one of its name."""
    globals: Sequence[str] = ()
    """Global variable lists, named like programs."""
    task: Sequence[TaskConfig] = ()

    @model_validator(mode="after")
    def _one_origin(self) -> "PlcConfig":
        if self.sources is not None and self.symbols is not None:
            raise ValueError("either sources or symbols, not both")
        if self.libraries and self.sources is None:
            raise ValueError("libraries go with sources")
        return self


class NcConfig(_Section):
    """[nc]: the motion device."""

    cycle: DurationNs = 2_000_000
    kernel: Literal["auto", "compiled", "interpreted"] = "auto"
    """`compiled` needs llvmlite (achse[fast]); `auto` takes it where it is there or pays."""


class AxisConfig(BaseModel):
    """[[axis]]: an axis of the NC. Further keys are the parameters of the motion record."""

    model_config = ConfigDict(extra="allow", frozen=True)

    id: int = Field(ge=1, le=255)
    name: str = Field(min_length=1, max_length=30)
    unit: str = Field(default="mm", max_length=10)
    modulo: bool = False
    """The position repeats every `encoder_modulo_factor`."""
    encoder_ids: tuple[int, ...] = ()
    controller_ids: tuple[int, ...] = ()
    drive_ids: tuple[int, ...] = ()
    """Encoders, controllers, drives; the first is the standard one. Default: one, the axis' id."""
    element: tuple[dict[str, Any], ...] = ()
    """Parameters of encoder, controller and drive number 1, 2, …"""

    @property
    def parameters(self) -> dict[str, Any]:
        return dict(self.model_extra or {})


class TableConfig(_Section):
    """[[table]]: the characteristic of a valve, which drives name by `drive_table_id`."""

    id: int = Field(ge=1, le=HIGHEST_TABLE_ID)
    name: str = Field(default="", max_length=30)
    type: Literal["equidistant_linear", "monotonic_linear"] = "monotonic_linear"
    points: Sequence[tuple[FiniteFloat, FiniteFloat]] = Field(min_length=2)
    """Velocity and output, each as a share of the full one, -1..1; the velocities rise."""


class FaultConfig(BaseModel):
    """[[fault]]: a fault at a given time. Further keys are the fields of its kind."""

    model_config = ConfigDict(extra="allow", frozen=True)

    kind: str
    at: MomentNs = 0
    lasting: MomentNs | None = None
    by: MomentNs | None = None

    @model_validator(mode="after")
    def _is_one(self) -> "FaultConfig":
        self.fault()
        return self

    def fault(self) -> StationFault:
        """The fault; raises FaultError."""
        seconds = {
            name: value / 1e9
            for name in ("at", "lasting", "by")
            if (value := getattr(self, name)) is not None
        }
        return STATION_FAULTS.of({"kind": self.kind, **seconds, **(self.model_extra or {})})


_LIMITS = ClientLimits()


class LimitsConfig(_Section):
    """[limits]: how much one client may hold of each device, and leave unread; `all_…` is for all
    clients and devices together."""

    handles: int = Field(default=_LIMITS.handles, ge=1)
    """Symbol handles (0x716 beyond)."""
    all_handles: int = Field(default=_LIMITS.all_handles, ge=1)
    """Symbol handles of all clients together (0x716 beyond)."""
    notifications: int = Field(default=_LIMITS.notifications, ge=1)
    """Subscriptions (0x716 beyond)."""
    all_notifications: int = Field(default=_LIMITS.all_notifications, ge=1)
    """Subscriptions of all clients together (0x716 beyond)."""
    sample_bytes: int = Field(default=_LIMITS.sample_bytes, ge=8)
    """Bytes of one sample (0x717 beyond)."""
    watched_bytes: int = Field(default=_LIMITS.watched_bytes, ge=8)
    """Bytes of one sample of each subscription together (0x717 beyond)."""
    all_watched_bytes: int = Field(default=_LIMITS.all_watched_bytes, ge=8)
    """The same of all clients together (0x717 beyond)."""
    queue_bytes: int = Field(default=_LIMITS.queue_bytes, ge=1024)
    """Bytes of samples kept for a client that does not read; beyond, the oldest are dropped."""
    all_queue_bytes: int = Field(default=_LIMITS.all_queue_bytes, ge=1024)
    """Bytes of samples kept for all clients together; beyond, those with the most lose theirs."""
    unread_bytes: int = Field(default=64 * 1024 * 1024, ge=65_536)
    """Bytes of answers and samples on a connection that is not read; beyond, it is cut off."""
    held_bytes: int = Field(default=DEFAULT_MAX_HELD, ge=1024 * 1024)
    """Bytes that all connections together leave unread, or send of packets without their end, and
    that wait for a route; beyond, those with the most of them are cut off until an eighth of it is
    free."""
    taps: int = Field(default=32, ge=1)
    """Taps of all clients together (0x716 beyond)."""
    tap_bytes: int = Field(default=16 * 1024 * 1024, ge=1024)
    """Bytes that are kept for all taps together; beyond, the oldest frames are lost to them."""
    samples: int = Field(default=_LIMITS.samples, ge=1000)
    """Samples a second for all clients together (a frame counts as 64); those who ask for more get
    theirs late."""
    log_lines: int = Field(default=_LIMITS.log_lines, ge=1)
    """Lines a second that one host may write into the log by ports 100 and 110."""
    all_log_lines: int = Field(default=_LIMITS.all_log_lines, ge=1)
    """The same of all hosts together; the messages reach those who subscribed all the same."""
    unreachable_time: DurationNs = _LIMITS.unreachable_ns
    """How long handles and subscriptions of a client to whom no way leads are kept."""

    def limits(self) -> ClientLimits:
        """What each device keeps to."""
        return ClientLimits(
            handles=self.handles,
            all_handles=self.all_handles,
            notifications=self.notifications,
            all_notifications=self.all_notifications,
            sample_bytes=self.sample_bytes,
            watched_bytes=self.watched_bytes,
            all_watched_bytes=self.all_watched_bytes,
            queue_bytes=self.queue_bytes,
            all_queue_bytes=self.all_queue_bytes,
            samples=self.samples,
            log_lines=self.log_lines,
            all_log_lines=self.all_log_lines,
            unreachable_ns=self.unreachable_time,
        )


class StationConfig(_Section):
    """A whole station."""

    name: str = "achse"
    router: RouterConfig = RouterConfig()
    system: SystemConfig = SystemConfig()
    route: Sequence[RouteConfig] = ()
    nc: NcConfig = NcConfig()
    plc: Sequence[PlcConfig] = ()
    table: Sequence[TableConfig] = ()
    axis: Sequence[AxisConfig] = ()
    fault: Sequence[FaultConfig] = ()
    limits: LimitsConfig = LimitsConfig()

    @model_validator(mode="after")
    def _distinct(self) -> "StationConfig":
        once: dict[str, list[Any]] = {
            "plc.port": [port for plc in self.plc for port in (plc.port, *plc.also)],
            "table.id": [table.id for table in self.table],
            "axis.id": [axis.id for axis in self.axis],
            "axis.name": [axis.name.casefold() for axis in self.axis],
            "route.name": [route.name.casefold() for route in self.route],
            "route.net_id": [str(route.net_id) for route in self.route],
        }
        for what, keys in once.items():
            twice = sorted({str(key) for key in keys if keys.count(key) > 1})
            if twice:
                raise ValueError(f"{what}: each once, got {', '.join(twice)} more than once")
        return self


def parse(document: dict[str, Any], source: str) -> StationConfig:
    """Validate a parsed document; `source` names it in errors. Raises ConfigError."""
    try:
        check_depth(document)
    except ValueError as fault:
        raise ConfigError(f"{source}: {fault}") from None
    try:
        return StationConfig.model_validate(document)
    except ValidationError as failure:
        lines = []
        for error in failure.errors():
            key = ""
            for part in error["loc"]:
                key += f"[{part + 1}]" if isinstance(part, int) else f"{'.' * bool(key)}{part}"
            expected = error["msg"].removeprefix("Value error, ")
            given = "" if error["type"] == "missing" else f", got {error['input']!r:.80}"
            if error["type"] == "extra_forbidden":
                expected, given = "no such key", ""
            if given in expected or not key:
                given = ""
            lines.append(f"{source}: {key + ': ' * bool(key)}{expected}{given}")
        raise ConfigError("\n".join(lines)) from None


def load(path: Path, *, net_id: str | None = None) -> StationConfig:
    """Read a station.toml; `net_id` replaces the one in there.

    Raises ConfigError; OSError if the file cannot be read.
    """
    try:
        document = parse_toml(path.read_text(encoding="utf-8"))
    except ValueError as failure:
        raise ConfigError(f"{path}: no valid TOML: {failure}") from None
    if net_id is not None and isinstance(document.setdefault("router", {}), dict):
        document["router"]["net_id"] = net_id
    return parse(document, str(path))
