"""Types that nothing declares, and the bases and interfaces among them."""

import pytest

from achse.st.declare import examine
from achse.st.missing.types import MissingTypes
from achse.st.syntax.parser import parse
from achse.st.syntax.tree import NamedType

SOURCE = """
INTERFACE I_Near EXTENDS I_Far END_INTERFACE
FUNCTION_BLOCK FB_Top EXTENDS FB_Middle IMPLEMENTS I_Near, I_Other END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Middle EXTENDS Lib.FB_Base END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Begun EXTENDS FB_Middle
METHOD FB_init : BOOL END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Ring EXTENDS FB_Ring END_FUNCTION_BLOCK
"""


@pytest.fixture
def types() -> MissingTypes:
    return MissingTypes(examine([parse(SOURCE)])[0].names)


@pytest.mark.parametrize(
    ("block", "base", "with_init"),
    [
        ("fb_top", "FB_Base", "FB_Base"),
        ("fb_begun", "FB_Base", None),
        ("fb_ring", None, None),
        ("i_near", "I_Far", None),
    ],
)
def test_missing_base(
    types: MissingTypes, block: str, base: str | None, with_init: str | None
) -> None:
    entry = types.scopes.entries[block]
    uses = types.base_of(entry), types.base_with_init(entry)
    assert [use and use.name for use in uses] == [base, with_init]
    assert types.base_of(None) is types.base_with_init(None) is None


def test_missing_interfaces_of_a_block(types: MissingTypes) -> None:
    interfaces = types.interfaces_of(types.scopes.entries["fb_top"])
    assert sorted(one.name for one in interfaces) == ["I_Far", "I_Other"]


def test_missing_type_is_one_use_with_its_library(types: MissingTypes) -> None:
    scope = types.scopes.scope(types.scopes.entries["fb_middle"])
    assert types.is_missing(NamedType("Lib.FB_Base"), scope)
    assert not types.is_missing(NamedType("FB_Top"), scope)
    use = types.use(NamedType("FB_Base"))
    assert types.use(NamedType("Lib.fb_base")) is use is types.uses["fb_base"]
    assert (use.name, use.library) == ("FB_Base", "Lib")
    assert types.use_at((NamedType("FB_Base"), scope)) is use
    assert types.member(NamedType("FB_Base"), "bDone") is use.members["bdone"]
