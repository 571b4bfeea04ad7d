"""Tc2_EtherCAT against a bus that answers as the manual of the master says."""

import struct
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from achse.server import Device, RawGroup
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.conftest import Ran

STATES = {1001: 8, 1002: 8}


class Bus(Device):
    """A master with two slaves; what is asked of it, and of them, is the same object."""

    def __init__(self, further: Sequence[RawGroup] = ()) -> None:
        self.states = dict(STATES)
        self.objects = {0x1018_0001: struct.pack("<I", 2)}
        self.objects[0xF002_0002] = b"\x03"
        self.objects[0xF040_0000] = struct.pack("<H", 2)
        self.frames = 0
        groups = [
            RawGroup(3, "master", read=lambda *_: struct.pack("<H", 8), last_offset=0x100),
            RawGroup(6, "count", read=lambda *_: struct.pack("<H", 2)),
            RawGroup(7, "addresses", read=lambda *_: struct.pack("<2H", *self.states)),
            RawGroup(9, "states", read=self._state, write=self._ask_for, last_offset=0xFFFF),
            RawGroup(0xC, "frames", read=self._frames),
            RawGroup(0x11, "identity", read=self._identity, last_offset=0xFFFF),
            RawGroup(0x12, "crc", read=self._crc, last_offset=0xFFFF),
            RawGroup(0x45, "state", read=lambda *_: struct.pack("<H", 0x1001)),
            RawGroup(
                0xF302, "objects", read=self._object, write=self._put, last_offset=0xFFFF_FFFF
            ),
        ]
        super().__init__("bus", (1, 0, 0), [*groups, *further], clock=lambda: 0)

    def _state(self, offset: int, length: int, client: bytes) -> bytes:
        chosen = [self.states[offset]] if offset else list(self.states.values())
        return b"".join(bytes((state, 0)) for state in chosen)[:length]

    def _ask_for(self, offset: int, data: bytes, client: bytes) -> None:
        self.states[offset] = struct.unpack("<H", data)[0]

    def _identity(self, offset: int, length: int, client: bytes) -> bytes:
        return struct.pack("<4I", 2, 0x07D4_3052, 0x0012_0000, 5)

    def _crc(self, offset: int, length: int, client: bytes) -> bytes:
        return struct.pack("<4I", 1, 2, 3, 4)[:length] if offset else struct.pack("<2I", 10, 0)

    def _frames(self, offset: int, length: int, client: bytes) -> bytes:
        self.frames += 1
        now = 3_950_000_000 + 500_000_000 * self.frames  # the counter of ns runs over
        return struct.pack("<5I", now & 0xFFFF_FFFF, 500 * self.frames, 3, 20 * self.frames, 1)

    def _object(self, offset: int, length: int, client: bytes) -> bytes:
        if offset & 0xF000_0100 == 0x9000_0100:
            number = offset >> 16 & 0xF
            return struct.pack("<HHIIIIH", 6, 1001 + number, 2, 3, 4, 5 + number, 0x5530)
        if offset & 0x8000_0100 == 0x8000_0100:
            number = offset >> 16 & 0xF
            return struct.pack(
                "<HH16s32sI4IHHB3x", 35, 1001 + number, b"EL2004", b"Term 1", 0, 2, 3, 4, 5, 0, 0, 0
            )
        return self.objects[offset]

    def _put(self, offset: int, data: bytes, client: bytes) -> None:
        self.objects[offset] = data


