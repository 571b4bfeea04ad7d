"""The scope server, AMS port 14000: the vendor's services and a modern face."""

from achse.devices.scope.device import ScopeDevice
from achse.devices.scope.scopes import ScopeLimits, ScopeServer

__all__ = ["ScopeDevice", "ScopeLimits", "ScopeServer"]
