"""station.toml: what a station consists of, validated; errors name file, key and expectation."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    ValidationError,
    model_validator,
)

from achse.faults.kinds import STATION_FAULTS
from achse.faults.site import StationFault
from achse.iec.nearest import did_you_mean
from achse.motion.machine.record import PARAMETERS as MACHINE_PARAMETERS
from achse.motion.nc import configurable
from achse.motion.record import FIELDS
from achse.motion.tables import HIGHEST_TABLE_ID
from achse.router.rights import rights_named
from achse.router.routes import Route
from achse.station.configuration.bus import BusConfig, DriveConfig
from achse.station.configuration.camshaft import CamshaftConfig
from achse.station.configuration.documents import check_depth, parse_toml
from achse.station.configuration.group import ChannelConfig, GroupConfig
from achse.station.configuration.http import MetricsConfig, WebConfig
from achse.station.configuration.limits import LimitsConfig
from achse.station.configuration.modbus import ModbusConfig
from achse.station.configuration.mqtt import MqttConfig
from achse.station.configuration.plc import PlcConfig
from achse.station.configuration.scope import ScopeConfig
from achse.station.configuration.secure import RouteTlsConfig, SecureConfig
from achse.station.configuration.signal import SIGNAL_KINDS, SignalConfig
from achse.station.configuration.terminal import TerminalConfig
from achse.station.configuration.types import (
    ALL_RIGHT_NAMES,
    ConfigError,
    ConfigTable,
    ConfiguredHash,
    ConfiguredNetId,
    ConfiguredRights,
    DurationNs,
    MomentNs,
    without_plugins,
)
from achse.transport.serial.port import Parity, SerialPort

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

__all__ = [
    "AxisConfig",
    "ConfigError",
    "FaultConfig",
    "LimitsConfig",
    "NcConfig",
    "RouteConfig",
    "RouterConfig",
    "SerialConfig",
    "StationConfig",
    "SystemConfig",
    "TableConfig",
    "axis_keys",
    "load",
    "parse",
]


_ANY_CASE = frozenset({"axis.name", "route.name"})
"""Names of which the case does not count."""

_FEW_KEYS = 12
"""So many keys of a table are listed whole."""


class RouterConfig(ConfigTable):
    """[router]: the address others see."""

    net_id: ConfiguredNetId | None = None
    """Without this key 127.0.0.1.1.1 on loopback; else the IP address that others reach with .1.1
    behind it: that of `host`, or for 0.0.0.0 that of this computer's default route."""
    host: str = Field(default="127.0.0.1", min_length=1)
    tcp_port: int = Field(default=48898, ge=0, le=65535)
    strict: bool = False
    """True for the behaviour of the original: one TCP connection per remote host, and clients need
    a route."""
    max_connections: int = Field(default=4096, ge=1)
    max_connections_per_host: int = Field(default=2048, ge=1)
    """Of these, those of one host; a further one replaces an idle one, or is refused with 0x508."""
    udp_port: int | None = Field(default=None, ge=0, le=65535)
    """Port that answers searches; 0 takes a free one. Without this key 48899 if it is free, and
    none if the TCP port is not 48898."""
    static_routes: str | None = None
    """A StaticRoutes.xml (relative to the station.toml): read at the start, kept up to date."""
    users: Mapping[str, ConfiguredHash] = {}
    """Users that may change routes by a UDP request with a password: name = "hash as `achse
    hash-password` prints it"."""
    routes_over_ads: bool = False
    """True if port 10000 may change routes (groups 801 and 802). These requests carry no password:
    any client may send them."""
    let_everybody_in: bool = False
    """Listen beyond this computer without `strict`: any client may do anything."""
    rights: ConfiguredRights = ALL_RIGHT_NAMES
    """Rights of clients that have no route, where they may connect; programs on this computer with
    a port of this router have every right."""
    user_rights: Mapping[str, ConfiguredRights] = {}
    """Rights of the routes that a user adds: name = ["read", …]; without it every right."""
    listen: Literal["plain", "secure", "both"] = "plain"
    """Plain AMS/TCP, Secure ADS as [secure] says, or both. With `secure` nothing listens at
    `tcp_port`, and searches are answered only if there is a `udp_port`."""


class RouteConfig(ConfigTable):
    """[[route]]: where the router of another NetId is."""

    name: str
    net_id: ConfiguredNetId
    host: str
    """Name or IP address, with `:port` if it is not 48898."""
    one_way: bool = False
    """True if requests from there are refused."""
    nat: ConfiguredNetId | None = None
    """The NetId it has itself, if `net_id` is only ours for it."""
    timeout: DurationNs = 5_000_000_000
    max_fragment: int = Field(default=0, ge=0, le=0xFFFF_FFFF)
    """Longest AMS packet, bytes; 0 for any."""
    tls: RouteTlsConfig | None = None
    """It goes by Secure ADS; the port is 8016 then."""
    rights: ConfiguredRights = ALL_RIGHT_NAMES
    """Rights of clients that come over this route: `read`, `write`, `state`, `files`, `methods`."""

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
            tls=None if self.tls is None else self.tls.tls(),
            rights=rights_named(self.rights),
        )


