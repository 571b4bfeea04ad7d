"""Parameters of a virtual SERCOS drive (SoE): the IDNs that its ESI file names.

These are the IDNs of start commands, those that PDOs of a device without CoE map, and the lists of
what is mapped: S-0-0016 (to the master) and S-0-0024 (from it). The words that are always mapped,
S-0-0134 and S-0-0135, are not in the lists.

Source: ETG.1000.6 §5.9; ETG.2000, SoE InitCmd; error codes and attributes as an open master has
them.
"""

import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from achse.codes import DataType
from achse.ethercat.description import PdoEntry
from achse.ethercat.mailbox import MailboxError
from achse.ethercat.master.esi_reader import EsiDevice
from achse.ethercat.master.soe_client import SoeElement
from achse.ethercat.master.xml_document import number_of

_HEAD = struct.Struct("<BBH")
_READ, _READ_ANSWER, _WRITE, _WRITE_ANSWER = 1, 2, 3, 4
_OPERATION, _INCOMPLETE, _ERROR = 0x07, 0x08, 0x10
_MOST_DRIVES = 8
_LIST_HEAD = struct.Struct("<HH")
_INPUT_LIST, _OUTPUT_LIST, _CONTROL_WORD, _STATUS_WORD = 16, 24, 134, 135
_NO_IDN, _NO_UNIT, _NO_MINIMUM, _NO_MAXIMUM = 0x1001, 0x4001, 0x5001, 0x6001
_TOO_SHORT, _TOO_LONG, _READ_ONLY, _INVALID_DATA = 0x7002, 0x7003, 0x7004, 0x7008
_UNCHANGEABLE = {
    SoeElement.NAME: 0x2004, SoeElement.ATTRIBUTE: 0x3004, SoeElement.UNIT: 0x4004,
    SoeElement.MINIMUM: 0x5004, SoeElement.MAXIMUM: 0x6004,
}  # fmt: skip
_ABSENT = {
    SoeElement.UNIT: _NO_UNIT, SoeElement.MINIMUM: _NO_MINIMUM, SoeElement.MAXIMUM: _NO_MAXIMUM,
}  # fmt: skip
_SIZES = {1: 0, 2: 1, 4: 2, 8: 3}
_SIZE_SHIFT, _LIST_BIT, _TYPE_SHIFT = 16, 1 << 18, 20
_UNSIGNED, _SIGNED, _HEXADECIMAL, _IDN, _REAL = 1, 2, 3, 5, 6
_LONGEST = 1 << 16


@dataclass
class _Parameter:
    """An IDN of one drive: `value` with its lengths in front for a list."""

    name: str
    value: bytes
    kind: int = _HEXADECIMAL
    is_list: bool = False
    writable: bool = True

    @property
    def attribute(self) -> int:
        size = 2 if self.is_list else len(self.value)
        shift = _SIZES.get(size, 0) << _SIZE_SHIFT
        return shift | self.is_list * _LIST_BIT | self.kind << _TYPE_SHIFT | 1

    def element(self, element: SoeElement) -> bytes | int:
        """Return the bytes of an element, or the code of one that is not there."""
        match element:
            case SoeElement.STATUS:
                return bytes(2)
            case SoeElement.NAME:
                name = self.name.encode("latin-1", "replace")
                return _LIST_HEAD.pack(len(name), len(name)) + name
            case SoeElement.ATTRIBUTE:
                return self.attribute.to_bytes(4, "little")
            case SoeElement.VALUE | SoeElement.DEFAULT:
                return self.value
        return _ABSENT[element]


