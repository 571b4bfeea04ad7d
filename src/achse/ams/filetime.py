"""FILETIME: 100 ns steps since 1601-01-01 UTC, the time stamp of notifications (002 §5.4.9)."""

from datetime import UTC, datetime, timedelta

_EPOCH = datetime(1601, 1, 1, tzinfo=UTC)
_UNIX_EPOCH = 116_444_736_000_000_000
"""1970-01-01 as FILETIME."""


def from_unix_ns(unix_ns: int) -> int:
    """Nanoseconds since 1970 as FILETIME (rounded down to 100 ns)."""
    return unix_ns // 100 + _UNIX_EPOCH


def to_unix_ns(filetime: int) -> int:
    """FILETIME as nanoseconds since 1970."""
    return (filetime - _UNIX_EPOCH) * 100


def to_datetime(filetime: int) -> datetime:
    """FILETIME as an aware UTC datetime (microseconds; the last 100 ns digit is dropped).

    Raises OverflowError beyond the year 9999.
    """
    return _EPOCH + timedelta(microseconds=filetime // 10)
