"""A PLC application with a bit of everything, and a device in front of it."""
# ruff: noqa: N815 (IEC names)

import pytest

from achse.devices.plc import PlcDevice
from achse.iec import (
    ARRAY,
    BIT,
    BOOL,
    BYTE,
    DINT,
    INT,
    LREAL,
    STRING,
    UDINT,
    UINT,
    FunctionBlock,
    GlobalVariables,
    Program,
    Struct,
    method,
    var,
)
from achse.plc import Area, Memory, PlcRuntime, Task

MS = 1_000_000


class ST_Point(Struct):  # noqa: N801
    nId = var(INT, 7)
    fX = var(LREAL)
    sName = var(STRING(15))
    aTags = var(ARRAY(BYTE, (0, 2)))
    bLow = var(BIT)
    bHigh = var(BIT, True)


class FB_Sum(FunctionBlock):  # noqa: N801
    nCalls = var(UDINT)

    def __init__(self) -> None:
        self.history: list[float] = []

    @method(LREAL, outputs={"nCount": UDINT}, fA=LREAL, fB=LREAL)
    def Add(self, a: float, b: float) -> tuple[float, int]:  # noqa: N802
        self.nCalls += 1
        self.history.append(a + b)
        return a + b, len(self.history)

    @method()
    def Clear(self) -> None:  # noqa: N802
        self.history.clear()


class GVL(GlobalVariables):
    aValues = var(ARRAY(INT, (-1, 3)), [1, 2, 3, 4, 5], comment="five values")
    aGrid = var(ARRAY(INT, (0, 1), (0, 2)), [[1, 2, 3], [4, 5, 6]])
    aPoints = var(ARRAY(ST_Point, (1, 2)))
    bInput = var(BOOL, at="%IX1.2")
    nOutput = var(UINT, 5, at="%QW4")
    nFlag = var(UDINT, 0x0403_0201, at="%MD8")
    nRetain = var(DINT, -1, retain=True)
    nKept = var(DINT, persistent=True)
    nFixed = var(INT, 42, constant=True, attributes={"Unit": "mm"})
    fbSums = var(ARRAY(FB_Sum, (0, 1)))


class MAIN(Program):
    nCounter = var(UDINT)
    nFaultAt = var(UDINT)

    def cycle(self) -> None:
        self.nCounter += 1
        if self.nCounter == self.nFaultAt:
            raise ZeroDivisionError


class Slow(Program):
    nSlow = var(UDINT)


@pytest.fixture
def plc() -> PlcRuntime:
    return PlcRuntime(
        [Task("PlcTask", 10 * MS, [MAIN]), Task("SlowTask", 100 * MS, [Slow], priority=30)],
        [GVL],
        memory=Memory({Area.INPUT: 128}),
    )


@pytest.fixture
def clock() -> list[int]:
    """The unix time in ns that the device sees."""
    return [1_700_000_000_000_000_000]


@pytest.fixture
def device(plc: PlcRuntime, clock: list[int]) -> PlcDevice:
    return PlcDevice(plc, clock=lambda: clock[0])
