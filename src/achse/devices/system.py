"""System service, port 10000: what a client asks first to learn whether a target is alive.

Source: 003; the state block as recorded from real targets.
"""

from collections.abc import Callable

from achse.ams import AdsState
from achse.server import READ, Device, Group, Layout, Service

__all__ = ["SystemDevice"]

_STATE_BLOCK = Layout("<HHHBBHBBH2x")


class SystemDevice(Device):
    """The system service: state, version and restart index of the whole station."""

    def __init__(self, *, clock: Callable[[], int]) -> None:
        self.restart_index = 0
        """Counts restarts of the station, so that clients notice one."""
        super().__init__(
            "TwinCAT System",
            (3, 1, 4024),
            [Group(0xF0, _STATE_SERVICES, self)],
            clock=clock,
            ads_state=AdsState.RUN,
            device_state=1,
        )


def _state_block(device: SystemDevice) -> tuple[int, ...]:
    platform, os_type, flags = 1, 0, 0
    return (
        device.ads_state,
        device.device_state,
        device.restart_index & 0xFFFF,
        *device.version,
        platform,
        os_type,
        flags,
    )


_STATE_SERVICES = (
    Service(
        0,
        "system_state",
        READ,
        _STATE_BLOCK,
        "ADS state, device state, restart index, version, revision, build, platform, OS, flags",
        read=_state_block,
    ),
)
