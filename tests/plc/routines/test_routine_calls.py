"""Calls of methods and properties from outside of a cycle."""

from tests.plc.one_text import plc_of

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
    plc = plc_of(CALLED)
    assert plc.bodies is not None
    tank = plc.instance("MAIN")["a"]
    method = type(tank).__iec__.method("Fill")
    data = b"\x07\0" + b"me".ljust(11, b"\0")
    answer = plc.bodies.calls.call_encoded(tank, method, data)
    assert answer == b"\1" + b"\x07\0\0\0" + b"me".ljust(11, b"\0")
    assert plc.bodies.calls.get_encoded(tank, "Twice") == b"\x0e\0\0\0"
    assert plc.bodies.calls.set_encoded(tank, "Twice", b"\x14\0\0\0")
    assert tank["nLevel"] == 10
    assert plc.bodies.calls.get_encoded(tank, "Other") is None
