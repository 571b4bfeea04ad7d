"""What every PLC project can name without declaring it: the standard function blocks and types.

Written as the sources they come from, as far as their memory goes; their bodies come with the
execution of Structured Text.
"""

from functools import cache

from achse.iec.st.parser import Parsed, parse
from achse.iec.st.source import Source

__all__ = ["standard_library"]

_TIMER = """
FUNCTION_BLOCK {name}
VAR_INPUT
    IN : BOOL;
    PT : {time};
END_VAR
VAR_OUTPUT
    Q : BOOL;
    ET : {time};
END_VAR
VAR
    {memory}
    StartTime : {time};
END_VAR
END_FUNCTION_BLOCK
"""
_TRIGGER = """
FUNCTION_BLOCK {name}
VAR_INPUT CLK : BOOL; END_VAR
VAR_OUTPUT Q : BOOL; END_VAR
VAR M : BOOL; END_VAR
END_FUNCTION_BLOCK
"""
_REST = """
FUNCTION_BLOCK CTU
VAR_INPUT CU, RESET : BOOL; PV : WORD; END_VAR
VAR_OUTPUT Q : BOOL; CV : WORD; END_VAR
VAR M : BOOL; END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK CTD
VAR_INPUT CD, LOAD : BOOL; PV : WORD; END_VAR
VAR_OUTPUT Q : BOOL; CV : WORD; END_VAR
VAR M : BOOL; END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK CTUD
VAR_INPUT CU, CD, RESET, LOAD : BOOL; PV : WORD; END_VAR
VAR_OUTPUT QU, QD : BOOL; CV : WORD; END_VAR
VAR MU, MD : BOOL; END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK SR
VAR_INPUT SET1, RESET : BOOL; END_VAR
VAR_OUTPUT Q1 : BOOL; END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK RS
VAR_INPUT SET, RESET1 : BOOL; END_VAR
VAR_OUTPUT Q1 : BOOL; END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK SEMA
VAR_INPUT CLAIM, RELEASE : BOOL; END_VAR
VAR_OUTPUT BUSY : BOOL; END_VAR
VAR X : BOOL; END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK GETCURTASKINDEX
VAR_OUTPUT index : BYTE; END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK GETCPUCOUNTER
VAR_OUTPUT cpuCntLoDW, cpuCntHiDW : UDINT; END_VAR
END_FUNCTION_BLOCK

{attribute 'qualified_only'}
TYPE TYPE_CLASS : (
    TYPE_BOOL, TYPE_BIT, TYPE_BYTE, TYPE_WORD, TYPE_DWORD, TYPE_LWORD, TYPE_SINT, TYPE_INT,
    TYPE_DINT, TYPE_LINT, TYPE_USINT, TYPE_UINT, TYPE_UDINT, TYPE_ULINT, TYPE_REAL, TYPE_LREAL,
    TYPE_STRING, TYPE_WSTRING, TYPE_TIME, TYPE_DATE, TYPE_DATEANDTIME, TYPE_TIMEOFDAY,
    TYPE_POINTER, TYPE_REFERENCE, TYPE_SUBRANGE, TYPE_ENUM, TYPE_ARRAY, TYPE_PARAMS,
    TYPE_USERDEF, TYPE_NONE, TYPE_ANY
) DINT;
END_TYPE

TYPE
    TypeClass : TYPE_CLASS;
    AnyType : STRUCT
        typeclass : TYPE_CLASS;
        pvalue : POINTER TO BYTE;
        diSize : DINT;
    END_STRUCT
    ST_LibVersion : STRUCT
        iMajor, iMinor, iBuild, iRevision : UINT;
        nFlags : DWORD;
        sVersion : STRING(23);
    END_STRUCT
    T_MaxString : STRING(255);
    T_AmsNetId : STRING(23);
    T_AmsPort : UINT;
    T_IPv4Addr : STRING(15);
    OTCID : UDINT;
    BOOL32 : UDINT;
    GUID : STRUCT
        Data1 : UDINT;
        Data2 : UINT;
        Data3 : UINT;
        Data4 : ARRAY [0..7] OF BYTE;
    END_STRUCT
    CLSID : GUID;
    IID : GUID;
END_TYPE

INTERFACE IQueryInterface
END_INTERFACE

VAR_GLOBAL CONSTANT
    PI : LREAL := 3.1415926535897932384626433832795;
    MAX_STRING_LENGTH : UDINT := 255;
END_VAR
"""


@cache
def standard_library() -> Parsed:
    """The declarations, read once."""
    parts = []
    for prefix, time in (("", "TIME"), ("L", "LTIME")):
        for kind in ("TON", "TOF", "TP"):
            memory = "" if kind == "TP" else "M : BOOL;"
            parts.append(_TIMER.format(name=prefix + kind, time=time, memory=memory))
    parts += [_TRIGGER.format(name=name) for name in ("R_TRIG", "F_TRIG")]
    source = Source("".join([*parts, _REST]), "<standard library>")
    return parse(source, name="StandardConstants").check()
