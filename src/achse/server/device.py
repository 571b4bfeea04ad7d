"""A device on an AMS port: its commands, dispatched to the services it offers.

The way of a request: `deliver` picks the command, unpacks its header, finds the index group in one
dictionary and answers with what the group gives. `DeviceError` is the one way to answer a fault.
"""

import logging
import struct
from collections.abc import Callable, Iterable, Mapping
from typing import ClassVar, Protocol

from achse.ams import AdsState, AmsAddress, Command, DeviceError, Endpoint, Frame
from achse.ams.commands import (
    ADD_NOTIFICATION_BODY,
    DEVICE_INFO,
    ERROR_PADDING,
    READ,
    RESULT,
    RESULT_LENGTH,
    RESULT_STATE,
    WRITE_CONTROL,
    AddNotificationRequest,
)
from achse.ams.commands import READ_WRITE as READ_WRITE_HEADER
from achse.codes import ReservedGroup, ReturnCode
from achse.server import rows
from achse.server.deferred import Deferred, Result
from achse.server.limits import ClientLimits
from achse.server.notifications import IN_CONTEXT, Notifications
from achse.server.rows import Layout, Service
from achse.server.sums import SumCommands
from achse.server.symbols import SymbolServices, SymbolSource
from achse.server.table import Group, IndexGroup, ServiceTable
from achse.server.usage import Usage

log = logging.getLogger("achse.server")

DIRECT_CODES_OF_A_PLC: Mapping[int, ReturnCode] = {
    ReturnCode.INVALID_GROUP.number: ReturnCode.SERVICE_NOT_SUPPORTED,
    ReturnCode.INVALID_OFFSET.number: ReturnCode.SERVICE_NOT_SUPPORTED,
}
"""A real PLC answers 0x701 where others say 0x702 or 0x703, except inside sum commands."""

_OK = RESULT.pack(0)
_WITHOUT_DATA = (Command.WRITE, Command.WRITE_CONTROL)
_SYMBOLIC = (ReservedGroup.SYMBOL_VALUE_BY_HANDLE, ReservedGroup.SYMBOL_NOTIFICATION)
_LAST_STATE = max(AdsState)
_NO_RESPONSE = 0x0002


class DeviceRouter(Protocol):
    """Part of the router that a device needs."""

    def register(self, port: int, endpoint: Endpoint) -> AmsAddress: ...

    def unregister(self, port: int) -> None: ...

    def deliver(self, frame: Frame) -> bool: ...

    def reaches(self, address: bytes) -> bool: ...

    def on_port_closed(self, listener: Callable[[AmsAddress], None]) -> None: ...

    def ignore_port_closed(self, listener: Callable[[AmsAddress], None]) -> None: ...

    def on_way_closed(
        self, listener: Callable[[Endpoint], None], uses: Callable[[Endpoint], bool] | None = None
    ) -> None: ...

    def ignore_way_closed(self, listener: Callable[[Endpoint], None]) -> None: ...


STATE_SERVICES = (
    Service(
        0,
        "ADS state",
        rows.READ,
        Layout("<HH"),
        "ADS state and device state; a length of 2 gives the first alone.",
        read=lambda device: (device.ads_state, device.device_state),
    ),
    Service(2, "device state", rows.READ, Layout("<H"), "Device state.", field="device_state"),
)
"""Group 0xF100 of every device: how clients watch its state."""


