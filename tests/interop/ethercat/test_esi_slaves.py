"""Slaves made from ESI files: masters by others bring them to Op through a network interface."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.ethercat.virtual.esi_text import ANALOG, COUPLER, DIGITAL_IN, DIGITAL_OUT, esi

OP = 8


@pytest.fixture
def line(bus: Any, tmp_path: Path) -> Any:
    """A coupler, two digital terminals and an analog one that gives back what it gets."""
    file = tmp_path / "boxes.xml"
    file.write_text(esi(COUPLER, DIGITAL_IN, DIGITAL_OUT, ANALOG))
    ready = bus.serve(
        *(sys.executable, "-m", "achse", "bus", "serve", "EK", "DI8", "DO8", "AIO"),
        *("--esi", file, "--behaviour", "4=loop-back", "--interface", "cable1"),
        *("--control", "none"),
    )
    assert ready == "achse bus ready interface=cable1 slaves=4 control=none\n"
    return bus


def test_pysoem(line: Any, judge: Callable[[Path], int], witness: Callable[[str], None]) -> None:
    witness("pysoem")
    line.record()
    found = line.master("pysoem_esi.py")
    line.end_record()
    assert found["count"] == 4
    assert found["names"] == ["EK", "DI8", "DO8", "AIO"]
    assert found["states"] == [OP] * 4, found["codes"]
    assert found["sizes"] == [[0, 0], [0, 1], [1, 0], [2, 4]]
    assert found["counter"][0] == found["counter"][1]
    assert found["inputs"][3] == found["sent"][3] + "0000"
    assert judge(line.capture) > 100


def test_kickcat(line: Any, witness: Callable[[str], None]) -> None:
    witness("kickcat")
    found = line.master("kickcat_esi.py")
    assert found["count"] == 4
    assert found["op"] == ["State.OPERATIONAL"] * 4
    assert found["inputs"][1:] == ["00", "", "00000000"]
