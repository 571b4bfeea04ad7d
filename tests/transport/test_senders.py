"""Who sends by one connection."""

from hypothesis import given
from hypothesis import strategies as st

from achse.transport.senders import MOST_SENDERS, Senders


@given(st.lists(st.sampled_from([b"a" * 8, b"b" * 8, b"c" * 8])))
def test_requests_are_counted_where_they_came_from(spoken: list[bytes]) -> None:
    senders = Senders()
    for source in spoken:
        assert senders.turn_to(source) is None
        senders.speaking.requests += 1
        senders.refused(source)
    assert list(senders) == list(dict.fromkeys(spoken))
    assert bool(senders) == bool(spoken)
    for source in senders:
        assert source in senders
        assert senders[source].requests == senders[source].errors == spoken.count(source)
    senders.clear()
    assert not senders


def test_the_oldest_is_forgotten_where_there_are_too_many() -> None:
    senders = Senders()
    names = [number.to_bytes(8, "little") for number in range(MOST_SENDERS + 1)]
    assert [senders.turn_to(name) for name in names] == [None] * MOST_SENDERS + [names[0]]
    senders.refused(names[0])
    assert names[0] not in senders
