"""Tc3_PLCopen_OpcUa: a station has no client module."""

import pytest

from tests.plc.code.conftest import Ran

BLOCKS = {
    "UA_Connect": "ServerUrl := 'opc.tcp://x:4840', SessionConnectInfo := info",
    "UA_Disconnect": "ConnectionHdl := 0",
    "UA_ConnectGetStatus": "ConnectionHdl := 1",
    "UA_GetNamespaceIndex": "ConnectionHdl := 1, NamespaceUri := 'urn:x'",
    "UA_NodeGetHandle": "ConnectionHdl := 1, NodeID := node",
    "UA_NodeReleaseHandle": "ConnectionHdl := 1, NodeHdl := 2",
    "UA_Read": "ConnectionHdl := 1, NodeHdl := 2, stNodeAddInfo := more, pVariable := ADR(data)",
    "UA_Write": "ConnectionHdl := 1, NodeHdl := 2, pVariable := ADR(data), cbData := 2",
    "UA_MethodGetHandle": "ConnectionHdl := 1, ObjectNodeID := node, MethodNodeID := node",
    "UA_MethodReleaseHandle": "ConnectionHdl := 1, MethodHdl := 2",
    "UA_MethodCall": "ConnectionHdl := 1, MethodHdl := 2, nNumberOfInputArguments := 0",
}


@pytest.mark.parametrize("block", BLOCKS)
def test_each_request_ends_without_its_port(block: str) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR request : {block}; info : ST_UASessionConnectInfo; node : ST_UANodeID;"
        " more : ST_UANodeAdditionalInfo; data : INT;"
        " ends : INT; END_VAR"
        f" request(Execute := TRUE, {BLOCKS[block]});"
        " IF NOT request.Busy THEN request(Execute := FALSE); ends := ends + 1; END_IF END_PROGRAM"
    ).cycle()
    assert (ran["request.Busy"], ran["request.Error"]) == (True, False)
    ran.cycle()
    assert (ran["request.Busy"], ran["request.Done"]) == (False, False)
    assert (ran["request.Error"], ran["request.ErrorID"], ran["ends"]) == (True, 6, 1)
    ran.cycle()
    assert (ran["request.Busy"], ran["request.Error"], ran["ends"]) == (True, False, 1)
