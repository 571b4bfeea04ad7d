"""An amount for each host, which time refills."""

from hypothesis import given
from hypothesis import strategies as st

from achse.transport.allowance import Allowance


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_each_host_has_its_own() -> None:
    clock = Clock()
    allowance = Allowance(clock, at_once=2, per_second=1)
    assert [allowance.take("a") for _ in range(3)] == [True, True, False]
    assert allowance.take("b")
    clock.now = 1.0
    assert [allowance.take("a") for _ in range(2)] == [True, False]


@given(st.lists(st.tuples(st.floats(0, 3), st.sampled_from("abc")), max_size=200))
def test_nobody_gets_more_than_the_amount_and_what_time_adds(
    takes: list[tuple[float, str]],
) -> None:
    clock = Clock()
    allowance = Allowance(clock, at_once=5, per_second=2)
    got = dict.fromkeys("abc", 0)
    for pause, host in takes:
        clock.now += pause
        got[host] += allowance.take(host)
        assert all(count <= 5 + 2 * clock.now for count in got.values())


def test_hosts_are_forgotten() -> None:
    allowance = Allowance(Clock(), at_once=1, per_second=0)
    for number in range(5000):
        assert allowance.take(str(number))
    assert len(allowance._left) == 4096
    assert not allowance.take("4999")
