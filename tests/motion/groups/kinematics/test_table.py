"""Every law of the table: there and back again, numbers by name, laws of users."""

import random
from pathlib import Path

import pytest

from achse.motion.groups.kinematics.table import KINEMATICS, law_from_file
from achse.motion.groups.parameters import GroupParametersError

RANGES = {"scara": ((-170, 170), (-170, 170)), "parallel": ((60, 170), (10, 120)),
          "delta": ((-40, 80),) * 3}  # fmt: skip


@pytest.mark.parametrize("name", KINEMATICS)
def test_there_and_back_again(name: str) -> None:
    """The inverse, with the present axes given, leads back to the same place."""
    law, source = KINEMATICS[name], random.Random(name)
    numbers = law.in_order({}, name)
    result = 0
    for _ in range(300):
        ranges = RANGES.get(name, ((-99, 99),) * 3)
        axes = [source.uniform(*limits) for limits in ranges]
        axes += [source.uniform(-9.0, 9.0) for _ in range(8 - len(axes))]
        places, back, again = [0.0] * 8, list(axes), [0.0] * 8
        if not law.forward(numbers, axes, places):
            continue
        result += 1
        assert law.inverse(numbers, places, back)
        assert law.forward(numbers, back, again)
        assert again == pytest.approx(places, abs=1e-9)
    assert result > 200


def test_numbers_have_names() -> None:
    assert KINEMATICS["scara"].in_order({"second_arm": 1.0}, "x") == [300.0, 1.0]
    with pytest.raises(GroupParametersError, match="no number 'arm'"):
        KINEMATICS["scara"].in_order({"arm": 1.0}, "x")


def test_a_law_of_the_user(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    with pytest.raises(GroupParametersError, match=r"mine\.py"):
        law_from_file(file)
    file.write_text(
        "NUMBERS = {'ratio': 2}\ndef forward(n, a, p):\n    p[0] = n[0] * a[0]\n    return 1\n"
    )
    with pytest.raises(GroupParametersError, match="inverse"):
        law_from_file(file)
    with file.open("a") as more:
        more.write("def inverse(n, p, a):\n    a[0] = p[0] / n[0]\n    return 1\n")
    law = law_from_file(file)
    places = [0.0] * 8
    assert law.forward(law.in_order({}, "x"), [4.0], places)
    assert places[0] == 8.0
    file.write_text("NUMBERS = 3\ndef forward(): ...\ndef inverse(): ...\n")
    with pytest.raises(GroupParametersError, match="NUMBERS"):
        law_from_file(file)
