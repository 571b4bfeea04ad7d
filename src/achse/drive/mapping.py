"""PDO mapping and assignment: what the process data hold, and the procedure that changes it.

Source: 001 §2.8, §3.1.2. In PreOp only: assignment off, count 0, entries, count, assigned PDO,
assignment on: steps 1 to 6, which refusals name. Each entry has to name an object that can
be mapped; number, length and whether one is there twice are checked when the assignment comes on: a
count beyond 8 is out of range as long as the old mapping is assigned, and a PDO that is too long
when the new one is.
"""

import struct
from collections.abc import Mapping
from contextlib import suppress

from achse.codes import AbortCode, SdoAbort
from achse.codes.cia import Number
from achse.drive.objects.communication import (
    DEFAULT_MAPPINGS,
    RX_ASSIGNMENT,
    RX_PDOS,
    TX_ASSIGNMENT,
    TX_PDOS,
)
from achse.drive.objects.dictionary import DICTIONARY
from achse.drive.objects.row import ObjectRow
from achse.drive.record import ENTRIES

MAX_BYTES = 32
"""Longest PDO (001 §2.2)."""

_PADDING_INDICES = 0x20
"""Entries of index 0 to 1Fh are data types, used as padding by some masters."""


class ProcessData:
    """The active mapping of one direction: which rows, in which form."""

    def __init__(self, rows: tuple[ObjectRow | int, ...]) -> None:
        """`rows` in order; a number is that many padding bits."""
        self.rows = tuple(row for row in rows if isinstance(row, ObjectRow))
        form = "".join(f"{row // 8}x" if isinstance(row, int) else row.type.form[1] for row in rows)
        self.layout = struct.Struct("<" + form)
        self.size = self.layout.size
        self.places = tuple(row.place for row in self.rows)
        self.fields = tuple(row.field for row in self.rows)
        self.keys = frozenset(row.key for row in self.rows)
        self.offsets: tuple[int, ...] = ()
        """Byte at which each row begins."""
        at = 0
        for row in rows:
            if isinstance(row, int):
                at += row // 8
            else:
                self.offsets += (at,)
                at += row.type.bits // 8


_NOTHING = ProcessData(())


def _off_first(assignment: int) -> str:
    return f"step 1 is missing: write 0 to {assignment:04X}:00 first"


