"""Edits of bodies in trees that are kept."""

from hypothesis import given
from hypothesis import strategies as st

from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.st.workspace.edits import body_edit

TEXT = """FUNCTION_BLOCK FB_X
VAR n : INT; END_VAR
METHOD M : INT
VAR k : INT; END_VAR
k := 1;
END_METHOD
n := 2;
END_FUNCTION_BLOCK
FUNCTION F : INT
F := 3;
END_FUNCTION
"""


@given(
    old=st.sampled_from(("k := 1;", "n := 2;", "F := 3;")),
    new=st.sampled_from(("", "k := n;\n", "  (* a *)\n;", "IF TRUE THEN n := 1; END_IF", ":=")),
)
def test_kept_trees_become_those_of_the_new_text(old: str, new: str) -> None:
    tree, fresh = parse(Source(TEXT)), parse(Source(TEXT.replace(old, new)))
    edit = body_edit(tree, fresh)
    assert edit is not None
    changed = edit.make()
    assert [one.name for one in changed] == [{"k": "M", "n": "FB_X", "F": "F"}[old[0]]]
    again = parse(Source(TEXT.replace(old, new)))
    assert tree.units == again.units
    assert _places(tree.units) == _places(again.units)
    assert tree.source.text == again.source.text


def _places(tree: object) -> list[object]:
    if isinstance(tree, tuple):
        return [_places(item) for item in tree]
    if not hasattr(tree, "__match_args__"):
        return []
    return [_places(getattr(tree, n)) if n != "at" else tree.at for n in tree.__match_args__]  # type: ignore[attr-defined]


def test_other_declarations_are_no_edit_of_bodies() -> None:
    for old, new in [("n : INT", "n : DINT"), ("METHOD M", "METHOD N"), ("FUNCTION F", "PROGRAM")]:
        assert body_edit(parse(Source(TEXT)), parse(Source(TEXT.replace(old, new, 1)))) is None


def test_findings_follow_or_are_inside() -> None:
    tree = parse(Source(TEXT))
    finding = tree.source.fault(TEXT.index("F := 3"), "wrong", Code.BAD_LITERAL)
    inside = tree.source.fault(TEXT.index("n := 2"), "gone", Code.BAD_LITERAL)
    edit = body_edit(tree, parse(Source(TEXT.replace("n := 2;", "\nq;"))))
    assert edit is not None
    edit.make()
    moved = edit.follow(finding)
    assert moved is not None
    assert moved.location.line == finding.location.line + 1
    assert moved.text == "F := 3;"
    assert edit.follow(inside) is None
