"""The PLC program of the demo station: a cycle counter, and one variable of every kind."""

from datetime import date, datetime, time, timedelta

from achse.iec import (
    ARRAY,
    BOOL,
    BYTE,
    DATE,
    DINT,
    DT,
    DWORD,
    INT,
    LDATE,
    LDT,
    LINT,
    LREAL,
    LTIME,
    LTOD,
    LWORD,
    REAL,
    SINT,
    STRING,
    TIME,
    TOD,
    UDINT,
    UINT,
    ULINT,
    USINT,
    WORD,
    WSTRING,
    Enumeration,
    GlobalVariables,
    Nanoseconds,
    Program,
    Struct,
    var,
)


class E_Colour(Enumeration):
    RED = 0
    GREEN = 1
    BLUE = 2


class ST_Point(Struct):
    fX = var(LREAL)
    fY = var(LREAL)
    sName = var(STRING(20))
    bValid = var(BOOL)


class MAIN(Program):
    """Counts the cycles of its task."""

    nCounter = var(UDINT, comment="task cycles since the start")

    def cycle(self) -> None:
        self.nCounter = (self.nCounter + 1) & 0xFFFF_FFFF


class GVL(GlobalVariables):
    """Something to read and write for every type."""

    bBool = var(BOOL, True)
    nByte = var(BYTE, 0x5A)
    nWord = var(WORD, 0xBEEF)
    nDword = var(DWORD, 0xDEAD_BEEF)
    nLword = var(LWORD, 0x0123_4567_89AB_CDEF)
    nSint = var(SINT, -8)
    nUsint = var(USINT, 8)
    nInt = var(INT, -16)
    nUint = var(UINT, 16)
    nDint = var(DINT, -32)
    nUdint = var(UDINT, 32)
    nLint = var(LINT, -64)
    nUlint = var(ULINT, 64)
    fReal = var(REAL, 1.5)
    fLreal = var(LREAL, 2.5)
    sString = var(STRING(80), "axis")
    wsString = var(WSTRING(80), "Achse °")
    tTime = var(TIME, timedelta(milliseconds=1500))
    tLtime = var(LTIME, Nanoseconds(1_500_000_001))
    dDate = var(DATE, date(2026, 1, 1))
    tTod = var(TOD, time(12, 30))
    dtDt = var(DT, datetime(2026, 1, 1, 12, 30))
    tLdate = var(LDATE, date(2026, 1, 1))
    tLtod = var(LTOD, Nanoseconds(45_000_000_000_001))
    tLdt = var(LDT, Nanoseconds(1_767_270_600_000_000_001))
    aInt = var(ARRAY(INT, (0, 9)), list(range(10)))
    aLreal = var(ARRAY(LREAL, (1, 2), (1, 3)), [[1.1, 1.2, 1.3], [2.1, 2.2, 2.3]])
    stPoint = var(ST_Point, {"fX": 1.0, "fY": 2.0, "sName": "home", "bValid": True})
    aPoints = var(ARRAY(ST_Point, (1, 3)))
    eColour = var(E_Colour, E_Colour.GREEN)
