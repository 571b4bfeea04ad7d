"""What each kind of fault does: to frames at the router, to services of a device, to a station."""

import struct
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.ams import Command, DeviceError, Frame
from achse.ams.commands import ERROR_PADDING, RESULT
from achse.codes import ReturnCode
from achse.plc import PlcRuntime
from achse.server import Device, IndexGroup, Symbol
from achse.server.symbols import decode_name
from achse.server.table import Reader
from achse.station.fault import COMMANDS, ActiveFault, Fault, FaultError, client_test

if TYPE_CHECKING:
    from achse.station.station import Station

__all__ = ["Disturbances"]

SPARED_PORT = 26_000
"""The station's own service: faults never cut off the way to clear them."""

_PLACE = struct.Struct("<II")
_WITH_PLACE = frozenset((Command.READ, Command.WRITE, Command.READ_WRITE, Command.ADD_NOTIFICATION))
_BY_NAME, _BY_HANDLE = 0xF004, 0xF005
_REMEMBERED = 4096
"""Requests under way whose answers are to be hit; more are no sensible test."""

_FRAME_KINDS = frozenset(
    (
        "drop", "delay", "duplicate", "reorder", "cut", "truncate", "wrong_invoke_id",
        "router_error",
    )
)  # fmt: skip

Later = Callable[[float, Callable[[], None]], None]
Onward = Callable[[Frame], bool]
Undo = Callable[[], None]


