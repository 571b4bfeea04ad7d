"""Object rows: one entry of the object dictionary, and where its value lives.

A row is the entry's number, name, type, access, PDO mappability, unit, range, default and meaning;
SDO access, PDO mapping, SDO information, ESI, CLI and tests walk the same rows. Its value is a
field of the drive record, a constant, or what two functions read and write.
"""

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Any, Protocol

from achse.codes import AbortCode, SdoAbort
from achse.drive.record import DriveFields

__all__ = ["Access", "DataType", "Holder", "Number", "ObjectRow", "PdoTable"]

Number = int | float


class DataType(Enum):
    """A data type of the dictionary: its CiA number, `struct` code and bits."""

    number: int
    form: str
    bits: int

    def __new__(cls, number: int, form: str) -> "DataType":
        member = object.__new__(cls)
        member._value_ = number
        member.number = number
        member.form = form
        member.bits = 8 * struct.calcsize(form)
        return member

    I8 = (0x02, "<b")
    I16 = (0x03, "<h")
    I32 = (0x04, "<i")
    U8 = (0x05, "<B")
    U16 = (0x06, "<H")
    U32 = (0x07, "<I")
    F32 = (0x08, "<f")

    @property
    def least(self) -> Number:
        if self is DataType.F32:
            return -3.4028234663852886e38
        return -(1 << self.bits - 1) if self.form[1].islower() else 0

    @property
    def most(self) -> Number:
        if self is DataType.F32:
            return 3.4028234663852886e38
        return (1 << (self.bits - 1 if self.form[1].islower() else self.bits)) - 1

    def pack(self, value: Number) -> bytes:
        return struct.pack(self.form, value)

    def unpack(self, data: bytes) -> Number:
        value: Number = struct.unpack(self.form, data)[0]
        return value


class Access(IntEnum):
    """Who may write an entry; the values are access words of SDO information."""

    RO = 0x0007
    RW = 0x003F
    RW_PREOP = 0x000F


class PdoTable(Protocol):
    """The mapping and assignment objects."""

    def read(self, index: int, subindex: int) -> int: ...
    def write(self, index: int, subindex: int, value: int) -> None: ...


class Holder(Protocol):
    """What rows see of the drive they belong to."""

    @property
    def record(self) -> DriveFields: ...
    @property
    def mapping(self) -> PdoTable: ...
    @property
    def identity(self) -> Any: ...
    @property
    def storing(self) -> bool: ...
    def save(self) -> None: ...
    def request_reset(self) -> None: ...
    def request_encoder_clear(self) -> None: ...


@dataclass(frozen=True, slots=True)
class ObjectRow:
    """One entry of the dictionary.

    `field` names the record field that holds the value; `command` the one a PDO writes instead,
    where writing commands something; `constant` is a fixed value. `read` and `write` take
    precedence for SDO. `values` lists the only values allowed; a row `judged_by_write` leaves that,
    and a range narrower than its type's, to `write`. A `stored` row is kept by 1010h; a
    `restart` row acts after the next reset. `modes` names the modes the entry belongs to, empty for
    all.
    """

    index: int
    subindex: int
    name: str
    type: DataType
    access: Access
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
    read: Callable[[Holder], Number] | None = None
    write: Callable[[Holder, Any], None] | None = None
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
        return self.access is not Access.RO

    @property
    def receivable(self) -> bool:
        """May be mapped into a RxPDO."""
        return self.pdo and self.writable

    @property
    def access_word(self) -> int:
        """Access as SDO information tells it: bit 6 RxPDO, 7 TxPDO, 8 backup."""
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

    def get(self, drive: Holder) -> Number:
        """The present value."""
        if self.read is not None:
            return self.read(drive)
        if self.constant is not None:
            return self.constant
        value: Number = getattr(drive.record, self.field)
        return value

    def put(self, drive: Holder, value: Number) -> None:
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
