"""The Modbus server, AMS port 10500: it forwards requests of PLC blocks to Modbus devices.

The vendor's numbers of these services are in no manual at hand; these are ours. Errors are those
of the manual of TF6250, return codes: 0x8000 + exception code, 0x80070000 + number of Windows.
"""

import asyncio
import errno
import socket
import struct
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError, Future
from ipaddress import AddressValueError, IPv4Address

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.modbus.pdu import (
    DEVICE_FAILURE,
    ILLEGAL_ADDRESS,
    ModbusRefusal,
    Query,
    answer_data,
    request_pdu,
)
from achse.server import Device, RawGroup
from achse.server.deferred import Answer, Deferred
from achse.transport.modbus import ModbusAnswerError, ModbusBusyError, ModbusClient, ModbusPeer

MODBUS_PORT = 10_500
REQUESTS = 1
"""Index group of requests; offset 0 goes by TCP, 1 by UDP."""

_REQUEST = struct.Struct("<16sHBBIHHHHI")
_EXCEPTION = 0x8000
_WINDOWS = 0x8007_0000
_LONGEST_S = 60.0
"""Longest time that a request waits for its answer, whatever its time-out."""

_ACCESS_DENIED, _BAD_ADDRESS, _RESET, _NO_SUCH_HOST = 10_013, 10_049, 10_054, 11_001
_NUMBERS: Mapping[int, int] = {
    errno.EACCES: _ACCESS_DENIED,
    errno.EADDRNOTAVAIL: _BAD_ADDRESS,
    errno.ENETUNREACH: 10_051,
    errno.ECONNABORTED: 10_053,
    errno.ECONNRESET: _RESET,
    errno.EPIPE: _RESET,
    errno.ETIMEDOUT: 10_060,
    errno.ECONNREFUSED: 10_061,
    errno.EHOSTUNREACH: 10_065,
}
"""Windows' numbers of what sockets say."""


class ModbusDevice(Device):
    """AMS device that queries Modbus devices for the PLC.

    `find(address, port)` returns the device that programs name so, or None: then it must not
    be queried. `beside()`: True if the station's loop goes on while a device is queried; in
    virtual time the station waits for the answer.
    """

    def __init__(
        self,
        find: Callable[[str, int], tuple[str, int] | None],
        *,
        clock: Callable[[], int],
        beside: Callable[[], bool] = lambda: False,
    ) -> None:
        self._find = find
        self._beside = beside
        self.client = ModbusClient()
        super().__init__(
            "Modbus Server",
            (1, 6, 4),
            (
                RawGroup(
                    REQUESTS,
                    "requests",
                    read_write=self._forward_request,
                    last_offset=1,
                    request="STRING(15) address, UINT16 port, UINT8 unit, UINT8 function,"
                    " UINT32 timeout ms, UINT16 address, UINT16 quantity or value, UINT16 write"
                    " address, UINT16 write quantity, UINT32 bytes, data",
                    response="data, registers with the low byte first",
                    description="Queries a Modbus device; offset 0 TCP, 1 UDP.",
                    source="achse",
                ),
            ),
            clock=clock,
        )

    def _forward_request(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        if offset > 1:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"Modbus requests have no {offset}")
        if len(data) < _REQUEST.size:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"{len(data)} bytes of a request")
        host, port, unit, function, timeout, first, count, second, others, size = (
            _REQUEST.unpack_from(data)
        )
        if len(data) != _REQUEST.size + size:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"{len(data)} bytes of a request")
        query = Query(function, first, count, second, others, data[_REQUEST.size :])
        try:
            pdu = request_pdu(query)
            if read_length < query.size:
                raise ModbusRefusal(
                    ILLEGAL_ADDRESS, f"{query.size} bytes come, there is room for {read_length}"
                )
        except ModbusRefusal as refusal:
            raise _refused(refusal) from None
        peer = self._peer(host.partition(b"\0")[0].decode("latin-1"), port, udp=offset == 1)
        response = self.client.request(peer, unit, pdu, min(timeout / 1000, _LONGEST_S))
        if not self._beside():
            return _result(query, response)
        loop = asyncio.get_running_loop()

        def start(answer: Answer) -> None:
            def deliver(done: "Future[bytes]") -> None:
                if not loop.is_closed():
                    loop.call_soon_threadsafe(answer, lambda: _result(query, done))

            response.add_done_callback(deliver)

        raise Deferred(start)

    def _peer(self, address: str, port: int, *, udp: bool) -> ModbusPeer:
        try:
            IPv4Address(address)
        except AddressValueError:
            raise _windows(_BAD_ADDRESS, f"{address!r} is not an IP address") from None
        peer = self._find(address, port)
        if peer is None:
            raise _windows(
                _ACCESS_DENIED, f"{address}:{port} is not one of modbus.peers in station.toml"
            )
        return ModbusPeer(*peer, udp)


def _result(query: Query, response: "Future[bytes]") -> bytes:
    """Return the data of the device's answer, or raise its error as a DeviceError."""
    try:
        return answer_data(query, response.result())
    except ModbusRefusal as refusal:
        raise _refused(refusal) from None
    except ModbusAnswerError as fault:
        raise _refused(ModbusRefusal(DEVICE_FAILURE, str(fault))) from None
    except ModbusBusyError as fault:
        raise DeviceError(ReturnCode.BUSY, str(fault)) from None
    except CancelledError:
        raise DeviceError(ReturnCode.CLIENT_REQUEST_CANCELLED, "the station restarts") from None
    except UnicodeError as fault:  # a name that cannot be one
        raise _windows(_NO_SUCH_HOST, str(fault)) from None
    except OSError as fault:
        if isinstance(fault, TimeoutError) and not fault.errno:
            raise DeviceError(ReturnCode.CLIENT_TIMEOUT, "the device did not answer") from None
        number = getattr(fault, "winerror", None) or _NUMBERS.get(fault.errno or 0, _RESET)
        if isinstance(fault, socket.gaierror):
            number = _NO_SUCH_HOST
        raise _windows(number, str(fault)) from None


def _refused(refusal: ModbusRefusal) -> DeviceError:
    return DeviceError(_EXCEPTION + refusal.code, str(refusal))


def _windows(number: int, text: str) -> DeviceError:
    return DeviceError(_WINDOWS + number, text)
