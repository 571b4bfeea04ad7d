"""The client: asks ADS devices, ours and real ones.

`connect` gives a `Client`; `achse.client.blocking` has the same without asyncio.
"""

from achse.client.client import Client, Connecting, connect
from achse.client.raw import DeviceInfo, DeviceState
from achse.client.secure_link import SecureTarget
from achse.client.session import Backoff
from achse.client.subscription import Sample, Subscription
from achse.client.target import MethodResult, Target
from achse.client.typed import Symbol

__all__ = [
    "Backoff",
    "Client",
    "Connecting",
    "DeviceInfo",
    "DeviceState",
    "MethodResult",
    "Sample",
    "SecureTarget",
    "Subscription",
    "Symbol",
    "Target",
    "connect",
]
