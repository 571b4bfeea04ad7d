"""FILETIME: 100 ns since 1601-01-01 UTC."""

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import filetime

EPOCH = datetime(1601, 1, 1, tzinfo=UTC)


def test_the_epochs() -> None:
    assert filetime.to_datetime(0) == EPOCH
    # 369 years with 89 leap days are between the epochs
    assert filetime.from_unix_ns(0) == (369 * 365 + 89) * 86_400 * 10_000_000


def test_a_recorded_stamp() -> None:
    stamp = int.from_bytes(bytes.fromhex("b064514b35e1d601"), "little")
    moment = filetime.to_datetime(stamp)
    assert moment.date().isoformat() == "2021-01-02"
    assert moment == EPOCH + timedelta(microseconds=stamp // 10)


@given(st.integers(-(2**62), 2**62))
def test_unix_time_and_back(steps: int) -> None:
    assert filetime.from_unix_ns(steps * 100) == filetime.from_unix_ns(0) + steps
    assert filetime.to_unix_ns(filetime.from_unix_ns(steps * 100)) == steps * 100


@given(st.datetimes(min_value=datetime(1601, 1, 1), timezones=st.just(UTC)))
def test_datetimes_of_stamps(moment: datetime) -> None:
    stamp = (moment - EPOCH) // timedelta(microseconds=1) * 10
    assert filetime.to_datetime(stamp) == filetime.to_datetime(stamp + 9) == moment


def test_beyond_the_calendar() -> None:
    with pytest.raises(OverflowError):
        filetime.to_datetime(2**64 - 1)
