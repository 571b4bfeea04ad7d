"""Nodes: compared without their places, and copied with other values."""

from achse.st.syntax.nodes import changed, node, place


@node
class Pair:
    """Of this test."""

    first: int
    second: str
    at: int = place()


def test_places_do_not_count() -> None:
    assert Pair(1, "a", at=3) == Pair(1, "a", at=9)
    assert hash(Pair(1, "a", at=3)) == hash(Pair(1, "a", at=9))
    assert repr(Pair(1, "a", at=3)) == "Pair(first=1, second='a')"


def test_changed_node_keeps_its_place() -> None:
    pair = Pair(1, "a", at=3)
    copy = changed(pair, second="b")
    assert (copy, copy.at) == (Pair(1, "b"), 3)
    assert pair == Pair(1, "a")
