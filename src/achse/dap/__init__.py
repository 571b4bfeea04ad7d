"""Debug Adapter Protocol: editors step through the Structured Text of a station.

What an editor can do, any ADS client can: the adapter asks the station's debugging service.
"""

from achse.dap.adapter import Adapter
from achse.dap.link import DebugLink, DebugRefused

__all__ = ["Adapter", "DebugLink", "DebugRefused"]
