"""Axes that are the places."""

from achse.motion.groups.kinematics.identity import forward, inverse


def test_nothing_changes() -> None:
    results = [0.0] * 3
    assert forward([], [1.0, 2.0, 3.0], results)
    assert results == [1.0, 2.0, 3.0]
    assert inverse([], [4.0, 5.0, 6.0], results)
    assert results == [4.0, 5.0, 6.0]
