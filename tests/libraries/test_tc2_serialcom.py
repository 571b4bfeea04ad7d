"""Tc2_SerialCom: texts and data through the process data of a terminal that echoes."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plc.code.conftest import Ran

ECHO = """
FUNCTION_BLOCK FB_Echo // what is sent comes back in the next cycle
VAR_INPUT pIn, pOut : POINTER TO BYTE; head, most : INT; END_VAR
VAR waits : ARRAY [0..63] OF BYTE; count, i : INT; END_VAR
IF count = 0 AND (pOut^ AND 1) <> (pIn^ AND 1) THEN
    IF head = 2 THEN count := pOut[1]; ELSE count := SHR(pOut^, 4) AND 7; END_IF
    FOR i := 0 TO count - 1 DO waits[i] := pOut[head + i]; END_FOR
    pIn^ := pIn^ XOR 1;
END_IF
IF count > 0 AND (pIn^ AND 2) = (pOut^ AND 2) THEN
    FOR i := 0 TO count - 1 DO pIn[head + i] := waits[i]; END_FOR
    IF head = 2 THEN pIn[1] := INT_TO_BYTE(count);
    ELSE pIn^ := pIn^ AND 16#0F OR SHL(INT_TO_BYTE(count), 4); END_IF
    pIn^ := pIn^ XOR 2;
    count := 0;
