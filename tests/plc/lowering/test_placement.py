"""Where storages of a typed project are."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.iec.elementary import DINT
from achse.iec.variables import Variable
from achse.plc.lowering.placement import MissingPlaceError, Placement, Spot
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.st.typed.places import ImageBase, StaticBase, UnitBase
from tests.plc.code.conftest import Ran


def test_units_statics_and_images_have_their_place() -> None:
    variable: Variable[Any, Any] = Variable(DINT, 7, name="n")
    memory = Memory()
    placement = Placement(memory, [PlacedVariable("MAIN.n", variable, Area.FLAG, 12, 3)])
    assert placement.spot(UnitBase("Main", variable)) == Spot(Area.FLAG, 12, 3)
    assert placement.spot(ImageBase("Q")) == Spot(Area.OUTPUT, 0)
    static = StaticBase("F_Count", variable)
    with pytest.raises(MissingPlaceError, match=r"F_Count\.n"):
        placement.spot(static)
    placement.add_static(static)
    spot = placement.spot(static)
    placement.add_static(static)
    assert placement.spot(static) == spot
    assert memory[Area.DATA].read(spot.offset, 4) == b"\x07\0\0\0"


BLOCKS = """
FUNCTION_BLOCK FB_Base
VAR_STAT nCalls : INT := 2; END_VAR
nCalls := nCalls + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Derived EXTENDS FB_Base
SUPER^(); nCalls := nCalls + 10;
END_FUNCTION_BLOCK
FUNCTION F_Local : INT
VAR fb : FB_Derived; END_VAR
fb(); F_Local := fb.nCalls;
END_FUNCTION
"""


@pytest.mark.parametrize(
    ("declared", "body"),
    [
        ("VAR fb : FB_Derived; END_VAR", "fb(); n := fb.nCalls;"),
        ("VAR z : FB_Derived; a : FB_Base; END_VAR", "z(); n := a.nCalls;"),
        ("VAR a : FB_Derived; z : FB_Base; END_VAR", "a(); n := z.nCalls;"),
        ("VAR_TEMP fb : FB_Derived; END_VAR", "fb(); n := fb.nCalls;"),
        ("", "n := F_Local();"),
        ("VAR p : POINTER TO FB_Derived; END_VAR",
         "p := __NEW(FB_Derived); p^(); n := p^.nCalls; __DELETE(p);"),
    ],
)  # fmt: skip
def test_a_block_and_those_that_extend_it_share_its_statics_wherever_instances_are(
    run: Callable[..., Ran], declared: str, body: str
) -> None:
    ran = run(f"{BLOCKS} PROGRAM MAIN VAR n : INT; END_VAR {declared} {body} END_PROGRAM", 3)
    assert (ran.plc.failure, ran["n"]) == ("", 2 + 3 * 11)
