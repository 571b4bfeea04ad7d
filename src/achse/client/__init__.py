"""The client: asks ADS devices, ours and real ones.

`connect` gives a `Client`; `achse.client.blocking` has the same without asyncio. Read `links` (the
way to a router), `session` (requests, bytes, symbols), `target` (a device with values by name) and
then `nc` (axes, tables).
"""

from achse.client.client import Client, Connecting, connect
from achse.client.links.secure_link import SecureTarget
from achse.client.session.raw import DeviceInfo, DeviceState
from achse.client.session.session import Backoff
from achse.client.session.subscription import Sample, Subscription
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