class SercosParameters:
    """The drives of a device; `room` is how long an answer may be behind its mailbox header."""

    def __init__(self, device: EsiDevice, room: int) -> None:
        """ValueError for a start command that cannot be read."""
        self.open(room)
        element = None if device.element is None else device.element.find("Mailbox/SoE")
        channels = 1 if element is None else number_of(element.get("ChannelCount", "1"), "SoE")
        if not 1 <= channels <= _MOST_DRIVES:
            raise ValueError(f"SoE ChannelCount: expected 1 to {_MOST_DRIVES}, got {channels}")
        self._drives: list[dict[int, _Parameter]] = [
            dict(_mapped(device)) if "CoE" not in device.protocols else {} for _ in range(channels)
        ]
        for command in device.idn_commands:
            drive, idn = command.drive, command.idn
            if not drive < channels or not idn:
                raise ValueError(f"SoE InitCmd: no IDN {idn} of drive {drive}")
            self._drives[drive].setdefault(idn, _Parameter(command.comment, command.data))

    def open(self, room: int) -> None:
        """Begin again with replies of up to `room` bytes behind their mailbox header."""
        self._room = max(room - _HEAD.size, 1)
        self._end_pending()

    def _end_pending(self) -> None:
        self._pending = bytearray()
        self._expected: tuple[int, int, int] | None = None
        """Drive, elements and number of fragments left that the next fragment has; None where a
        write begins."""

    def value(self, idn: int, drive: int = 0) -> bytes:
        """Return the value of an IDN; KeyError."""
        return self._drives[drive][idn].value

    def answer(self, data: bytes) -> Iterable[bytes] | int:
        """Return the reply to a message, in fragments, or a mailbox error.

        A fragment of another write than the pending one (another drive, other elements, a number of
        fragments left that does not follow) is refused with 0x7008; the pending write ends with it.
        Only the last fragment has the IDN.
        """
        if len(data) < _HEAD.size:
            return MailboxError.SIZE_TOO_SHORT
        flags, elements, idn = _HEAD.unpack_from(data)
        operation, drive = flags & _OPERATION, flags >> 5
        if operation == _READ:
            self._end_pending()
            outcome = self._read(drive, idn, elements)
            if isinstance(outcome, bytes):
                return list(self._fragments(drive, elements, idn, outcome))
            return (_refusal(_READ_ANSWER, drive, elements, idn, outcome),)
        if operation != _WRITE:
            return MailboxError.SERVICE_NOT_SUPPORTED
        left = idn if flags & _INCOMPLETE else 0
        if self._expected not in (None, (drive, elements, left)):
            self._end_pending()
            return (_refusal(_WRITE_ANSWER, drive, elements, idn, _INVALID_DATA),)
        self._pending += data[_HEAD.size :]
        if len(self._pending) > _LONGEST:
            self._end_pending()
            return MailboxError.NO_MEMORY
        if flags & _INCOMPLETE:
            self._expected = (drive, elements, left - 1)
            return ()
        value = bytes(self._pending)
        self._end_pending()
        code = self._write(drive, idn, elements, value)
        if code:
            return (_refusal(_WRITE_ANSWER, drive, elements, idn, code),)
        return (_HEAD.pack(_WRITE_ANSWER | drive << 5, elements, idn),)

    def _parameter(self, drive: int, idn: int) -> _Parameter | None:
        return self._drives[drive].get(idn) if drive < len(self._drives) else None

    def _read(self, drive: int, idn: int, elements: int) -> bytes | int:
        parameter = self._parameter(drive, idn)
        if parameter is None:
            return _NO_IDN
        parts = []
        for element in SoeElement:
            if element & elements:
                part = parameter.element(element)
                if isinstance(part, int):
                    return part
                parts.append(part)
        return b"".join(parts)

    def _write(self, drive: int, idn: int, elements: int, value: bytes) -> int:
        """Code of a refusal, 0 for a value that is taken over."""
        parameter = self._parameter(drive, idn)
        if parameter is None:
            return _NO_IDN
        if elements != SoeElement.VALUE:
            codes = (code for each, code in _UNCHANGEABLE.items() if each & elements)
            return next(codes, _READ_ONLY)
        if not parameter.writable:
            if not parameter.is_list:
                return _READ_ONLY
            content = slice(_LIST_HEAD.size, None)
            return 0 if value[content] == parameter.value[content] else _INVALID_DATA
        if len(value) != len(parameter.value):
            return _TOO_SHORT if len(value) < len(parameter.value) else _TOO_LONG
        parameter.value = value
        return 0

    def _fragments(self, drive: int, elements: int, idn: int, value: bytes) -> Iterator[bytes]:
        room = self._room
        parts = [value[at : at + room] for at in range(0, len(value), room)] or [b""]
        for left, part in zip(range(len(parts) - 1, -1, -1), parts, strict=True):
            flags = _READ_ANSWER | drive << 5 | (_INCOMPLETE if left else 0)
            yield _HEAD.pack(flags, elements, left or idn) + part


def _refusal(operation: int, drive: int, elements: int, idn: int, code: int) -> bytes:
    head = _HEAD.pack(operation | _ERROR | drive << 5, elements, idn)
    return head + code.to_bytes(2, "little")


def _mapped(device: EsiDevice) -> Iterator[tuple[int, _Parameter]]:
    """Yield the parameters that PDOs map, whose entries have the IDN as index, and their lists.

    A master may write the lists, as start commands do; the mapping is that of the file, so that a
    list with other IDNs is refused.
    """
    for which, pdos, always in (
        (_OUTPUT_LIST, device.outputs, _CONTROL_WORD),
        (_INPUT_LIST, device.inputs, _STATUS_WORD),
    ):
        entries = [entry for each in pdos for entry in each.pdo.entries if entry.index]
        for entry in entries:
            yield entry.index, _of_entry(entry)
        listed = [entry.index for entry in entries if entry.index != always]
        yield which, _idn_list(f"IDNs of PDO {which}", listed)


def _of_entry(entry: PdoEntry) -> _Parameter:
    size = min(max(entry.bits + 7 >> 3, 1), 8)
    kind = _HEXADECIMAL
    if entry.data_type in (DataType.F32, DataType.F64):
        kind = _REAL
    elif entry.data_type in (DataType.I8, DataType.I16, DataType.I32, DataType.I64):
        kind = _SIGNED
    elif entry.data_type in (DataType.U8, DataType.U16, DataType.U32, DataType.U64):
        kind = _UNSIGNED
    return _Parameter(entry.name, bytes(size), kind)


def _idn_list(name: str, idns: Sequence[int]) -> _Parameter:
    size = 2 * len(idns)
    value = _LIST_HEAD.pack(size, size) + b"".join(each.to_bytes(2, "little") for each in idns)
    return _Parameter(name, value, _IDN, is_list=True, writable=False)
