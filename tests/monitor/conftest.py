"""Traffic of a client with the demo station, captured in virtual time."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.router.tap import Captured, Taps
from achse.station import Station


class Traffic:
    """A station with a tap, and a clock of its own that goes on 1 ms with each packet."""

    def __init__(self, client_of: Any) -> None:
        self.station = Station.demo()
        self.now = 1_000_000_000_000_000_000
        self.tap = Taps(self.station.router, self._tick).open()
        self.plc = client_of(self.station.router, 851)
        self.nc = client_of(self.station.router, 501)

    def _tick(self) -> int:
        self.now += 1_000_000
        return self.now

    def captures(self) -> list[Captured]:
        """What passed since the last call."""
        return self.tap.take(1 << 30)

    def handle(self, name: str) -> int:
        """A handle for a symbol of the PLC."""
        data = self.plc.exchange(0xF003, 0, 4, name.encode() + b"\0")
        return int.from_bytes(data, "little")


@pytest.fixture
def traffic(client_of: Any) -> Traffic:
    return Traffic(client_of)


@pytest.fixture
def make_traffic(client_of: Any) -> Callable[[], Traffic]:
    return lambda: Traffic(client_of)
