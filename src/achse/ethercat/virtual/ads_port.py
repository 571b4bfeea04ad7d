"""ADS port of a virtual slave (AoE): its objects, name and state.

Source: ETG.1020 §3 (AoE); manuals of modules with AoE for group 0xF302.
"""

import struct
from collections.abc import Callable, Iterable
from typing import Protocol

from achse.codes import AlState, ReturnCode, SdoAbort, return_code_of
from achse.ethercat.mailbox import MailboxError

_HEAD = struct.Struct("<8s8sHHIII")
_RESPONSE = 0x0001
_NAME, _READ, _WRITE, _STATE = 1, 2, 3, 4
_PLACE = struct.Struct("<III")
_OBJECTS = 0xF302
_COMPLETE = 1 << 8
_VERSION = bytes((1, 0, 0, 0))
_RUN, _STOP = 5, 6


class _Objects(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def state(self) -> AlState: ...
    def read_object(self, index: int, subindex: int) -> bytes: ...
    def write_object(self, index: int, subindex: int, data: bytes) -> None: ...


class AdsPort:
    """Answers ADS requests from a device's objects, whatever NetId and port they are for.

    Entries are at group 0xF302, index and subindex in the offset; an object as a whole is refused,
    and so are all other groups and commands (0x701, 0x702).
    """

    def __init__(self, device: _Objects, room: int) -> None:
        self._device = device
        self.open(room)
        self._commands: dict[int, Callable[[bytes], bytes | ReturnCode]] = {
            _NAME: self._name, _READ: self._read, _WRITE: self._write, _STATE: self._state,
        }  # fmt: skip

    def open(self, room: int) -> None:
        """Begin again with replies of up to `room` bytes."""
        self._room = room

    def answer(self, data: bytes) -> Iterable[bytes] | int:
        """Return the reply to a packet, or a mailbox error; responses are taken in silence."""
        if len(data) < _HEAD.size:
            return MailboxError.SIZE_TOO_SHORT
        target, source, command, flags, length, _, invoke = _HEAD.unpack_from(data)
        body = data[_HEAD.size :]
        if length != len(body):
            return MailboxError.INVALID_SIZE
        if flags & _RESPONSE:
            return ()
        do = self._commands.get(command)
        outcome = ReturnCode.SERVICE_NOT_SUPPORTED if do is None else do(body)
        if not isinstance(outcome, bytes):
            # commands without data answer with the code alone, a read with its length too
            outcome = int(outcome).to_bytes(4, "little") + bytes(4 * (command == _READ))
        head = _HEAD.pack(source, target, command, flags | _RESPONSE, len(outcome), 0, invoke)
        return (head + outcome,)

    def _name(self, _: bytes) -> bytes:
        name = self._device.name.encode("latin-1", "replace")[:15].ljust(16, b"\0")
        return bytes(4) + _VERSION + name

    def _state(self, _: bytes) -> bytes:
        state = self._device.state
        return struct.pack("<IHH", 0, _RUN if state is AlState.OP else _STOP, int(state))

    def _read(self, body: bytes) -> bytes | ReturnCode:
        if len(body) != _PLACE.size:
            return ReturnCode.INVALID_SIZE
        group, offset, length = _PLACE.unpack(body)
        if group != _OBJECTS or offset & _COMPLETE:
            return ReturnCode.INVALID_GROUP
        try:
            value = self._device.read_object(offset >> 16, offset & 0xFF)
        except SdoAbort as abort:
            return return_code_of(abort.code)
        if len(value) > min(length, self._room - _HEAD.size - 8):
            return ReturnCode.INVALID_SIZE
        return struct.pack("<II", 0, len(value)) + value

    def _write(self, body: bytes) -> bytes | ReturnCode:
        if len(body) < _PLACE.size:
            return ReturnCode.INVALID_SIZE
        group, offset, length = _PLACE.unpack_from(body)
        data = body[_PLACE.size :]
        if group != _OBJECTS or offset & _COMPLETE:
            return ReturnCode.INVALID_GROUP
        if len(data) != length:
            return ReturnCode.INVALID_SIZE
        try:
            self._device.write_object(offset >> 16, offset & 0xFF, data)
        except SdoAbort as abort:
            return return_code_of(abort.code)
        return bytes(4)
