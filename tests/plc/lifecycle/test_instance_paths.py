"""Variables with attribute instance-path hold the name of their instance, as far as it fits."""

from achse.plc.runtime import PlcRuntime
from tests.plc.code.conftest import Ran

TEXT = """
{{attribute '{reflection}'}}
FUNCTION_BLOCK FB_Named
VAR
    {{attribute 'instance-path'}}
    {{attribute 'noinit'}}
    sPath : STRING({length});
END_VAR
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Early EXTENDS FB_Named
VAR sEarly : STRING; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR
sEarly := sPath;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR f : FB_Named; e : FB_Early; a : ARRAY [-1..0, 3..4] OF FB_Named; END_VAR
END_PROGRAM
"""


def _ran(reflection: str = "reflection", length: int = 80) -> Ran:
    return Ran(TEXT.format(reflection=reflection, length=length))


def test_each_instance_has_its_own_name_before_fb_init() -> None:
    ran = _ran()
    assert ran["f.sPath"] == "MAIN.f"
    assert ran["e.sEarly"] == "MAIN.e"
    array = ran.plc.instance("MAIN")["a"]
    assert array[0, 3]["sPath"] == "MAIN.a[0,3]"


def test_only_blocks_with_reflection_are_looked_at() -> None:
    assert _ran("other")["f.sPath"] == ""


def test_a_long_name_is_cut_at_the_end() -> None:
    assert _ran(length=4)["f.sPath"] == "MAIN"


def test_a_reset_keeps_the_names() -> None:
    ran = _ran()
    plc: PlcRuntime = ran.plc
    plc.instance("MAIN")["f"]["sPath"] = "x"
    plc.reset(origin=True)
    assert ran["f.sPath"] == "MAIN.f"
