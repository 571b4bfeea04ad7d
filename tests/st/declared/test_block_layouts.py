"""Layouts of blocks: given sizes, bases laid out with the block, sections without symbols."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as some

from achse.iec.describe import describe_type, types_shown
from achse.iec.layout import TC3_X64, TC3_X86, LayoutRules
from achse.iec.structs import StructType
from achse.iec.variables import Section
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from tests.plc.code.conftest import Ran

_BASE = """
{attribute 'joint_layout'}
FUNCTION_BLOCK ABSTRACT _Root
{attribute 'TcNoSymbol'} VAR state : LINT; END_VAR
METHOD PROTECTED Count
state := state + Step();
END_METHOD
METHOD PROTECTED ABSTRACT Step : LINT
END_METHOD
END_FUNCTION_BLOCK

{attribute 'joint_layout'}
FUNCTION_BLOCK ABSTRACT _Base EXTENDS _Root
VAR_INPUT Execute : BOOL; END_VAR
VAR_OUTPUT Done : BOOL; END_VAR
END_FUNCTION_BLOCK

{attribute 'size' := '64'} {attribute 'size_32' := '48'}
FUNCTION_BLOCK FB EXTENDS _Base
VAR_INPUT Position : LREAL; END_VAR
VAR_OUTPUT Sum : LINT; END_VAR
{attribute 'TcNoSymbol'} VAR own : INT := 3; END_VAR
Count();
Sum := state;
Done := Execute;
METHOD PROTECTED Step : LINT
Step := own;
END_METHOD
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Other EXTENDS _Base
VAR_OUTPUT Sum : LINT; END_VAR
Count();
Sum := state;
METHOD PROTECTED Step : LINT
Step := 10;
END_METHOD
END_FUNCTION_BLOCK
"""


def _type(name: str, text: str = _BASE, rules: LayoutRules = TC3_X64) -> StructType[Any]:
    type = declare([parse(Source(text, "a.st"), name="a")], rules=rules).types[name.lower()]
    assert isinstance(type, StructType)
    return type


def test_joint_layout_has_the_interface_first() -> None:
    type = _type("FB")
    assert [(each.name, each.offset) for each in type.shown] == [
        ("Execute", 8),
        ("Position", 16),
        ("Done", 24),
        ("Sum", 32),
    ]
    hidden = {each.name: each.offset for each in type.members if each.hidden}
    assert hidden == {"state": 40, "own": 48}


@pytest.mark.parametrize(("rules", "size"), [(TC3_X64, 64), (TC3_X86, 48)])
def test_size_is_that_of_the_platform(rules: LayoutRules, size: int) -> None:
    assert _type("FB", rules=rules).size == size


def test_type_entry_shows_neither_base_nor_private_members() -> None:
    entry = describe_type(_type("FB"))
    assert [member.name for member in entry.members] == ["Execute", "Position", "Done", "Sum"]
    assert entry.attributes == ()
    assert "_Base<FB>" not in {type.name for type in types_shown([_type("FB")])}


def test_bases_with_joint_layout_work_in_each_block() -> None:
    text = f"""{_BASE}
PROGRAM MAIN VAR first : FB; others : ARRAY [0..1] OF FB_Other; copy : FB; END_VAR
first(Execute := TRUE);
first();
others[1]();
copy := first;
copy();
END_PROGRAM"""
    ran = Ran(text).cycle()
    main: Any = ran.plc.instance("MAIN")
    assert (main["first"]["Sum"], main["first"]["Done"]) == (6, True)
    assert (main["others"][1]["Sum"], main["others"][0]["Sum"]) == (10, 0)
    assert main["copy"]["Sum"] == 9


_SIZES = {"BOOL": 1, "INT": 2, "DINT": 4, "LREAL": 8, "STRING(10)": 11}
_SECTIONS = ("VAR_IN_OUT", "VAR_INPUT", "VAR_OUTPUT", "VAR")
_ORDER = (Section.IN_OUT, Section.INPUT, Section.OUTPUT, Section.LOCAL)


@given(
    some.lists(
        some.lists(
            some.tuples(some.sampled_from(_SECTIONS), some.sampled_from(sorted(_SIZES))),
            max_size=4,
        ),
        min_size=2,
        max_size=4,
    ),
    some.sampled_from((TC3_X64, TC3_X86)),
    some.integers(0, 200),
)
def test_joint_layout_is_that_of_one_block(
    levels: list[list[tuple[str, str]]], rules: LayoutRules, size: int
) -> None:
    text, number = "", 0
    for level, members in enumerate(levels):
        last = level == len(levels) - 1
        head = f"{{attribute 'size' := '{size}'}}" if last else "{attribute 'joint_layout'}"
        base = f" EXTENDS B{level - 1}" if level else ""
        text += f"{head}\nFUNCTION_BLOCK B{level}{base}\n"
        for section, kind in members:
            text += f"{section} m{number} : {kind}; END_VAR\n"
            number += 1
        text += "END_FUNCTION_BLOCK\n"
    type = _type(f"B{len(levels) - 1}", text, rules)
    flat = [one for members in levels for one in members]
    flat.sort(key=lambda one: _SECTIONS.index(one[0]))
    lines = "".join(f"{section} m{n} : {kind}; END_VAR\n" for n, (section, kind) in enumerate(flat))
    same = _type("FB", f"FUNCTION_BLOCK FB\n{lines}END_FUNCTION_BLOCK", rules)
    assert [one.offset for one in type.shown] == [one.offset for one in same.members]
    assert [_ORDER.index(one.section) for one in type.shown] == sorted(
        _ORDER.index(one.section) for one in type.shown
    )
    wanted = size if rules is TC3_X64 else 0
    assert same.size <= type.size < max(same.size, wanted) + 8
    assert type.size >= wanted
