"""Who sends by one connection."""

from hypothesis import given
from hypothesis import strategies as st

from achse.transport.connections.senders import MOST_SENDERS, Senders


@given(st.lists(st.sampled_from([b"a" * 8, b"b" * 8, b"c" * 8])))
def test_senders_are_known_in_their_order(spoken: list[bytes]) -> None:
    senders = Senders()
    for source in spoken:
        assert senders.add(source) is None
        assert source in senders
    assert list(senders) == list(dict.fromkeys(spoken))
    assert bool(senders) == bool(spoken)
    senders.clear()
    assert not senders


def test_the_oldest_is_forgotten_where_there_are_too_many() -> None:
    senders = Senders()
    names = [number.to_bytes(8, "little") for number in range(MOST_SENDERS + 1)]
    assert [senders.add(name) for name in names] == [None] * MOST_SENDERS + [names[0]]
    assert names[0] not in senders
