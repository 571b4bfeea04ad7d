"""What is gathered and held back, without a socket."""

from hypothesis import given
from hypothesis import strategies as st

from achse.transport.connections.write_buffer import WriteBuffer


def test_samples_wait_behind_the_answer_to_an_add() -> None:
    out = WriteBuffer()
    assert not out.delay(b"before", 1.0)
    out.put(b"answer")
    out.added(1.0)
    assert out.delay(b"sample", 1.005)
    assert (out.size, out.delayed_size, out.due) == (6, 6, 1.01)
    out.release(1.009)
    assert out.take() == b"answer"
    assert out.delay(b"later", 1.02)  # others are delayed: the order stays
    out.release(1.02)
    assert out.take() == b"samplelater"
    assert (out.size, out.delayed_size, out.due) == (0, 0, None)


def test_a_peer_that_is_gone_keeps_nothing() -> None:
    out = WriteBuffer()
    out.added(0.0)
    out.put(b"answer")
    out.delay(b"sample", 0.0)
    out.clear()
    assert (out.size, out.delayed_size, out.due) == (0, 0, None)


@given(
    st.lists(
        st.tuples(st.sampled_from(("answer", "add", "sample", "wait", "take")), st.integers(0, 15)),
        max_size=80,
    )
)
def test_samples_come_in_order_none_is_lost_and_each_waits_as_long_as_it_must(
    steps: list[tuple[str, int]],
) -> None:
    out, now = WriteBuffer(), 0.0
    sent, expected = bytearray(), list[int]()
    added = -1.0
    early: dict[int, float] = {}
    for number, (what, size) in enumerate(steps, 1):
        packet = bytes((number,)) * size if what == "answer" else bytes((number,))
        if what in ("answer", "add"):
            out.put(packet)
            if what == "add":
                added = now
                out.added(now)
        elif what == "sample":
            expected.append(number)
            early[number] = added + 0.01
            if not out.delay(packet, now):
                out.put(packet)
        elif what == "wait":
            now += size / 1000
            out.release(now)
        elif out.size:
            data = out.take()
            assert all(early.get(each, 0.0) <= now + 1e-9 for each in data)
            sent += data
    now += 1
    out.release(now)
    if out.size:
        sent += out.take()
    assert [each for each in sent if each in expected] == expected
    assert (out.size, out.delayed_size, out.due) == (0, 0, None)
