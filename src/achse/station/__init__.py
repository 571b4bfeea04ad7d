"""The composition root: a station from its configuration, its cycle, and its life on a network.

Read `station` first, the public face. Below it, from above to below: `running` (states, real time
and figures), `building` (all parts from the configuration), `slaves` (drives in a process of their
own), `buses`, `plcs`, `routes`, `persistence`, `clocks` (the cycle and its pace) and
`configuration` (the keys of a station.toml). `demo` is the PLC program of the demo station.
Names are loaded when they are first used: a router without devices uses `routes` and
`configuration` alone.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from achse.station.configuration.station_file import StationConfig as StationConfig
    from achse.station.configuration.types import ConfigError as ConfigError
    from achse.station.running.operation import RunningStation as RunningStation
    from achse.station.station import Station as Station

__all__ = ["ConfigError", "RunningStation", "Station", "StationConfig"]

_MODULES = {
    "ConfigError": "configuration.types",
    "RunningStation": "running.operation",
    "Station": "station",
    "StationConfig": "configuration.station_file",
}
"""Module of each name, below this package."""


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value
