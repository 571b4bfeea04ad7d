"""Router, port 1: its figures."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.router import FIGURES, ROUTER_FIGURES, RouterDevice
from achse.router import Router
from achse.router.routes import Route
from achse.server import Device


class Figures:
    def __init__(self, client_of: Callable[..., Any]) -> None:
        self.router = Router(NetId("5.1.2.3.1.1"))
        self.device = RouterDevice(self.router, lambda: [self.device], clock=lambda: 0)
        self.device.attach(self.router, 1)
        self.client = client_of(self.router, 1)
        self._offsets = {row.name: row.offset for row in ROUTER_FIGURES}

    def read(self, name: str) -> bytes:
        return bytes(self.client.read(FIGURES, self._offsets[name], 0xFFFF))

    def number(self, name: str) -> int:
        return int(struct.unpack("<I", self.read(name))[0])


@pytest.fixture
def figures(client_of: Callable[..., Any]) -> Figures:
    return Figures(client_of)


def test_net_id_and_ports(figures: Figures) -> None:
    assert figures.read("net_id") == bytes([5, 1, 2, 3, 1, 1])
    assert figures.read("ports") == struct.pack("<HH", 1, 32768)


def test_routes_clients_and_lost_frames(figures: Figures) -> None:
    assert [figures.number(name) for name in ("routes", "clients", "lost_frames")] == [0, 0, 0]
    figures.router.routes.add(Route(name="a", net_id=NetId("5.9.9.9.1.1"), host="h"))
    figures.router.learn(b"12345678", figures.client)
    figures.router.lost_frames = 3
    assert [figures.number(name) for name in ("routes", "clients", "lost_frames")] == [1, 1, 3]


def test_memory_follows_the_rule_of_the_manual(figures: Figures) -> None:
    """1 kB for a small notification, the packet size for a large one, 700 kB in any case."""
    assert (figures.number("notifications"), figures.number("memory")) == (0, 700)
    figures.client.subscribe(FIGURES, 7, 4)
    figures.client.subscribe(FIGURES, 7, 2048)
    assert (figures.number("notifications"), figures.number("memory")) == (2, 704)


def test_every_device_has_its_sizes(figures: Figures) -> None:
    assert isinstance(figures.device, Device)
    figures.client.subscribe(FIGURES, 1, 6)
    assert figures.device.sample_sizes() == [6]
