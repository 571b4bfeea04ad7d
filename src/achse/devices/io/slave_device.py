"""A slave of a bus, at the port of its station address: objects by SDO, descriptions, last errors.

Source: the header of ADS interfaces that the vendor publishes; 002 for blocks that use it.
"""

import struct
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from typing import ClassVar

from achse.ams import AdsState, DeviceError
from achse.codes import ReturnCode
from achse.devices.io.groups import SlaveGroup
from achse.devices.io.later import answer_later
from achse.devices.io.served import ServedBus, bus_error
from achse.devices.io.slave_files import SlaveFiles
from achse.ethercat.description import MailboxBit
from achse.ethercat.master import BusError, BusSlave, SdoRefusal
from achse.ethercat.master.errors import WrongAnswer
from achse.ethercat.master.foe_client import FoeRefusal
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.pdo_client import MAX_PDO, PdoClient
from achse.ethercat.master.sdo_client import SdoClient
from achse.ethercat.master.soe_client import SoeClient, SoeRefusal
from achse.ethercat.master.steps import Steps
from achse.ethercat.master.voe_client import VendorMessage, VoeClient
from achse.ethercat.pdo_service import RX_PDO, TX_PDO
from achse.server import Device, IndexGroup, RawGroup

_COMPLETE, _LONG = 0x0100, 0x0200
"""Bits of an offset: the whole object; ten times the time."""
_PATIENCE = 10
_U32 = 0xFFFF_FFFF
_PART = struct.Struct("<III")
_MOST_PARTS = 500
_MOST_CLIENTS = 64
_MOST_BYTES = 1 << 20
_HEADER = "vendor's interface header"
_LIST, _OBJECT, _ENTRY = 1, 3, 5
_REFUSALS = (SdoRefusal, FoeRefusal, SoeRefusal)


