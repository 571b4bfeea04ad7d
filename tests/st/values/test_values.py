"""How values of constant expressions fit into types."""

from typing import Any

import pytest

from achse.iec import (
    BOOL,
    BYTE,
    DWORD,
    INT,
    LREAL,
    LTIME,
    REAL,
    SINT,
    STRING,
    TIME,
    UINT,
    WSTRING,
    IecType,
    pointer_to,
)
from achse.st.syntax.cursor import Unexpected
from achse.st.values.values import Constant, fitted


@pytest.mark.parametrize(
    ("constant", "type", "value"),
    [
        (Constant(5), INT, 5),
        (Constant(5), LREAL, 5.0),
        (Constant(1.5), REAL, 1.5),
        (Constant(True), BOOL, True),
        (Constant(1), BOOL, 1),
        (Constant("x"), STRING(1), "x"),
        (Constant("x"), WSTRING(1), "x"),
        (Constant("xyz"), STRING(2), "xy"),
        (Constant("a\N{GRINNING FACE}"), WSTRING(2), "a"),
        (Constant(0xFF, BYTE), SINT, -1),
        (Constant(0x8000, UINT), INT, -0x8000),
        (Constant(5, BYTE), INT, 5),
        (Constant(-3), DWORD, 0xFFFFFFFD),
        (Constant(-128), BYTE, 0x80),
        (Constant(1500, TIME), TIME, 1500),
        (Constant(1500, TIME), LTIME, 1_500_000_000),
        (Constant(2_000_000, LTIME), TIME, 2),
        (Constant(7), TIME, 7),
        (Constant(0), pointer_to(INT), 0),
    ],
)
def test_constants_fit(constant: Constant, type: IecType[Any], value: object) -> None:
    assert fitted(constant, type, 0) == value


@pytest.mark.parametrize(
    ("constant", "type"),
    [
        (Constant(40000), INT),
        (Constant(0x18000, UINT), INT),
        (Constant(-129), BYTE),
        (Constant(1.5), INT),
        (Constant(True), INT),
        (Constant("x"), INT),
        (Constant(5), STRING(5)),
        (Constant(1, LTIME), TIME),
        (Constant(1.5), BOOL),
        (Constant(-1), pointer_to(INT)),
    ],
)
def test_constants_do_not_fit(constant: Constant, type: IecType[Any]) -> None:
    with pytest.raises(Unexpected):
        fitted(constant, type, 0)
