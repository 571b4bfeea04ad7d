"""RETAIN and PERSISTENT variables of a PLC go into the next one, if they have the same type."""

from hypothesis import given
from hypothesis import strategies as st

from achse.plc.remains import inherit_variables, kept_variables
from tests.plc.code.conftest import Ran

TEXT = """
FUNCTION_BLOCK FB_Pump
VAR PERSISTENT nStarts : {type}; END_VAR
VAR n : INT; END_VAR
END_FUNCTION_BLOCK
VAR_GLOBAL PERSISTENT sName : STRING(10); END_VAR
PROGRAM MAIN
VAR RETAIN r : INT := 3; END_VAR
VAR PERSISTENT p : ARRAY [1..2] OF DINT; END_VAR
VAR a : ARRAY [0..1] OF FB_Pump; n : INT; END_VAR
END_PROGRAM
"""


def _ran(type: str = "UDINT") -> Ran:
    return Ran(TEXT.replace("{type}", type)).cycle()


@given(
    st.integers(-(1 << 15), (1 << 15) - 1),
    st.lists(st.integers(0, (1 << 31) - 1), min_size=4, max_size=4),
    st.text("abcX", max_size=10),
)
def test_what_was_kept_is_there_again(number: int, numbers: list[int], text: str) -> None:
    before, after = _ran(), _ran()
    main = before.plc.instance("MAIN")
    main["r"], main["n"] = number, 7
    main["p"][1], main["p"][2] = numbers[:2]
    main["a"][0]["nStarts"], main["a"][1]["nStarts"] = numbers[2:]
    before.plc.instance("GVL")["sName"] = text
    kept = kept_variables(before.plc)
    assert set(kept) == {
        "MAIN.r", "MAIN.p", "MAIN.a[0].nStarts", "MAIN.a[1].nStarts", "GVL.sName"
    }  # fmt: skip
    assert inherit_variables(after.plc, kept) == []
    assert (after["r"], after["p"], after["n"]) == (number, numbers[:2], 0)
    assert [one["nStarts"] for one in after.plc.instance("MAIN")["a"]] == numbers[2:]
    assert after.plc.instance("GVL")["sName"] == text


def test_another_type_begins_as_declared_and_is_told() -> None:
    before, after = _ran(), _ran("LINT")
    before.plc.instance("MAIN")["a"][0]["nStarts"] = 5
    left = inherit_variables(after.plc, kept_variables(before.plc))
    assert left == ["MAIN.a[0].nStarts", "MAIN.a[1].nStarts"]
    assert after.plc.instance("MAIN")["a"][0]["nStarts"] == 0
