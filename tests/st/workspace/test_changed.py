"""Names that an edit of declarations changes."""

from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.st.syntax.units import Unit
from achse.st.workspace.changed import ChangedNames, changed_names, members_of, unchanged_parts

TEXT = """TYPE ST_Part : STRUCT nSize : INT; fWeight : LREAL; END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Press
VAR_INPUT bRun : BOOL; END_VAR
VAR stPart : ST_Part; aLimits : ARRAY [0..cMost] OF INT; eMode : (Slow, Fast); END_VAR
METHOD Push : BOOL
VAR_INPUT nForce : INT; END_VAR
VAR nLocal : INT; END_VAR
Push := TRUE;
END_METHOD
METHOD Release : BOOL
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Heavy EXTENDS FB_Press
END_FUNCTION_BLOCK
VAR_GLOBAL CONSTANT cMost : INT := 3; cOther : INT := 4; END_VAR
"""


def _units(text: str) -> dict[str, Unit]:
    return {unit.name.lower(): unit for unit in parse(Source(text)).units}


def _changed(old: str, new: str, text: str = TEXT) -> ChangedNames:
    assert old in text
    after = _units(text.replace(old, new))
    return changed_names(
        _units(text), after, (), {key: members_of(unit) for key, unit in after.items()}
    )


def _others(changed: ChangedNames) -> set[str]:
    """The names but for those of units by themselves, which are all touched here, and of what is
    declared by them."""
    return changed.names - _units(TEXT).keys() - {"stpart"}


def test_a_member_is_changed_and_what_has_its_type_by_itself() -> None:
    changed = _changed("nSize : INT", "nSize : DINT")
    assert not changed.wholes
    assert _others(changed) == {"nsize", "nsize."}
    assert "stpart" in changed.names
    assert "stpart." not in changed.names


def test_a_method_is_changed_by_its_parameters_but_not_by_its_locals_or_body() -> None:
    assert _others(_changed("nForce : INT", "nForce : DINT")) == {"push", "push."}
    assert not _others(_changed("Push := TRUE;", "Push := FALSE;"))


def test_a_constant_changes_what_it_is_the_bound_of() -> None:
    changed = _changed("cMost : INT := 3", "cMost : INT := 5")
    assert _others(changed) == {"cmost", "cmost.", "alimits", "alimits."}


def test_the_values_of_an_enumeration_change_with_its_variable() -> None:
    changed = _changed("(Slow, Fast)", "(Fast, Slow)")
    assert {"emode", "emode.", "slow", "fast"} <= changed.names


def test_a_head_changes_the_whole_unit_and_those_that_extend_it() -> None:
    changed = _changed("FUNCTION_BLOCK FB_Press", "FUNCTION_BLOCK ABSTRACT FB_Press")
    assert changed.wholes == {"fb_press", "fb_heavy"}
    assert {"fb_press.", "fb_heavy."} <= changed.names
    assert "st_part." not in changed.names


def test_two_members_of_one_name_change_the_whole_unit() -> None:
    assert "fb_press" in _changed("METHOD Release", "METHOD Push").wholes


def test_parts_are_the_same_with_their_bodies() -> None:
    before, after = _units(TEXT), _units(TEXT.replace("Push := TRUE;", "Push := FALSE;"))
    assert unchanged_parts(before["fb_press"], after["fb_press"]) == {"release", ""}
