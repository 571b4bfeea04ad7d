"""fleet.toml: many stations of one template, what is different of some, the broker they join."""

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from achse.ams import NetId
from achse.ams.host_port import host_and_port
from achse.fleet.lines import line_of
from achse.iec.nearest import did_you_mean
from achse.station import Station
from achse.station.configuration.documents import parse_toml
from achse.station.configuration.mqtt import MqttConfig
from achse.station.configuration.station_file import StationConfig, parse
from achse.station.configuration.types import ConfigError, ConfigTable, ConfiguredNetId, DurationNs

MOST_STATIONS = 10_000

_FILES = ("ca", "certificate", "key")
"""Keys of [mqtt.tls] that name files."""

_WRITTEN = (("system", "persistent_data"), ("router", "static_routes"))
"""Files that a station writes."""

_PORTS = (("router", "tcp_port"), ("router", "udp_port"), ("secure", "port"), ("metrics", "port"))

Numbers = Annotated[str, Field(pattern=r"^\d{1,5}(-\d{1,5})?$")] | int


_Made = TypeVar("_Made")


class OverrideConfig(BaseModel):
    """[[station]]: what is different of some stations. Further keys are those of station.toml."""

    model_config = ConfigDict(
        extra="allow", frozen=True, arbitrary_types_allowed=True, defer_build=True
    )

    number: Numbers
    """Number of the station, 1 and up, or several: `"3-7"`."""
    name: str | None = Field(default=None, min_length=1, max_length=63)
    net_id: ConfiguredNetId | None = None
    speed: Annotated[FiniteFloat, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _single(self) -> "OverrideConfig":
        if len(self.numbers) != 1 and (self.name is not None or self.net_id is not None):
            raise ValueError("name and net_id are those of one station")
        return self

    @property
    def numbers(self) -> range:
        first, _, last = str(self.number).partition("-")
        return range(int(first), int(last or first) + 1)


class FleetConfig(ConfigTable):
    """A whole fleet.toml."""

    name: str = Field(default="fleet", pattern=r"^[a-z]([a-z0-9-]{0,40}[a-z0-9])?$")
    """Small letters, digits and `-`. Station 3 of `press` is called `press-3`."""
    template: str = Field(min_length=1)
    """A station.toml (relative to the fleet.toml). In its texts `{name}` and `{number}` are those
    of the station; its TCP, UDP and metrics ports count up by station."""
    count: int = Field(ge=1, le=MOST_STATIONS)
    net_id: ConfiguredNetId
    """Of station 1; the first four numbers count up."""
    speed: FiniteFloat = Field(default=1.0, gt=0)
    """Station time per wall-clock time."""
    stations_per_process: int = Field(default=1, ge=1, le=1000)
    """A process more costs about 60 MB, a station more in a process about 5 MB."""
    cores: Literal["all", "none"] | Sequence[Annotated[int, Field(ge=0)]] = "all"
    """Processes are pinned to these in turn (Linux); `none`: not at all."""
    restarts: int = Field(default=5, ge=0, le=1000)
    """So often within `restart_window` a process that ended is started again; then no more."""
    restart_window: DurationNs = 60_000_000_000
    log_level: Literal["debug", "info", "warning", "error"] = "warning"
    mqtt: MqttConfig
    """The broker and the network that all stations join; keys as in station.toml."""
    station: Sequence[OverrideConfig] = ()

    @model_validator(mode="after")
    def _can_be(self) -> "FleetConfig":
        if self.mqtt.file is not None:
            raise ValueError("mqtt: expected broker and topic; a file is for one station")
        if self.mqtt.client_id and "{n" not in self.mqtt.client_id and self.count > 1:
            raise ValueError('mqtt.client_id: each station needs its own: "{name}"')
        if not isinstance(self.cores, str) and not self.cores:
            raise ValueError('cores: expected "all", "none" or a list of numbers')
        return self


@dataclass(frozen=True, slots=True)
class FleetStation:
    """One station of a fleet."""

    number: int
    """1 and up."""
    name: str
    net_id: NetId
    speed: float
    overrides: tuple[int, ...] = ()
    """Places of the [[station]] tables that change it."""


@dataclass(frozen=True)
class FleetPlan:
    """A fleet.toml that was read: its stations and their configurations."""

    file: Path
    config: FleetConfig
    stations: tuple[FleetStation, ...]
    _text: str = field(repr=False)
    _mqtt: Mapping[str, Any] = field(repr=False)
    _template: Mapping[str, Any] = field(repr=False)

    @classmethod
    def load(cls, path: str | Path, *, broker: str | None = None) -> "FleetPlan":
        """Read a fleet.toml and its template; `broker`, `host` or `host:port`, replaces its own.

        Raises ConfigError with file and line; OSError if the fleet.toml cannot be read.
        """
        file = Path(path)
        text = _read(file)
        document = _document(file, text)
        if broker is not None and isinstance(mqtt := document.get("mqtt"), dict):
            mqtt["broker"], mqtt["port"] = _broker(broker)
        try:
            config = FleetConfig.model_validate(document)
        except ValidationError as failure:
            errors = [_error_text(file, text, document, fault) for fault in failure.errors()]
            raise ConfigError("\n".join(errors)) from None
        template = file.parent / config.template
        try:
            station = _document(template, _read(template))
        except OSError as failure:
            where = _at(file, text, ("template",))
            raise ConfigError(f"{where}template: {template}: {failure.strerror}") from None
        plan = cls(file, config, (), text, document["mqtt"], station)
        plan = replace(plan, stations=tuple(plan._stations()))
        plan._check_names()
        return plan

    @property
    def name(self) -> str:
        return self.config.name

    @property
    def base(self) -> Path:
        """The folder that files of a station are relative to."""
        return (self.file.parent / self.config.template).parent

    @property
    def template(self) -> Path:
        return self.file.parent / self.config.template

    def line(self, *place: str | int) -> str:
        """`fleet.toml:7: `: where a key is."""
        return _at(self.file, self._text, place)

    def station(self, number: int) -> FleetStation:
        """Station `number`; raises ConfigError."""
        if not 1 <= number <= len(self.stations):
            raise ConfigError(f"{self.name} has stations 1 … {len(self.stations)}, not {number}")
        return self.stations[number - 1]

    def groups(self) -> list[tuple[FleetStation, ...]]:
        """Stations by process."""
        size = self.config.stations_per_process
        return [self.stations[at : at + size] for at in range(0, len(self.stations), size)]

    def station_config(self, number: int, *, alone: bool = False) -> StationConfig:
        """Return the configuration of station `number`, checked. Raises ConfigError.

        `alone` on its computer, as in a container, it has the ports of the template.
        """
        return self._attempt(self.station(number), alone, parse)

    def _attempt(
        self, station: FleetStation, alone: bool, make: Callable[[dict[str, Any], str], _Made]
    ) -> _Made:
        """Return the result of `make` for the document of a station.

        If `make` fails, its ConfigError names the first [[station]] with which it failed, or the
        template.
        """
        places = station.overrides
        try:
            return make(self._document(station, places, alone), "")
        except ConfigError:
            pass
        where = f"{self.template}, station {station.number}"
        for count in range(len(places) + 1):
            if count:
                where = f"{self.line('station', places[count - 1])}station {station.number}"
            try:
                make(self._document(station, places[:count], alone), where)
            except ConfigError:
                break
        return make(self._document(station, places, alone), where)

    def _document(
        self, station: FleetStation, places: Sequence[int], alone: bool
    ) -> dict[str, Any]:
        """Return its station.toml, with the overrides of `places`."""
        document = deepcopy(dict(self._template))
        for place in places:
            _merge(document, deepcopy(self.config.station[place].model_extra or {}))
        mqtt = deepcopy(dict(self._mqtt))
        for key in _FILES:
            if isinstance(tls := mqtt.get("tls"), dict) and isinstance(tls.get(key), str):
                tls[key] = str((self.file.parent / tls[key]).resolve())
        document = dict(_filled(document | {"mqtt": [mqtt]}, station))
        router, secure = document.setdefault("router", {}), document.setdefault("secure", {})
        if isinstance(router, dict) and isinstance(secure, dict):
            router["net_id"] = str(station.net_id)
            secure.setdefault("folder", f"certificates/{station.name}")
            if not alone:
                router.setdefault("tcp_port", 0)
                _count_up(document, station.number)
        return document | {"name": station.name}

    def _stations(self) -> Iterator[FleetStation]:
        config = self.config
        overrides: dict[int, list[int]] = {}
        for place, override in enumerate(config.station):
            numbers = override.numbers
            if not numbers or numbers[0] < 1 or numbers[-1] > config.count:
                raise ConfigError(
                    f"{self.line('station', place, 'number')}station[{place + 1}].number: expected"
                    f" 1 … {config.count}, or several, from-to; got {override.number}"
                )
            for number in numbers:
                overrides.setdefault(number, []).append(place)
        first = int.from_bytes(bytes(config.net_id)[:4], "big")
        if first + config.count > 1 << 32:
            raise ConfigError(
                f"{self.line('net_id')}net_id: there are not {config.count} NetIds from"
                f" {config.net_id} on"
            )
        for number in range(1, config.count + 1):
            net_id = NetId((first + number - 1).to_bytes(4, "big") + bytes(config.net_id)[4:])
            name, speed = f"{config.name}-{number}", config.speed
            places = tuple(overrides.get(number, ()))
            for override in (config.station[place] for place in places):
                name = override.name or name
                net_id = override.net_id or net_id
                speed = override.speed or speed
            yield FleetStation(number, name, net_id, speed, places)

    def _check_names(self) -> None:
        for what in ("name", "net_id"):
            seen: dict[str, int] = {}
            for station in self.stations:
                key = str(getattr(station, what)).casefold()
                if key in seen:
                    places = (*self.stations[seen[key] - 1].overrides, *station.overrides)
                    said = [at for at in places if getattr(self.config.station[at], what)]
                    where = self.line("station", said[-1], what) if said else self.line(what)
                    raise ConfigError(
                        f"{where}{what}: each once, stations {seen[key]} and {station.number}"
                        f" have {key}"
                    )
                seen[key] = station.number

    def check(self) -> None:
        """Put some stations together: those as the template has them, and each that is different.

        Raises ConfigError for what a station would not start with.
        """
        alike = [station.number for station in self.stations if not station.overrides]
        looked_at = {station.number for station in self.stations if station.overrides}
        looked_at |= {*alike[:2], *alike[-1:]}
        files: dict[str, int] = {}
        for number in sorted(looked_at):
            config = self.station_config(number)
            for table, key in _WRITTEN:
                written = getattr(getattr(config, table), key)
                other = files.setdefault(f"{table}.{key}: {written}", number)
                if written is not None and other != number:
                    raise ConfigError(
                        f"{self.template}: {table}.{key}: stations {other} and {number} would write"
                        f" the same file {written!r}; put {{name}} into it"
                    )
            self._attempt(self.station(number), False, self._put_together)

    def _put_together(self, document: dict[str, Any], where: str) -> Station:
        config = parse(document, where)
        try:
            return Station(config, base=self.base)
        except ConfigError as fault:
            raise ConfigError(f"{where}: {fault}") from fault


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as failure:
        raise ConfigError(f"{file}: not UTF-8, byte {failure.start + 1}") from None


def _document(file: Path, text: str) -> dict[str, Any]:
    try:
        return parse_toml(text)
    except tomllib.TOMLDecodeError as failure:
        said, at, where = str(failure).partition(" (at line ")
        line = f":{where.partition(',')[0]}" if at and where[:1].isdigit() else ""
        raise ConfigError(f"{file}{line}: no valid TOML: {said}") from None
    except ValueError as failure:
        raise ConfigError(f"{file}: no valid TOML: {failure}") from None


def _at(file: Path, text: str, place: Sequence[str | int]) -> str:
    """`file:line: `; of what is not there the line of the table in which it would be."""
    for length in range(len(place), 0, -1):
        if line := line_of(text, place[:length]):
            return f"{file}:{line}: "
    return f"{file}: "


def _error_text(file: Path, text: str, document: Mapping[str, Any], fault: Any) -> str:
    """Line, key, expectation and what came."""
    place: list[str | int] = []
    inside: Any = document
    for part in fault["loc"]:  # it names kinds of unions too, which are not in the file
        try:
            inside = inside[part]
        except (KeyError, IndexError, TypeError):
            if fault["type"] == "missing":
                place.append(part)
            break
        place.append(part)
    key = ""
    for part in place:
        key += f"[{part + 1}]" if isinstance(part, int) else f"{'.' * bool(key)}{part}"
    expected = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "missing":
        expected = "expected, but not there"
    elif fault["type"] == "extra_forbidden":
        known = [*FleetConfig.model_fields] if len(place) == 1 else [*MqttConfig.model_fields]
        near = did_you_mean(str(place[-1]), known)
        expected = f"no such key{near or '; there are ' + ', '.join(known)}"
    elif not isinstance(fault["input"], dict | list):
        expected += f", got {fault['input']!r:.80}"
    return f"{_at(file, text, place)}{key + ': ' * bool(key)}{expected}"


def _broker(text: str) -> tuple[str, int]:
    try:
        return host_and_port(text, 0)
    except ValueError:
        raise ConfigError(f"a broker is host or host:port, got {text!r:.80}") from None


def _merge(document: dict[str, Any], changes: Mapping[str, Any]) -> None:
    """Merge tables, and lists of tables by `id`; all else replaces what is there."""
    for key, value in changes.items():
        there = document.get(key)
        if isinstance(there, dict) and isinstance(value, dict):
            _merge(there, value)
        elif there is not None and _with_ids(there) and _with_ids(value):
            for entry in value:
                same = [each for each in there if each["id"] == entry["id"]]
                if same:
                    _merge(same[0], entry)
                else:
                    there.append(entry)
        else:
            document[key] = value


def _with_ids(value: Any) -> Any:
    return isinstance(value, list) and all(isinstance(row, dict) and "id" in row for row in value)


def _filled(value: Any, station: FleetStation) -> Any:
    """With `{name}` and `{number}` in its texts replaced."""
    if isinstance(value, dict):
        return {key: _filled(inner, station) for key, inner in value.items()}
    if isinstance(value, list):
        return [_filled(inner, station) for inner in value]
    if isinstance(value, str):
        return value.replace("{name}", station.name).replace("{number}", str(station.number))
    return value


def _count_up(document: Mapping[str, Any], number: int) -> None:
    """Count the ports up: each station on this computer has ports of its own; 0 takes free ones."""
    for table, key in _PORTS:
        there = document.get(table)
        if isinstance(there, dict) and isinstance(there.get(key), int) and there[key] > 0:
            there[key] += number - 1
