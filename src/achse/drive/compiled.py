"""The kernel in machine code: drives in one memory, which do their steps in one call.

A drive of a bank only notes that a step is postponed. The first read of any of them, by the master
or by another caller, makes all drives do their postponed steps.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from achse.codes import DataType
from achse.drive.exchange import exchange
from achse.drive.mapping import ProcessData
from achse.drive.record import FIELDS, LAYOUT, DriveFields, DriveSlots
from achse.native.compiled import Kernel
from achse.native.declare import pack
from achse.native.memory import Rows, RowView, field_property

KERNEL = Kernel("drive", exchange, {DriveFields: LAYOUT})
"""Called with address and number of the records, and address and number of their words."""

_POSTPONED = FIELDS["postponed"].offset
_CYCLES = FIELDS["postponed_cycles"].offset
_TIME = FIELDS["postponed_time"].offset
_CAME = FIELDS["outputs_came"].offset
_SERVICE_REQUEST = FIELDS["service_request"].offset


class Bank:
    """Memory for the records of up to `size` drives, which do their steps together.

    The drives of a bank belong to one thread.
    """

    def __init__(self, size: int) -> None:
        self.turn = 0
        """Number of steps done; work postponed since the last step is postponed in this turn."""
        self.rows = Rows(LAYOUT, size)
        self._row_count = 0
        self._postponed_records: list[CompiledRecord] = []
        address = self.rows.address
        self._exchange: Callable[[], int] = KERNEL.bind(address, size, address, size * LAYOUT.words)

    def take(self) -> int:
        """Return the index of a record that is not used yet; ValueError if there is none."""
        if self._row_count == self.rows.count:
            raise ValueError(f"the bank holds {self._row_count} drives, no more")
        self._row_count += 1
        return self._row_count - 1

    def postpone(self, record: "CompiledRecord") -> None:
        """Postpone the step that is noted in this record."""
        self._postponed_records.append(record)

    def settle(self) -> None:
        """Do all steps that are postponed."""
        records, self._postponed_records = self._postponed_records, []
        self.turn += 1
        if self._exchange():
            for record in records:
                if record.ints[_SERVICE_REQUEST]:
                    record.service()


if TYPE_CHECKING:

    class _Fields(DriveFields):
        pass

else:

    class _Fields:
        __slots__ = ()


class CompiledRecord(RowView, _Fields):
    """A record in a bank, the fields are attributes. `service` is called on request."""

    __slots__ = ("_inputs", "_outputs", "bank", "mapped", "service")

    def __init__(self, bank: Bank, service: Callable[[], None]) -> None:
        super().__init__(bank.rows, bank.take())
        self.bank = bank
        self.service = service
        self.mapped = False
        """True if the kernel knows the mapping of the process data."""
        self.row[:] = pack(LAYOUT, DriveSlots())

    def map(self, received: ProcessData, sent: ProcessData) -> None:
        """Take the mapping over, unless it holds floating-point objects, which go around."""
        self.received_count = self.sent_count = 0
        rows = (*received.rows, *sent.rows)
        self.mapped = not any(row.type is DataType.F32 for row in rows)
        if not self.mapped:
            return
        for n, (row, at) in enumerate(zip(received.rows, received.offsets, strict=True)):
            size = row.type.bits // 8
            self.received_word[n] = FIELDS[row.place].offset
            self.received_at[n] = at
            self.received_size[n] = -size if row.type.least < 0 else size
        for n, (row, at) in enumerate(zip(sent.rows, sent.offsets, strict=True)):
            self.sent_word[n] = FIELDS[row.field].offset
            self.sent_at[n] = at
            self.sent_size[n] = row.type.bits // 8
        self.received_count, self.sent_count = len(received.rows), len(sent.rows)
        first = 8 * FIELDS["outputs"].offset
        self._outputs = self.row[first : first + received.size]
        first = 8 * FIELDS["inputs"].offset
        self._inputs = self.row[first : first + sent.size]

    def postpone(self, outputs: bytes | None, dt: float, count: int, service_request: bool) -> None:
        """Note a step of `count` cycles, before it the outputs."""
        ints = self.ints
        if outputs is not None:
            self._outputs[:] = outputs
            ints[_CAME] = 1
        if service_request:
            ints[_SERVICE_REQUEST] = 1
        ints[_CYCLES] = count
        self.floats[_TIME] = dt
        ints[_POSTPONED] = 1
        self.bank.postpone(self)

    def newest_inputs(self) -> bytes:
        """Inputs as the last step left them."""
        return self._inputs.tobytes()


for _name, _slot in FIELDS.items():
    setattr(CompiledRecord, _name, field_property(_slot))