CALLS = (
    ("count : FB_EcGetSlaveCount", "", ""),
    ("all : FB_EcGetAllSlaveStates", "pStateBuf := ADR(buffer), cbBufLen := SIZEOF(buffer)", ""),
    ("addrs : FB_EcGetAllSlaveAddr", "pAddrBuf := ADR(words), cbBufLen := SIZEOF(words)", ""),
    ("one : FB_EcGetSlaveState",
     "nSlaveAddr := 1002", "text := F_ConvSlaveStateToString(one.state);"),
    ("id : FB_EcGetSlaveIdentity",
     "nSlaveAddr := 1002", "name := F_ConvProductCodeToString(id.identity);"),
    ("crc : FB_EcGetSlaveCrcErrorEx", "nSlaveAddr := 1001", ""),
    ("sums : FB_EcGetAllSlaveCrcErrors",
     "pCrcErrorBuf := ADR(longs), cbBufLen := SIZEOF(longs)", ""),
    ("master : FB_EcGetMasterState", "", ""),
    ("dev : FB_EcGetMasterDevState", "", "devs := F_ConvMasterDevStateToString(dev.nDevState);"),
    ("wr : FB_EcCoESdoWrite",
     "nSlaveAddr := 1001, nIndex := 16#8010, nSubIndex := 2, pSrcBuf := ADR(value),"
     " cbBufLen := 4", ""),
    ("rd : FB_EcCoESdoRead",
     "nSlaveAddr := 1001, nIndex := 16#8010, nSubIndex := 2, pDstBuf := ADR(back),"
     " cbBufLen := 4", ""),
    ("req : FB_EcSetSlaveState", "nSlaveAddr := 1002, reqState := 4", ""),
    ("conf : FB_EcGetConfSlaves",
     "pArrEcConfSlaveInfo := ADR(slaves), cbBufLen := SIZEOF(slaves)", ""),
    ("frames : FB_EcMasterFrameStatistic", "", ""),
    ("scan : FB_EcGetScannedSlaves",
     "pArrEcScannedSlaveInfo := ADR(seen), cbBufLen := SIZEOF(seen)", ""),
    ("small : FB_EcGetScannedSlaves",
     "pArrEcScannedSlaveInfo := ADR(seen), cbBufLen := 30", ""),
    ("nowhere : FB_EcGetScannedSlaves", "cbBufLen := 300", ""),
    ("lost : FB_EcGetSlaveState", "sNetId := '9.9.9.9.1.1', nSlaveAddr := 1", ""),
)  # fmt: skip


def test_diagnosis_and_objects(tmp_path: Path) -> None:
    variables, body = "", "CASE step OF\n"
    for number, (declared, inputs, after) in enumerate(CALLS):
        name = declared.split()[0]
        variables += f" {declared};"
        start = f"{inputs}, " if inputs else ""
        body += (
            f"{number}: {name}({start}bExecute := TRUE); IF NOT {name}.bBusy THEN {after}"
            f" errors[{number}] := {name}.bError; step := step + 1; END_IF\n"
        )
    text = (
        f"PROGRAM MAIN VAR step : INT; errors : ARRAY [0..20] OF BOOL; {variables}"
        " buffer : ARRAY [0..9] OF ST_EcSlaveState; words : ARRAY [0..9] OF UINT; longs : ARRAY"
        " [0..9] OF UDINT; text, name, devs : T_MaxString; value : DINT := 77; back : DINT;"
        " seen : ARRAY [0..3] OF ST_EcSlaveScannedData; slaves :"
        f" ARRAY [0..3] OF ST_EcSlaveConfigData; END_VAR {body} END_CASE END_PROGRAM"
    )
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=tmp_path)
    bus = Bus()
    for port in (0xFFFF, 1001, 1002):
        bus.attach(station.router, port)
    station.advance(2)
    plc = station.plcs[851]
    assert plc.failure == ""
    main: Any = plc.instance("MAIN")
    assert main["step"] == len(CALLS)
    last = len(CALLS)
    assert [n for n, error in enumerate(main["errors"]) if error] == [last - 3, last - 2, last - 1]
    assert (main["small"]["nErrorId"], main["nowhere"]["nErrorId"]) == (0x705, 0x706)
    assert main["scan"]["nSlaves"] == 2
    result = main["seen"][1]
    assert (result["nAddr"], result["stSlaveIdentity"]["serialNo"]) == (1002, 6)
    assert result["ndlStatusReg"] == 0x5530
    assert bus.objects[0xF002_0001] == b"\x01\0"
    frames = main["frames"]
    assert (frames["nLostFrames"], frames["nLostQueuedFrames"]) == (3, 1)
    assert (frames["fFramesPerSecond"], frames["fQueuedFramesPerSecond"]) == (1000.0, 40.0)
    assert (main["count"]["nSlaves"], main["all"]["nSlaves"], main["addrs"]["nSlaves"]) == (2, 2, 2)
    assert list(main["words"])[:2] == [1001, 1002]
    assert (main["text"], main["name"]) == ("OP", "EL2004-0000-0018")
    assert main["crc"]["crcError"]["portD"] == 4
    assert (list(main["longs"])[:2], main["sums"]["nSlaves"]) == ([10, 0], 2)
    assert (main["master"]["state"], main["devs"]) == (8, "Link error, DC not in sync")
    assert (main["back"], main["rd"]["cbRead"]) == (77, 4)
    assert bus.states[1002] == main["req"]["currState"]["deviceState"] == 4
    assert main["conf"]["nSlaves"] == 2
    assert [(slave["nAddr"], slave["sName"]) for slave in main["slaves"]][:2] == [
        (1001, "Term 1"),
        (1002, "Term 1"),
    ]
    assert main["slaves"][1]["stSlaveIdentity"]["serialNo"] == 5


