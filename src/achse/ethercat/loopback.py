"""The smallest application: what the master puts out comes back as input one local cycle later.

Source: ETG.1000.4, §6.7 for its buffers.
"""

from achse.codes import AbortCode, AlState, AlStatus, DataType, SdoAbort
from achse.ethercat.application import ObjectAccess, ObjectCode
from achse.ethercat.dictionary import (
    DictionaryIdentity,
    DictionaryObject,
    entry_of,
    number,
    record_object,
    text_object,
)

_RO = int(ObjectAccess.READ)
_RW = int(ObjectAccess.READ | ObjectAccess.WRITE)
_LOCAL_CYCLE_NS = 250_000


class Loopback:
    """An application with `size` bytes of outputs and as many inputs, at most 8.

    Objects: 1000h, 1008h, 1018h, fixed PDO mappings, 2000h (a text of any length, read and
    written), 6000h inputs, 7000h outputs. Faults for tests: `refuse` is the answer to the next
    request for a state, `fault` what the next local cycle finds, `emergencies` what waits.
    """

    local_cycle_ns = _LOCAL_CYCLE_NS

    def __init__(self, size: int = 4, name: str = "loopback", serial_number: int = 0) -> None:
        self.name = name
        self.identity = DictionaryIdentity(serial_number=serial_number)
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

    def _dictionary(self, size: int) -> tuple[DictionaryObject, ...]:
        identity = enumerate(vars(self.identity).items(), start=1)
        inputs, outputs = _RO | ObjectAccess.TX_PDO, _RW | ObjectAccess.RX_PDO
        return (
            DictionaryObject(
                *(0x1000, "Device type", ObjectCode.VAR, DataType.U32),
                (number(0, "Device type", 32, 0xC0_DE_00_01),),
            ),
            text_object(0x1008, "Device name", self.name.encode()),
            record_object(
                0x1018, "Identity", [number(n, text, 32, value) for n, (text, value) in identity]
            ),
            _list(
                0x1600, "Outputs mapping", [0x7000_0100 + 0x100 * n + 8 for n in range(size)], 32
            ),
            _list(0x1A00, "Inputs mapping", [0x6000_0100 + 0x100 * n + 8 for n in range(size)], 32),
            _list(0x1C00, "SyncManager types", [1, 2, 3, 4], 8),
            _list(0x1C12, "Outputs assignment", [0x1600], 16),
            _list(0x1C13, "Inputs assignment", [0x1A00], 16),
            text_object(0x2000, "Text", b"", 256, _RW),
            record_object(
                *(0x6000, "Inputs"),
                [number(1 + n, f"Input {n}", 8, access=inputs) for n in range(size)],
            ),
            record_object(
                *(0x7000, "Outputs"),
                [number(1 + n, f"Output {n}", 8, access=outputs) for n in range(size)],
            ),
        )

    def objects(self) -> tuple[DictionaryObject, ...]:
        return self._objects

    def read_object(self, index: int, subindex: int) -> bytes:
        """Return the value of an entry."""
        entry_of(self._objects, index, subindex)
        if index == 0x2000:
            return self.text
        if index == 0x6000 and subindex:
            return self._inputs[subindex - 1 : subindex]
        if index == 0x7000 and subindex:
            return self._outputs[subindex - 1 : subindex]
        return self._values[index, subindex]

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        """Write 2000h or an output."""
        entry = entry_of(self._objects, index, subindex)
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

    def write_outputs(self, data: bytes) -> None:
        """Accept outputs from the master."""
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
        """Return the oldest of `emergencies`."""
        return self.emergencies.pop(0) if self.emergencies else None


def _list(index: int, name: str, numbers: list[int], bits: int) -> DictionaryObject:
    entries = [number(n, f"Entry {n}", bits, value) for n, value in enumerate(numbers, 1)]
    return record_object(index, name, entries)
