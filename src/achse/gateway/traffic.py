"""Traffic of a gateway: taps at AMS port 26000, where a station has them too."""

from collections.abc import Callable

from achse.ams import Endpoint
from achse.devices.taps import TapService
from achse.router import Router
from achse.router.tap import Taps
from achse.server import Device


class TrafficDevice(Device):
    """Taps of `router`; requests for AMS port `port`, where the device is, are left out."""

    def __init__(self, router: Router, port: int, *, clock: Callable[[], int]) -> None:
        self._taps = TapService(Taps(router, clock, spared=port), lambda: self.request_way)
        super().__init__("achse router", (0, 1, 0), (self._taps.group,), clock=clock)

    def end_client(self, client: bytes) -> None:
        """Close what a client left open."""
        self._taps.end_client(client)
        super().end_client(client)

    def end_way(self, way: Endpoint) -> None:
        """Close what was opened over a connection that is gone."""
        self._taps.end_way(way)
        super().end_way(way)

    def _clients(self) -> set[bytes]:
        return super()._clients() | self._taps.clients
