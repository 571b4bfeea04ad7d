"""The project with 30 tests, and a library that looks like TcUnit from outside."""

from pathlib import Path

import pytest

DATA = Path(__file__).parents[1] / "data" / "unit_tests"


@pytest.fixture
def press() -> Path:
    return DATA / "press" / "Press.plcproj"


@pytest.fixture
def tcunit_stub() -> Path:
    return DATA / "tcunit_stub"
