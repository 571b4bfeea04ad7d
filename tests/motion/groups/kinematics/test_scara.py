"""SCARA: the elbow stays on its side, the arms keep their turns."""

import pytest

from achse.motion.groups.kinematics.scara import forward, inverse

ARMS = [300.0, 200.0]


def test_the_figures_of_the_facts() -> None:
    places = [0.0] * 3
    assert forward(ARMS, [30.0, 60.0, 5.0], places)
    assert places == pytest.approx([259.807621135, 350.0, 5.0])


@pytest.mark.parametrize(("shoulder", "elbow"), [(30.0, 60.0), (30.0, -60.0), (390.0, 60.0)])
def test_of_two_solutions_the_present_one(shoulder: float, elbow: float) -> None:
    places, axes = [0.0] * 2, [shoulder + 3.0, elbow - 2.0]
    forward(ARMS, [shoulder, elbow], places)
    assert inverse(ARMS, places, axes)
    assert axes == pytest.approx([shoulder, elbow])


@pytest.mark.parametrize("place", [(501.0, 0.0), (0.0, 99.0), (0.0, 0.0)])
def test_out_of_reach(place: tuple[float, float]) -> None:
    assert not inverse(ARMS, place, [0.0, 0.0])