class Disturbances:
    """Begins faults and gives what ends them."""

    def __init__(
        self, station: "Station", later: Later, finish: Callable[[ActiveFault], None]
    ) -> None:
        self._station = station
        self._frames = _FrameFaults(station, later, finish)
        self._finish = finish
        self._groups: dict[tuple[Device, int], _RefusingGroup] = {}
        self._standing: list[_Standing] = []

    def check(self, fault: Fault) -> None:
        """Raise FaultError for what this station cannot do."""
        client_test(fault.client)
        if fault.symbol:
            self._symbol(fault)
        if fault.kind in ("online_change", "download", "slow_cycle"):
            self._plcs(fault)

    def begin(self, active: ActiveFault) -> Undo | None:
        fault = active.fault
        if fault.kind in _FRAME_KINDS:
            return self._frames.begin(active, self._selection(fault))
        if fault.kind == "error":
            if fault.group is None and not fault.symbol:
                return self._frames.begin(active, self._selection(fault))
            return self._refuse(active)
        begin: Callable[[Fault], Undo | None] = getattr(self, f"_{fault.kind}")
        return begin(fault)

    # selection -------------------------------------------------------------------------------

    def _symbol(self, fault: Fault) -> tuple[Device, Symbol]:
        for device in self._devices(fault):
            if device.symbols is not None:
                symbol = device.symbols.source.resolve(fault.symbol)
                if symbol is not None:
                    return device, symbol
        raise FaultError(f"symbol: no device of the station has {fault.symbol!r}")

    def _devices(self, fault: Fault) -> list[Device]:
        devices = [
            device
            for device in self._station.devices
            if fault.port is None or any(item.port == fault.port for item in device.addresses)
        ]
        if not devices:
            raise FaultError(f"port: expected one of the station's devices, got {fault.port}")
        return devices

    def _selection(self, fault: Fault) -> "_Selection":
        found = self._symbol(fault) if fault.symbol else None
        return _Selection(fault, None if found is None else _Touch(*found))

    # errors of services ----------------------------------------------------------------------

    def _refuse(self, active: ActiveFault) -> Undo:
        fault = active.fault
        touch: _Touch | None = None
        if fault.symbol:
            device, symbol = self._symbol(fault)
            touch = _Touch(device, symbol)
            places = [(device, group) for group in (_BY_NAME, _BY_HANDLE, symbol.index_group)]
        else:
            assert fault.group is not None
            places = [(device, fault.group) for device in self._devices(fault)]
        refusal = _Refusal(active, _Selection(fault, touch), self._host, self._finish)
        for place in places:
            self._group(*place).refusals.append(refusal)
        return lambda: self._allow(refusal, places)

    def _host(self, client: bytes) -> str:
        return _host(self._station.router.way_to(client))

    def _group(self, device: Device, index_group: int) -> "_RefusingGroup":
        group = self._groups.get((device, index_group))
        if group is None:
            group = self._groups[device, index_group] = _RefusingGroup()
            group.behind = device.replace(index_group, group)
        return group

    def _allow(self, refusal: "_Refusal", places: list[tuple[Device, int]]) -> None:
        for device, index_group in places:
            group = self._groups[device, index_group]
            group.refusals = [each for each in group.refusals if each is not refusal]
            if not group.refusals:
                device.replace(index_group, group.behind)
                del self._groups[device, index_group]

    # what stands ---------------------------------------------------------------------------

    def _stand(self, standing: "_Standing") -> Undo:
        self._standing.append(standing)
        self._settle()

        def undo() -> None:
            self._standing.remove(standing)
            self._settle()

        return undo

    def _settle(self) -> None:
        """Make listeners and tasks as the configuration and all that stands want them."""
        station = self._station
        router = station.config.router
        kinds = {each.fault.kind for each in self._standing}
        for listener in station.listeners:
            listener.strict = router.strict or "one_connection" in kinds
            listener.accepting = "refuse_links" not in kinds
        for port, plc in station.plcs.items():
            factors = [each.fault.factor or 2 for each in self._standing if port in each.plcs]
            for task in plc.tasks:
                task.stretch = max(factors, default=1)

    # links -----------------------------------------------------------------------------------

    def _drop_link(self, fault: Fault) -> None:
        is_client = client_test(fault.client)
        for listener in self._station.listeners:
            for connection in list(listener.connections):
                addresses = (*connection.registered, *connection.sources) or (b"",)
                if any(is_client(address, connection.peer_host) for address in addresses):
                    listener.loop.call_soon(connection.abort)  # who asked for it is answered

    def _refuse_links(self, fault: Fault) -> Undo:
        return self._stand(_Standing(fault))

    def _one_connection(self, fault: Fault) -> Undo:
        return self._stand(_Standing(fault))

    # PLC and station -------------------------------------------------------------------------

    def _plcs(self, fault: Fault) -> list[tuple[PlcRuntime, Device]]:
        """The runtimes that a fault means, each with its device."""
        found = [
            (plc, device)
            for port, plc in self._station.plcs.items()
            for device in self._devices(fault)
            if any(address.port == port for address in device.addresses)
        ]
        if not found:
            raise FaultError("port: expected that of a PLC of the station")
        return found

    def _online_change(self, fault: Fault) -> None:
        for plc, _ in self._plcs(fault):
            plc.online_change()

    def _download(self, fault: Fault) -> None:
        for plc, device in self._plcs(fault):
            plc.reset()
            plc.online_change()
            device.end_notifications()
            plc.run()

    def _slow_cycle(self, fault: Fault) -> Undo:
        return self._stand(_Standing(fault, [plc.port for plc, _ in self._plcs(fault)]))

    def _restart(self, fault: Fault) -> None:
        self._station.restart()

    def _config(self, fault: Fault) -> Undo:
        self._station.configure()
        return self._station.restart


class _Standing(NamedTuple):
    """A fault that is a setting as long as it lasts."""

    fault: Fault
    plcs: Sequence[int] = ()
    """Ports of the PLCs that it slows down."""


class _Touch:
    """Whether a request reads or writes one variable: by name, by handle or by address."""

    def __init__(self, device: Device, symbol: Symbol) -> None:
        assert device.symbols is not None
        self.ports = [address.port for address in device.addresses]
        self._symbols = device.symbols
        self._group = symbol.index_group
        self._start = symbol.index_offset
        self._end = symbol.index_offset + symbol.size

    def __call__(self, group: int, offset: int, length: int, data: bytes) -> bool:
        if group == self._group:
            return offset < self._end and self._start < offset + max(length, 1)
        symbol: Symbol | None = None
        if group == _BY_HANDLE:
            symbol = self._symbols.held(offset)
        elif group == _BY_NAME:
            symbol = self._symbols.source.resolve(decode_name(data))
        return (
            symbol is not None
            and symbol.index_group == self._group
            and symbol.index_offset < self._end
            and self._start < symbol.index_offset + symbol.size
        )