class SerialConfig(ConfigTable):
    """[[serial]]: a serial port where somebody may ask the station, or is asked (extra `serial`).

    A packet on it has 255 bytes at most.
    """

    port: str
    """`/dev/ttyUSB0`, `COM3`, or `socket://host:port` of a serial server."""
    baud: int = 38_400
    parity: Parity = "none"
    stop_bits: int = 1
    net_id: ConfiguredNetId | None = None
    """The NetId of who is at the other end: what asks for it goes there."""

    @model_validator(mode="after")
    def _can_be(self) -> "SerialConfig":
        self.serial_port()
        return self

    def serial_port(self) -> SerialPort:
        """The port with its settings; raises SerialPortError."""
        return SerialPort(self.port, self.baud, self.parity, self.stop_bits)


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
    kernel: Literal["auto", "compiled", "interpreted"] = "auto"
    """`compiled` needs llvmlite (achse[fast]); `auto` takes it where it is there or pays."""


class AxisConfig(BaseModel):
    """[[axis]]: an axis of the NC. Further keys are the parameters of the motion record."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)

    id: int = Field(ge=1, le=255)
    name: str = Field(min_length=1, max_length=30)
    unit: str = Field(default="mm", max_length=10)
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
    """The parameters that a table of an axis may have, beside the keys of `AxisConfig`."""
    return [name for name in {**FIELDS, **MACHINE_PARAMETERS} if configurable(name)]


class TableConfig(ConfigTable):
    """[[table]]: the characteristic of a valve, which drives name by `drive_table_id`; a cam or a
    motion function, which slaves follow."""

    id: int = Field(ge=1, le=HIGHEST_TABLE_ID)
    name: str = Field(default="", max_length=30)
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
        """The fault; raises FaultError."""
        seconds = {
            name: value / 1e9
            for name in ("at", "lasting", "by")
            if (value := getattr(self, name)) is not None
        }
        return STATION_FAULTS.of({"kind": self.kind, **seconds, **(self.model_extra or {})})


class StationConfig(ConfigTable):
    """A whole station."""

    name: str = "achse"
    router: RouterConfig = RouterConfig.model_construct()
    system: SystemConfig = SystemConfig.model_construct()
    secure: SecureConfig = SecureConfig.model_construct()
    mqtt: Sequence[MqttConfig] = ()
    metrics: MetricsConfig = MetricsConfig.model_construct()
    web: WebConfig = WebConfig.model_construct()
    route: Sequence[RouteConfig] = ()
    serial: Sequence[SerialConfig] = ()
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
    scope: ScopeConfig = ScopeConfig.model_construct()
    modbus: ModbusConfig | None = None
    camshaft: Sequence[CamshaftConfig] = Field(default=(), max_length=4)
    limits: LimitsConfig = LimitsConfig.model_construct()

    @model_validator(mode="after")
    def _distinct(self) -> "StationConfig":
        once: dict[str, list[Any]] = {
            "plc.port": [port for plc in self.plc for port in (plc.port, *plc.also)],
            "table.id": [table.id for table in self.table],
            "axis.id": [axis.id for axis in self.axis],
            "channel.id": [channel.id for channel in self.channel],
            "group.id": [group.id for group in self.group],
            "axis.name": [axis.name for axis in self.axis],
            "bus.name": [bus.name for bus in self.bus],
            "bus.interface": [each for bus in self.bus for each in bus.interfaces],
            "serial.port": [serial.port for serial in self.serial],
            "route.name": [route.name for route in self.route],
            "route.net_id": [
                *(str(route.net_id) for route in self.route),
                *(str(serial.net_id) for serial in self.serial if serial.net_id),
            ],
        }
        for what, keys in once.items():
            folded = [key.casefold() if what in _ANY_CASE else key for key in keys]
            times = Counter(folded)
            twice = sorted(
                {str(key) for key, fold in zip(keys, folded, strict=True) if times[fold] > 1}
            )
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
        with without_plugins():
            return StationConfig.model_validate(document)
    except ValidationError as failure:
        lines = [f"{source}: {_told(error)}" for error in failure.errors()]
        raise ConfigError("\n".join(lines)) from None


_EXPECTED = {
    "string_type": "expected a text",
    "bool_type": "expected true or false",
    "bool_parsing": "expected true or false",
    "int_type": "expected a whole number",
    "int_parsing": "expected a whole number",
    "int_from_float": "expected a whole number",
    "float_type": "expected a number",
    "float_parsing": "expected a number",
    "finite_number": "expected a finite number",
    "literal_error": "expected {expected}",
    "greater_than": "expected more than {gt}",
    "greater_than_equal": "expected {ge} or more",
    "less_than": "expected less than {lt}",
    "less_than_equal": "expected {le} or less",
    "too_long": "expected at most {max_length} of them",
    "too_short": "expected at least {min_length} of them",
}
"""Description of a valid value, by the kind of error that pydantic reports."""


def _told(error: "ErrorDetails") -> str:
    """Key, expectation and what came."""
    place = list(error["loc"])
    if place[:1] == ["signal"] and len(place) > 2:
        del place[2]  # the kind, by which pydantic names the table
    expected = error["msg"].removeprefix("Value error, ")
    given = "" if error["type"] == "missing" else f", got {error['input']!r:.80}"
    if error["type"] == "missing":
        expected = "expected, but not there"
    elif error["type"] == "extra_forbidden":
        expected, given = f"no such key{_instead(str(place[-1]), _keys_of(error['loc']))}", ""
    elif error["type"] in _EXPECTED:
        limits = {
            name: int(value) if isinstance(value, float) and value.is_integer() else value
            for name, value in error.get("ctx", {}).items()
        }
        expected = _EXPECTED[error["type"]].format(**limits)
    elif error["type"] in ("model_type", "model_attributes_type", "dict_type"):
        expected = "expected a table"
    elif error["type"] in ("is_instance_of", "tuple_type", "list_type"):
        expected = "expected a list"
        if isinstance(error["input"], dict):  # [axis] where [[axis]] was meant
            names = ".".join(str(part) for part in place if isinstance(part, str))
            expected = f"there may be several: write [[{names}]]"
    elif error["type"].startswith("union_tag"):
        place.append("kind")
        kind = error["input"].get("kind") if isinstance(error["input"], dict) else None
        expected = f"one of {', '.join(SIGNAL_KINDS)}"
        given = "" if kind is None else f", got {kind!r:.80}{did_you_mean(str(kind), SIGNAL_KINDS)}"
    key = ""
    for part in place:
        key += f"[{part + 1}]" if isinstance(part, int) else f"{'.' * bool(key)}{part}"
    if given in expected or not key:
        given = ""
    return f"{key + ': ' * bool(key)}{expected}{given}"


def _instead(key: str, known: list[str]) -> str:
    """Return a hint to the key that may be meant; to all keys where none is near and there are
    few."""
    few = len(known) <= _FEW_KEYS
    return did_you_mean(key, known) or (f"; there are {', '.join(known)}" if few else "")


def _keys_of(place: Sequence[int | str]) -> list[str]:
    """The keys of the table in which an unknown key is."""
    models: list[type[BaseModel]] = [StationConfig]
    for part in place[:-1]:
        if isinstance(part, int):
            continue
        tagged = [model for model in models if _kind_of(model) == part]
        if tagged:
            models = tagged
            continue
        models = [
            inner
            for model in models
            if part in model.model_fields
            for inner in _models_in(model.model_fields[part].annotation)
        ]
    return [key for model in models for key in model.model_fields]


def _kind_of(model: type[BaseModel]) -> str | None:
    """Return the value of `kind` for a model that is one of several."""
    kind = model.model_fields.get("kind")
    return next(iter(get_args(kind.annotation)), None) if kind is not None else None


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """The models that a key's type names."""
    if parts := get_args(annotation):
        return [model for part in parts for model in _models_in(part)]
    is_model = isinstance(annotation, type) and issubclass(annotation, BaseModel)
    return [annotation] if is_model else []


