"""ADS blocks of PLC programs: edges, BUSY, errors, silence; each through a router."""

from collections.abc import Callable
from datetime import timedelta
from types import SimpleNamespace
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import (
    DataResponse,
    ReadDeviceInfoResponse,
    ReadRequest,
    ReadStateResponse,
    ResultResponse,
    WriteRequest,
)
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
def test_without_a_device_the_error_of_the_router_is_shown(
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
def test_an_answer_that_is_not_one_is_reported(answer: bytes) -> None:
    asking = Asking(READER.format(block="ADSREAD"))
    asking.peer.reply = lambda frame: answer
    asking.set(go=True)
    asking.cycle(2)
    assert asking.outputs == (False, True, 0x754)


def test_more_than_the_memory_has_is_an_access_violation_without_a_request() -> None:
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
    results = [(one.kind, one.port, one.text) for one in messages if one is not None]
    assert results == [(0x14, 851, "part A of %s"), (1, 851, "n -5"), (1, 851, "x 1.500000")]


class FakePlc:
    """What blocks see of a PLC: its time, and one memory that begins at address 100."""

    def __init__(self) -> None:
        self.time_ns = 0
        self.memory = bytearray(100 * b".")

    def load_bytes(self, address: int, size: int) -> bytes:
        assert address >= 100
        return bytes(self.memory[address - 100 :][:size])

    def store_bytes(self, address: int, data: bytes) -> None:
        assert address >= 100
        self.memory[address - 100 : address - 100 + len(data)] = data


class Blocks:
    """Requests without programs: a test calls blocks and gives answers."""

    def __init__(self, *, is_connected: bool = True) -> None:
        self.plc: Any = FakePlc()
        self.requests = PlcRequests(lambda: 0)
        self.frames: list[Frame] = []
        if is_connected:
            self.connect()

    def connect(self) -> None:
        router: Any = SimpleNamespace(deliver=self.frames.append)
        self.requests.connect(router, AmsAddress.of(HERE, 851))

    def start(self, name: str, input: str, **values: Any) -> Any:
        """A block after its rising edge."""
        inputs = {
            "NETID": "",
            "PORT": 1000,
            "IDXGRP": 1,
            "IDXOFFS": 2,
            "TMOUT": timedelta(seconds=5),
        }
        block = SimpleNamespace(BUSY=False, before=False, ERR=False, ERRID=0, **inputs | values)
        setattr(block, input, True)
        self.call(name, block)
        return block

    def call(self, name: str, block: Any) -> None:
        self.requests.blocks[name](self.plc, block)

    def read(self, **values: Any) -> Any:
        return self.start("adsreadex", "READ", **{"LEN": 4, "DESTADDR": 100, "COUNT_R": 9} | values)

    def answer(self, response: Any, **changes: Any) -> None:
        """Answer the last request that was sent."""
        self.requests.end_cycle()
        frame = self.frames[-1].reply(response.encode())
        for name, value in changes.items():
            setattr(frame, name, value)
        self.requests.receive(frame)

    def end(self, name: str, block: Any) -> tuple[bool, bool, int]:
        """Outputs of a block in the next cycle."""
        self.requests.begin_cycle(self.plc)
        self.call(name, block)
        return block.BUSY, block.ERR, block.ERRID


def test_answer_waits_for_a_block_that_is_called_later() -> None:
    blocks = Blocks()
    block = blocks.read()
    assert block.COUNT_R == 0
    blocks.answer(DataResponse(0, b"abcde"))
    for _ in range(3):
        blocks.requests.begin_cycle(blocks.plc)
    assert blocks.end("adsreadex", block) == (False, False, 0)
    assert (blocks.plc.memory[:6], block.COUNT_R) == (b"abcd..", 4)


def test_first_answer_counts() -> None:
    blocks = Blocks()
    block = blocks.read()
    blocks.answer(DataResponse(0, b"one"))
    blocks.answer(DataResponse(0, b"two"))
    blocks.answer(DataResponse(0), error=7)
    assert blocks.end("adsreadex", block) == (False, False, 0)
    assert blocks.plc.memory[:4] == b"one."
    block = blocks.read()
    blocks.answer(DataResponse(0), error=7)
    blocks.answer(DataResponse(0, b"two"))
    assert blocks.end("adsreadex", block) == (False, True, 7)
    assert blocks.plc.memory[:4] == b"one."


def test_answer_to_another_command_is_dropped() -> None:
    blocks = Blocks()
    block = blocks.read()
    blocks.answer(DataResponse(0, b"one"), command=Command.READ_WRITE)
    assert blocks.end("adsreadex", block) == (True, False, 0)


def test_failed_read_stores_nothing_and_a_read_of_nothing_needs_no_memory() -> None:
    blocks = Blocks()
    block = blocks.read()
    blocks.answer(DataResponse(0x703, b"one"))
    assert blocks.end("adsreadex", block) == (False, True, 0x703)
    assert (blocks.plc.memory[:4], block.COUNT_R) == (b"....", 0)
    block = blocks.read(LEN=0, DESTADDR=0)
    blocks.answer(DataResponse(0, b"one"))
    assert blocks.end("adsreadex", block) == (False, False, 0)
    assert (blocks.plc.memory[:4], block.COUNT_R) == (b"....", 0)


def test_result_of_a_write_is_the_error_of_its_block() -> None:
    blocks = Blocks()
    for result in (0, 0x705):
        block = blocks.start("adswrite", "WRITE", LEN=4, SRCADDR=100)
        blocks.answer(ResultResponse(result))
        assert blocks.end("adswrite", block) == (False, result != 0, result)
        assert not hasattr(block, "COUNT_R")


@pytest.mark.parametrize("missing", ["DESTADDR", "SRCADDR"])
def test_block_without_address_sends_nothing(missing: str) -> None:
    blocks = Blocks()
    values = {"READLEN": 4, "WRITELEN": 4, "DESTADDR": 100, "SRCADDR": 104} | {missing: 0}
    block = blocks.start("adsrdwrt", "WRTRD", **values)
    blocks.requests.end_cycle()
    assert (block.BUSY, block.ERR, block.ERRID, blocks.frames) == (False, True, 0x741, [])


def test_state_and_device_info_are_shown_unless_the_request_failed() -> None:
    blocks = Blocks()
    for result in (0, 0x701):
        block = blocks.start("adsrdstate", "RDSTATE", ADSSTATE=0, DEVSTATE=0)
        blocks.answer(ReadStateResponse(result, 5, 7))
        assert blocks.end("adsrdstate", block) == (False, result != 0, result)
        assert ((5, 7) if result == 0 else (0, 0)) == (block.ADSSTATE, block.DEVSTATE)
        block = blocks.start("adsrddevinfo", "RDINFO", DEVNAME="", DEVVER=0)
        blocks.answer(ReadDeviceInfoResponse(result, 0x11, 0x22, 0x4433, "x"))
        assert blocks.end("adsrddevinfo", block) == (False, result != 0, result)
        shown = ("x", 0x4433_2211) if result == 0 else ("", 0)
        assert shown == (block.DEVNAME, block.DEVVER)


def test_request_ends_after_its_timeout_to_the_nanosecond() -> None:
    blocks = Blocks()
    blocks.plc.time_ns = 3
    block = blocks.read()
    blocks.plc.time_ns = 5_000_000_002
    assert blocks.end("adsreadex", block) == (True, False, 0)
    blocks.plc.time_ns += 1
    assert blocks.end("adsreadex", block) == (False, True, 0x745)


def test_requests_without_a_router_are_lost() -> None:
    blocks = Blocks(is_connected=False)
    blocks.read()
    blocks.requests.end_cycle()
    blocks.connect()
    blocks.requests.end_cycle()
    assert blocks.frames == []


def test_forgotten_requests_are_not_sent() -> None:
    blocks = Blocks()
    forgotten: list[str] = []
    blocks.requests.indications.forget = lambda: forgotten.append("indications")  # type: ignore[method-assign]
    block = blocks.read()
    blocks.requests.forget()
    blocks.requests.end_cycle()
    assert (blocks.frames, forgotten) == ([], ["indications"])
    assert blocks.end("adsreadex", block) == (False, True, 0x756)


def test_invoke_ids_count_from_1_to_the_largest() -> None:
    blocks = Blocks()
    tickets = [blocks.read().ticket for _ in range(2)]
    blocks.requests._last = 0xFFFF_FFFE
    tickets += [blocks.read().ticket for _ in range(2)]
    assert tickets == [1, 2, 0xFFFF_FFFF, 1]


@pytest.mark.parametrize(("count", "left"), [(4095, 4096), (4096, 2)])
def test_results_that_no_block_fetches_are_forgotten_from_4096_on(count: int, left: int) -> None:
    blocks = Blocks()
    blocks.read(TMOUT=timedelta(hours=1))
    for _ in range(count - 1):
        blocks.read()
    blocks.plc.time_ns = 5_000_000_000
    blocks.requests.begin_cycle(blocks.plc)
    blocks.read()
    assert len(blocks.requests._open) == left


def test_own_net_id_is_shown_at_the_rising_edge() -> None:
    blocks = Blocks()
    block = SimpleNamespace(bExecute=False, before=False, AddrString="", AddrBytes=[0] * 6)
    shown = []
    for execute in (False, True, True, False, True):
        block.bExecute = execute
        blocks.call("fb_getlocalamsnetid", block)
        shown.append(block.AddrString)
        block.AddrString = ""
    assert shown == ["", str(HERE), "", "", str(HERE)]
    assert block.AddrBytes == [5, 1, 2, 3, 1, 1]


@pytest.mark.parametrize(
    ("severity", "kind"), [(-1, 1), (0, 1), (1, 0x10), (2, 2), (3, 4), (4, 4), (5, 4), (6, 4)]
)
def test_event_goes_to_the_event_logger(severity: int, kind: int) -> None:
    blocks = Blocks()
    assert blocks.requests.functions["tc_event_send"](blocks.plc, severity, b"text") == 0
    blocks.requests.end_cycle()
    [frame] = blocks.frames
    assert frame.target == AmsAddress.of(HERE, 110)
    request = WriteRequest.decode(frame.data)
    assert (request.index_group, request.index_offset) == (1, 0)
    message = LogMessage.decode(request.data)
    assert message is not None
    assert (message.kind, message.port, message.text) == (kind, 851, "text")


def test_log_message_has_253_characters_at_most() -> None:
    blocks = Blocks()
    assert blocks.requests.functions["adslogstr"](blocks.plc, 1, b"%s" + b"x" * 300, b"yz") == 0
    blocks.requests.end_cycle()
    request = WriteRequest.decode(blocks.frames[0].data)
    assert (request.index_group, request.index_offset) == (1, 0)
    message = LogMessage.decode(request.data)
    assert message is not None
    assert message.text == "yz" + "x" * 251
