"""ADS requests of PLC programs: the blocks and functions of Tc2_System that send requests to other
AMS ports.

A block starts a request in a cycle; it leaves when the cycle has ended, through the router like any
client's, from the port of the PLC. Answers are queued until the next cycle begins: only then bytes
go to where the program wants them, so that every run in virtual time is the same.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from achse.ams import AdsError, AmsAddress, Command, Frame, NetId
from achse.ams.commands import (
    DataResponse,
    EmptyRequest,
    ReadDeviceInfoResponse,
    ReadRequest,
    ReadStateResponse,
    ReadWriteRequest,
    Request,
    ResultResponse,
    WriteControlRequest,
    WriteRequest,
)
from achse.ams.filetime import from_unix_ns
from achse.codes import ReturnCode
from achse.codes.ports import EVENT_LOGGER_PORT, LOGGER_PORT
from achse.devices.logger import LogMessage, MessageType
from achse.devices.plc.serving import PlcIndications
from achse.plc.code.faults import PlcFault
from achse.plc.routines.builtins import BlockBody, BuiltinContext, FunctionBody
from achse.server.device import DeviceRouter

_SENDER = "TCPLC"
_KINDS = (
    MessageType.HINT,
    MessageType.LOG,
    MessageType.WARNING,
    MessageType.ERROR,
)
"""Kinds of messages by the severity of an event; the last is that of critical ones too."""
_LONGEST_MESSAGE = 253
_MOST_OPEN = 4096
_PLACE_OF_VALUE = re.compile(r"%[sdfSDF]")


class _BlockRequest(NamedTuple):
    """A request of a block, and where the data of its answer go."""

    command: Command
    request: Request
    target: int = 0
    """Address in the memory of the PLC."""
    room: int = 0
    """Number of bytes there."""


@dataclass(slots=True)
class _Open:
    """A request under way, or its result."""

    command: Command
    target: int
    room: int
    deadline_ns: int
    data: bytes | None = None
    error: int = 0
    done: bool = False
    count: int = 0
    response: ReadStateResponse | ReadDeviceInfoResponse | None = None


class PlcRequests:
    """Requests of one PLC to other devices. `clock`: Unix time of the station, ns, for the log."""

    def __init__(self, clock: Callable[[], int]) -> None:
        self._clock = clock
        self._router: DeviceRouter | None = None
        self._own = AmsAddress(bytes(8))
        self._open: dict[int, _Open] = {}
        self._out: list[Frame] = []
        self._last = 0
        self.indications = PlcIndications()
        """Requests of clients to the programs."""
        self.blocks: Mapping[str, BlockBody] = {
            "adsread": self._block("READ", _read),
            "adsreadex": self._block("READ", _read, _count),
            "adswrite": self._block("WRITE", _write),
            "adsrdwrt": self._block("WRTRD", _read_write),
            "adsrdwrtex": self._block("WRTRD", _read_write, _count),
            "adsrdstate": self._block("RDSTATE", _read_state, _state),
            "adsrddevinfo": self._block("RDINFO", _read_device_info, _device_info),
            "adswrtctl": self._block("WRITE", _write_control),
            "fb_getlocalamsnetid": self._own_net_id,
            **self.indications.blocks,
        }
        """Function blocks of `tc2_system/ads.st` and `serving.st`, and one of
        `tc2_utilities/computer.st`."""
        self.functions: Mapping[str, FunctionBody] = {
            "adslogstr": self._log,
            "adslogdint": self._log,
            "adsloglreal": self._log,
            "tc_event_send": self._event,
        }
        """Functions of `tc2_system/log.st` and `tc3_eventlogger/events.st`."""

    def connect(self, router: DeviceRouter, own: AmsAddress) -> None:
        """Ask through `router` from now on, as `own`."""
        self._router, self._own = router, own

    def disconnect(self) -> None:
        """Drop what programs request from now on."""
        self._router = None

    # between two cycles ----------------------------------------------------------------------

    def begin_cycle(self, plc: BuiltinContext) -> None:
        """Take over the answers that came, and end what took too long."""
        for entry in self._open.values():
            if entry.done:
                continue
            if entry.data is not None:
                self._take_over(plc, entry)
            elif entry.error or plc.time_ns >= entry.deadline_ns:
                entry.error = entry.error or ReturnCode.CLIENT_TIMEOUT.number
                entry.done = True

    def end_cycle(self) -> None:
        """Send the requests of the cycle."""
        self.indications.end_cycle()
        out, self._out = self._out, []
        if self._router is None:
            return
        for frame in out:
            self._router.deliver(frame)

    def forget(self) -> None:
        """Drop all answers: variables begin again, or their places changed."""
        self._open.clear()
        self._out.clear()
        self.indications.forget()

    def receive(self, frame: Frame) -> None:
        """Note that an answer came; it waits for the next cycle. An unexpected one is dropped."""
        entry = self._open.get(frame.invoke_id)
        if entry is None or entry.data is not None or entry.error:
            return
        if frame.error:
            entry.error = frame.error
        elif frame.command == entry.command:
            entry.data = frame.data

    def _take_over(self, plc: BuiltinContext, entry: _Open) -> None:
        entry.done = True
        assert entry.data is not None
        data, entry.data = entry.data, b""
        try:
            if entry.command in (Command.READ, Command.READ_WRITE):
                response = DataResponse.decode(data)
                entry.error = response.result
                if not response.result and entry.room:
                    taken = response.data[: entry.room]
                    plc.store_bytes(entry.target, taken)
                    entry.count = len(taken)
            elif entry.command == Command.READ_STATE:
                entry.response = ReadStateResponse.decode(data)
                entry.error = entry.response.result
            elif entry.command == Command.READ_DEVICE_INFO:
                entry.response = ReadDeviceInfoResponse.decode(data)
                entry.error = entry.response.result
            else:
                entry.error = ResultResponse.decode(data).result
        except AdsError:
            entry.error = ReturnCode.CLIENT_SYNC_RESPONSE_INVALID.number
        except PlcFault:  # what __NEW made is gone since
            entry.error = ReturnCode.CLIENT_INVALID_PARAMETER.number

    # blocks ----------------------------------------------------------------------------------

    def _block(
        self,
        start: str,
        make: Callable[[BuiltinContext, Any], _BlockRequest],
        show: Callable[[Any, _Open], None] = lambda block, entry: None,
    ) -> BlockBody:
        """Return the body of a block: `start` is its input with the edge."""

        def run(plc: BuiltinContext, block: Any) -> None:
            wanted = getattr(block, start)
            rises, block.before = wanted and not block.before, wanted
            if block.BUSY:
                entry = self._open.get(block.ticket)
                if entry is None:
                    # A reset or an online change came in between.
                    self._end(block, ReturnCode.CLIENT_REQUEST_CANCELLED.number)
                elif entry.done:
                    del self._open[block.ticket]
                    self._end(block, entry.error)
                    if not entry.error:
                        show(block, entry)
            elif rises:
                self._start(plc, block, make)

        return run

    def _end(self, block: Any, error: int) -> None:
        block.BUSY = False
        block.ERR, block.ERRID = error != 0, error

    def _start(
        self, plc: BuiltinContext, block: Any, make: Callable[[BuiltinContext, Any], _BlockRequest]
    ) -> None:
        if hasattr(block, "COUNT_R"):
            block.COUNT_R = 0
        try:
            net_id = NetId(block.NETID) if block.NETID else self._own.net_id
        except ValueError:
            self._end(block, ReturnCode.CLIENT_NO_AMS_ADDRESS.number)
            return
        try:
            outgoing = make(plc, block)
        except _NullPointer:
            self._end(block, ReturnCode.CLIENT_INVALID_PARAMETER.number)
            return
        wait_ns = round(block.TMOUT.total_seconds() * 1000) * 1_000_000
        if len(self._open) >= _MOST_OPEN:  # also requests of blocks that no program calls any more
            self._open = {ticket: one for ticket, one in self._open.items() if not one.done}
        block.ticket = self._send_request(
            AmsAddress.of(net_id, block.PORT), outgoing.command, outgoing.request
        )
        self._open[block.ticket] = _Open(
            outgoing.command, outgoing.target, outgoing.room, plc.time_ns + wait_ns
        )
        block.BUSY, block.ERR, block.ERRID = True, False, 0

    def _send_request(self, target: AmsAddress, command: Command, request: Request) -> int:
        self._last = self._last % 0xFFFF_FFFF + 1
        frame = Frame(target, self._own, command, invoke_id=self._last, data=request.encode())
        self._out.append(frame)
        return self._last

    def _own_net_id(self, plc: BuiltinContext, block: Any) -> None:
        if block.bExecute and not block.before:
            net_id = self._own.net_id
            block.AddrString = str(net_id)
            for place, number in enumerate(str(net_id).split(".")):
                block.AddrBytes[place] = int(number)
        block.before = block.bExecute

    # the log ---------------------------------------------------------------------------------

    def _log(self, plc: BuiltinContext, mask: int, text: Any, value: Any) -> int:
        shown = f"{value:.6f}" if isinstance(value, float) else _text(value)
        shown_text = _PLACE_OF_VALUE.sub(lambda _: shown, _text(text), count=1)[:_LONGEST_MESSAGE]
        message = LogMessage(
            from_unix_ns(self._clock()), mask, self._own.port, _SENDER, shown_text
        ).encode()
        request = WriteRequest(1, 0, message)
        self._send_request(AmsAddress.of(self._own.net_id, LOGGER_PORT), Command.WRITE, request)
        return 0

    def _event(self, plc: BuiltinContext, severity: int, text: Any) -> int:
        kind = _KINDS[max(0, min(severity, len(_KINDS) - 1))]
        message = LogMessage(
            from_unix_ns(self._clock()), kind, self._own.port, _SENDER, _text(text)
        ).encode()
        target = AmsAddress.of(self._own.net_id, EVENT_LOGGER_PORT)
        self._send_request(target, Command.WRITE, WriteRequest(1, 0, message))
        return 0


class _NullPointer(Exception):
    """Error of a request that has bytes to read or write, and no address."""


def _text(value: Any) -> str:
    return value.decode("cp1252", "replace") if isinstance(value, bytes) else str(value)


def _source(plc: BuiltinContext, address: int, size: int) -> bytes:
    if size and not address:
        raise _NullPointer
    return plc.load_bytes(address, size) if size else b""


def _read(plc: BuiltinContext, block: Any) -> _BlockRequest:
    _source(plc, block.DESTADDR, block.LEN)  # all bytes exist, before a request is sent
    request = ReadRequest(block.IDXGRP, block.IDXOFFS, block.LEN)
    return _BlockRequest(Command.READ, request, block.DESTADDR, block.LEN)


def _write(plc: BuiltinContext, block: Any) -> _BlockRequest:
    data = _source(plc, block.SRCADDR, block.LEN)
    return _BlockRequest(Command.WRITE, WriteRequest(block.IDXGRP, block.IDXOFFS, data))


def _read_write(plc: BuiltinContext, block: Any) -> _BlockRequest:
    _source(plc, block.DESTADDR, block.READLEN)
    data = _source(plc, block.SRCADDR, block.WRITELEN)
    request = ReadWriteRequest(block.IDXGRP, block.IDXOFFS, block.READLEN, data)
    return _BlockRequest(Command.READ_WRITE, request, block.DESTADDR, block.READLEN)


def _read_state(plc: BuiltinContext, block: Any) -> _BlockRequest:
    return _BlockRequest(Command.READ_STATE, EmptyRequest())


def _read_device_info(plc: BuiltinContext, block: Any) -> _BlockRequest:
    return _BlockRequest(Command.READ_DEVICE_INFO, EmptyRequest())


def _write_control(plc: BuiltinContext, block: Any) -> _BlockRequest:
    data = _source(plc, block.SRCADDR, block.LEN)
    return _BlockRequest(
        Command.WRITE_CONTROL, WriteControlRequest(block.ADSSTATE, block.DEVSTATE, data)
    )


def _count(block: Any, entry: _Open) -> None:
    block.COUNT_R = entry.count


def _state(block: Any, entry: _Open) -> None:
    assert isinstance(entry.response, ReadStateResponse)
    block.ADSSTATE, block.DEVSTATE = entry.response.ads_state, entry.response.device_state


def _device_info(block: Any, entry: _Open) -> None:
    """Answer DEVVER: version, revision and build, from the lowest byte on."""
    info = entry.response
    assert isinstance(info, ReadDeviceInfoResponse)
    block.DEVNAME = info.name
    block.DEVVER = info.major | info.minor << 8 | info.build << 16
