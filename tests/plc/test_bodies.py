"""Bodies: life of instances, calls from outside, online change."""

from achse.iec import plain
from achse.plc.bodies import Bodies
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.parser import parse
from achse.st.source import Source

LIFE = """
FUNCTION_BLOCK FB_Inner
VAR nInit : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; nStart : INT; END_VAR
nInit := nStart;
GVL.sLog := CONCAT(GVL.sLog, 'i');
END_METHOD
METHOD FB_exit : BOOL
VAR_INPUT bInCopyCode : BOOL; END_VAR
GVL.sLog := CONCAT(GVL.sLog, 'e');
END_METHOD
METHOD FB_reinit : BOOL
GVL.sLog := CONCAT(GVL.sLog, 'r');
END_METHOD
END_FUNCTION_BLOCK
VAR_GLOBAL sLog : STRING; END_VAR
PROGRAM MAIN
VAR a : FB_Inner(nStart := 7); n : INT; {more} END_VAR
n := n + {step};
END_PROGRAM
"""


def _declared(text: str) -> Declarations:
    return declare([parse(Source(text, "life.st"), name="GVL")])


def _bodies(declared: Declarations) -> Bodies:
    typed = check(declared)
    assert not typed.faults, "\n".join(map(str, typed.faults))
    return Bodies(typed)


def _plc(text: str) -> PlcRuntime:
    declared = _declared(text)
    main = declared.programs["main"]
    task = Task("PlcTask", 10_000_000, [main])
    return PlcRuntime([task], declared.units, bodies=_bodies(declared))


def _text(step: int = 1, more: str = "") -> str:
    return LIFE.replace("{step}", str(step)).replace("{more}", more)


def test_instances_come_to_life_with_the_arguments_of_their_declaration() -> None:
    plc = _plc(_text())
    main = plc.instance("MAIN")
    assert plain(main["a"])["nInit"] == 7
    assert plc.instance("GVL")["sLog"] == "i"
    plc.reset()
    assert plc.instance("GVL")["sLog"] == "i"


def test_an_online_change_ends_lives_copies_values_and_goes_on() -> None:
    plc = _plc(_text())
    plc.run_due(30_000_000)
    assert plc.instance("MAIN")["n"] == 3
    changed = _declared(_text(10, "x : LREAL := 2.5;"))
    plc.online_change(
        [unit for unit in changed.units if unit is not changed.programs["main"]],
        {"PlcTask": [changed.programs["main"]]},
        bodies=_bodies(changed),
    )
    assert plc.state is PlcState.RUN, plc.failure
    plc.run_due(40_000_000)
    main = plc.instance("MAIN")
    assert (main["n"], main["x"], plain(main["a"])["nInit"]) == (13, 2.5, 7)
    # The values are copied after FB_init of the new instances, FB_reinit follows.
    assert plc.instance("GVL")["sLog"] == "ier"


def test_a_fault_in_fb_init_is_an_exception_not_a_crash() -> None:
    plc = _plc(_text().replace("nInit := nStart;", "nInit := nStart / nInit;"))
    assert plc.state is PlcState.EXCEPTION
    assert plc.fault is not None
    assert plc.fault.name == "DIVIDEBYZERO"
    assert plc.fault.routine == "FB_Inner.FB_init"


CALLED = """
FUNCTION_BLOCK FB_Tank
VAR nLevel : DINT; END_VAR
{attribute 'TcRpcEnable'}
METHOD Fill : BOOL
VAR_INPUT nLitres : INT; sWho : STRING(10); END_VAR
VAR_OUTPUT nNow : DINT; sSaid : STRING(10); END_VAR
nLevel := nLevel + nLitres;
nNow := nLevel;
sSaid := sWho;
Fill := nLevel > 5;
END_METHOD
{attribute 'monitoring' := 'call'}
PROPERTY Twice : DINT
GET
Twice := nLevel * 2;
END_GET
SET
nLevel := Twice / 2;
END_SET
END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR a : FB_Tank; END_VAR
END_PROGRAM
"""


def test_clients_call_methods_and_properties_by_their_bytes() -> None:
    plc = _plc(CALLED)
    assert plc.bodies is not None
    tank = plc.instance("MAIN")["a"]
    method = type(tank).__iec__.method("Fill")
    data = b"\x07\0" + b"me".ljust(11, b"\0")
    answer = plc.bodies.call_encoded(tank, method, data)
    assert answer == b"\1" + b"\x07\0\0\0" + b"me".ljust(11, b"\0")
    assert plc.bodies.get_encoded(tank, "Twice") == b"\x0e\0\0\0"
    assert plc.bodies.set_encoded(tank, "Twice", b"\x14\0\0\0")
    assert tank["nLevel"] == 10
    assert plc.bodies.get_encoded(tank, "Other") is None
