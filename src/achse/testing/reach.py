"""Ways to reach a drive on EtherCAT: through a segment in this process, or through pysoem.

What a check of drives needs of a master is small: objects, states, one cycle of process data.
"""

import struct
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any, Protocol

from achse.codes import AbortCode, AlState, SdoAbort
from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Segment
from achse.ethercat.description import LAYOUT
from achse.ethercat.registers import FMMU_BASE, SM_BASE, Register

_MAILBOX_OUT, _MAILBOX_IN, _OUTPUTS, _INPUTS = (
    LAYOUT.mailbox_out,
    LAYOUT.mailbox_in,
    LAYOUT.outputs,
    LAYOUT.inputs,
)
_MAILBOX = struct.Struct("<HHBB")
_SDO = struct.Struct("<HBHB")
_COE, _REQUEST, _EMERGENCY, _ABORT = 3, 0x2000, 1, 0x80
_FULL = 0x08
_ERROR = 0x10
_PATIENCE_S = 1.0
_ANSWERS_WITHIN_S = 10.0
"""On a real bus, whose master may have to wait for its processor."""


class ReachError(Exception):
    """A drive cannot be reached: a frame or an answer did not come."""


class DriveReach(Protocol):
    """One drive, seen from a master."""

    cycle_s: float
    """Seconds of one cycle."""

    def read(self, index: int, subindex: int = 0) -> bytes:
        """Read an object by SDO; raises SdoAbort."""
        ...

    def write(self, index: int, subindex: int, data: bytes) -> None:
        """Write an object by SDO; raises SdoAbort."""
        ...

    def request(self, state: int) -> tuple[int, int]:
        """Request a state, with bit 4 to acknowledge; AL status and code it leads to.

        On the way from PreOp to SafeOp process data are set up as the drive has them mapped.
        """
        ...

    def exchange(self, outputs: bytes) -> bytes:
        """One cycle with these outputs; the inputs."""
        ...

    def watchdog(self, seconds: float) -> None:
        """Set the process data watchdog, up to 6.5 s."""
        ...

    def pause(self, seconds: float) -> None:
        """Let time pass and send nothing."""
        ...


class SegmentReach:
    """A slave of a segment in this process, in virtual time, by frames alone.

    The other slaves stay as they are; `cycle_s` is what `exchange` lets pass.
    """

    def __init__(self, segment: Segment, position: int = 0, *, cycle_s: float = 0.001) -> None:
        self.segment = segment
        self.cycle_s = cycle_s
        self._position = position
        self._station = 0x1001 + position
        self._counter = 0
        self._logical = 0x0100_0000 * (position + 1)
        self._sizes = (0, 0)
        self._send(
            DatagramCommand.APWR,
            -position,
            Register.STATION_ADDRESS,
            self._station.to_bytes(2, "little"),
        )

    def _send(self, command: DatagramCommand, address: int, offset: int, data: bytes) -> Datagram:
        reply = self.segment.process(
            EthercatFrame([Datagram.at(command, address, offset, data)]).encode()
        )
        if reply is None:
            raise ReachError("a frame was lost")
        return EthercatFrame.decode(reply).datagrams[0]

    def _get(self, offset: int, length: int) -> bytes:
        return self._send(DatagramCommand.FPRD, self._station, offset, bytes(length)).data

    def _put(self, offset: int, data: bytes) -> int:
        return self._send(DatagramCommand.FPWR, self._station, offset, data).counter

    def watchdog(self, seconds: float) -> None:
        """Set the process data watchdog, in steps of 0.1 ms."""
        self._put(Register.PROCESS_WATCHDOG, round(seconds * 1e4).to_bytes(2, "little"))

    def pause(self, seconds: float) -> None:
        """Let virtual time pass."""
        self.segment.advance(self.segment.time.now_ns + round(seconds * 1e9))

    def _until(self, condition: Callable[[], object], what: str) -> None:
        for _ in range(round(_PATIENCE_S / self.cycle_s)):
            if condition():
                return
            self.pause(self.cycle_s)
        raise ReachError(f"no {what} within {_PATIENCE_S} s")

    # objects

    def coe(self, message: bytes) -> bytes:
        """Return a CoE message, header and all, and the answer to it; emergencies are passed
        over."""
        self._counter = self._counter % 7 + 1
        message = _MAILBOX.pack(len(message), 0, 0, _COE | self._counter << 4) + message
        message = message.ljust(_MAILBOX_OUT.length, b"\0")
        self._until(lambda: self._put(_MAILBOX_OUT.start, message), "place in the mailbox")
        while True:
            self._until(lambda: self._get(SM_BASE + 8 + 5, 1)[0] & _FULL, "answer")
            answer = self._get(_MAILBOX_IN.start, _MAILBOX_IN.length)
            length, _, _, kind = _MAILBOX.unpack_from(answer)
            body = answer[_MAILBOX.size : _MAILBOX.size + length]
            if kind & 0x0F != _COE:
                raise ReachError(f"mailbox error {body.hex()}")
            if body[1] >> 4 != _EMERGENCY:
                return body

    def _request(self, command: int, index: int, subindex: int, data: bytes) -> bytes:
        """Return the body of the answer to an SDO request."""
        request = _SDO.pack(_REQUEST, command, index, subindex) + data.ljust(4, b"\0")
        answer = self.coe(request)[2:]
        if answer[0] == _ABORT:
            number = int.from_bytes(answer[4:8], "little")
            raise SdoAbort(AbortCode.of(number) or AbortCode.GENERAL)
        return answer

    def read(self, index: int, subindex: int = 0) -> bytes:
        """Read an object of up to one mailbox; raises SdoAbort."""
        answer = self._request(0x40, index, subindex, b"")
        if answer[0] & 0x02:
            return answer[4 : 8 - (answer[0] >> 2 & 3)]
        size = int.from_bytes(answer[4:8], "little")
        return answer[8 : 8 + size]

    def write(self, index: int, subindex: int, data: bytes) -> None:
        """Write an object of up to four bytes or one mailbox; raises SdoAbort."""
        if 0 < len(data) <= 4:
            self._request(0x23 | 4 - len(data) << 2, index, subindex, data)
        else:
            self._request(0x21, index, subindex, len(data).to_bytes(4, "little") + data)

    # states and process data

    def request(self, state: int) -> tuple[int, int]:
        """Request a state; AL status and code."""
        present = self._status()[0]
        if state & 0x0F == AlState.PREOP and present & 0x0F == AlState.INIT:
            areas = ((_MAILBOX_OUT, _MAILBOX_OUT.length), (_MAILBOX_IN, _MAILBOX_IN.length))
            self._put(SM_BASE, b"".join(_channel(*area) for area in areas))
        if state & 0x0F == AlState.SAFEOP and present & 0x0F == AlState.PREOP:
            self._map()
        self._put(Register.AL_CONTROL, state.to_bytes(2, "little"))
        for _ in range(round(0.2 / self.cycle_s)):
            status, code = self._status()
            if status & 0x0F == state & 0x0F or status & _ERROR:
                break
            self.pause(self.cycle_s)
        return status, code

    def _status(self) -> tuple[int, int]:
        data = self._get(Register.AL_STATUS, 6)
        return data[0] | data[1] << 8, data[4] | data[5] << 8

    def _map(self) -> None:
        """Set SyncManagers 2 and 3 and their FMMUs up for what is mapped."""
        sizes = self._sizes = (self._mapped(0x1C12), self._mapped(0x1C13))
        self._put(SM_BASE + 16, _channel(_OUTPUTS, sizes[0]) + _channel(_INPUTS, sizes[1]))
        mapping = b"".join(
            struct.pack("<IHBBHBBB3x", logical, size, 0, 7, area.start, 0, direction, 1)
            for logical, size, area, direction in (
                (self._logical, sizes[0], _OUTPUTS, 2),
                (self._logical + sizes[0], sizes[1], _INPUTS, 1),
            )
        )
        self._put(FMMU_BASE, mapping)

    def _mapped(self, assignment: int) -> int:
        """Return bytes of the process data in one direction."""
        bits = 0
        for number in range(1, self.read(assignment)[0] + 1):
            pdo = int.from_bytes(self.read(assignment, number), "little")
            for entry in range(1, self.read(pdo)[0] + 1):
                bits += self.read(pdo, entry)[0]
        return bits // 8

    def exchange(self, outputs: bytes) -> bytes:
        """One LRW, then a cycle of time; the inputs it brought."""
        size, inputs = self._sizes
        data = outputs.ljust(size, b"\0") + bytes(inputs)
        reply = self.segment.process(
            EthercatFrame([Datagram(DatagramCommand.LRW, self._logical, data)]).encode()
        )
        if reply is None:
            raise ReachError("a frame was lost")
        self.pause(self.cycle_s)
        return EthercatFrame.decode(reply).datagrams[0].data[size:]