class _Selection:
    """Which requests a fault means."""

    def __init__(self, fault: Fault, touch: _Touch | None) -> None:
        self.command = COMMANDS[fault.command] if fault.command else None
        self.is_client = client_test(fault.client)
        self.port = fault.port
        self._group = fault.group
        self._offset = fault.offset
        self._touch = touch
        self._placed = fault.group is not None or touch is not None

    def peer(self, address: bytes, host: str, port: int) -> bool:
        """Client and device fit."""
        return (self.port is None or self.port == port) and self.is_client(address, host)

    def place(self, group: int, offset: int, length: int, data: bytes) -> bool:
        """Service or symbol fit."""
        if self._touch is not None:
            return self._touch(group, offset, length, data)
        return (self._group is None or group == self._group) and (
            self._offset is None or offset == self._offset
        )

    def request(self, frame: Frame) -> bool:
        """The frame is one of them."""
        command = frame.command
        if self.command is not None and command != self.command:
            return False
        if not self.peer(frame.source, _host(frame.origin), _port(frame.target)):
            return False
        if not self._placed:
            return True
        data = frame.data
        if command not in _WITH_PLACE or len(data) < 12:
            return False
        group, offset = _PLACE.unpack_from(data)
        length = int.from_bytes(data[8:12], "little")
        return self.place(group, offset, length, data[16:])

    def sample(self, frame: Frame) -> bool:
        """The frame is a notification for them; asked only of a fault of notifications."""
        return self.peer(frame.target, _host(frame.via), _port(frame.source))


def _host(endpoint: object) -> str:
    return getattr(endpoint, "peer_host", "")


def _port(address: bytes) -> int:
    return address[6] | address[7] << 8


class _Refusal:
    """An error on a service or symbol."""

    def __init__(
        self,
        active: ActiveFault,
        selection: _Selection,
        host: Callable[[bytes], str],
        finish: Callable[[ActiveFault], None],
    ) -> None:
        self._active = active
        self._selection = selection
        self._host = host
        self._finish = finish

    def check(
        self, command: Command, group: int, offset: int, length: int, data: bytes, client: bytes
    ) -> None:
        selection, active = self._selection, self._active
        if (
            selection.command in (None, command)
            and selection.is_client(client, self._host(client))
            and selection.place(group, offset, length, data)
            and active.take()
        ):
            if active.used_up:
                self._finish(active)
            assert active.fault.code is not None
            raise DeviceError(active.fault.code, f"fault {active.number}")


