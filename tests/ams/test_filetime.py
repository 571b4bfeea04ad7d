"""FILETIME: 100 ns since 1601-01-01 UTC."""

from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import filetime


def test_the_epochs() -> None:
    assert filetime.to_datetime(0) == datetime(1601, 1, 1, tzinfo=UTC)
    # 369 years with 89 leap days are between the epochs
    assert filetime.from_unix_ns(0) == (369 * 365 + 89) * 86_400 * 10_000_000


def test_a_recorded_stamp() -> None:
    stamp = int.from_bytes(bytes.fromhex("b064514b35e1d601"), "little")
    moment = filetime.to_datetime(stamp)
    assert moment.date().isoformat() == "2021-01-02"
    assert filetime.from_datetime(moment) == stamp // 10 * 10


@given(st.integers(-(2**62), 2**62))
def test_unix_time_and_back(steps: int) -> None:
    assert filetime.from_unix_ns(steps * 100) == filetime.from_unix_ns(0) + steps
    assert filetime.to_unix_ns(filetime.from_unix_ns(steps * 100)) == steps * 100


@given(st.datetimes(min_value=datetime(1601, 1, 1), timezones=st.just(UTC)))
def test_datetimes_and_back(moment: datetime) -> None:
    assert filetime.to_datetime(filetime.from_datetime(moment)) == moment


def test_a_time_zone_is_taken_into_account() -> None:
    utc = datetime(2026, 1, 1, 12, tzinfo=UTC)
    east = utc.astimezone(timezone(timedelta(hours=5, minutes=30)))
    assert filetime.from_datetime(east) == filetime.from_datetime(utc)


def test_a_naive_datetime_is_refused() -> None:
    with pytest.raises(ValueError, match="time zone"):
        filetime.from_datetime(datetime(2026, 1, 1))


def test_beyond_the_calendar() -> None:
    with pytest.raises(OverflowError):
        filetime.to_datetime(2**64 - 1)
