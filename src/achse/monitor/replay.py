"""A recording served again as a target: devices that answer as the recorded ones did."""

import asyncio
import contextlib
import logging
import time
from collections.abc import AsyncIterator, Callable

from achse.ams import AdsState, Command, DeviceError
from achse.client.session.sums import Outcome
from achse.codes import ReservedGroup, ReturnCode
from achse.codes.groups import NAMED, SUMS
from achse.monitor.recording import (
    Key,
    RecordedDevice,
    Recording,
    symbol_name,
)
from achse.router import Router
from achse.server import Device, IndexGroup
from achse.server.table import Reader
from achse.transport.tcp.listener import TCP_PORT, TcpListener

log = logging.getLogger("achse.replay")

_TICK = 0.005
"""Seconds between two checks for samples that are due."""

_GRID_NS = 1_000_000


class Replay:
    """The target of a recording on a router of its own: `async with Replay(recording).serving()`.

    - A repeated request gets the recorded answers in their order, then the last one again.
    - A subscription gets the recorded samples, as long after it as they came then.
    - A request that is not in the recording is answered 0x701 and logged once.

    `clock` gives Unix ns; without one it is the time of day at the start, and what went by since.
    """

    def __init__(self, recording: Recording, clock: Callable[[], int] | None = None) -> None:
        self.router = Router(recording.net_id)
        if clock is None:
            began = time.time_ns() - time.monotonic_ns()
            clock = _from(began)
        self._clock = clock
        self.devices = [ReplayDevice(device, clock) for device in recording.devices.values()]
        for device in self.devices:
            device.attach(self.router, device.recorded.port)

    def tick(self) -> None:
        """Send the samples that are due."""
        now = self._clock()
        for device in self.devices:
            device.notifications.tick(now)
            device.sweep(now)

    @contextlib.asynccontextmanager
    async def serving(
        self, host: str = "127.0.0.1", tcp_port: int = TCP_PORT
    ) -> AsyncIterator[TcpListener]:
        """Listen for clients; raises OSError if the port is taken."""
        listener = TcpListener(self.router)
        await listener.open(host, tcp_port)

        async def tick_forever() -> None:
            while True:
                await asyncio.sleep(_TICK)
                self.tick()

        ticking = asyncio.create_task(tick_forever())
        try:
            yield listener
        finally:
            ticking.cancel()
            await asyncio.gather(ticking, return_exceptions=True)
            await listener.close()


class ReplayDevice(Device):
    """One recorded AMS port. Sums and notifications come from the device framework."""

    def __init__(self, recorded: RecordedDevice, clock: Callable[[], int]) -> None:
        self.recorded = recorded
        self.clock = clock
        self._next: dict[Key, int] = {}
        self._logged_keys: set[Key] = set()
        info, state = recorded.info, recorded.state
        groups = {key.group for key in (*recorded.answers, *recorded.samples)}
        groups -= {ReservedGroup.DEVICE, 0, *SUMS}
        super().__init__(
            "Replay" if info is None else info.name,
            (0, 0, 0) if info is None else (info.major, info.minor, info.build),
            [
                _Recorded(
                    self,
                    groups
                    | {
                        ReservedGroup.SYMBOL_VALUE_BY_HANDLE,
                        ReservedGroup.RELEASE_SYMBOL_HANDLE,
                        ReservedGroup.SYMBOL_NOTIFICATION,
                    },
                )
            ],
            clock=clock,
            task_cycle_ns=_GRID_NS,
            ads_state=AdsState.RUN if state is None else AdsState(state.ads_state),
            device_state=0 if state is None else state.device_state,
        )

    def next(self, key: Key) -> bytes:
        """Return the next recorded answer; raise DeviceError as the target did."""
        answers = self.recorded.answers.get(key)
        if answers is None:
            if key not in self._logged_keys:
                self._logged_keys.add(key)
                log.warning("not in the recording: %s 0x%X:0x%X %r", key[0].name, *key[1:])
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "not in the recording")
        number = self._next.get(key, 0)
        if number + 1 < len(answers):
            self._next[key] = number + 1
        outcome: Outcome = answers[number]
        if outcome.result:
            raise DeviceError(outcome.result, "as recorded")
        return outcome.data

    def write_control(self, ads_state: int, device_state: int, data: bytes) -> None:
        """Refuse with 0x701: a recording has one state."""
        raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "a recording has one state")


class _Recorded(IndexGroup):
    """All recorded index groups of one device."""

    def __init__(self, device: ReplayDevice, groups: set[int]) -> None:
        self._device = device
        self._recorded = device.recorded
        self._groups = sorted(groups)

    def index_groups(self) -> list[int]:
        return self._groups

    def describe(self):  # type: ignore[no-untyped-def]
        return iter(())

    def _key(self, command: Command, group: int, offset: int) -> Key:
        if group in (ReservedGroup.SYMBOL_VALUE_BY_HANDLE, ReservedGroup.SYMBOL_NOTIFICATION):
            name = self._recorded.names.get(offset)
            if name is None:
                raise DeviceError(ReturnCode.SYMBOL_NOT_FOUND, f"handle 0x{offset:X}")
            return Key(command, group, 0, name)
        return Key(command, group, offset, b"")

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        key = self._key(Command.READ, group, offset)
        if key not in self._recorded.answers:
            samples = self._recorded.samples.get(key._replace(command=Command.ADD_NOTIFICATION))
            if samples:
                return samples[0][1][:length]
        return self._device.next(key)[:length]

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        return lambda: self.read(group, offset, length, client)

    def watch(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        key = self._key(Command.ADD_NOTIFICATION, group, offset)
        self._device.next(key)
        samples = self._recorded.samples.get(key) or [(0, bytes(length))]
        began, clock = self._device.clock(), self._device.clock
        position = 0

        def read() -> bytes:
            nonlocal position
            passed = clock() - began
            while position + 1 < len(samples) and samples[position + 1][0] <= passed:
                position += 1
            return samples[position][1][:length]

        return read

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        if group == ReservedGroup.RELEASE_SYMBOL_HANDLE:
            return  # each name has one handle here
        self._device.next(self._key(Command.WRITE, group, offset))

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        if group == ReservedGroup.SYMBOL_VALUE_BY_HANDLE:
            key = self._key(Command.READ_WRITE, group, offset)
            key = key._replace(name=key.name + data)
        elif group in NAMED:
            key = Key(Command.READ_WRITE, group, offset, symbol_name(data))
        else:
            key = Key(Command.READ_WRITE, group, offset, data)
        answer = self._device.next(key)
        if group == ReservedGroup.SYMBOL_HANDLE_BY_NAME:
            first = self._recorded.handles[key.name].to_bytes(4, "little")
            answer = first + answer[4:]
        return answer[:read_length]


def _from(began: int) -> Callable[[], int]:
    return lambda: began + time.monotonic_ns()
