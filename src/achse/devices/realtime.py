"""Real-time settings, AMS port 200: the processor of the cycle, and how late cycles began.

Source: public clients of the vendor.
"""

import os
from collections.abc import Callable
from typing import Protocol

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server import READ, READ_WRITE, Device, Group, Layout, Service

REALTIME_PORT = 200

_GROUP = 1
_MOST = 0xFFFF_FFFF
_LATENCY = Layout("<III")
_SETTINGS = Layout("<IIQIIII")


class CycleTimes(Protocol):
    """Lateness of the station's cycle, ns of wall time."""

    behind_ns: float
    """Lateness of the present tick, ns."""
    latest_ns: float
    """Largest lateness of a tick since the last reset, ns."""

    @property
    def tick_ns(self) -> float: ...


class RealtimeDevice(Device):
    """Times of the cycle that `times()` gives; None in virtual time, where nothing is late."""

    def __init__(self, times: Callable[[], CycleTimes | None], *, clock: Callable[[], int]) -> None:
        self._times = times
        super().__init__("achse Realtime", (3, 1, 4024), [Group(_GROUP, _ROWS, self)], clock=clock)

    def latency(self) -> tuple[int, int, int]:
        """Present and largest lateness, and that from which a tick is late, µs."""
        times = self._times()
        if times is None:
            return 0, 0, 0
        figures = (times.behind_ns, times.latest_ns, times.tick_ns)
        present, largest, limit = (min(round(each / 1000), _MOST) for each in figures)
        return present, largest, limit

    def reset(self) -> tuple[int, int, int]:
        """Return the lateness and forget the largest."""
        latency = self.latency()
        times = self._times()
        if times is not None:
            times.latest_ns = 0.0
        return latency


def _of_processor(
    figures: Callable[[RealtimeDevice], tuple[int, int, int]],
) -> Callable[[RealtimeDevice, int], tuple[int, int, int]]:
    def exchange(device: RealtimeDevice, processor: int) -> tuple[int, int, int]:
        if processor != 0:
            raise DeviceError(ReturnCode.INVALID_DATA, f"expected processor 0, got {processor}")
        return figures(device)

    return exchange


def _settings(device: RealtimeDevice) -> tuple[int, ...]:
    return os.cpu_count() or 1, 0, 1, 1, 0, 0, 0


_U32 = Layout("<I")
_ROWS = (
    Service(
        0x2,
        "latency",
        READ_WRITE,
        _U32,
        "Number of the processor, 0; answers present and largest lateness, and that of late ticks",
        "µs",
        exchange=_of_processor(RealtimeDevice.latency),
        response=_LATENCY,
    ),
    Service(
        0x2,
        "latency_of_cycle",
        READ,
        _LATENCY,
        "Present and largest lateness of the cycle, and that of late ticks",
        "µs",
        read=RealtimeDevice.latency,
    ),
    Service(
        0xB,
        "reset_latency",
        READ_WRITE,
        _U32,
        "Answers the lateness as offset 2 and forgets the largest",
        "µs",
        exchange=_of_processor(RealtimeDevice.reset),
        response=_LATENCY,
    ),
    Service(
        0xD,
        "processors",
        READ,
        _SETTINGS,
        "Shared and isolated processors, mask of the cycle's, their number, type, family, MHz"
        " (0: not known)",
        read=_settings,
    ),
)