def _channel(area: Any, length: int) -> bytes:
    return struct.pack("<HHBBBB", area.start, length, area.control, 0, 1, 0)


class PysoemReach:
    """A slave of a pysoem master that has found its slaves (`config_init`)."""

    def __init__(self, master: Any, position: int = 0, *, cycle_s: float = 0.002) -> None:
        self._aborted = import_module("pysoem").SdoError
        self._master = master
        self._slave = master.slaves[position]
        self.emergencies: list[Any] = []
        """Emergencies that pysoem reported while it waited for answers."""
        self._slave.add_emergency_callback(self.emergencies.append)
        self.cycle_s = cycle_s

    def read(self, index: int, subindex: int = 0) -> bytes:
        """Read an object; raises SdoAbort."""
        try:
            return bytes(self._slave.sdo_read(index, subindex))
        except self._aborted as refusal:
            raise SdoAbort(AbortCode.of(refusal.abort_code) or AbortCode.GENERAL) from None

    def write(self, index: int, subindex: int, data: bytes) -> None:
        """Write an object; raises SdoAbort."""
        try:
            self._slave.sdo_write(index, subindex, data)
        except self._aborted as refusal:
            raise SdoAbort(AbortCode.of(refusal.abort_code) or AbortCode.GENERAL) from None

    def request(self, state: int) -> tuple[int, int]:
        """Request a state; AL status and code."""
        self._master.read_state()
        if state & 0x0F == AlState.SAFEOP and self._slave.state & 0x0F == AlState.PREOP:
            self._master.config_map()
        self._slave.state = state
        self._slave.write_state()
        end = time.monotonic() + _ANSWERS_WITHIN_S
        while time.monotonic() < end:
            if state & 0x0F == AlState.OP:
                self._master.send_processdata()
                self._master.receive_processdata(2000)
            self._master.read_state()
            if self._slave.state & 0x0F == state & 0x0F or self._slave.state & _ERROR:
                break
            time.sleep(0.001)
        return self._slave.state, self._slave.al_status

    def exchange(self, outputs: bytes) -> bytes:
        """One cycle of process data; the inputs it brought."""
        self._slave.output = outputs
        self._master.send_processdata()
        self._master.receive_processdata(10_000)
        time.sleep(self.cycle_s)
        return bytes(self._slave.input)

    def watchdog(self, seconds: float) -> None:
        """Set the process data watchdog."""
        self._slave.set_watchdog("processdata", 1000.0 * seconds)

    def pause(self, seconds: float) -> None:
        """Send nothing for so long."""
        time.sleep(seconds)
