"""The scope server, AMS port 14000: the vendor's services and a modern face.

Read `device` first. `scopes` are the recordings of one station, `channels` where their values come
from, `files` what is loaded and exported.
"""

from achse.devices.scope.device import ScopeDevice
from achse.devices.scope.scopes import ScopeLimits, ScopeServer

__all__ = ["ScopeDevice", "ScopeLimits", "ScopeServer"]
