"""Router (port 1): what it carries, and the memory that a router of the real kind would need.

Source: 002 §3 for the port; 000 §6.4 for the rule. The services are our own.
"""

from collections.abc import Callable, Iterable, Sequence

from achse.router import Router
from achse.router.memory import notification_packet, router_memory_kb
from achse.server import BYTES, READ, Device, Group, IndexGroup, Layout, Service

FIGURES = 1
"""Index group of the figures."""

_U32 = Layout("<I")


class RouterDevice(Device):
    """Figures of a router; `devices()` gives all devices whose notifications count.

    `further` are index groups of a router that has more to say.
    """

    def __init__(
        self,
        router: Router,
        devices: Callable[[], Iterable[Device]],
        *,
        clock: Callable[[], int],
        further: Sequence[IndexGroup] = (),
    ) -> None:
        self.router = router
        self._devices = devices
        super().__init__(
            "TwinCAT Router",
            (3, 1, 4024),
            [Group(FIGURES, ROUTER_FIGURES, self), *further],
            clock=clock,
        )

    def sample_sizes(self) -> Sequence[int]:
        """Return bytes of a sample of each notification of this station."""
        return [size for device in self._devices() for size in device.notifications.sample_sizes]


def _ports(device: RouterDevice) -> bytes:
    return b"".join(port.to_bytes(2, "little") for port in device.router.ports)


def _memory(device: RouterDevice) -> int:
    return router_memory_kb(map(notification_packet, device.sample_sizes()))


ROUTER_FIGURES = (
    Service(1, "net_id", READ, BYTES, "NetId, 6 bytes", read=lambda d: bytes(d.router.net_id)),
    Service(2, "ports", READ, BYTES, "Ports in use, UINT each, ascending", read=_ports),
    Service(3, "routes", READ, _U32, "Routes in the table", read=lambda d: len(d.router.routes)),
    Service(4, "clients", READ, _U32, "Clients known elsewhere", read=lambda d: d.router.clients),
    Service(
        5,
        "lost_frames",
        READ,
        _U32,
        "Answers and samples without a receiver",
        read=lambda d: d.router.lost_frames & 0xFFFF_FFFF,
    ),
    Service(
        6,
        "notifications",
        READ,
        _U32,
        "Notifications of all devices",
        read=lambda d: len(d.sample_sizes()),
    ),
    Service(
        7,
        "memory",
        READ,
        _U32,
        "What a router of the real kind needs for them: 1 kB or the packet size each, 500 kB"
        " message buffer, 200 kB administration",
        "kB",
        read=_memory,
        source="000 §6.4",
    ),
)