END_IF
IF (pOut^ AND 4) <> 0 THEN pIn^ := pIn^ OR 4; count := 0; ELSE pIn^ := pIn^ AND 16#FB; END_IF
END_FUNCTION_BLOCK
"""

MODES = [
    ("EL6", "22B", "SERIALLINEMODE_EL6_22B", 2, 22),
    ("KL6", "22B", "SERIALLINEMODE_KL6_22B_STANDARD", 2, 22),
    ("KL6", "5B", "SERIALLINEMODE_KL6_5B_STANDARD", 1, 5),
    ("KL6", "", "SERIALLINEMODE_KL6_3B_ALTERNATIVE", 1, 3),
    ("PcCom", "", "SERIALLINEMODE_PC_COM_PORT", 2, 64),
]


def _line(mode: int, body: str, variables: str = "") -> Ran:
    family, kind, name, head, most = MODES[mode]
    data = (
        "inData" if family != "PcCom" else "InData",
        "outData" if family != "PcCom" else "OutData",
    )
    return Ran(
        f"{ECHO}PROGRAM MAIN VAR i : {family}{data[0]}{kind}; o : {family}{data[1]}{kind};"
        " line : SerialLineControl; tx, rx : ComBuffer; echo : FB_Echo;"
        f" {variables} END_VAR\n{body}\n"
        f"line(Mode := ComSerialLineMode_t.{name}, pComIn := ADR(i), pComOut := ADR(o),"
        " SizeComIn := SIZEOF(i), TxBuffer := tx, RxBuffer := rx);\n"
        f"echo(pIn := ADR(i), pOut := ADR(o), head := {head}, most := {most}); END_PROGRAM"
    )


TEXTS = st.text(
    st.characters(min_codepoint=33, max_codepoint=126, exclude_characters="<>"), max_size=70
)


@pytest.fixture(scope="module", params=range(len(MODES)), ids=lambda mode: MODES[mode][2])
def strings(request: pytest.FixtureRequest) -> Ran:
    return _line(
        request.param,
        "IF step = 1 THEN send(SendString := text, TxBuffer := tx);"
        " IF NOT send.Busy THEN step := 2; END_IF END_IF"
        " receive(Prefix := '<', Suffix := '>$R', ReceivedString := now, RxBuffer := rx);"
        " IF receive.StringReceived THEN got := now; count := count + 1; END_IF",
        "step : INT; text, now, got : STRING; count : INT; send : SendString;"
        " receive : ReceiveString;",
    )


@given(noise=TEXTS.map(lambda text: text[:8]), text=TEXTS)
@settings(max_examples=4, deadline=None)
def test_a_text_between_its_marks(strings: Ran, noise: str, text: str) -> None:
    main: Any = strings.plc.instance("MAIN")
    main["count"] = 0
    main["text"] = f"{noise}<{text[: 68 - len(noise)]}>\r"
    main["step"] = 1
    strings.cycle(90)
    assert strings.plc.failure == ""
    assert (strings["count"], strings["got"]) == (1, f"<{text[: 68 - len(noise)]}>\r")
    assert (strings["tx.Count"], strings["rx.Count"], strings["rx.FreeByte"]) == (0, 0, 300)


def test_data_end_with_a_pause() -> None:
    ran = _line(
        0,
        "IF n < 2 THEN send(pSendData := ADR(data), Length := 30, TxBuffer := tx); END_IF"
        " n := n + 1;"
        " receive(pReceiveData := ADR(back), SizeReceiveData := 100, Timeout := T#50MS,"
        " RxBuffer := rx);"
        " IF receive.DataReceived THEN length := receive.LenReceiveData; END_IF",
        "n : INT; data : ARRAY [0..29] OF BYTE := [10(1), 10(0), 10(255)]; send : SendData;"
        " back : ARRAY [0..99] OF BYTE; receive : ReceiveData; length : UDINT;",
    )
    ran.cycle(8)
    assert (ran["length"], ran["receive.busy"]) == (0, True)
    ran.cycle(12)
    assert (ran["length"], ran["receive.busy"]) == (60, False)
    assert ran["back"][:60] == ([1] * 10 + [0] * 10 + [255] * 10) * 2


@pytest.mark.parametrize(
    ("sent", "inputs", "error", "timeout"),
    [
        ("'$00'", "Suffix := 'z'", "COMERROR_ZEROCHARINVALID", False),
        ("'abc'", "Suffix := 'z', Timeout := T#30MS", "COMERROR_NOERROR", True),
        ("'abc'", "Suffix := 'c'", "COMERROR_NOERROR", False),
    ],
)
def test_what_goes_wrong_with_texts(sent: str, inputs: str, error: str, timeout: bool) -> None:
    ran = Ran(
        f"PROGRAM MAIN VAR rx : ComBuffer; text : STRING := {sent}; now : STRING; n : INT;"
        " send : SendData; receive : ReceiveString; error : ComError_t; late, done : BOOL; END_VAR"
        " IF n = 0 THEN send(pSendData := ADR(text), Length := MAX(LEN(text), 1), TxBuffer := rx);"
        " n := 1; END_IF"
        f" receive({inputs}, ReceivedString := now, RxBuffer := rx);"
        " IF receive.Error <> 0 THEN error := receive.Error; END_IF"
        " IF receive.RxTimeout THEN late := TRUE; END_IF"
        " IF receive.StringReceived THEN done := TRUE; END_IF END_PROGRAM"
    ).cycle(10)
    assert (ran["error"].name, ran["late"]) == (error, timeout)
    assert ran["done"] is (not timeout and error == "COMERROR_NOERROR")


def test_a_text_that_never_ends_overruns() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR rx : ComBuffer; one : SendByte; receive : ReceiveString; now : STRING;"
        " i : INT; END_VAR"
        " FOR i := 0 TO 80 DO one(SendByte := 65, TxBuffer := rx); END_FOR"
        " receive(Suffix := 'z', ReceivedString := now, RxBuffer := rx); END_PROGRAM"
    ).cycle()
    assert ran["receive.Error"].name == "COMERROR_STRINGOVERRUN"
    assert ran["receive.busy"] is False


def test_a_full_buffer_makes_busy_and_loses_nothing() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR rx : ComBuffer; send : SendData; data : ARRAY [0..399] OF BYTE; i : INT;"
        " get : ReceiveByte; sum, n : DINT; busy : BOOL; empty : ClearComBuffer; END_VAR"
        " IF n = 0 THEN FOR i := 0 TO 399 DO data[i] := INT_TO_BYTE(i); END_FOR END_IF"
        " IF n = 0 OR send.Busy THEN"
        " send(pSendData := ADR(data), Length := 400, TxBuffer := rx); END_IF"
        " IF n = 0 THEN busy := send.Busy; END_IF"
        " FOR i := 0 TO 249 DO get(RxBuffer := rx);"
        " IF get.ByteReceived THEN sum := sum * 31 + get.ReceivedByte; n := n + 1; END_IF END_FOR"
        " END_PROGRAM"
    ).cycle(3)
    wanted = 0
    for number in range(400):
        wanted = (wanted * 31 + number % 256) % (1 << 32)
    assert (ran["busy"], ran["n"], ran["sum"] % (1 << 32)) == (True, 400, wanted)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ("pComIn := 0, pComOut := ADR(o), SizeComIn := 24", "COMERROR_INVALIDPOINTER"),
        ("pComIn := ADR(i), pComOut := ADR(o), SizeComIn := 23", "COMERROR_INVALIDPROCESSDATASIZE"),
        (
            "pComIn := ADR(i), pComOut := ADR(o), SizeComIn := 24,"
            " Mode := ComSerialLineMode_t.SERIALLINEMODE_IE6_11B",
            "COMERROR_MODENOTSUPPORTED",
        ),
    ],
)
def test_process_data_that_do_not_fit(arguments: str, error: str) -> None:
    ran = Ran(
        "PROGRAM MAIN VAR i : EL6inData22B; o : EL6outData22B; tx, rx : ComBuffer;"
        f" line : SerialLineControl; END_VAR line({arguments}, TxBuffer := tx, RxBuffer := rx);"
        " END_PROGRAM"
    ).cycle()
    assert (ran["line.Error"], ran["line.ErrorID"].name) == (True, error)


def test_reset_of_a_terminal() -> None:
    ran = _line(
        0,
        "reset(Execute := TRUE, pComIn := ADR(i), pComOut := ADR(o), SizeComIn := SIZEOF(i));",
        "reset : ComReset;",
    ).cycle(4)
    assert (ran["reset.Done"], ran["reset.Busy"], ran["reset.Error"]) == (True, False, False)


def test_a_terminal_that_never_answers_and_ports_of_the_computer() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR i : EL6inData22B; o : EL6outData22B; tx, rx : ComBuffer;"
        " reset : ComReset; ads : SerialLineControlADS; END_VAR"
        " reset(Execute := TRUE, pComIn := ADR(i), pComOut := ADR(o), SizeComIn := 24);"
        " ads(Connect := TRUE, TxBuffer := tx, RxBuffer := rx); END_PROGRAM"
    ).cycle(510)
    assert (ran["reset.Busy"], ran["reset.ErrorID"].name) == (False, "COMERROR_TIMEOUT")
    assert (ran["ads.PortOpened"], ran["ads.Error"], ran["ads.ErrorID"]) == (False, True, 6)


@pytest.mark.parametrize(
    ("changed", "error"),
    [
        ("", "COMERROR_TIMEOUT"),
        ("Baudrate := 9601", "COMERROR_INVALIDBAUDRATE"),
        ("NoDatabits := 9", "COMERROR_INVALIDNUMDATABITS"),
        ("Stopbits := 0", "COMERROR_INVALIDNUMSTOPBITS"),
        ("Parity := ComParity_t.PARITY_MARK", "COMERROR_INVALIDPARITY"),
        ("Mode := ComSerialLineMode_t.SERIALLINEMODE_EL6_22B", "COMERROR_MODENOTSUPPORTED"),
        ("SizeComIn := 7", "COMERROR_INVALIDPROCESSDATASIZE"),
        ("pComOut := 0", "COMERROR_INVALIDPOINTER"),
    ],
)
def test_parameters_of_a_terminal_without_registers(changed: str, error: str) -> None:
    inputs = {
        "Mode": "ComSerialLineMode_t.SERIALLINEMODE_KL6_22B_STANDARD",
        "Baudrate": "19200",
        "NoDatabits": "8",
        "Parity": "ComParity_t.PARITY_EVEN",
        "Stopbits": "1",
        "Handshake": "ComHandshake_t.RS485_HALFDUPLEX",
        "pComIn": "ADR(i)",
        "pComOut": "ADR(o)",
        "SizeComIn": "SIZEOF(i)",
    }
    name, _, value = changed.partition(" := ")
    if name:
        inputs[name] = value
    arguments = ", ".join(f"{name} := {value}" for name, value in inputs.items())
    ran = Ran(
        "PROGRAM MAIN VAR i : KL6inData22B; o : KL6outData22B; config : KL6Configuration; END_VAR"
        f" config(Execute := TRUE, {arguments}); END_PROGRAM"
    ).cycle(1 if name else 510)
    assert (ran["config.Error"], ran["config.Busy"], ran["config.Done"]) == (True, False, False)
    assert ran["config.ErrorId"].name == error
