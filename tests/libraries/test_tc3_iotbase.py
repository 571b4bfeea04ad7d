"""Tc3_IotBase: clients that a station leaves unconnected, and say so."""

import pytest

from tests.plc.code.conftest import Ran

NO_SERVICE = 0x98110006 - (1 << 32)


@pytest.mark.parametrize("version", ["", "5"])
def test_a_client_of_a_broker_stays_unconnected(version: str) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR c : FB_IotMqtt{version}Client; connect : BOOL := TRUE; n : INT;"
        " quiet, told, again : HRESULT; sent, subscribed : BOOL; payload : STRING := 'a'; END_VAR"
        " IF n = 0 THEN c.Execute(FALSE); quiet := c.hrErrorCode; END_IF"
        " c.Execute(connect); told := c.hrErrorCode; n := n + 1;"
        " sent := c.Publish(sTopic := 'a/b', pPayload := ADR(payload), nPayloadSize := 2,"
        " eQoS := TcIotMqttQos.AtMostOnceDelivery, bRetain := FALSE, bQueue := FALSE);"
        " subscribed := c.Subscribe(sTopic := 'a/#', eQoS := TcIotMqttQos.ExactlyOnceDelivery);"
        " again := c.hrErrorCode; END_PROGRAM"
    ).cycle(3)
    assert ran.plc.failure == ""
    assert (ran["quiet"], ran["told"], ran["again"]) == (0, NO_SERVICE, NO_SERVICE)
    assert (ran["sent"], ran["subscribed"], ran["c.bConnected"]) == (False, False, False)
    assert (ran["c.bError"], ran["c.eConnectionState"].name) == (True, "MQTT_ERR_NO_CONN")


def test_a_callback_of_the_program_overrides_that_of_the_client() -> None:
    ran = Ran(
        "FUNCTION_BLOCK FB_Mine EXTENDS FB_IotMqttClient METHOD OnMqttMessage : HRESULT"
        " VAR_IN_OUT CONSTANT topic : STRING; END_VAR"
        " VAR_INPUT payload : PVOID; length : UDINT; qos : TcIotMqttQos; repeated : BOOL; END_VAR"
        " SUPER^.nMessagesRcv := SUPER^.nMessagesRcv + length; END_METHOD END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR c : FB_Mine; q : FB_IotMqttMessageQueue; m : FB_IotMqttMessage;"
        " got : BOOL; END_VAR c.ipMessageQueue := q; c.Execute(TRUE);"
        " c.OnMqttMessage(topic := 'a', payload := NULL, length := 3, qos := 0, repeated := FALSE);"
        " IF q.nQueuedMessages > 0 OR q.Dequeue(fbMessage := m) THEN got := TRUE; END_IF"
        " END_PROGRAM"
    ).cycle(2)
    assert (ran["c.nMessagesRcv"], ran["got"]) == (6, False)


def test_a_client_of_a_web_server_gets_no_answer() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR c : FB_IotHttpClient := (sHostName := 'a.b', nHostPort := 443);"
        " r : FB_IotHttpRequest; h : FB_IotHttpHeaderFieldMap; sent, content : BOOL;"
        " text : STRING; END_VAR c.Execute(); h.AddField('Accept', '*/*', TRUE);"
        " sent := r.SendRequest(sUri := '/x', fbClient := c,"
        " eRequestType := ETcIotHttpRequestType.HTTP_GET, 0, 0, h);"
        " content := r.GetContent(ADR(text), SIZEOF(text), TRUE); END_PROGRAM"
    ).cycle()
    assert (ran["c.bConfigured"], ran["sent"], ran["content"]) == (True, False, False)
    assert (ran["r.bBusy"], ran["r.bError"], ran["r.hrErrorCode"]) == (False, True, NO_SERVICE)
