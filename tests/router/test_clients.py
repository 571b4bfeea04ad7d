"""Who asks through a router."""

from hypothesis import given
from hypothesis import strategies as st

from achse.router.clients import Clients

NAMES = st.sampled_from([b"a" * 8, b"b" * 8, b"c" * 8])


@given(st.lists(st.tuples(NAMES, st.integers(1, 1000), st.booleans())))
def test_requests_and_errors_are_counted_by_their_source(
    count_requests: list[tuple[bytes, int, bool]],
) -> None:
    clients = Clients()
    for source, count, wrong in count_requests:
        clients.count_requests(source, count)
        if wrong:
            clients.count_error(source)
    assert list(clients) == list(dict.fromkeys(source for source, _, _ in count_requests))
    for source in clients:
        own = [each for each in count_requests if each[0] == source]
        assert clients[source].requests == sum(count for _, count, _ in own)
        assert clients[source].errors == sum(wrong for _, _, wrong in own)
        clients[source].errors = 0
    for source in list(clients):
        clients.forget(source)
        clients.forget(source)
        clients.count_error(source)
    assert len(clients) == 0


def test_the_first_is_forgotten_where_there_are_too_many() -> None:
    clients = Clients()
    names = [number.to_bytes(8, "little") for number in range(4097)]
    for name in names:
        clients.count_requests(name)
    assert list(clients) == names[1:]


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(1, 9))), st.integers(0, 12))
def test_busiest_clients_come_first(count_requests: list[tuple[int, int]], most: int) -> None:
    clients = Clients()
    totals: dict[bytes, int] = {}
    for number, count in count_requests:
        source = bytes([number])
        clients.count_requests(source, count)
        totals[source] = totals.get(source, 0) + count
    busiest = clients.busiest(most)
    assert [totals[each] for each in busiest] == sorted(totals.values(), reverse=True)[:most]
    for source in totals:
        figures = clients.get(source)
        assert figures is not None
        assert source in clients
        assert figures.requests == totals[source]
    assert clients.get(b"unknown") is None