class BusSlaveDevice(Device):
    """Answers for one slave."""

    accepted_states: ClassVar[Mapping[int, AdsState]] = {AdsState.RUN: AdsState.RUN}

    def __init__(self, bus: ServedBus, slave: BusSlave, *, clock: Callable[[], int]) -> None:
        self.bus = bus
        self.station = slave.station
        self._errors: OrderedDict[bytes, tuple[int, str]] = OrderedDict()
        self._files = SlaveFiles(bus, self._mailbox, self._note)
        super().__init__(slave.name, (1, 0, 0), self._own_groups(), clock=clock)

    @property
    def slave(self) -> BusSlave:
        """The slave at that address; another object where the bus was searched again."""
        return self.bus.slave(self.station)

    def _own_groups(self) -> Iterator[IndexGroup]:
        yield RawGroup(
            SlaveGroup.SDO,
            "object",
            read=self._read,
            write=self._write,
            last_offset=_U32,
            description="SDO upload and download; offset = index << 16 | subindex, + 0x100 complete"
            " access, + 0x200 ten times the time. Longer than requested is 0x705",
            source=_HEADER,
        )
        for group, name in (
            (SlaveGroup.SDO_ERROR, "last SDO error"),
            (SlaveGroup.FILE_ERROR, "last error of a file"),
            (SlaveGroup.SERVO_ERROR, "last error of a parameter"),
        ):
            yield RawGroup(
                group,
                name,
                read=self._read_error,
                response="AMS address of the client; UINT32 code of the slave; text",
                description="The last of this client, of any kind; without one zeros",
                source=_HEADER,
            )
        yield from self._files.groups()
        yield RawGroup(
            SlaveGroup.SERVO_PARAMETER,
            "parameter of a SERCOS drive",
            read=self._read_parameter,
            write=self._write_parameter,
            last_offset=_U32,
            description="SoE; offset = IDN | element << 16 | drive << 24",
            source=_HEADER,
        )
        for group, name, read_write in (
            (SlaveGroup.SDO_SUM_READ, "objects, read", self._sum_read),
            (SlaveGroup.SDO_SUM_WRITE, "objects, written", self._sum_write),
        ):
            yield RawGroup(
                group,
                name,
                read_write=read_write,
                last_offset=_MOST_PARTS,
                request="UINT32 group, offset, length each; for writes the data behind",
                response="UINT32 result (for reads result and length) each; data",
                description="Many SDO requests in one; offset: how many",
                source=_HEADER,
            )
        yield RawGroup(
            SlaveGroup.VENDOR_SPECIFIC,
            "message of a vendor's own form",
            read=self._read_vendor,
            write=self._write_vendor,
            read_write=self._request_vendor,
            request="UINT32 vendor; UINT16 type; BYTE[n]",
            response="read: UINT32 how many came, UINT32 vendor, UINT16 type, BYTE[n] of the last;"
            " read and write: UINT32 vendor, UINT16 type, BYTE[n]",
            description="VoE. Write sends, a notification has what comes; read and write"
            " requests and waits for the next of that vendor",
            source=_HEADER,
        )
        for group, name, operation, request in (
            (SlaveGroup.OBJECT_LIST, "list of objects", _LIST, "list type << 16"),
            (SlaveGroup.OBJECT_DESCRIPTION, "description of an object", _OBJECT, "index << 16"),
            (
                SlaveGroup.ENTRY_DESCRIPTION,
                "description of an entry",
                _ENTRY,
                "index << 16 | value info << 8 | subindex",
            ),
        ):
            yield RawGroup(
                group,
                name,
                read=self._describe(operation),
                last_offset=_U32,
                description=f"SDO information behind its header; offset = {request}",
                source=_HEADER,
            )
        for group, name, base, write in (
            (SlaveGroup.TX_PDO, "TxPDO by mailbox", TX_PDO, None),
            (SlaveGroup.RX_PDO, "RxPDO by mailbox", RX_PDO, self._write_pdo),
        ):
            yield RawGroup(
                group,
                name,
                read=self._read_pdo(base),
                write=write,
                last_offset=_U32,
                description=f"A whole PDO; offset: its number, 0 to {MAX_PDO}, or {base:04X}h + it."
                " A slave does not say what becomes of one that is written",
                source=_HEADER,
            )
        yield RawGroup(
            SlaveGroup.NETWORK_INFORMATION,
            "network information",
            read=_unserved,
            write=_unserved_write,
            read_write=_unserved_both,
            last_offset=_U32,
            description="Not served: answers 0x701",
            source=_HEADER,
        )

    # objects

    def _sdo(self) -> SdoClient:
        slave = self.slave
        if slave.sdo is None:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{slave.name} has no CoE")
        if not slave.speaks:
            raise DeviceError(
                ReturnCode.INVALID_STATE, f"{slave.name} is in state {slave.state}: CoE needs PreOp"
            )
        return slave.sdo

    def _patience(self, offset: int) -> int:
        own = self.slave.configuration.times.response_ns
        return own * (_PATIENCE if offset & _LONG else 1)

    def _upload(self, sdo: SdoClient, offset: int) -> Steps[bytes]:
        return sdo.upload(
            offset >> 16,
            offset & 0xFF,
            complete=bool(offset & _COMPLETE),
            response_ns=self._patience(offset),
        )

    def _download(self, sdo: SdoClient, offset: int, data: bytes) -> Steps[None]:
        return sdo.download(
            offset >> 16,
            offset & 0xFF,
            data,
            complete=bool(offset & _COMPLETE),
            response_ns=self._patience(offset),
        )

    def _read(self, offset: int, length: int, client: bytes) -> bytes:
        raise answer_later(
            self.bus.master,
            self._upload(self._sdo(), offset),
            lambda value: _whole(value, length),
            lambda trouble: self._note(client, trouble),
        )

    def _write(self, offset: int, data: bytes, client: bytes) -> None:
        raise answer_later(
            self.bus.master,
            self._download(self._sdo(), offset, data),
            lambda value: b"",
            lambda trouble: self._note(client, trouble),
        )

    # PDOs

    def _pdos(self) -> PdoClient:
        self._sdo()  # speaks CoE, now
        assert self.slave.mailbox is not None
        return PdoClient(self.slave.mailbox)

    def _read_pdo(self, base: int) -> Callable[[int, int, bytes], bytes]:
        def read(offset: int, length: int, client: bytes) -> bytes:
            number = _pdo_number(offset, base)
            raise answer_later(
                self.bus.master,
                self._pdos().read(number, output=base == RX_PDO),
                lambda value: _whole(value, length),
                lambda trouble: self._note(client, trouble),
            )

        return read

    def _write_pdo(self, offset: int, data: bytes, client: bytes) -> None:
        number = _pdo_number(offset, RX_PDO)
        raise answer_later(
            self.bus.master,
            self._pdos().write(number, data),
            lambda none: b"",
            lambda trouble: self._note(client, trouble),
        )

    # parameters

    def _mailbox(self) -> MailboxClient:
        slave = self.slave
        if slave.mailbox is None:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{slave.name} has no mailbox")
        if not slave.present or slave.state < 2:
            raise DeviceError(
                ReturnCode.INVALID_STATE,
                f"{slave.name} is in state {slave.state}: its mailbox needs PreOp",
            )
        return slave.mailbox

    def _soe(self) -> SoeClient:
        return SoeClient(self._mailbox())

    def _read_parameter(self, offset: int, length: int, client: bytes) -> bytes:
        idn, element, drive = offset & 0xFFFF, offset >> 16 & 0xFF, offset >> 24 & 7
        raise answer_later(
            self.bus.master,
            self._soe().read(idn, element, drive),
            lambda value: _whole(value, length),
            lambda trouble: self._note(client, trouble),
        )

    def _write_parameter(self, offset: int, data: bytes, client: bytes) -> None:
        idn, element, drive = offset & 0xFFFF, offset >> 16 & 0xFF, offset >> 24 & 7
        raise answer_later(
            self.bus.master,
            self._soe().write(idn, data, element, drive),
            lambda none: b"",
            lambda trouble: self._note(client, trouble),
        )

    # messages of a vendor's own form

    def _voe(self) -> VoeClient:
        """Return the client of VoE; DeviceError 0x701 for a slave that does not speak it."""
        voe = self.slave.voe
        if voe is None or not self.slave.configuration.protocols & MailboxBit.VOE:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{self.name} does not speak VoE")
        return voe

    def _ready_voe(self) -> VoeClient:
        voe = self._voe()
        self._mailbox()
        return voe

    def _read_vendor(self, offset: int, length: int, client: bytes) -> bytes:
        voe = self._voe()
        last = voe.last or VendorMessage(0, 0)
        return ((voe.count & _U32).to_bytes(4, "little") + last.encode())[:length]

    def _write_vendor(self, offset: int, data: bytes, client: bytes) -> None:
        raise answer_later(
            self.bus.master,
            self._ready_voe().send(_vendor_message(data)),
            lambda none: b"",
            lambda trouble: self._note(client, trouble),
        )

    def _request_vendor(self, offset: int, length: int, data: bytes, client: bytes) -> bytes:
        raise answer_later(
            self.bus.master,
            self._ready_voe().request(_vendor_message(data)),
            lambda answer: _whole(answer.encode(), length),
            lambda trouble: self._note(client, trouble),
        )

    # errors

    def _note(self, client: bytes, trouble: BusError) -> None:
        """Keep the last error of a client; those of the most recent clients stay."""
        number = trouble.number if isinstance(trouble, _REFUSALS) else 0
        self._errors.pop(client, None)
        self._errors[client] = number, str(trouble)
        while len(self._errors) > _MOST_CLIENTS:
            self._errors.popitem(last=False)

    def _read_error(self, offset: int, length: int, client: bytes) -> bytes:
        number, text = self._errors.get(client, (0, ""))
        return client.ljust(8, b"\0") + number.to_bytes(4, "little") + text.encode() + b"\0"

    def end_client(self, client: bytes) -> None:
        """Note that a client is gone; its last error with it."""
        self._errors.pop(client, None)
        self._files.end_client(client)
        super().end_client(client)

    # many in one

    def _parts(self, count: int, data: bytes) -> list[tuple[int, int]]:
        """Offset and length of each part; DeviceError for a request that does not hold together."""
        if not 0 < count <= _MOST_PARTS:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"1 to {_MOST_PARTS} parts, got {count}")
        if len(data) < count * _PART.size:
            raise DeviceError(
                ReturnCode.INVALID_SIZE, f"{count} parts of 12 bytes, got {len(data)} bytes"
            )
        parts = []
        for number in range(count):
            group, offset, length = _PART.unpack_from(data, number * _PART.size)
            if group != SlaveGroup.SDO:
                raise DeviceError(ReturnCode.INVALID_GROUP, f"0x{group:X} in a sum of objects")
            parts.append((offset, length))
        if sum(length for _, length in parts) > _MOST_BYTES:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"{_MOST_BYTES} bytes in all at most")
        return parts

    def _sum_read(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        parts = self._parts(offset, data)
        sdo = self._sdo()

        def steps() -> Steps[bytes]:
            heads, values = b"", b""
            for place, length in parts:
                try:
                    value = _whole((yield from self._upload(sdo, place)), length)
                    code = 0
                except (BusError, DeviceError) as trouble:
                    value, code = b"", self._code(client, trouble)
                heads += struct.pack("<II", code, len(value))
                values += value
            return heads + values

        raise answer_later(self.bus.master, steps(), lambda answer: answer[:read_length])

    def _sum_write(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        parts = self._parts(offset, data)
        if len(data) != len(parts) * _PART.size + sum(length for _, length in parts):
            raise DeviceError(ReturnCode.INVALID_SIZE, "the lengths do not sum up to the data")
        sdo = self._sdo()

        def steps() -> Steps[bytes]:
            results = b""
            at = len(parts) * _PART.size
            for place, length in parts:
                try:
                    yield from self._download(sdo, place, data[at : at + length])
                    code = 0
                except BusError as trouble:
                    code = self._code(client, trouble)
                results += code.to_bytes(4, "little")
                at += length
            return results

        raise answer_later(self.bus.master, steps(), lambda answer: answer[:read_length])

    def _code(self, client: bytes, trouble: BusError | DeviceError) -> int:
        if isinstance(trouble, DeviceError):
            return int(trouble.code)
        self._note(client, trouble)
        return int(bus_error(trouble).code)

    # descriptions

    def _describe(self, operation: int) -> Callable[[int, int, bytes], bytes]:
        def read(offset: int, length: int, client: bytes) -> bytes:
            request = (offset >> 16).to_bytes(2, "little")
            if operation == _ENTRY:
                request += bytes((offset & 0xFF, offset >> 8 & 0xFF))
            raise answer_later(
                self.bus.master,
                self._sdo().inform(operation, request),
                lambda value: _whole(value, length),
                lambda trouble: self._note(client, trouble),
            )

        return read


def _pdo_number(offset: int, base: int) -> int:
    number = offset - base if offset >= base else offset
    if number > MAX_PDO:
        raise DeviceError(
            ReturnCode.INVALID_OFFSET, f"a PDO has the number 0 to {MAX_PDO}, got 0x{offset:X}"
        )
    return number


def _vendor_message(data: bytes) -> VendorMessage:
    try:
        return VendorMessage.decode(data)
    except WrongAnswer as fault:
        raise DeviceError(ReturnCode.INVALID_SIZE, str(fault)) from None


def _whole(value: bytes, length: int) -> bytes:
    if len(value) > length:
        raise DeviceError(ReturnCode.INVALID_SIZE, f"the object has {len(value)} bytes")
    return value


def _unserved(offset: int, length: int, client: bytes) -> bytes:
    raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "not served for slaves")


def _unserved_write(offset: int, data: bytes, client: bytes) -> None:
    _unserved(offset, 0, client)


def _unserved_both(offset: int, length: int, data: bytes, client: bytes) -> bytes:
    return _unserved(offset, length, client)
