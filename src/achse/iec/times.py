"""Durations, dates and times of day, one row each.

The 32-bit types are `timedelta`, `date`, `time` and naive `datetime`, exact to their unit. The
64-bit types count nanoseconds, finer than Python's microseconds, so LTIME, LTOD and LDT are
`Nanoseconds`: an int that converts. Every type also takes its raw count as an int.

Source: IEC 61131-3 (2013) table 10, no. 10 to 12c; units and origins as in TwinCAT 3.
"""

import struct
from collections.abc import Callable, Mapping
from datetime import date, datetime, time, timedelta
from typing import Self, TypeVar

from achse.iec.elementary import base_guid
from achse.iec.errors import IecDecodeError
from achse.iec.types import Adst, Buffer, IecType, derived_guid, no_attributes

V = TypeVar("V")

_EPOCH = datetime(1970, 1, 1)
_SECOND = timedelta(seconds=1)
_MILLISECOND = timedelta(milliseconds=1)
_MICROSECOND = timedelta(microseconds=1)
_DAY_S = 86_400
_DAY_MS = 86_400_000
_DAY_NS = 86_400_000_000_000


class Nanoseconds(int):
    """A duration, a time of day or the time since 1970, in whole nanoseconds.

    `timedelta`, `time` and `datetime` give it in Python's microseconds, rounded down.
    """

    __slots__ = ()

    @classmethod
    def of(cls, value: timedelta | time | datetime) -> Self:
        """Return the nanoseconds of a duration, of a time of day, or since 1970 (naive
        datetime)."""
        if isinstance(value, datetime):
            value = value - _EPOCH
        elif isinstance(value, time):
            value = _since_midnight(value)
        return cls(value // _MICROSECOND * 1000)

    @property
    def timedelta(self) -> timedelta:
        return timedelta(microseconds=self // 1000)

    @property
    def time(self) -> time:
        return (_EPOCH + timedelta(microseconds=self // 1000)).time()

    @property
    def datetime(self) -> datetime:
        return _EPOCH + timedelta(microseconds=self // 1000)

    def __repr__(self) -> str:
        return f"Nanoseconds({int(self)})"


def _since_midnight(value: time) -> timedelta:
    return timedelta(
        hours=value.hour,
        minutes=value.minute,
        seconds=value.second,
        microseconds=value.microsecond,
    )


def _exactly(value: timedelta, unit: timedelta) -> int | None:
    count, rest = divmod(value, unit)
    return None if rest else count


def _duration_ms(value: object) -> int | None:
    return _exactly(value, _MILLISECOND) if isinstance(value, timedelta) else None


def _duration_ns(value: object) -> int | None:
    return Nanoseconds.of(value) if isinstance(value, timedelta) else None


def _days_s(value: object) -> int | None:
    if isinstance(value, date) and not isinstance(value, datetime):
        return (value.toordinal() - _EPOCH.toordinal()) * _DAY_S
    return None


def _days_ns(value: object) -> int | None:
    seconds = _days_s(value)
    return None if seconds is None else seconds * 1_000_000_000


def _clock_ms(value: object) -> int | None:
    if isinstance(value, time) and value.tzinfo is None:
        return _exactly(_since_midnight(value), _MILLISECOND)
    return None


def _clock_ns(value: object) -> int | None:
    return Nanoseconds.of(value) if isinstance(value, time) and value.tzinfo is None else None


def _moment_s(value: object) -> int | None:
    if isinstance(value, datetime) and value.tzinfo is None:
        return _exactly(value - _EPOCH, _SECOND)
    return None


def _moment_ns(value: object) -> int | None:
    return Nanoseconds.of(value) if isinstance(value, datetime) and value.tzinfo is None else None


class TimeType(IecType[V]):
    """An unsigned count of a unit, as a Python time.

    A count beyond `modulus` (a time of day after midnight) wraps when read. Written as a count it
    is kept, as `TO_TOD(4294967295)` of a PLC does.
    """

    def __init__(
        self,
        name: str,
        code: str,
        to_python: Callable[[int], V],
        to_count: Callable[[object], int | None],
        expected: str,
        *,
        modulus: int = 0,
        guid_number: int | None = None,
        attributes: Mapping[str, str] = no_attributes,
    ) -> None:
        self.codec = struct.Struct(f"<{code}")
        size = self.codec.size
        adst = Adst.UINT32 if size == 4 else Adst.UINT64
        super().__init__(name, size, size, adst, attributes=attributes)
        self.to_python = to_python
        self.to_count = to_count
        self.modulus = modulus or 1 << 8 * size
        self._expected = expected
        self.guid = derived_guid(name) if guid_number is None else base_guid(guid_number)

    def count(self, value: object) -> int:
        """Return the raw count of a value. Raises `IecValueError` if it is finer than the unit."""
        if isinstance(value, int) and not isinstance(value, bool):
            count: int | None = value
        else:
            count = self.to_count(value)
        if count is None or not 0 <= count < 1 << 8 * self.size:
            raise self.reject(value)
        return count

    def encode(self, value: object) -> bytes:
        return self.codec.pack(self.count(value))

    def decode(self, data: bytes | Buffer) -> V:
        if len(data) < self.size:
            raise IecDecodeError(f"{self.name} has {self.size} bytes, got {len(data)}")
        return self.to_python(self.codec.unpack_from(data)[0] % self.modulus)

    def read(self, buffer: Buffer, offset: int) -> V:
        return self.to_python(self.codec.unpack_from(buffer, offset)[0] % self.modulus)

    def write(self, buffer: Buffer, offset: int, value: object) -> None:
        self.codec.pack_into(buffer, offset, self.count(value))

    @property
    def expected(self) -> str:
        return f"{self._expected}, or its count in 0..{(1 << 8 * self.size) - 1}"


def _to_timedelta(milliseconds: int) -> timedelta:
    return timedelta(milliseconds=milliseconds)


def _to_date(seconds: int) -> date:
    return date.fromordinal(_EPOCH.toordinal() + seconds // _DAY_S)


def _to_long_date(nanoseconds: int) -> date:
    return _to_date(nanoseconds // 1_000_000_000)


def _to_time(milliseconds: int) -> time:
    return (_EPOCH + timedelta(milliseconds=milliseconds)).time()


def _to_datetime(seconds: int) -> datetime:
    return _EPOCH + timedelta(seconds=seconds)


_MOMENT = "a naive datetime of whole seconds from 1970 to 2106"

TIME = TimeType(
    "TIME", "I", _to_timedelta, _duration_ms, "a timedelta of whole milliseconds below 49.7 days"
)
DATE = TimeType("DATE", "I", _to_date, _days_s, "a date from 1970 to 2106")
TOD = TimeType("TOD", "I", _to_time, _clock_ms, "a time of whole milliseconds", modulus=_DAY_MS)
TIME_OF_DAY = TimeType(
    "TIME_OF_DAY", "I", _to_time, _clock_ms, "a time of whole milliseconds", modulus=_DAY_MS
)
DT = TimeType("DT", "I", _to_datetime, _moment_s, _MOMENT, guid_number=0x4C)
DATE_AND_TIME = TimeType("DATE_AND_TIME", "I", _to_datetime, _moment_s, _MOMENT, guid_number=0x4D)
LTIME = TimeType("LTIME", "Q", Nanoseconds, _duration_ns, "a timedelta from 0")
LDATE = TimeType("LDATE", "Q", _to_long_date, _days_ns, "a date from 1970 to 2554")
LTOD = TimeType("LTOD", "Q", Nanoseconds, _clock_ns, "a time without zone", modulus=_DAY_NS)
LDT = TimeType("LDT", "Q", Nanoseconds, _moment_ns, "a naive datetime from 1970 to 2554")

TIMES = (TIME, DATE, TOD, TIME_OF_DAY, DT, DATE_AND_TIME, LTIME, LDATE, LTOD, LDT)
