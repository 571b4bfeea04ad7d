"""Percentiles of latencies from counts."""

from hypothesis import given
from hypothesis import strategies as st

from achse.router.forwarding.latency import Latencies


@given(st.lists(st.integers(0, 100_000_000_000), min_size=1, max_size=50), st.floats(0.01, 1.0))
def test_percentile_is_at_most_a_fourth_above_the_sample(samples: list[int], share: float) -> None:
    latencies = Latencies()
    for sample in samples:
        latencies.add(sample)
    ordered = sorted(samples)
    exact = next(each for n, each in enumerate(ordered, 1) if n >= share * len(ordered))
    assert exact <= latencies.within_ns(share) <= max(1024, exact * 1.26)


def test_percentile_without_samples_is_zero() -> None:
    assert Latencies().within_ns(0.5) == 0
    endless = Latencies()
    endless.add(10**15)
    assert endless.within_ns(1.0) > 100_000_000_000
