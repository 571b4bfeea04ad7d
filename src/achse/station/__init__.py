"""The composition root: configuration, clock, cycle and links of one station."""

from achse.station.configuration.station_file import ConfigError, StationConfig
from achse.station.station import RunningStation, Station

__all__ = ["ConfigError", "RunningStation", "Station", "StationConfig"]