def test_times_of_distributed_clocks() -> None:
    from tests.plc.code.conftest import Ran

    ran = Ran(
        "PROGRAM MAIN VAR now : T_DCTIME64; t : TIMESTRUCT; s : STRING(29); back : T_DCTIME64;"
        " END_VAR now := F_GetCurDcTaskTime64(); t := DCTIME64_TO_SYSTEMTIME(now);"
        " s := DCTIME64_TO_STRING(now + 7); back := SYSTEMTIME_TO_DCTIME64(t, 3, 4); END_PROGRAM",
        epoch=lambda: 946_684_800_000_000_000 + 86_400_000_000_000,
    ).cycle(2)
    assert ran["now"] == 86_400_000_000_000 + 20_000_000
    assert ran["s"] == "2000-01-02-00:00:00.020000007"
    assert ran["back"] == ran["now"] + 3004


def test_states_of_slaves_are_bits() -> None:
    from tests.plc.code.conftest import Ran

    ran = Ran(
        "PROGRAM MAIN VAR s : ST_EcSlaveState; b : ST_EcSlaveStateBitsEx; t : T_DCTIME; END_VAR"
        " s.deviceState := 16#94; s.linkState := 16#81; b := F_ConvSlaveStateToBitsEx(s);"
        " t := F_GetCurDcTaskTime(); END_PROGRAM",
        epoch=lambda: 946_684_800_000_000_000 + 86_400_000_000_000,
    ).cycle()
    bits = ran["b"]
    names = ["bInit", "bSafeOp", "bOp", "bError", "bDisabled", "bLinkNotPresent", "bPortD"]
    assert [name for name in names if bits[name]] == [
        "bSafeOp", "bError", "bDisabled", "bLinkNotPresent", "bPortD",
    ]  # fmt: skip
    time = ran["t"]
    assert time["dwHighPart"] << 32 | time["dwLowPart"] == 86_400_010_000_000


