"""ADS blocks of PLC programs: edges, BUSY, errors, silence; each through a router."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import DataResponse, ReadRequest, WriteRequest
from achse.devices.logger import LogMessage
from achse.devices.plc import PlcDevice, PlcRequests
from achse.router import Router
from tests.plc.code.conftest import Ran

HERE = NetId("5.1.2.3.1.1")
LATER = 1000


class Peer:
    """A port that keeps requests; `answer` sends what comes back."""

    def __init__(self, router: Router, port: int) -> None:
        self.frames: list[Frame] = []
        self.router = router
        self.reply: Callable[[Frame], bytes] | None = None
        router.register(port, self)

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        if self.reply is not None:
            self.router.deliver(frame.reply(self.reply(frame)))
        return True


class Asking(Ran):
    """A PLC at port 851 of a router, with a silent peer at port 1000."""

    def __init__(self, text: str) -> None:
        requests = PlcRequests(lambda: 0)
        super().__init__(text, services=requests)
        self.router = Router(HERE)
        self.peer = Peer(self.router, LATER)
        PlcDevice(self.plc, clock=lambda: 0, requests=requests).attach(self.router, 851)

    @property
    def outputs(self) -> tuple[bool, bool, int]:
        assert self.plc.failure == ""
        return self["fb.BUSY"], self["fb.ERR"], self["fb.ERRID"]

    def set(self, **values: Any) -> None:
        main: Any = self.plc.instance("MAIN")
        for name, value in values.items():
            main[name] = value


READER = (
    "PROGRAM MAIN VAR fb : {block}; d : ARRAY[0..3] OF BYTE := [9, 9, 9, 9]; go : BOOL;"
    " port : UINT := 1000; net : STRING; len : UDINT := 4; END_VAR"
    " fb(NETID := net, PORT := port, IDXGRP := 16#4020, IDXOFFS := 8, LEN := len,"
    " DESTADDR := ADR(d), READ := go, TMOUT := T#50MS); END_PROGRAM"
)


def test_a_read_is_busy_until_its_answer_which_comes_between_two_cycles() -> None:
    asking = Asking(READER.format(block="ADSREADEX"))
    asking.cycle()
    assert asking.outputs == (False, False, 0)
    asking.set(go=True)
    asking.cycle()
    assert asking.outputs == (True, False, 0)
    (frame,) = asking.peer.frames
    assert frame.command == Command.READ
    assert frame.source == AmsAddress.of(HERE, 851)
    assert ReadRequest.decode(frame.data) == ReadRequest(0x4020, 8, 4)
    asking.cycle()
    assert asking.outputs == (True, False, 0)
    asking.router.deliver(frame.reply(DataResponse(0, b"\1\2\3").encode()))
    assert (asking.outputs, asking["d"]) == ((True, False, 0), [9, 9, 9, 9])
    asking.cycle()
    assert (asking.outputs, asking["d"]) == ((False, False, 0), [1, 2, 3, 9])
    assert asking["fb.COUNT_R"] == 3
    asking.cycle(3)
    assert len(asking.peer.frames) == 1  # go is still TRUE: not an edge
    asking.set(go=False)
    asking.cycle()
    asking.set(go=True)
    asking.cycle()
    assert len(asking.peer.frames) == 2


def test_edges_while_busy_are_lost() -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    for go in (True, False, True, True):
        asking.set(go=go)
        asking.cycle()
    assert (asking.outputs, len(asking.peer.frames)) == ((True, False, 0), 1)


def test_silence_is_a_timeout_and_a_late_answer_is_dropped() -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.set(go=True)
    asking.cycle()
    asking.cycle(4)
    assert asking.outputs == (True, False, 0)
    asking.cycle()
    assert asking.outputs == (False, True, 0x745)
    asking.router.deliver(asking.peer.frames[0].reply(DataResponse(0, b"late").encode()))
    asking.set(go=False)
    asking.cycle(2)
    assert (asking.outputs, asking["d"]) == ((False, True, 0x745), [9, 9, 9, 9])
    asking.set(go=True)
    asking.cycle()
    assert asking.outputs == (True, False, 0)


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ({"port": 999}, 0x6),
        ({"net": "1.2.3.4.5.6"}, 0x7),
        ({"net": "nowhere"}, 0x749),
    ],
)
def test_where_nobody_is_the_error_of_the_router_is_shown(
    values: dict[str, Any], error: int
) -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.set(go=True, **values)
    asking.cycle(2)
    assert asking.outputs == (False, True, error)


def test_the_result_of_the_device_is_the_error() -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.peer.reply = lambda frame: DataResponse(0x703).encode()
    asking.set(go=True)
    asking.cycle(2)
    assert (asking.outputs, asking["d"]) == ((False, True, 0x703), [9, 9, 9, 9])


@pytest.mark.parametrize("answer", [b"", b"\0\0\0\0\5\0\0\0ab"])
def test_an_answer_that_is_not_one_is_told(answer: bytes) -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.peer.reply = lambda frame: answer
    asking.set(go=True)
    asking.cycle(2)
    assert asking.outputs == (False, True, 0x754)


def test_more_than_the_memory_has_is_an_access_violation_and_asks_nobody() -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.set(go=True, len=0x7FFF_FFFF)
    asking.cycle()
    assert asking.stopped.name == "ACCESS_VIOLATION"
    assert asking.peer.frames == []


def test_a_reset_forgets_what_is_under_way() -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.set(go=True)
    asking.cycle()
    asking.plc.reset()
    asking.plc.run()
    asking.router.deliver(asking.peer.frames[0].reply(DataResponse(0, b"late").encode()))
    asking.cycle(2)
    assert (asking.outputs, asking["d"]) == ((False, False, 0), [9, 9, 9, 9])


def test_an_online_change_ends_what_is_under_way() -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.set(go=True)
    asking.cycle()
    asking.plc.online_change(programs={}, globals=[])
    asking.cycle()
    assert asking.outputs == (False, True, 0x756)


def test_write_read_write_control_state_and_device_info() -> None:
    asking = Asking(
        "PROGRAM MAIN VAR w : ADSWRITE; x : ADSRDWRTEX; s : ADSRDSTATE; c : ADSWRTCTL;"
        " i : ADSRDDEVINFO; z : ADSWRITE; n : DINT := -2; r : DINT; END_VAR"
        " w(PORT := 1000, IDXGRP := 1, IDXOFFS := 2, LEN := 4, SRCADDR := ADR(n), WRITE := TRUE);"
        " x(PORT := 851, IDXGRP := 16#F003, WRITELEN := 7, READLEN := 4, SRCADDR := ADR('MAIN.n'),"
        " DESTADDR := ADR(r), WRTRD := TRUE);"
        " s(PORT := 851, RDSTATE := TRUE); i(PORT := 851, RDINFO := TRUE);"
        " z(PORT := 1000, LEN := 4, WRITE := TRUE);"
        " c(PORT := 851, ADSSTATE := ADSSTATE_STOP, WRITE := s.ADSSTATE = 5); END_PROGRAM"
    )
    asking.cycle()
    assert asking.plc.failure == ""
    (frame,) = asking.peer.frames
    assert WriteRequest.decode(frame.data) == WriteRequest(1, 2, b"\xfe\xff\xff\xff")
    assert (asking["z.BUSY"], asking["z.ERR"], asking["z.ERRID"]) == (False, True, 0x741)
    asking.cycle()
    assert (asking["x.BUSY"], asking["x.ERR"], asking["x.COUNT_R"]) == (False, False, 4)
    assert asking["r"] != 0
    assert (asking["s.ADSSTATE"], asking["i.DEVNAME"]) == (5, "Plc30 App")
    assert asking.plc.state.value == "stop"


def test_log_functions_write_to_the_logger_when_the_cycle_has_ended() -> None:
    asking = Asking(
        "PROGRAM MAIN VAR done : BOOL; r : DINT := 7; END_VAR IF NOT done THEN done := TRUE;"
        " r := ADSLOGSTR(ADSLOG_MSGTYPE_ERROR OR ADSLOG_MSGTYPE_LOG, 'part %s of %s', 'A');"
        " ADSLOGDINT(ADSLOG_MSGTYPE_HINT, 'n %d', -5); ADSLOGLREAL(1, 'x %f', 1.5);"
        " END_IF END_PROGRAM"
    )
    logger = Peer(asking.router, 100)
    asking.cycle(2)
    assert (asking["r"], asking.plc.failure) == (0, "")
    messages = [LogMessage.decode(WriteRequest.decode(one.data).data) for one in logger.frames]
    found = [(one.kind, one.port, one.text) for one in messages if one is not None]
    assert found == [(0x14, 851, "part A of %s"), (1, 851, "n -5"), (1, 851, "x 1.500000")]
