"""The composition root: a station from its configuration, its cycle, and its life on a network.

Read `station` first, the public face. Below it, from above to below: `running` (states, real time
and figures), `building` (all parts from the configuration), `slaves` (drives in a process of their
own), `buses`, `plcs`, `routes`, `persistence`, `clocks` (the cycle and its pace) and
`configuration` (the keys of a station.toml). `demo` is the PLC program of the demo station.
"""

from achse.station.configuration.station_file import StationConfig
from achse.station.configuration.types import ConfigError
from achse.station.running.operation import RunningStation
from achse.station.station import Station

__all__ = ["ConfigError", "RunningStation", "Station", "StationConfig"]