class FileBus(Bus):
    """The same, with files of slaves."""

    def __init__(self) -> None:
        self.files = {"FW": b"12345" * 500}
        self.open: dict[int, tuple[str, int, bytearray]] = {}
        self.visited = set[int]()
        actions = {0xF401: self._open, 0xF402: self._open, 0xF403: self._close}
        actions |= {0xF404: self._take, 0xF405: self._append}
        super().__init__([self._group(*item) for item in actions.items()])

    @staticmethod
    def _group(number: int, action: Callable[..., bytes]) -> RawGroup:
        def answer(offset: int, length: int, data: bytes, client: bytes) -> bytes:
            return action(number, offset, length, data, client)

        return RawGroup(number, "file", read_write=answer, last_offset=0xFFFF_FFFF)

    def _ask_for(self, offset: int, data: bytes, client: bytes) -> None:
        super()._ask_for(offset, data, client)
        self.visited.add(self.states[offset])

    def _open(self, group: int, password: int, length: int, data: bytes, client: bytes) -> bytes:
        name = data.rstrip(b"\0").decode()
        content = self.files[name] if group == 0xF401 else b""
        self.open[len(self.open) + 1] = (name, group, bytearray(content))
        return struct.pack("<I", len(self.open))

    def _close(self, group: int, handle: int, length: int, data: bytes, client: bytes) -> bytes:
        name, way, content = self.open[handle]
        if way == 0xF402:
            self.files[name] = bytes(content)
        return b""

    def _take(self, group: int, handle: int, length: int, data: bytes, client: bytes) -> bytes:
        content = self.open[handle][2]
        part = bytes(content[:length])
        del content[:length]
        return part

    def _append(self, group: int, handle: int, length: int, data: bytes, client: bytes) -> bytes:
        self.open[handle][2].extend(data)
        return b""


def test_file_of_a_slave_goes_both_ways(tmp_path: Path) -> None:
    text = """PROGRAM MAIN VAR step : INT; load, store : FB_EcFoeLoad; open : FB_EcFoeOpen; END_VAR
        CASE step OF
        0: load(nSlaveAddr := 1001, sPathName := 'FW.bin', eMode := eFoeMode_Read,
            bExecute := TRUE);
            IF NOT load.bBusy THEN step := 1; END_IF
        1: store(nSlaveAddr := 1002, sPathName := 'FW.bin', bExecute := TRUE);
            IF NOT store.bBusy THEN step := 2; bEcFoeOpenFileNameWithFileExt := TRUE; END_IF
        2: open(nPort := 1001, sPathName := 'c:\\x.y\\New.txt', eMode := eFoeMode_Write,
            bExecute := TRUE);
            IF NOT open.bBusy THEN step := 3; END_IF
        END_CASE END_PROGRAM"""
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    (tmp_path / "shown").mkdir()
    document = {"plc": [{"sources": "a.st"}], "system": {"root": "shown"}}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    bus = FileBus()
    content = bus.files["FW"]
    for port in (0xFFFF, 1001, 1002):
        bus.attach(station.router, port)
    station.advance(3)
    plc = station.plcs[851]
    assert plc.failure == ""
    main: Any = plc.instance("MAIN")
    assert main["step"] == 3
    assert (main["load"]["nErrId"], main["load"]["cbLoad"]) == (0, 2500)
    assert (main["store"]["nErrId"], main["store"]["cbLoad"]) == (0, 2500)
    assert (tmp_path / "shown/FW.bin").read_bytes() == content
    assert bus.files == {"FW": content}
    assert (bus.states, bus.visited) == (STATES, {1, 3, 8})
    assert main["open"]["hFoe"]["handle"] == 3
    assert bus.open[3][0] == "New.txt"


def test_offsets_lead_from_the_dc_time_to_others() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR dc, ext, tc, back, now, own : ULINT; END_VAR own := F_GetCurDcTime64();"
        " dc := F_ConvTcTimeToDcTime64(TcTime := 1000, DcToTcTimeOffset := 300);"
        " ext := F_ConvTcTimeToExtTime64(1000, DcToTcTimeOffset := 300, DcToExtTimeOffset := 50);"
        " back := F_ConvExtTimeToDcTime64(ExtTime := ext, DcToExtTimeOffset := 50);"
        " now := F_GetCurExtTime64(DcToExtTimeOffset := 70, DcToTcTimeOffset := 20); END_PROGRAM"
    ).cycle()
    assert (ran["dc"], ran["ext"], ran["back"]) == (700, 750, 700)
    assert ran["now"] - ran["own"] == 50