def load(
    path: Path,
    *,
    net_id: str | None = None,
    host: str | None = None,
    interfaces: Mapping[str, str] | None = None,
    redundant: Mapping[str, str] | None = None,
) -> StationConfig:
    """Read a station.toml; `net_id` and `host` replace those in there, `interfaces` and `redundant`
    (the second ones) those of buses by name ("" for the only bus).

    Raises ConfigError; OSError if the file cannot be read.
    """
    try:
        document = parse_toml(path.read_text(encoding="utf-8-sig"))  # editors begin with a mark
    except UnicodeDecodeError as failure:
        raise ConfigError(
            f"{path}: not UTF-8, byte {failure.start + 1} is 0x{failure.object[failure.start]:02X};"
            " save it as UTF-8"
        ) from None
    except ValueError as failure:
        raise ConfigError(f"{path}: no valid TOML: {failure}") from None
    for key, value in (("net_id", net_id), ("host", host)):
        if value is not None and isinstance(document.setdefault("router", {}), dict):
            document["router"][key] = value
    for key, wanted in (("interface", interfaces), ("redundant", redundant)):
        if wanted:
            _put_on_interfaces(document, key, wanted, str(path))
    return parse(document, str(path))


def _put_on_interfaces(
    document: dict[str, Any], key: str, interfaces: Mapping[str, str], source: str
) -> None:
    """Write interfaces into the tables of buses."""
    tables = document.get("bus", [])
    if not isinstance(tables, list) or not all(isinstance(each, dict) for each in tables):
        return  # the file is wrong, and that is told
    names = [str(table.get("name", BusConfig.model_fields["name"].default)) for table in tables]
    told = ", ".join(names) or "none"
    wanted = dict(interfaces)
    if "" in wanted:
        if len(names) != 1:
            raise ConfigError(f"{source}: which bus? Expected BUS=INTERFACE; buses: {told}")
        wanted[names[0]] = wanted.pop("")
    for name in wanted.keys() - set(names):
        raise ConfigError(f"{source}: no bus {name!r}; buses: {told}")
    for name, table in zip(names, tables, strict=True):
        if name in wanted:
            table[key] = wanted[name]