class PdoMapping:
    """Objects 1600h to 1603h, 1A00h to 1A03h, 1C12h and 1C13h.

    `open` is True in PreOp only. A `strict` mapping follows the manual to the letter; one that is
    not also accepts changes while the assignment is on (it is checked with the new count) and
    padding entries, as some masters send them.
    """

    def __init__(self, *, strict: bool = True) -> None:
        self.strict = strict
        self.open = False
        self.rx_data = _NOTHING
        self.tx_data = _NOTHING
        self._entries = {
            index: [*entries, *[0] * (ENTRIES - len(entries))]
            for index, entries in DEFAULT_MAPPINGS.items()
        }
        self._counts = {index: len(entries) for index, entries in DEFAULT_MAPPINGS.items()}
        self._assigned = {RX_ASSIGNMENT: RX_PDOS[0], TX_ASSIGNMENT: TX_PDOS[0]}
        self._active = {RX_ASSIGNMENT: 0, TX_ASSIGNMENT: 0}
        for assignment in self._active:
            self._activate(assignment)

    def read(self, index: int, subindex: int) -> int:
        """Return the value of an entry of these objects."""
        if index in self._active:
            return self._assigned[index] if subindex else self._active[index]
        return self._entries[index][subindex - 1] if subindex else self._counts[index]

    def write(self, index: int, subindex: int, value: int) -> None:
        """Take one step of the procedure, or raise `SdoAbort` with the code it is refused with."""
        if not self.open:
            raise SdoAbort(AbortCode.READ_ONLY, "the mapping changes in PreOp only")
        if index in self._active:
            self._write_assignment(index, subindex, value)
        else:
            self._write_mapping(index, subindex, value)

    def restore(self, values: Mapping[int, Number]) -> None:
        """Take stored values over, by index << 8 | subindex; what does not fit is left out."""
        for key, stored in values.items():
            index, subindex = key >> 8, key & 0xFF
            if index in self._active:
                if subindex and stored in self._entries:
                    self._assigned[index] = int(stored)
            elif index in self._entries:
                if subindex == 0:
                    self._counts[index] = int(stored)
                elif subindex <= ENTRIES:
                    self._entries[index][subindex - 1] = int(stored)
        for assignment in self._active:
            self._deactivate(assignment)
            if values.get(assignment << 8, 1):
                with suppress(SdoAbort):
                    self._activate(assignment)

    def _write_assignment(self, assignment: int, subindex: int, value: int) -> None:
        if subindex:
            if self._active[assignment]:
                raise SdoAbort(AbortCode.UNSUPPORTED_ACCESS, _off_first(assignment))
            self._assigned[assignment] = value
        elif value:
            self._activate(assignment)
        else:
            self._deactivate(assignment)

    def _write_mapping(self, index: int, subindex: int, value: int) -> None:
        assignment = RX_ASSIGNMENT if index in RX_PDOS else TX_ASSIGNMENT
        active = self._active[assignment] != 0
        if active and self.strict:
            beyond = subindex == 0 and value > ENTRIES
            code = AbortCode.VALUE_RANGE if beyond else AbortCode.UNSUPPORTED_ACCESS
            raise SdoAbort(code, _off_first(assignment))
        if subindex:
            if self._counts[index]:
                missing = f"step 2 is missing: write 0 to {index:04X}:00 before its entries"
                raise SdoAbort(AbortCode.UNSUPPORTED_ACCESS, missing)
            if value:
                self._row(index, value)
            self._entries[index][subindex - 1] = value
            return
        before = self._counts[index]
        self._counts[index] = value
        if active and self._assigned[assignment] == index:
            try:
                self._activate(assignment)
            except SdoAbort:
                self._counts[index] = before
                raise

    def _pads(self, entry: int) -> bool:
        return not self.strict and entry >> 16 < _PADDING_INDICES and entry & 7 == 0 < entry

    def _row(self, index: int, entry: int) -> ObjectRow | int:
        """Return the row an entry maps; raises `SdoAbort` unless it can be mapped there."""
        if self._pads(entry):
            return entry & 0xFF
        row = DICTIONARY.get(entry >> 8)
        mapped = f"step 3: {entry >> 16:04X}:{entry >> 8 & 0xFF:02X}"
        if row is None:
            raise SdoAbort(AbortCode.NO_OBJECT, f"{mapped} is not an object of the drive")
        if row.type.bits != entry & 0xFF:
            bits = f"{mapped} has {row.type.bits} bits, got {entry & 0xFF}"
            raise SdoAbort(AbortCode.NO_OBJECT, bits)
        if not (row.receivable if index in RX_PDOS else row.pdo):
            way = "received" if index in RX_PDOS else "sent"
            raise SdoAbort(AbortCode.NO_OBJECT, f"{mapped} cannot be {way} as process data")
        return row

    def _activate(self, assignment: int) -> None:
        index = self._assigned[assignment]
        count = self._counts[index]
        if count > ENTRIES:
            many = f"step 6: {index:04X} has {count} entries, expected up to {ENTRIES}"
            raise SdoAbort(AbortCode.PDO_LENGTH, many)
        data = ProcessData(tuple(self._row(index, entry) for entry in self._entries[index][:count]))
        if data.size > MAX_BYTES:
            long = f"step 6: {index:04X} has {data.size} bytes, expected up to {MAX_BYTES}"
            raise SdoAbort(AbortCode.PDO_LENGTH, long)
        if len(data.keys) < len(data.rows):
            raise SdoAbort(
                AbortCode.UNSUPPORTED_ACCESS, f"step 6: {index:04X} maps an object twice"
            )
        self._active[assignment] = 1
        self._set(assignment, data)

    def _deactivate(self, assignment: int) -> None:
        self._active[assignment] = 0
        self._set(assignment, _NOTHING)

    def _set(self, assignment: int, data: ProcessData) -> None:
        if assignment == RX_ASSIGNMENT:
            self.rx_data = data
        else:
            self.tx_data = data
