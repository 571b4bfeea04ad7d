"""A folder with PLC programs in Python, one of them broken."""

from pathlib import Path

import pytest

from tests.station.plant_units import plant_units, put_unit

__all__ = ["folder", "plant_units", "put_unit"]

PROGRAM = """
from achse.iec import GlobalVariables, INT, Program, var

class Count(Program):
    nValue = var(INT)

    def cycle(self) -> None:
        self.nValue = self.nValue + 1

class Values(GlobalVariables):
    nGlobal = var(INT, 7)

class Neither:
    pass
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "broken.py").write_text("1 / 0\n", encoding="utf-8")
    return tmp_path
