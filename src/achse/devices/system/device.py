"""System service, port 10000: the first query of a client, to learn if a target is alive.

Source: 003; 000 §5.1 for files and shutdown; state block, routes and target description as recorded
from real targets.
"""

import asyncio
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from achse.ams import AdsState, DeviceError
from achse.codes import ReturnCode
from achse.devices.system.diagnosis import Diagnosis
from achse.devices.system.file_worker import FileWorker
from achse.devices.system.files import Files
from achse.devices.system.folder import Folder
from achse.devices.system.processes import Processes
from achse.devices.system.registry import Registry
from achse.devices.system.routes import RouteServices
from achse.devices.system.target import TargetDescription
from achse.devices.system.time_service import TimeService
from achse.router.routes import RouteTable
from achse.server import READ, Device, Group, Layout, RawGroup, Service

VERSION = (3, 1, 4024)
"""Version, revision and build that the station claims."""

_STATE_BLOCK = Layout("<HHHBBHBBH2x")
_LONGEST_DELAY = 7 * 24 * 3600
"""Seconds; a shutdown further away is a mistake."""

_REFUSED = {
    110: "create file",
    112: "flush",
    113: "device names",
    128: "scan file",
    129: "print to file",
    300: "send mail",
    600: "change NetId",
    701: "IP helper",
    702: "IP host name",
    808: "enable route",
    1200: "cores",
}
"""Index groups of the system service that reach into an operating system: not on this station."""


class StationControl(Protocol):
    """Commands of the system service to the station. All take effect after the answer."""

    def restart(self) -> None: ...

    def configure(self) -> None: ...

    def shut_down(self, delay_s: float, restart: bool) -> None: ...


class SystemDevice(Device):
    """The system service: state, version and restart index of the whole station.

    `control` obeys Write Control; without it every state is refused. `root` is the folder that the
    file services show; `routes` what the route services list, and change if `routes_writable`;
    `programs` are those that clients may start.
    """

    def __init__(
        self,
        *,
        clock: Callable[[], int],
        control: StationControl | None = None,
        root: Path | None = None,
        routes: RouteTable | None = None,
        routes_writable: bool = False,
        programs: Sequence[str] = (),
        name: str = "achse",
    ) -> None:
        self.restart_index = 0
        """Counts restarts of the station, so that clients notice one."""
        self.control = control
        self.files = Files(None if root is None else Folder(root), clock)
        self._processes = Processes(programs, self.files.beside)
        table = RouteTable() if routes is None else routes
        super().__init__(
            "TwinCAT System",
            VERSION,
            [
                Group(0xF0, _STATE_SERVICES, self),
                *self.files.groups(),
                *TargetDescription(name, self).groups(),
                *TimeService(clock).groups(),
                *Diagnosis(name, self, table, VERSION, clock).groups(),
                *RouteServices(table, clock, writable=routes_writable).groups(),
                *Registry().groups(),
                *self._processes.groups(),
                *(_refused(*item) for item in _REFUSED.items()),
            ],
            clock=clock,
            ads_state=AdsState.RUN,
            device_state=1,
        )

    def write_control(self, ads_state: int, device_state: int, data: bytes) -> None:
        """Restart in RUN (RESET), go to CONFIG (RECONFIG, CONFIG) or end the station (SHUTDOWN).

        SHUTDOWN takes a delay in seconds as four bytes; device state 1 restarts instead.
        """
        control = self.control
        if control is not None and ads_state == AdsState.RESET:
            control.restart()
        elif control is not None and ads_state in (AdsState.RECONFIG, AdsState.CONFIG):
            control.configure()
        elif control is not None and ads_state == AdsState.SHUTDOWN:
            if len(data) not in (0, 4):
                raise DeviceError(ReturnCode.INVALID_SIZE, f"delay of {len(data)} bytes")
            delay = int.from_bytes(data, "little")
            if device_state not in (0, 1) or delay > _LONGEST_DELAY:
                raise DeviceError(ReturnCode.INVALID_DATA, f"shutdown {device_state} in {delay} s")
            control.shut_down(delay, restart=device_state == 1)
        else:
            super().write_control(ads_state, device_state, data)

    @contextmanager
    def files_beside(self, loop: asyncio.AbstractEventLoop) -> Iterator[None]:
        """Let a thread do the disk accesses of file services, while `loop` serves clients."""
        if self.files.worker is not None:  # another listener has one already
            yield
            return
        worker = self.files.worker = FileWorker(loop)
        try:
            yield
        finally:
            self.files.worker = None
            worker.stop()

    def sweep(self, now_ns: int) -> None:
        """Drop clients that are gone, and close unused files."""
        super().sweep(now_ns)
        self.files.sweep(now_ns)
        self._processes.sweep()

    def end_client(self, client: bytes) -> None:
        """Drop what belongs to a client that is gone, its files too."""
        super().end_client(client)
        self.files.end_client(client)

    def _clients(self) -> set[bytes]:
        return super()._clients() | self.files.clients


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


def _refused(index_group: int, name: str) -> RawGroup:
    def refuse(*_: object) -> bytes:
        raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, name)

    def refuse_write(*_: object) -> None:
        refuse()

    return RawGroup(
        index_group,
        name,
        read=refuse,
        write=refuse_write,
        read_write=refuse,
        last_offset=0xFFFF_FFFF,
        description="Not on this station: 0x701.",
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
