"""achse: a motion station in Python, speaking ADS/AMS as the real ones do.

`achse.connect` opens a client, `achse.blocking` is the same without asyncio, `achse.Station` is a
station. Names are loaded when they are first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from achse.client import blocking as blocking
    from achse.client import connect as connect
    from achse.station import Station as Station

__version__ = "0.1.0"

__all__ = ["Station", "blocking", "connect"]

_HOMES = {
    "Station": ("achse.station", "Station"),
    "blocking": ("achse.client.blocking", ""),
    "connect": ("achse.client", "connect"),
}
"""Where each name lives: module, and attribute or nothing for the module itself."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home, attribute = _HOMES[name]
    module = import_module(home)
    value = getattr(module, attribute) if attribute else module
    globals()[name] = value
    return value
