"""The library that every project can name."""

import pytest

from achse.iec import StructType
from achse.st.declare import declare
from achse.st.parser import parse


@pytest.mark.parametrize(
    ("name", "size", "members"),
    [
        # 8 bytes table pointer, IN at 8, PT at 12, Q at 16, ET at 20, M at 24, StartTime at 28.
        ("TON", 32, {"IN": 8, "PT": 12, "Q": 16, "ET": 20, "M": 24, "StartTime": 28}),
        ("TOF", 32, {"M": 24}),
        ("TP", 32, {"ET": 20, "StartTime": 24}),
        ("LTON", 56, {"PT": 16, "ET": 32, "StartTime": 48}),
        ("R_TRIG", 16, {"CLK": 8, "Q": 9, "M": 10}),
        ("CTUD", 24, {"CU": 8, "LOAD": 11, "PV": 12, "QD": 15, "CV": 16, "MD": 19}),
        ("GUID", 16, {"Data4": 8}),
        ("AMSADDR", 8, {"port": 6}),
        # Six numbers up to 20, a class, 80 bytes of text, three numbers of 4, an area, 40 and 80.
        ("__SYSTEM.VAR_INFO", 240, {"BitNo": 12, "TypeClass": 20, "TypeName": 24, "Symbol": 120}),
        ("__SYSTEM.AnyType", 24, {"pvalue": 8, "diSize": 16}),
    ],
)
def test_layouts(name: str, size: int, members: dict[str, int]) -> None:
    text = f"PROGRAM P VAR x : {name}; END_VAR END_PROGRAM"
    (variable,) = declare([parse(text)]).programs["p"].__iec__.members
    assert isinstance(variable.type, StructType)
    assert variable.type.size == size
    for member, offset in members.items():
        assert variable.type.member(member).offset == offset


def test_constants() -> None:
    text = "PROGRAM P VAR x : LREAL := PI; s : T_MaxString; END_VAR END_PROGRAM"
    x, s = declare([parse(text)]).programs["p"].__iec__.members
    assert x.initial == pytest.approx(3.141592653589793)
    assert s.type.size == 256


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("__SYSTEM.TYPE_CLASS := __SYSTEM.TYPE_CLASS.TYPE_BITCONST", 38),
        ("__SYSTEM.MEMORY_AREA := __SYSTEM.MEMORY_AREA.MEM_LOCAL", 5),
        ("__SYSTEM.ExceptionCode := __SYSTEM.ExceptionCode.RTSEXCPT_DIVIDEBYZERO", 0x102),
    ],
)
def test_values_of_system_enumerations(text: str, value: int) -> None:
    (x,) = (
        declare([parse(f"PROGRAM P VAR x : {text}; END_VAR END_PROGRAM")])
        .programs["p"]
        .__iec__.members
    )
    assert x.initial == value
    assert x.type.size == 4


def test_inputs_of_any_type_are_descriptions_of_what_is_passed() -> None:
    text = "FUNCTION_BLOCK FB VAR_INPUT a : ANY; b : ANY_NUM; END_VAR END_FUNCTION_BLOCK"
    block = declare([parse(text)]).types["fb"]
    assert isinstance(block, StructType)
    assert block.size == 8 + 2 * 24
    declare([parse("FUNCTION F : INT VAR_INPUT a : ANY; END_VAR END_FUNCTION")])
