"""A PLC as server: requests that its programs answer, by ADSREADIND, ADSREADRES and so on.

Requests to index groups 0x80000000 to 0x80FFFFFF wait for a program that fetches them; the answer
leaves when the cycle has ended in which the program gave it. Up to 10 of each kind are queued until
they are answered, further ones are refused with 0x716. Source: Tc2_System, expanded ADS blocks.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from achse.ams import AdsError, AmsAddress, Command, Frame
from achse.ams.commands import (
    DataResponse,
    ReadRequest,
    ReadWriteRequest,
    ResultResponse,
    WriteRequest,
)
from achse.codes import ReturnCode
from achse.plc.routines.builtins import BlockBody, BuiltinContext

_FIRST_GROUP, _LAST_GROUP = 0x8000_0000, 0x80FF_FFFF
_MOST = 10
"""Requests of a kind that are not answered yet."""

_INDICATIONS = {
    Command.READ: "adsreadind",
    Command.WRITE: "adswriteind",
    Command.READ_WRITE: "adsrdwrtind",
}
"""The blocks that take requests, by the command."""


_DataRequest = ReadRequest | WriteRequest | ReadWriteRequest
_REQUESTS: Mapping[Command, type[_DataRequest]] = {
    Command.READ: ReadRequest,
    Command.WRITE: WriteRequest,
    Command.READ_WRITE: ReadWriteRequest,
}


@dataclass(slots=True)
class _Waiting:
    """A request that is not answered yet."""

    frame: Frame
    request: _DataRequest
    is_taken: bool = False


def _room(request: ReadRequest | ReadWriteRequest) -> int:
    return request.length if isinstance(request, ReadRequest) else request.read_length


class PlcIndications:
    """Requests of clients to the programs of one PLC."""

    def __init__(self) -> None:
        self._reply: Callable[[Frame], None] | None = None
        self._waiting: dict[Command, list[_Waiting]] = {command: [] for command in _INDICATIONS}
        self._out: list[Frame] = []
        self.blocks: Mapping[str, BlockBody] = {
            "adsreadind": self._indication(Command.READ),
            "adswriteind": self._indication(Command.WRITE),
            "adsrdwrtind": self._indication(Command.READ_WRITE),
            "adsreadres": self._response(Command.READ),
            "adswriteres": self._response(Command.WRITE),
            "adsrdwrtres": self._response(Command.READ_WRITE),
        }
        """Function blocks of `tc2_system/serving.st`."""

    def connect(self, reply: Callable[[Frame], None]) -> None:
        """Answer by `reply` from now on."""
        self._reply = reply

    def take(self, frame: Frame, has_block: Callable[[str], bool]) -> bool:
        """Keep a request for the programs; False if it is not for them.

        `has_block`: True if the project uses a block of a name.
        """
        name = next(
            (indication for one, indication in _INDICATIONS.items() if one == frame.command), ""
        )
        group = int.from_bytes(frame.data[:4], "little")
        if not (name and _FIRST_GROUP <= group <= _LAST_GROUP and has_block(name)):
            return False
        command = Command(frame.command)
        waiting = self._waiting[command]
        if len(waiting) >= _MOST:
            self._answer(frame, ReturnCode.NO_MORE_HANDLES.number)
            return True
        try:
            waiting.append(_Waiting(frame, _REQUESTS[command].decode(frame.data)))
        except AdsError:
            return False  # the device reports what is wrong with it
        return True

    def end_cycle(self) -> None:
        """Send what the programs have answered."""
        out, self._out = self._out, []
        for frame in out:
            if self._reply is not None:
                self._reply(frame)

    def forget(self) -> None:
        """Drop the requests of programs that begin again."""
        for waiting in self._waiting.values():
            for one in waiting:
                self._answer(one.frame, ReturnCode.INVALID_STATE.number)
            waiting.clear()
        self.end_cycle()

    def _answer(self, frame: Frame, result: int, data: bytes = b"") -> None:
        if frame.command == Command.WRITE:
            answer = ResultResponse(result).encode()
        else:
            answer = DataResponse(result, data).encode()
        self._out.append(frame.reply(answer))

    # blocks ----------------------------------------------------------------------------------

    def _indication(self, command: Command) -> BlockBody:
        """Shows the next request while CLEAR is FALSE, until CLEAR rises."""

        def run(plc: BuiltinContext, block: Any) -> None:
            if block.CLEAR:
                if not block.before:
                    self._clear(plc, block)
            elif not block.VALID:
                for one in self._waiting[command]:
                    if not one.is_taken:
                        self._show(plc, block, one)
                        break
            block.before = block.CLEAR

        return run

    def _clear(self, plc: BuiltinContext, block: Any) -> None:
        block.VALID, block.NETID = False, ""
        block.PORT = block.INVOKEID = block.IDXGRP = block.IDXOFFS = 0
        if hasattr(block, "LENGTH"):
            block.LENGTH = 0
        else:
            block.RDLENGTH = block.WRTLENGTH = 0
        if hasattr(block, "DATAADDR"):
            address, block.DATAADDR = int(block.DATAADDR), 0
            if address:
                plc.free_bytes(address)

    def _show(self, plc: BuiltinContext, block: Any, one: _Waiting) -> None:
        request = one.request
        data = b"" if isinstance(request, ReadRequest) else request.data
        if data:
            address = plc.make_bytes(data)
            if not address:
                self._waiting[Command(one.frame.command)].remove(one)
                self._answer(one.frame, ReturnCode.DEVICE_NO_MEMORY.number)
                return
            block.DATAADDR = address
        source = AmsAddress(one.frame.source)
        block.NETID, block.PORT = str(source.net_id), source.port
        block.INVOKEID = one.frame.invoke_id
        block.IDXGRP, block.IDXOFFS = request.index_group, request.index_offset
        if isinstance(request, ReadRequest):
            block.LENGTH = request.length
        elif isinstance(request, WriteRequest):
            block.LENGTH = len(data)
        else:
            block.RDLENGTH, block.WRTLENGTH = request.read_length, len(data)
        one.is_taken = block.VALID = True

    def _response(self, command: Command) -> BlockBody:
        """Answers a request when RESPOND rises; one that is unknown is passed over."""

        def run(plc: BuiltinContext, block: Any) -> None:
            wanted = block.RESPOND
            rises, block.before = wanted and not block.before, wanted
            if not rises:
                return
            for one in self._waiting[command]:
                source = AmsAddress(one.frame.source)
                if one.frame.invoke_id != block.INVOKEID or source.port != block.PORT:
                    continue
                if str(source.net_id) != block.NETID:
                    continue
                self._waiting[command].remove(one)
                data = b""
                if not isinstance(one.request, WriteRequest) and block.LEN and block.DATAADDR:
                    size = min(block.LEN, _room(one.request))
                    data = plc.load_bytes(int(block.DATAADDR), size) if size else b""
                self._answer(one.frame, block.RESULT, data)
                return

        return run
