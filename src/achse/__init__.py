"""achse: a motion station in Python, speaking ADS/AMS as the real ones do.

`achse.connect` opens a client, `achse.blocking` is the same without asyncio, `achse.Station` is a
station. Names are loaded when they are first used.
"""

TYPE_CHECKING = False  # that of typing; the command line imports little before it minds Ctrl-C
if TYPE_CHECKING:
    from typing import Any

    from achse import plot as plot
    from achse.client import blocking as blocking
    from achse.client import connect as connect
    from achse.station import Station as Station
    from achse.sweeps import sweep as sweep

__version__ = "0.1.0"

__all__ = ["Station", "blocking", "connect", "plot", "sweep"]

_HOMES = {
    "Station": ("achse.station", "Station"),
    "blocking": ("achse.client.blocking", ""),
    "connect": ("achse.client", "connect"),
    "plot": ("achse.plot", ""),
    "sweep": ("achse.sweeps", "sweep"),
}
"""Module of each name, and its attribute there; without one the module itself."""


def __getattr__(name: str) -> "Any":
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    home, attribute = _HOMES[name]
    module = import_module(home)
    value = getattr(module, attribute) if attribute else module
    globals()[name] = value
    return value
