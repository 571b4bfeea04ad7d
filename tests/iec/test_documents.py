"""IEC values as literals and as JSON has them."""

import math
from datetime import timedelta
from typing import Any

import pytest

from achse.iec import (
    ARRAY,
    BOOL,
    INT,
    LREAL,
    STRING,
    TIME,
    Enumeration,
    IecType,
    Struct,
    iec_type,
    var,
)
from achse.iec.derived import OpaqueType
from achse.iec.documents import as_json, as_text


class E_Mode(Enumeration):  # noqa: N801
    OFF = 0
    ON = 3


class ST_Axis(Struct):  # noqa: N801
    nId = var(INT)  # noqa: N815
    eMode = var(E_Mode)  # noqa: N815
    tRamp = var(TIME)  # noqa: N815
    aSteps = var(ARRAY(INT, (0, 1), (1, 2)))  # noqa: N815


@pytest.mark.parametrize(
    ("type", "value", "text", "document"),
    [
        (INT, -5, "-5", -5),
        (BOOL, True, "TRUE", True),
        (LREAL, 1.5, "1.5", 1.5),
        (LREAL, math.inf, "inf", "inf"),
        (STRING(10), "it's", "'it$'s'", "it's"),
        (TIME, timedelta(milliseconds=1500), "T#1s500ms", "T#1s500ms"),
        (iec_type(E_Mode), E_Mode.ON, "ON", "ON"),
        (ARRAY(INT, (1, 3)), [1, 2, 3], "[1, 2, 3]", [1, 2, 3]),
        (OpaqueType("?", 3, 1, 0), b"\1\2\xff", "01 02 ff", "01 02 ff"),
        (
            iec_type(ST_Axis),
            {"nId": 7, "eMode": 3, "tRamp": timedelta(seconds=2), "aSteps": [[1, 2], [3, 4]]},
            "(nId := 7, eMode := ON, tRamp := T#2s, aSteps := [[1, 2], [3, 4]])",
            {"nId": 7, "eMode": "ON", "tRamp": "T#2s", "aSteps": [[1, 2], [3, 4]]},
        ),
    ],
    ids=lambda item: item.name if isinstance(item, IecType) else "",
)
def test_a_value_as_text_and_as_json(
    type: IecType[Any], value: object, text: str, document: object
) -> None:
    received = type.decode(type.encode(value))
    assert as_text(type, received) == text
    assert as_json(type, received) == document
