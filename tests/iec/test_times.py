"""Durations, dates and times of day."""

from datetime import UTC, date, datetime, time, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.errors import IecDecodeError, IecValueError
from achse.iec.times import (
    DATE,
    DT,
    LDATE,
    LDT,
    LTIME,
    LTOD,
    TIME,
    TIMES,
    TOD,
    Nanoseconds,
    TimeType,
)

U32 = 2**32 - 1


@given(st.integers(0, U32))
def test_time_is_whole_milliseconds(count: int) -> None:
    value = timedelta(milliseconds=count)
    assert TIME.encode(value) == count.to_bytes(4, "little")
    assert TIME.decode(TIME.encode(value)) == value


@given(st.integers(0, U32))
def test_dt_is_seconds_since_1970(count: int) -> None:
    value = datetime(1970, 1, 1) + timedelta(seconds=count)
    assert DT.encode(value) == count.to_bytes(4, "little")
    assert DT.decode(DT.encode(value)) == value


@given(st.dates(date(1970, 1, 1), date(2106, 2, 7)))
def test_dates_come_back(value: date) -> None:
    assert DATE.decode(DATE.encode(value)) == value
    assert LDATE.decode(LDATE.encode(value)) == value


def test_a_date_is_midnight_of_its_day() -> None:
    assert DATE.encode(date(1970, 1, 2)) == (86_400).to_bytes(4, "little")
    assert DATE.decode((86_400 * 2 - 1).to_bytes(4, "little")) == date(1970, 1, 2)


@given(st.integers(0, 86_399_999))
def test_tod_is_milliseconds_since_midnight(count: int) -> None:
    value = (datetime(1970, 1, 1) + timedelta(milliseconds=count)).time()
    assert TOD.encode(value) == count.to_bytes(4, "little")
    assert TOD.decode(TOD.encode(value)) == value


@pytest.mark.parametrize("type", [LTIME, LDT], ids=lambda type: type.name)
@given(count=st.integers(0, 2**64 - 1))
def test_long_types_keep_every_nanosecond(type: TimeType[Nanoseconds], count: int) -> None:
    value = type.decode(count.to_bytes(8, "little"))
    assert value == count
    assert type.encode(value) == count.to_bytes(8, "little")


def test_nanoseconds_convert_to_pythons_microseconds() -> None:
    value = Nanoseconds(1_234_567_890_123)
    assert value.timedelta == timedelta(microseconds=1_234_567_890)
    assert value.time == time(0, 20, 34, 567890)
    assert value.datetime == datetime(1970, 1, 1, 0, 20, 34, 567890)
    for moment in (value.timedelta, value.time, value.datetime):
        assert Nanoseconds.of(moment) == 1_234_567_890_000
    assert repr(value) == "Nanoseconds(1234567890123)"
    assert LTIME.encode(timedelta(microseconds=1)) == (1000).to_bytes(8, "little")
    assert LTOD.encode(time(0, 0, 1)) == (10**9).to_bytes(8, "little")
    assert LDT.encode(datetime(1970, 1, 1, 0, 0, 1)) == (10**9).to_bytes(8, "little")


@pytest.mark.parametrize(
    ("type", "value"),
    [
        (TIME, timedelta(microseconds=1)),
        (TIME, timedelta(milliseconds=-1)),
        (TIME, timedelta(days=50)),
        (TIME, 1.0),
        (TIME, True),
        (DATE, datetime(2020, 1, 1)),
        (DATE, date(1969, 12, 31)),
        (DATE, date(2107, 1, 1)),
        (TOD, time(1, tzinfo=UTC)),
        (TOD, time(0, 0, 0, 1)),
        (TOD, 2**32),
        (DT, datetime(2020, 1, 1, tzinfo=UTC)),
        (DT, datetime(2020, 1, 1, 0, 0, 0, 1)),
        (DT, date(2020, 1, 1)),
        (LTIME, timedelta(-1)),
        (LTIME, 2**64),
        (LTOD, 2**64),
        (LDT, datetime(1969, 1, 1)),
        (LDATE, "2020-01-01"),
    ],
)
def test_what_does_not_fit_is_refused(type: TimeType[object], value: object) -> None:
    with pytest.raises(IecValueError, match=f"{type.name} takes"):
        type.encode(value)


@pytest.mark.parametrize("type", TIMES, ids=lambda type: type.name)
@given(data=st.binary(max_size=9))
def test_any_bytes_are_a_time_that_can_be_written_back(type: TimeType[object], data: bytes) -> None:
    if len(data) < type.size:
        with pytest.raises(IecDecodeError, match="bytes, got"):
            type.decode(data)
    else:
        value = type.decode(data)
        assert type.decode(type.encode(value)) == value
        assert type.read(bytearray(data), 0) == value


def test_a_time_of_day_beyond_midnight_wraps() -> None:
    assert TOD.decode((86_400_000 + 1).to_bytes(4, "little")) == time(0, 0, 0, 1000)
    assert TOD.encode(86_400_000 + 1) == (86_400_000 + 1).to_bytes(4, "little")


def test_raw_counts_are_taken_too() -> None:
    memory = bytearray(4)
    TIME.write(memory, 0, 1500)
    assert TIME.read(memory, 0) == timedelta(seconds=1.5)


def test_what_the_tables_say_of_them() -> None:
    assert all(type.adst == 19 for type in TIMES if type.size == 4)
    assert all(type.adst == 21 for type in TIMES if type.size == 8)
    assert DT.guid.hex()[-2:] == "4c"
