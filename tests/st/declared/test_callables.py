"""What of a block clients may call."""

from typing import Any

from achse.iec import BOOL, INT, LREAL, StructType
from achse.st.declare import declare
from achse.st.syntax.parser import parse

BLOCK = """
FUNCTION_BLOCK FB
{attribute 'TcRpcEnable' := '1'}
METHOD Move : BOOL // goes there
VAR_INPUT fTo : LREAL; END_VAR
VAR_OUTPUT nA, nB : INT; END_VAR
VAR_IN_OUT nC : INT; END_VAR
VAR nInside : INT; END_VAR
END_METHOD
METHOD Quiet END_METHOD
{attribute 'monitoring' := 'call'} PROPERTY Both : INT GET END_GET SET END_SET END_PROPERTY
PROPERTY ByGet : LREAL {attribute 'Monitoring' := 'CALL'} GET END_GET END_PROPERTY
{attribute 'monitoring' := 'variable'} PROPERTY Kept : INT GET END_GET END_PROPERTY
PROPERTY Quiet2 : INT GET END_GET END_PROPERTY
END_FUNCTION_BLOCK
"""


def block() -> StructType[Any]:
    type = declare([parse(BLOCK)]).types["fb"]
    assert isinstance(type, StructType)
    return type


def test_methods_for_clients_with_their_parameters() -> None:
    (move,) = block().methods
    assert (move.name, move.returns, dict(move.attributes)) == ("Move", BOOL, {"TcRpcEnable": "1"})
    assert [
        (item.name, item.type, item.is_output, item.by_reference) for item in move.parameters
    ] == [
        ("fTo", LREAL, False, False),
        ("nA", INT, True, False),
        ("nB", INT, True, False),
        ("nC", INT, False, True),
    ]


def test_properties_for_clients() -> None:
    properties = [(one.name, one.type, one.readable, one.writable) for one in block().properties]
    assert properties == [("Both", INT, True, True), ("ByGet", LREAL, True, False)]
