"""Object rows: one entry of the object dictionary, and the place of its value.

A row is the entry's number, name, type, access, PDO mappability, unit, range, default and meaning;
SDO access, PDO mapping, SDO information, ESI, CLI and tests walk the same rows. Its value is a
field of the drive record, a constant, or what two functions read and write.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Protocol

from achse.codes import AbortCode, DataType, SdoAbort
from achse.codes.cia import Number
from achse.drive.record import DriveFields


class EntryAccess(IntEnum):
    """Write access to an entry; the values are access words of SDO information."""

    RO = 0x0007
    RW = 0x003F
    RW_PREOP = 0x000F


class PdoTable(Protocol):
    """The mapping and assignment objects."""

    def read(self, index: int, subindex: int) -> int: ...
    def write(self, index: int, subindex: int, value: int) -> None: ...


class DriveView(Protocol):
    """Interface of the drive to the rows of its dictionary."""

    @property
    def record(self) -> DriveFields: ...
    @property
    def mapping(self) -> PdoTable: ...
    @property
    def identity(self) -> Any: ...
    @property
    def storing(self) -> bool: ...
    @property
    def missed_events(self) -> int: ...
    @property
    def sync_error(self) -> bool: ...
    def save(self) -> None: ...
    def request_reset(self) -> None: ...
    def request_encoder_clear(self) -> None: ...


@dataclass(frozen=True, slots=True)
class ObjectRow:
    """One entry of the dictionary.

    `field` names the record field that holds the value; `command` the one a PDO writes instead,
    where writing commands something; `constant` is a fixed value. `read` and `write` take
    precedence for SDO. `values` lists the only values allowed; a row `judged_by_write` leaves that,
    and a range narrower than its type's, to `write`. A `stored` row is saved by 1010h; a
    `restart` row acts after the next reset. `modes` names the modes the entry belongs to, empty for
    all.
    """

    index: int
    subindex: int
    name: str
    type: DataType
    access: EntryAccess
    doc: str
    field: str = ""
    default: Number = 0
    unit: str = ""
    pdo: bool = False
    minimum: Number | None = None
    maximum: Number | None = None
    values: tuple[int, ...] = ()
    modes: str = ""
    stored: bool = False
    restart: bool = False
    command: str = ""
    constant: Number | None = None
    read: Callable[[DriveView], Number] | None = None
    write: Callable[[DriveView, Any], None] | None = None
    judged_by_write: bool = False

    @property
    def key(self) -> int:
        """Index and subindex in one number, as a mapping entry has them."""
        return self.index << 8 | self.subindex

    @property
    def object_name(self) -> str:
        return self.name.partition(": ")[0]

    @property
    def entry_name(self) -> str:
        return self.name.partition(": ")[2] or self.name

    @property
    def least(self) -> Number:
        return self.type.least if self.minimum is None else self.minimum

    @property
    def most(self) -> Number:
        return self.type.most if self.maximum is None else self.maximum

    @property
    def writable(self) -> bool:
        return self.access is not EntryAccess.RO

    @property
    def receivable(self) -> bool:
        """True if the entry may be mapped into a RxPDO."""
        return self.pdo and self.writable

    @property
    def access_word(self) -> int:
        """Access as in SDO information: bit 6 RxPDO, 7 TxPDO, 8 backup."""
        word = int(self.access)
        if self.receivable:
            word |= 0x40
        if self.pdo:
            word |= 0x80
        return word | 0x100 if self.stored else word

    @property
    def place(self) -> str:
        """The record field a RxPDO writes."""
        return self.command or self.field

    def get(self, drive: DriveView) -> Number:
        """Return the present value."""
        if self.read is not None:
            return self.read(drive)
        if self.constant is not None:
            return self.constant
        value: Number = getattr(drive.record, self.field)
        return value

    def put(self, drive: DriveView, value: Number) -> None:
        """Take a value over; raises `SdoAbort` if it is refused."""
        if not self.writable:
            raise SdoAbort(AbortCode.READ_ONLY)
        self.check(value)
        if self.write is not None:
            self.write(drive, value)
        else:
            setattr(drive.record, self.field, value)

    def check(self, value: Number) -> None:
        """Raise VALUE_RANGE unless the row allows the value."""
        if self.judged_by_write:
            allowed = self.type.least <= value <= self.type.most
        else:
            allowed = value in self.values if self.values else self.least <= value <= self.most
        if not allowed or not math.isfinite(value):
            raise SdoAbort(AbortCode.VALUE_RANGE)
