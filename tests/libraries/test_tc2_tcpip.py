"""Tc2_TcpIp in a station, which has no TCP/IP server: what programs get then."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.conftest import Ran

MAIN = """
PROGRAM MAIN
VAR
    client : FB_ClientServerConnection; server : FB_ServerClientConnection;
    plain : FB_ConnectionlessSocket; handle : T_HSERVER; enable : BOOL := TRUE; n : INT;
    errors, tries : ARRAY [0..2] OF UDINT; before : ARRAY [0..2] OF BOOL;
END_VAR
n := n + 1;
enable := n < 250;
F_CreateServerHnd(sLocalHost := '127.0.0.1', nLocalPort := 200, hServer := handle);
client(sRemoteHost := '127.0.0.1', nRemotePort := 200, bEnable := enable, tReconnect := T#1s);
server(hServer := handle, bEnable := enable, tReconnect := T#1s);
plain(nLocalPort := 1000, bEnable := enable, tReconnect := T#1s);
errors[0] := MAX(errors[0], client.nErrId);
errors[1] := MAX(errors[1], server.nErrId);
errors[2] := MAX(errors[2], plain.nErrId);
IF client.bBusy AND NOT before[0] THEN tries[0] := tries[0] + 1; END_IF
IF server.bBusy AND NOT before[1] THEN tries[1] := tries[1] + 1; END_IF
before[0] := client.bBusy;
before[1] := server.bBusy;
END_PROGRAM
"""


def test_a_missing_peer_is_tried_again(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(MAIN, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=tmp_path)
    station.advance(2.45)
    plc = station.plcs[851]
    main: Any = plc.instance("MAIN")
    assert plc.failure == ""
    assert list(main["errors"]) == [6, 6, 6]
    assert list(main["tries"])[:2] == [3, 3]
    station.advance(0.2)
    assert (main["client"]["bError"], main["client"]["bBusy"], main["client"]["nErrId"]) == (
        False,
        False,
        0,
    )


def test_each_block_is_refused(steps: Callable[..., Any]) -> None:
    names = ["Connect", "Close", "CloseAll", "Listen", "Accept", "Send", "Receive"]
    names += ["UdpCreate", "UdpSendTo", "UdpReceiveFrom"]
    blocks = [f"FB_Socket{name}" for name in names]
    blocks += [f"FB_TlsSocket{name}" for name in ("Create", "Connect", "Listen", "AddCa", "SetPsk")]
    declared = " ".join(f"b{number} : {name};" for number, name in enumerate(blocks))
    calls = [
        (f"b{number}", "", f"errors[{number}] := b{number}.nErrId;")
        for number in range(len(blocks))
    ]
    ran = steps(f"{declared} errors : ARRAY [0..{len(blocks)}] OF UDINT;", *calls)
    assert list(ran["errors"])[: len(blocks)] == [6] * len(blocks)


def test_texts_of_sockets_and_bytes() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR h : T_HSOCKET := (handle := 7, localAddr := (nPort := 80, sAddr :="
        " '10.0.0.1')); s, x : T_MaxString; b : ARRAY [0..3] OF BYTE := [1, 171, 0, 255];"
        " c : ARRAY [0..3] OF BYTE; n, odd, full : UDINT; END_VAR s := HSOCKET_TO_STRING(h);"
        " x := DATA_TO_HEXSTR(ADR(b), 4, FALSE); n := HEXSTR_TO_DATA(x, ADR(c), 4);"
        " odd := HEXSTR_TO_DATA('123', ADR(c[3]), 1); full := HEXSTR_TO_DATA('0102', ADR(c[3]), 1);"
        " END_PROGRAM"
    ).cycle()
    assert ran["s"] == "Handle:7 Local:10.0.0.1:80 Remote::0"
    assert (ran["x"], ran["n"], ran["odd"], ran["full"]) == ("01 AB 00 FF", 4, 0, 0)
    assert list(ran["c"])[:3] == [1, 171, 0]
