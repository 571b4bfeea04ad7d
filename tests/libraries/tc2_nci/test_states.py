"""What functions say of the cyclic structures, and what they put into them."""

from pathlib import Path
from typing import Any

import pytest

from achse.native.backend import compiler_installed
from achse.station import Station
from achse.station.configuration.station_file import parse

READ: dict[str, tuple[str, dict[str, Any], Any]] = {
    "ItpGetBlockNumber": ("UDINT", {"BlockNo": 70}, 70),
    "ItpGetChannelId": ("UDINT", {"ChnId": 3}, 3),
    "ItpGetGroupId": ("UDINT", {"GrpId": 11}, 11),
    "ItpGetItfVersion": ("UDINT", {"ItfVersion": 2}, 2),
    "ItpGetStateInterpreter": ("UDINT", {"ItpState": 16}, 16),
    "ItpGetError": ("UDINT", {"ErrorCode": 0x4110}, 0x4110),
    "ItpHasError": ("BOOL", {"ErrorCode": 0x4110}, True),
    "ItpGetSetPathVelocity": ("LREAL", {"PathVelo": 12.5}, 12.5),
    "ItpGetHParam": ("DINT", {"HFuncValue": 0xFFFF_FFFE}, -2),
    "ItpGetSParam": ("WORD", {"SpindleRpm": 9000}, 9000),
    "ItpGetTParam": ("WORD", {"Tool": 5}, 5),
    "ItpIsHskMFunc": ("BOOL", {"HskMFuncReq": 1}, True),
    "ItpGetHskMFunc": ("INT", {"HskMFuncReq": 1, "HskMFuncNo": 40}, 40),
    **{
        f"ItpReadCyclicLRealParam{n}": ("LREAL", {f"DoubleParams.{n - 1}": n + 0.5}, n + 0.5)
        for n in (1, 2, 3, 4)
    },
    **{
        f"ItpReadCyclicUdintParam{n}": ("UDINT", {f"IntParams.{n - 1}": n}, n) for n in (1, 2, 3, 4)
    },
}
BITS = {
    "ItpIsEStopEx": "bIsEStopRequested",
    "ItpIsFeedFromBackupList": "bIsFeedFromBackupList",
    "ItpIsMovingBackwards": "bIsMovingBackward",
    "ItpIsFirstSegmentReached": "bRetraceStartPosReached",
}

PROGRAM = """PROGRAM MAIN
VAR
    shown : NCTOPLC_NCICHANNEL_REF;
    given : PLCTONC_NCICHANNEL_REF;
    {declared}
    kind : INT;
    nFast : INT;
    bFast : BOOL;
    ids : ARRAY [1..8] OF DWORD;
    nIds : DWORD;
    fPercent, fNone, fGiven : LREAL;
    bSet : BOOL;
    version : ARRAY [0..4] OF UINT;
    sVersion, sOlder, sNone : STRING(20);
    n : INT;
END_VAR
{calls}
kind := ItpGetChannelType(shown);
bFast := ItpIsFastMFunc(nFast, shown);
nIds := ItpGetGroupAxisIds(ids, shown);
bSet := ItpSetOverridePercent(fPercent, given);
fGiven := ItpGetOverridePercent(given);
FOR n := 0 TO 4 DO
    version[n] := F_GetVersionTcNciUtilities(n);
END_FOR
sVersion := ItpGetVersion(TRUE);
sOlder := Get_TcNcCfg_Version(TRUE);
sNone := ItpGetVersion(FALSE);
END_PROGRAM
"""


@pytest.fixture(params=("plain", "machine") if compiler_installed() else ("plain",))
def main(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    names = {**{name: row[0] for name, row in READ.items()}, **dict.fromkeys(BITS, "BOOL")}
    text = PROGRAM.format(
        declared="\n    ".join(f"r{name} : {type};" for name, type in names.items()),
        calls="\n".join(f"r{name} := {name}(shown);" for name in names),
    )
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    document = {"plc": [{"sources": "a.st", "code": request.param}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    plc = station.plcs[851]
    instance: Any = plc.instance("MAIN")

    def cycle() -> None:
        station.advance(0.01)
        assert plc.failure == ""

    return instance, cycle


def _set(structure: Any, path: str, value: Any) -> None:
    *owners, last = path.split(".")
    for each in owners:
        structure = structure[each]
    structure[int(last) if last.isdecimal() else last] = value


def test_functions_that_read(main: Any) -> None:
    plc, cycle = main
    cycle()
    for name in (*READ, *BITS):
        assert not plc[f"r{name}"], name
    for _, members, _ in READ.values():
        for path, value in members.items():
            _set(plc["shown"], path, value)
    cycle()
    for name, (_, _, wanted) in READ.items():
        assert plc[f"r{name}"] == wanted, name
    for name, bit in BITS.items():
        plc["shown"]["ChnState"][bit] = True
        cycle()
        assert [each for each in BITS if plc[f"r{each}"]] == [name]
        plc["shown"]["ChnState"][bit] = False
    plc["shown"]["HskMFuncReq"] = 0
    cycle()
    assert (plc["rItpIsHskMFunc"], plc["rItpGetHskMFunc"]) == (False, 0)


def test_kind_of_a_channel_and_its_axes(main: Any) -> None:
    plc, cycle = main
    state = plc["shown"]["ChnState"]
    for interpolates, transforms, wanted in ((0, 0, 0), (1, 0, 1), (0, 1, 2)):
        state["bIsInterpolationChannel"] = bool(interpolates)
        state["bIsKinematicChannel"] = bool(transforms)
        cycle()
        assert plc["kind"] == wanted
    assert plc["nIds"] == 0x4B14
    plc["shown"]["ItfVersion"] = 2
    for n in range(8):
        plc["shown"]["McsAxisIDs"][n] = n + 1
    cycle()
    assert plc["nIds"] == 0
    assert list(plc["ids"]) == [1, 2, 3, 4, 5, 6, 7, 8]


def test_fast_m_functions(main: Any) -> None:
    plc, cycle = main
    for number in (0, 31, 32, 95, 159):
        for word in range(1, 6):
            plc["shown"]["FastMFuncMask"][word] = 0
        plc["shown"]["FastMFuncMask"][number // 32 + 1] = 1 << number % 32
        seen = []
        for m_function in (-1, 0, 31, 32, 95, 159, 160, 32767):
            plc["nFast"] = m_function
            cycle()
            if plc["bFast"]:
                seen.append(m_function)
        assert seen == [number]


def test_overrides(main: Any) -> None:
    plc, cycle = main
    for percent, wanted in ((0.0, 0), (37.5, 375_000), (100.0, 10**6), (-1.0, 0), (1e300, 10**6)):
        plc["fPercent"] = percent
        cycle()
        assert plc["given"]["ChnAxesOvr"] == wanted
        assert (plc["bSet"], plc["fGiven"]) == (True, wanted / 10_000)
    plc["fPercent"] = float("nan")
    cycle()
    assert plc["given"]["ChnAxesOvr"] == 0


def test_versions(main: Any) -> None:
    plc, cycle = main
    cycle()
    assert list(plc["version"]) == [0, 3, 3, 12, 0]
    assert (plc["sVersion"], plc["sOlder"], plc["sNone"]) == ("3.3.12.0", "3.3.12.0", "")
