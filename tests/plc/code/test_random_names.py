"""Any names in a program: it does the same as with plain ones, in both forms of code."""

import re
from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.native.backend import compiler_installed
from achse.plc.code.execution import CodeForm
from achse.plc.code.faults import ExceptionCode
from achse.plc.runtime import PlcState
from achse.st.lexis.source import SourceError
from tests.plc.code.conftest import BEST, Ran, checked
from tests.plc.code.hostile_names import NAMES

TEMPLATE = """
TYPE <Mode> : (<idle> := 3, <busy> := 5, <done>) DINT; END_TYPE
TYPE <Part> : STRUCT <number> : LINT; <text> : STRING(20); <mode> : <Mode>; END_STRUCT END_TYPE
TYPE <Pair> : UNION <whole> : LINT; <halves> : ARRAY [0..1] OF DINT; END_UNION END_TYPE
INTERFACE <Counts> METHOD <Add> : LINT VAR_INPUT <by> : LINT; END_VAR END_METHOD END_INTERFACE
FUNCTION <Sum> : LINT
VAR_INPUT <a> : LINT; <b> : LINT := 40; <word> : STRING(9) := 'abc'; END_VAR
VAR_OUTPUT <less> : LINT; END_VAR
VAR_IN_OUT <both> : <Part>; END_VAR
VAR <local> : LINT; <other> : LINT; <real> : LREAL; <list> : ARRAY [0..3] OF LINT; END_VAR
<local> := <a> + 1; <real> := 0.5;
FOR <other> := 0 TO 3 DO <list>[<other> MOD 4] := <local>; <local> := <local> + 1; END_FOR
<less> := <a> - <b>; <both>.<number> := <both>.<number> + <local>; <both>.<mode> := <Mode>.<busy>;
<Sum> := <local> + <other> * LREAL_TO_LINT(<real> * 4.0) + <list>[2] + LEN(<word>);
END_FUNCTION
FUNCTION_BLOCK <Base> VAR <hidden> : LINT := 2; END_VAR
METHOD PROTECTED <Double> : LINT VAR_INPUT <what> : LINT; END_VAR <Double> := <what> * <hidden>;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK <Block> EXTENDS <Base> IMPLEMENTS <Counts>
VAR_INPUT <step> : LINT := 7; END_VAR VAR_OUTPUT <total> : LINT; END_VAR
VAR <count> : LINT; <part> : <Part>; <pair> : <Pair>; END_VAR
<count> := <count> + <step>; <Act>(); <total> := <total> + <Level>;
ACTION <Act> <count> := <count> + 1; <pair>.<whole> := 16#1_0000_0002; END_ACTION
METHOD <Add> : LINT VAR_INPUT <by> : LINT; END_VAR VAR <kept> : LINT; END_VAR
<kept> := <Double>(<by>); <count> := <count> + <kept>;
<Add> := <Sum>(<a> := <count>, <both> := <part>, <word> := 'wxyz', <less> => <kept>) + <kept>;
END_METHOD
PROPERTY <Level> : LINT GET <Level> := <count> + <pair>.<halves>[1]; END_GET
SET <count> := <Level>; END_SET END_PROPERTY
END_FUNCTION_BLOCK
VAR_GLOBAL <global> : LINT := 5; END_VAR
VAR_GLOBAL CONSTANT <FIXED> : LINT := 11; END_VAR
PROGRAM <Main>
VAR <block> : <Block>; <blocks> : ARRAY [1..2] OF <Block>; <face> : <Counts>; <at> : POINTER TO
<Part>; <record> : <Part> := (<number> := 9, <text> := 'begin'); <result> : LINT; <caught> : LINT;
END_VAR
<block>(<step> := <FIXED>); <blocks>[2](); <face> := <block>;
<result> := <result> + <face>.<Add>(<by> := 3) + <block>.<total>; <block>.<Level> := <global>;
<at> := ADR(<record>); <at>^.<number> := <at>^.<number> + <Sum>(<global>, <both> := <record>);
CASE <record>.<mode> OF <Mode>.<idle> : <caught> := 1; <Mode>.<busy> : <caught> := 2; END_CASE
__TRY <result> := <result> + 1 / (<caught> - 2); __CATCH <caught> := <caught> + 30; __ENDTRY
<record>.<text> := CONCAT(<record>.<text>, LINT_TO_STRING(<blocks>[2].<Level>));
<global> := <global> + <result> + <blocks>[2].<total>;
END_PROGRAM
"""

ROLES = sorted(set(re.findall(r"<(\w+)>", TEMPLATE)))

SHOWN = "result", "caught", "record", "block"


def text_with(names: dict[str, str]) -> str:
    return re.sub(r"<(\w+)>", lambda match: names[match[1]], TEMPLATE)


def results(names: dict[str, str], form: CodeForm = BEST) -> list[object]:
    ran = Ran(text_with(names), form).cycle(3)
    assert ran.plc.state is PlcState.RUN, ran.plc.fault
    return [len(ran.plain_routines), *(values(ran[names[role]]) for role in SHOWN)]


def values(value: object) -> object:
    """A record without the names of its members."""
    return [values(each) for each in value.values()] if isinstance(value, dict) else value


@cache
def expected() -> list[object]:
    return results({role: f"plain_{role}" for role in ROLES})


@pytest.mark.skipif(not compiler_installed(), reason="llvmlite is not installed")
@given(st.lists(NAMES, min_size=len(ROLES), max_size=len(ROLES), unique_by=str.lower))
def test_program_does_the_same_whatever_its_names_are(drawn: list[str]) -> None:
    names = dict(zip(ROLES, drawn, strict=True))
    assert results(names) == expected()


FEW = st.lists(NAMES, min_size=1, max_size=9, unique_by=str.lower).flatmap(
    lambda few: st.lists(st.sampled_from(few), min_size=len(ROLES), max_size=len(ROLES))
)


@given(FEW, st.sets(st.integers(0, len(ROLES) - 1), max_size=12))
def test_names_of_several_things_are_refused_or_mean_the_same_in_both_forms(
    few: list[str], places: set[int]
) -> None:
    """`Ran` compares the memory of plain and machine code after each cycle."""
    names = {role: f"plain_{role}" for role in ROLES}
    names |= {ROLES[place]: few[place] for place in places}
    text = text_with(names)
    try:
        is_refused = bool(checked(text)[1].faults)
    except SourceError:
        is_refused = True
    if is_refused:
        return
    ran = Ran(text, BEST).cycle(2)
    fault = ran.plc.fault
    assert fault is None or fault.code != ExceptionCode.UNRESOLVED_EXTREFS, fault
