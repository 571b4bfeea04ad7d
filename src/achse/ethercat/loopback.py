"""The smallest application: what the master puts out comes back as input one local cycle later.

Source: ETG.1000.4, §6.7 for its buffers.
"""

from dataclasses import dataclass, field

from achse.codes import AbortCode, AlState, AlStatus, DataType, SdoAbort
from achse.ethercat.application import ObjectAccess, ObjectCode

__all__ = ["Loopback", "LoopbackEntry", "LoopbackIdentity", "LoopbackObject"]

_RO = int(ObjectAccess.READ)
_RW = int(ObjectAccess.READ | ObjectAccess.WRITE)
_LOCAL_CYCLE_NS = 250_000


@dataclass(frozen=True)
class LoopbackIdentity:
    """Vendor and product of nobody."""

    vendor_id: int = 0
    product_code: int = 0x10_0B
    revision_number: int = 1
    serial_number: int = 0


@dataclass(frozen=True)
class LoopbackEntry:
    """One entry of the dictionary."""

    subindex: int
    name: str
    data_type: int
    bits: int
    access: int
    default: bytes | None = None
    minimum: bytes | None = None
    maximum: bytes | None = None


@dataclass(frozen=True)
class LoopbackObject:
    """One object of the dictionary."""

    index: int
    name: str
    code: int
    data_type: int
    entries: tuple[LoopbackEntry, ...] = field(default=())