class Device:
    """Answers ADS requests on one or several AMS ports.

    - `groups`: what the device offers; state (0xF100), sum commands and, with `symbols`, the
      symbol services come with every device. `services` is the whole table.
    - `accepted_states`: what Write Control may ask for, and the state it leads to.
    - `direct_codes`: results replaced outside sum commands, see `DIRECT_CODES_OF_A_PLC`.
    - `clock`: unix ns of the station, as stamps show it. Nothing in here reads another clock.
    - `task_cycle_ns`: cycle of the default task, on whose grid notifications are sampled.

    `client` is everywhere the AMS address of the asking client; b"" is a caller in this process.
    """

    accepted_states: ClassVar[Mapping[int, AdsState]] = {}

    def __init__(
        self,
        name: str,
        version: tuple[int, int, int],
        groups: Iterable[IndexGroup] = (),
        symbols: SymbolSource | None = None,
        *,
        clock: Callable[[], int],
        task_cycle_ns: int = 10_000_000,
        ads_state: AdsState = AdsState.RUN,
        device_state: int = 0,
        direct_codes: Mapping[int, ReturnCode] | None = None,
        limits: ClientLimits | None = None,
    ) -> None:
        self.name = name
        self.version = version
        self.ads_state = ads_state
        self.device_state = device_state
        self.task_cycle_ns = task_cycle_ns
        self.limits = limits or ClientLimits()
        self.notifications = Notifications(clock, self.task_cycle, self.limits)
        self.request_count = 0
        """Requests that came here; repeated reads of one variable take a shorter way."""
        self.error_count = 0
        """Of these, those that were answered with an error."""
        self.addresses: list[AmsAddress] = []
        self.symbols = (
            None
            if symbols is None
            else SymbolServices(symbols, self.limits, clock, lambda: self.request_way)
        )
        single = ServiceTable(
            (
                *groups,
                Group(ReservedGroup.DEVICE, STATE_SERVICES, self),
                *(() if self.symbols is None else self.symbols.groups()),
            )
        )
        self.services = ServiceTable(SumCommands(single, self).groups(), single)
        self._groups = self.services.by_index
        self.readable_groups: Mapping[int, IndexGroup] | None = self._groups
        """Index groups that answer a Read: a transport may read from them directly, without a
        frame."""
        self._in_sums = single
        self._direct_codes = direct_codes or {}
        self._router: DeviceRouter | None = None
        self._request: Frame | None = None
        """The request being answered: a subscription goes back the way it came."""
        self._unreachable_since: dict[bytes, int] = {}
        self._commands: dict[int, Callable[[Frame], bytes]] = {
            Command.READ_DEVICE_INFO: self._answer_device_info,
            Command.READ: self._answer_read,
            Command.WRITE: self._answer_write,
            Command.READ_STATE: self._answer_state,
            Command.WRITE_CONTROL: self._answer_write_control,
            Command.ADD_NOTIFICATION: self._answer_add_notification,
            Command.DELETE_NOTIFICATION: self._answer_delete_notification,
            Command.READ_WRITE: self._answer_read_write,
        }

    @property
    def address(self) -> AmsAddress:
        """Address at which the device was attached first. Raises LookupError if it is attached to
        no router."""
        if not self.addresses:
            raise LookupError(f"{self.name} is attached to no router")
        return self.addresses[0]

    # router ----------------------------------------------------------------------------------

    def attach(self, router: DeviceRouter, port: int) -> AmsAddress:
        """Answer on `port` of `router`; several ports are possible. Raises RouterError."""
        if self._router is None:
            self._router = router
            self.notifications.sender = router
            router.on_port_closed(self.end_client)
            router.on_way_closed(self.end_way, self.notifications.uses)
        elif self._router is not router:
            raise ValueError("a device is attached to one router")
        address = router.register(port, self)
        self.addresses.append(address)
        return address

    def detach(self) -> None:
        """Leave all ports; end handles and subscriptions."""
        router, self._router = self._router, None
        if router is not None:
            for address in self.addresses:
                router.unregister(address.port)
            router.ignore_port_closed(self.end_client)
            router.ignore_way_closed(self.end_way)
        self.addresses.clear()
        self.end_clients()

    def deliver(self, frame: Frame) -> bool:
        """Answer a request. Other frames are ignored: a device sends no requests."""
        flags = frame.flags
        if flags & 1:
            return True
        command = self._commands.get(frame.command)
        if command is None:
            if frame.command != Command.NOTIFICATION and not flags & _NO_RESPONSE:
                self._reply(frame.reply(error=ReturnCode.UNKNOWN_COMMAND.number))
            return True
        self.request_count += 1
        try:
            payload = command(frame)
            if len(payload) > self.limits.answer_bytes:
                raise DeviceError(ReturnCode.INVALID_SIZE, f"an answer of {len(payload)} bytes")
        except Deferred as later:
            later.start(lambda result: self._answer_later(frame, result))
            return True
        except Exception as failure:
            payload = self._refusal(frame, failure)
        if not flags & _NO_RESPONSE:
            self._reply(frame.reply(payload))
        if self.notifications.fresh:
            self.notifications.send_first()
        return True

    def _answer_later(self, frame: Frame, result: Result) -> None:
        """Answer a request whose result took a while."""
        try:
            value = result()
            if frame.command in _WITHOUT_DATA:
                payload = _OK
            else:
                payload = RESULT_LENGTH.pack(0, len(value)) + value
        except Exception as failure:
            payload = self._refusal(frame, failure)
        if not frame.flags & _NO_RESPONSE:
            self._reply(frame.reply(payload))

    def _refusal(self, frame: Frame, failure: Exception) -> bytes:
        """Return the answer that says what went wrong."""
        self.error_count += 1
        name = Command(frame.command).name
        if isinstance(failure, DeviceError):
            code = int(self._direct_codes.get(failure.code, failure.code))
            log.debug(
                "%s: %s of %s refused: %s",
                *(self.name, name, AmsAddress(frame.source), failure),
                extra=frame.sender,
            )
        else:
            code = ReturnCode.INTERNAL_ERROR.number
            log.error(
                "%s: %s of %s failed",
                *(self.name, name, AmsAddress(frame.source)),
                exc_info=failure,
                extra=frame.sender,
            )
        return RESULT.pack(code) + ERROR_PADDING[Command(frame.command)]

    def _reply(self, response: Frame) -> None:
        if self._router is not None:
            self._router.deliver(response)

    # commands --------------------------------------------------------------------------------

    def _answer_device_info(self, frame: Frame) -> bytes:
        _expect(frame.data, 0)
        return DEVICE_INFO.pack(0, *self.version, self.name.encode("cp1252", "replace")[:16])

    def _answer_read(self, frame: Frame) -> bytes:
        data = frame.data
        if len(data) != 12:
            raise _wrong_size(data, 12)
        group, offset, length = READ.unpack(data)
        services = self._groups.get(group) or self.services.find(group)
        value = services.read(group, offset, length, frame.source)
        return RESULT_LENGTH.pack(0, len(value)) + value

    def _answer_write(self, frame: Frame) -> bytes:
        data = frame.data
        group, offset = _header(data, READ)
        services = self._groups.get(group) or self.services.find(group)
        services.write(group, offset, data[12:], frame.source)
        return _OK

    def _answer_read_write(self, frame: Frame) -> bytes:
        data = frame.data
        group, offset, read_length = _header(data, READ_WRITE_HEADER)
        services = self._groups.get(group) or self.services.find(group)
        outer, self._request = self._request, frame
        try:
            value = services.read_write(group, offset, read_length, data[16:], frame.source)
        finally:
            self._request = outer
        return RESULT_LENGTH.pack(0, len(value)) + value

    def _answer_state(self, frame: Frame) -> bytes:
        _expect(frame.data, 0)
        return RESULT_STATE.pack(0, self.ads_state, self.device_state)

    def _answer_write_control(self, frame: Frame) -> bytes:
        data = frame.data
        ads_state, device_state = _header(data, WRITE_CONTROL)
        if not 0 < ads_state <= _LAST_STATE:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"ADS state {ads_state}")
        self.write_control(ads_state, device_state, data[8:])
        return _OK

    def _answer_add_notification(self, frame: Frame) -> bytes:
        _expect(frame.data, 40)
        request = AddNotificationRequest(*ADD_NOTIFICATION_BODY.unpack(frame.data))
        outer, self._request = self._request, frame
        try:
            handle = self.add_notification(request, frame.source)
        finally:
            self._request = outer
        return RESULT_LENGTH.pack(0, handle)

    def _answer_delete_notification(self, frame: Frame) -> bytes:
        _expect(frame.data, 4)
        self.delete_notification(RESULT.unpack(frame.data)[0], frame.source)
        return _OK

    # the same in this process ----------------------------------------------------------------

    def read(self, group: int, offset: int, length: int, client: bytes = b"") -> bytes:
        """Return up to `length` bytes; raises DeviceError."""
        return self.services.find(group).read(group, offset, length, client)

    def write(self, group: int, offset: int, data: bytes, client: bytes = b"") -> None:
        """Write `data`; raises DeviceError."""
        self.services.find(group).write(group, offset, data, client)

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes = b""
    ) -> bytes:
        """Hand over `data`, get up to `read_length` bytes; raises DeviceError."""
        return self.services.find(group).read_write(group, offset, read_length, data, client)

    def limit(self, limits: ClientLimits) -> None:
        """Keep to other limits from now on; what clients hold already stays."""
        self.limits = self.notifications.limits = limits
        self.notifications.usage.budget.per_second = limits.samples
        if self.symbols is not None:
            self.symbols.handles.limits = limits

    def share(self, usage: Usage, epoch: Callable[[], int] = int) -> None:
        """Count what clients hold together with other devices, before there are any.

        The owner of the notifications serves the budget then, and ticks in a time of its own:
        `epoch()` is the Unix time in ns at its 0.
        """
        self.notifications.share(usage, epoch)
        if self.symbols is not None:
            self.symbols.handles.usage = usage

    def replace(self, index_group: int, group: IndexGroup | None) -> IndexGroup | None:
        """Let `group` answer for `index_group`, alone and in sums; what answered before.

        None: none. Faults are before a group in this way.
        """
        before = self.services.get(index_group)
        tables = [self.services]
        if before is None or self._in_sums.get(index_group) is not None:
            tables.append(self._in_sums)
        for table in tables:
            table.put(index_group, group)
        return before

    def write_control(self, ads_state: int, device_state: int, data: bytes) -> None:
        """Go to the state that `ads_state` (1..19) leads to; `data` is for devices that use it.

        Raises DeviceError 0x712 if the device does not accept this state.
        """
        state = self.accepted_states.get(ads_state)
        if state is None:
            raise DeviceError(
                ReturnCode.INVALID_STATE, f"{self.name} cannot go to {AdsState(ads_state).name}"
            )
        self.ads_state = state
        self.device_state = device_state

    # notifications ---------------------------------------------------------------------------

    def add_notification(self, request: AddNotificationRequest, client: bytes) -> int:
        """Subscribe the client of the current request; return the handle."""
        frame = self._request
        if frame is None:
            raise DeviceError(ReturnCode.CLIENT_UNKNOWN, "notifications need an AMS address")
        group, offset, length, mode, max_delay, cycle_time = request
        services = self.services.find(group)
        return self.notifications.add(
            client,
            frame.target,
            frame.origin,
            services.watch(group, offset, length, client),
            length,
            mode,
            max_delay,
            cycle_time,
            context=services.context(group, offset, client) if mode in IN_CONTEXT else 0,
            symbolic=group in _SYMBOLIC,
        )

    def delete_notification(self, handle: int, client: bytes) -> None:
        """End a subscription; raises DeviceError 0x714."""
        self.notifications.delete(handle, client)

    def task_cycle(self, context: int) -> int:
        """Cycle in ns of the task `context`; devices with several tasks know better."""
        return self.task_cycle_ns

    # clients ---------------------------------------------------------------------------------

    def symbols_changed(self) -> None:
        """Note that the symbol table is another one: handles answer 0x711, their subscriptions end.

        For a download call `end_clients` as well; an online change leaves the others alive.
        """
        if self.symbols is not None:
            self.symbols.handles.invalidate()
        self.notifications.end_symbolic()

    def end_client(self, client: bytes) -> None:
        """End the subscriptions of a client that is gone, and abandon its handles."""
        self.notifications.end_client(client)
        if self.symbols is not None:
            self.symbols.handles.abandon_client(client)
        self._unreachable_since.pop(client, None)

    def end_way(self, way: Endpoint) -> None:
        """End subscriptions and abandon handles of a connection that has ended.

        The same address may come back as another client.
        """
        self.notifications.end_way(way)
        if self.symbols is not None:
            self.symbols.handles.abandon_way(way)

    @property
    def request_way(self) -> Endpoint | None:
        """The connection by which the request came that is being answered."""
        return None if self._request is None else self._request.origin

    def end_notifications(self) -> None:
        """End all subscriptions: restart, configuration mode, download."""
        self.notifications.end_all()

    def end_clients(self) -> None:
        """End the subscriptions and handles of all clients, abandoned handles among them."""
        clients = self._clients()
        if self.symbols is not None:
            self.symbols.handles.end_all()
        for client in clients:
            self.end_client(client)

    def end_abandoned(self) -> None:
        """End handles whose connection has ended."""
        if self.symbols is not None:
            self.symbols.handles.end_abandoned()

    def _clients(self) -> set[bytes]:
        clients = set(self.notifications.clients)
        if self.symbols is not None:
            clients.update(self.symbols.handles.clients)
        return clients

    def sweep(self, now_ns: int) -> None:
        """Drop clients that nothing has led to for a while: they cannot come back to tidy up.

        Called with the time (unix ns) about once a second.
        """
        router = self._router
        if self.symbols is not None:
            self.symbols.handles.clear()
        if router is None:
            return
        since = self._unreachable_since
        for client in self._clients():
            if not client or router.reaches(client):
                since.pop(client, None)
            elif now_ns - since.setdefault(client, now_ns) >= self.limits.unreachable_ns:
                log.info("%s is gone: its notifications end", AmsAddress(client))
                self.end_client(client)


def _wrong_size(data: bytes, size: int) -> DeviceError:
    return DeviceError(ReturnCode.INVALID_SIZE, f"the request has {size} bytes, got {len(data)}")


def _expect(data: bytes, size: int) -> None:
    if len(data) != size:
        raise _wrong_size(data, size)


def _header(data: bytes, layout: struct.Struct) -> tuple[int, ...]:
    """Return the fields of a request without the last, the length of what must follow them."""
    if len(data) < layout.size:
        raise _wrong_size(data, layout.size)
    fields: tuple[int, ...] = layout.unpack_from(data)
    if len(data) != layout.size + fields[-1]:
        raise _wrong_size(data, layout.size + fields[-1])
    return fields[:-1]
