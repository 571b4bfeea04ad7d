"""Numbers of the station's own service."""

from achse.codes.station import MISSING_CONDITION, ONLINE_CHANGE, SERVICE_PORT
from achse.devices.station import FAULTS, STATISTICS
from achse.devices.taps import TAPS


def test_numbers_are_in_the_range_of_customers_and_different() -> None:
    assert 26_000 <= SERVICE_PORT <= 26_999
    groups = (FAULTS, TAPS, STATISTICS, ONLINE_CHANGE, MISSING_CONDITION)
    assert len(set(groups)) == len(groups)