class Loopback:
    """An application with `size` bytes of outputs and as many inputs, at most 8.

    Objects: 1000h, 1008h, 1018h, fixed PDO mappings, 2000h (a text of any length, read and
    written), 6000h inputs, 7000h outputs. Faults for tests: `refuse` is the answer to the next
    request for a state, `fault` what the next local cycle finds, `emergencies` what waits.
    """

    local_cycle_ns = _LOCAL_CYCLE_NS

    def __init__(self, size: int = 4, name: str = "loopback", serial_number: int = 0) -> None:
        self.name = name
        self.identity = LoopbackIdentity(serial_number=serial_number)
        self.output_size = self.input_size = size
        self.text = b"any text"
        self.state = AlState.INIT
        self.cause = AlStatus.NO_ERROR
        self.elapsed_ns = 0
        self.cycles = 0
        self.sync0_ns = 0
        self.refuse = AlStatus.NO_ERROR
        self.fault = AlStatus.NO_ERROR
        self.emergencies: list[bytes] = []
        self._outputs = self._inputs = bytes(size)
        self._objects = self._dictionary(size)
        self._values = {
            (each.index, entry.subindex): entry.default or bytes(entry.bits // 8)
            for each in self._objects
            for entry in each.entries
        }

    def _dictionary(self, size: int) -> tuple[LoopbackObject, ...]:
        numbers = (0xC0_DE_00_01, *vars(self.identity).values())
        name = self.name.encode()
        return (
            _variable(0x1000, "Device type", DataType.U32, numbers[0].to_bytes(4, "little")),
            _variable(0x1008, "Device name", DataType.VISIBLE_STRING, name),
            _record(
                0x1018,
                "Identity",
                DataType.IDENTITY,
                [
                    LoopbackEntry(
                        subindex, text, DataType.U32, 32, _RO, number.to_bytes(4, "little")
                    )
                    for subindex, (text, number) in enumerate(vars(self.identity).items(), start=1)
                ],
            ),
            _list(
                0x1600, "Outputs mapping", [0x7000_0100 + 0x100 * n + 8 for n in range(size)], 32
            ),
            _list(0x1A00, "Inputs mapping", [0x6000_0100 + 0x100 * n + 8 for n in range(size)], 32),
            _list(0x1C00, "SyncManager types", [1, 2, 3, 4], 8),
            _list(0x1C12, "Outputs assignment", [0x1600], 16),
            _list(0x1C13, "Inputs assignment", [0x1A00], 16),
            LoopbackObject(
                0x2000,
                "Text",
                ObjectCode.VAR,
                DataType.VISIBLE_STRING,
                (LoopbackEntry(0, "Text", DataType.VISIBLE_STRING, 8 * 256, _RW, b""),),
            ),
            _record(
                0x6000,
                "Inputs",
                DataType.U8,
                [
                    LoopbackEntry(
                        1 + n, f"Input {n}", DataType.U8, 8, _RO | ObjectAccess.TX_PDO, b"\0"
                    )
                    for n in range(size)
                ],
            ),
            _record(
                0x7000,
                "Outputs",
                DataType.U8,
                [
                    LoopbackEntry(
                        1 + n, f"Output {n}", DataType.U8, 8, _RW | ObjectAccess.RX_PDO, b"\0"
                    )
                    for n in range(size)
                ],
            ),
        )

    def objects(self) -> tuple[LoopbackObject, ...]:
        """The dictionary."""
        return self._objects

    def read_object(self, index: int, subindex: int) -> bytes:
        """The value of an entry."""
        self._entry(index, subindex)
        if index == 0x2000:
            return self.text
        if index == 0x6000 and subindex:
            return self._inputs[subindex - 1 : subindex]
        if index == 0x7000 and subindex:
            return self._outputs[subindex - 1 : subindex]
        return self._values[index, subindex]

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        """Write 2000h or an output."""
        entry = self._entry(index, subindex)
        if not entry.access & ObjectAccess.WRITE:
            raise SdoAbort(AbortCode.READ_ONLY)
        if index == 0x2000:
            self.text = data
        elif len(data) != 1:
            raise SdoAbort(AbortCode.LENGTH)
        else:
            outputs = bytearray(self._outputs)
            outputs[subindex - 1] = data[0]
            self._outputs = bytes(outputs)

    def _entry(self, index: int, subindex: int) -> LoopbackEntry:
        for each in self._objects:
            if each.index == index:
                for entry in each.entries:
                    if entry.subindex == subindex:
                        return entry
                raise SdoAbort(AbortCode.NO_SUBINDEX)
        raise SdoAbort(AbortCode.NO_OBJECT)

    def write_outputs(self, data: bytes) -> None:
        """Outputs from the master."""
        self._outputs = data

    def read_inputs(self) -> bytes:
        """Inputs to the master."""
        return self._inputs

    def enter(self, state: AlState, sync0_ns: int, cause: AlStatus) -> AlStatus:
        """Follow the slave's state, unless `refuse` says no."""
        refused, self.refuse = self.refuse, AlStatus.NO_ERROR
        if cause is AlStatus.NO_ERROR and refused is not AlStatus.NO_ERROR:
            return refused
        self.state = state
        self.sync0_ns = sync0_ns
        self.cause = cause
        if state is not AlState.OP:
            self._outputs = bytes(self.output_size)
        return AlStatus.NO_ERROR

    def step(self, elapsed_ns: int) -> AlStatus:
        """Outputs become inputs."""
        self.elapsed_ns += elapsed_ns
        self.cycles += 1
        self._inputs = self._outputs
        fault, self.fault = self.fault, AlStatus.NO_ERROR
        return fault

    def take_emergency(self) -> bytes | None:
        """The oldest of `emergencies`."""
        return self.emergencies.pop(0) if self.emergencies else None


def _variable(index: int, name: str, data_type: int, value: bytes) -> LoopbackObject:
    entry = LoopbackEntry(0, name, data_type, 8 * len(value), _RO, value)
    return LoopbackObject(index, name, ObjectCode.VAR, data_type, (entry,))


def _record(index: int, name: str, data_type: int, entries: list[LoopbackEntry]) -> LoopbackObject:
    count = LoopbackEntry(0, "Number of entries", DataType.U8, 8, _RO, bytes((len(entries),)))
    return LoopbackObject(index, name, ObjectCode.RECORD, data_type, (count, *entries))


def _list(index: int, name: str, numbers: list[int], bits: int) -> LoopbackObject:
    data_type = {8: DataType.U8, 16: DataType.U16, 32: DataType.U32}[bits]
    entries = [
        LoopbackEntry(n, f"Entry {n}", data_type, bits, _RO, number.to_bytes(bits // 8, "little"))
        for n, number in enumerate(numbers, 1)
    ]
    return _record(index, name, data_type, entries)