class _RefusingGroup(IndexGroup):
    """Stands before an index group, which may be one that the device does not have."""

    def __init__(self) -> None:
        self.behind: IndexGroup | None = None
        self.refusals: list[_Refusal] = []

    def _inner(
        self,
        command: Command,
        group: int,
        offset: int,
        length: int,
        data: bytes,
        client: bytes,
    ) -> IndexGroup:
        for refusal in self.refusals:
            refusal.check(command, group, offset, length, data, client)
        if self.behind is None:
            raise DeviceError(ReturnCode.INVALID_GROUP, f"0x{group:X}")
        return self.behind

    def read(self, group: int, offset: int, length: int, client: bytes) -> bytes:
        inner = self._inner(Command.READ, group, offset, length, b"", client)
        return inner.read(group, offset, length, client)

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        inner = self._inner(Command.READ, group, offset, length, b"", client)
        return inner.reader(group, offset, length, client)

    def watch(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        inner = self._inner(Command.ADD_NOTIFICATION, group, offset, length, b"", client)
        return inner.watch(group, offset, length, client)

    def context(self, group: int, offset: int, client: bytes) -> int:
        return 0 if self.behind is None else self.behind.context(group, offset, client)

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        inner = self._inner(Command.WRITE, group, offset, len(data), data, client)
        inner.write(group, offset, data, client)

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        inner = self._inner(Command.READ_WRITE, group, offset, read_length, data, client)
        return inner.read_write(group, offset, read_length, data, client)


class _FrameFaults:
    """The gate in the router through which all frames pass while a frame fault is at work."""

    def __init__(
        self, station: "Station", later: Later, finish: Callable[[ActiveFault], None]
    ) -> None:
        self._router = station.router
        self._later = later
        self._finish = finish
        self._standing = False
        self._on_requests: list[tuple[ActiveFault, _Selection]] = []
        self._on_samples: list[tuple[ActiveFault, _Selection]] = []
        self._marked: dict[tuple[Any, ...], list[ActiveFault]] = {}
        self._held: dict[int, tuple[Frame, Onward]] = {}
        """By fault number: the frame that waits to be overtaken."""

    def begin(self, active: ActiveFault, selection: _Selection) -> Undo:
        entry = (active, selection)
        samples = selection.command == Command.NOTIFICATION
        faults = self._on_samples if samples else self._on_requests
        faults.append(entry)
        self._stand()

        def undo() -> None:
            faults.remove(entry)
            self._stand()

        return undo

    def _stand(self) -> None:
        """Be in the way of the frames as long as there is something to do."""
        needed = bool(self._on_requests or self._on_samples or self._marked)
        if needed and not self._standing:
            self._router.put_gate(self._gate)
        elif self._standing and not needed:
            self._router.put_gate(None)
        self._standing = needed

    def _gate(self, frame: Frame, onward: Onward) -> bool:
        if frame.command == Command.NOTIFICATION:
            hits = self._take(self._on_samples, lambda selection: selection.sample(frame))
        elif frame.is_response:
            hits = self._marked.pop(_exchange(frame), [])
            if hits:
                self._stand()
        elif _port(frame.target) == SPARED_PORT:
            return onward(frame)
        else:
            hits = self._take(self._on_requests, lambda selection: selection.request(frame))
            later = [each for each in hits if _acts_on_answer(each.fault)]
            if later:
                self._marked[_exchange(frame)] = later
                if len(self._marked) > _REMEMBERED:
                    del self._marked[next(iter(self._marked))]
                self._stand()
                hits = [each for each in hits if each not in later]
        for active in hits:
            onward = self._disturbed(active, onward)
        return onward(frame)

    def _take(
        self,
        faults: list[tuple[ActiveFault, _Selection]],
        selects: Callable[[_Selection], bool],
    ) -> list[ActiveFault]:
        """Those of the faults that hit this frame."""
        hits = [active for active, selection in faults if selects(selection)]
        hits = [active for active in hits if active.take()]
        for active in hits:
            if active.used_up:
                self._finish(active)
        return hits

    def _disturbed(self, active: ActiveFault, onward: Onward) -> Onward:
        """`onward` with the fault in its way."""
        act = getattr(self, f"_{active.fault.kind}")
        return lambda frame: bool(act(active, frame, onward))

    def _drop(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        return True

    def _delay(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        assert active.fault.by is not None

        def arrive() -> None:
            onward(frame)

        self._later(active.fault.by, arrive)
        return True

    def _duplicate(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        second = Frame(
            frame.target, frame.source, frame.command, frame.flags, frame.error,
            frame.invoke_id, frame.data,
        )  # fmt: skip
        second.origin, second.via = frame.origin, frame.via
        return onward(frame) and onward(second)

    def _reorder(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        first = self._held.pop(active.number, None)
        if first is not None:
            return onward(frame) and first[1](first[0])
        entry = self._held[active.number] = (frame, onward)

        def give_up() -> None:
            if self._held.get(active.number) is entry:
                del self._held[active.number]
                onward(frame)

        self._later(0.1 if active.fault.by is None else active.fault.by, give_up)
        return True

    def _cut(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        break_off = getattr(frame.via, "break_off", None)
        if break_off is not None:
            break_off(frame)
        return True

    def _truncate(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        frame.data = frame.data[: -(active.fault.size or 1)]
        return onward(frame)

    def _wrong_invoke_id(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        frame.invoke_id ^= 0x8000_0000
        return onward(frame)

    def _error(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        assert active.fault.code is not None
        try:
            padding = ERROR_PADDING[Command(frame.command)]
        except (KeyError, ValueError):
            return onward(frame)  # the device says that there is no such command
        return self._router.deliver(frame.reply(RESULT.pack(active.fault.code) + padding))

    def _router_error(self, active: ActiveFault, frame: Frame, onward: Onward) -> bool:
        assert active.fault.code is not None
        return self._router.deliver(frame.reply(error=active.fault.code))


def _acts_on_answer(fault: Fault) -> bool:
    return fault.side == "answer" and fault.kind not in ("error", "router_error")


def _exchange(frame: Frame) -> tuple[Any, ...]:
    """What a request and its answer have in common."""
    if frame.is_response:
        return (frame.target, frame.source, frame.command, frame.invoke_id, id(frame.via))
    return (frame.source, frame.target, frame.command, frame.invoke_id, id(frame.origin))
