"""The scope server: every row of the manual's table, every rule of its chapter, the modern face."""

import json
import struct
from pathlib import Path
from typing import Any

import pytest

from achse.ams import AmsAddress
from achse.devices.scope.device import ROOT_FUNCTIONS, ROOT_STATES, VIEW
from achse.scope import ScopeData
from achse.scope.binary import chunks_in
from achse.scope.service import SAMPLES_REQUEST, ScopeGroup
from achse.server import READ, WRITE
from achse.station import Station

ROWS = [
    line.split("\t")
    for line in (Path(__file__).parents[2] / "data" / "scope_services.tsv")
    .read_text(encoding="utf-8")
    .splitlines()[1:]
]
"""Of 000 §5.2: group, offset, access, data; id is 1."""

ROOT, LOAD, VIEW_GROUP = 0x1000, 0x2000, 0x3000
TRIGGER, LENGTH, EXPORT, EXPORT_VIEW = 0x101, 0x201, 0x1001, 0x1011


def online(scope: Any) -> int:
    [state] = scope.read(ROOT, 1, 1)
    return int(state)


# the rows --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("group", "offset", "access", "data"), ROWS)
def test_every_row_is_served_as_the_table_says(
    station: Station, scope: Any, refused: Any, folder: Path,
    group: str, offset: str, access: str, data: str,
) -> None:  # fmt: skip
    place = int(group, 16), int(offset, 16)
    name = b"name.scp\0" if data == "char[]" else b""
    if place[0] == LOAD:
        (folder / "name.scp").write_text('{"channels": ["MAIN.nCounter"]}')
    if place[1] in (TRIGGER, EXPORT):
        scope.write(ROOT, 1, b"")
        station.advance(0.1)
    if "R" in access:
        size = {"BYTE": 1, "REAL64": 8}[data]
        assert len(scope.read(*place, 100)) == size
    elif place != (ROOT, 1):
        with refused(0x704):
            scope.read(*place, 8)
    if "W" in access:
        content = {"void": b"", "char[]": name, "REAL64": struct.pack("<d", 2.0)}[data]
        if data != "char[]":
            with refused(0x705):
                scope.write(*place, content + b"\0")
        scope.write(*place, content)
    with refused(0x704):
        scope.exchange(*place, 8, b"")


def test_the_table_has_every_row_of_ours() -> None:
    served = {
        (f"0x{group:X}", f"0x{row.offset:X}", access)
        for group, rows in ((ROOT, ROOT_STATES), (LOAD, ROOT_FUNCTIONS), (VIEW_GROUP, VIEW))
        for row in rows
        for access, flag in (("R", READ), ("W", WRITE))
        if flag in row.access
    }
    listed = {(group, offset, one) for group, offset, access, _ in ROWS for one in access}
    assert served == listed


@pytest.mark.parametrize("offset", [0, 0x100, 0x102, 0x200, 0x202, 0x1000, 0x1002, 0x1010, 0x1012])
def test_there_is_only_the_view_with_id_1(scope: Any, refused: Any, offset: int) -> None:
    """Only one view is open, its id is always 1 (000 §5.2); others answer 0x703."""
    for size in (0, 8):
        with refused(0x703):
            scope.write(VIEW_GROUP, offset, bytes(size))
    with refused(0x703):
        scope.read(VIEW_GROUP, offset, 8)


# the rules -------------------------------------------------------------------------------------


def test_the_device_reports_its_name_at_its_port(station: Station) -> None:
    [device] = [each for each in station.devices if each.name == "TwinCAT Scope"]
    assert device.address == AmsAddress("127.0.0.1.1.1:14000")


def test_online_and_offline(station: Station, scope: Any) -> None:
    assert online(scope) == 0
    scope.write(ROOT, 1, b"")
    assert online(scope) == 1
    station.advance(0.1)
    scope.write(ROOT, 1, b"")  # again: it goes on
    station.advance(0.1)
    assert station.scope("MAIN.nCounter").number == 2
    scope.write(ROOT, 2, b"")
    assert online(scope) == 0
    scope.write(ROOT, 2, b"")
    state = json.loads(scope.read(ScopeGroup.SCOPES, 1, 100_000))
    assert [group["count"] for group in state["channel_groups"]] == [100, 20]


def test_a_trigger_works_only_online(station: Station, scope: Any, refused: Any) -> None:
    with refused(0x712):
        scope.write(VIEW_GROUP, TRIGGER, b"")
    scope.write(ROOT, 1, b"")
    station.advance(0.2)
    scope.write(VIEW_GROUP, TRIGGER, b"")
    with refused(0x712):
        scope.write(VIEW_GROUP, TRIGGER, b"")
    station.advance(1.0)
    state = json.loads(scope.read(ScopeGroup.SCOPES, 1, 100_000))
    assert (state["state"], state["trigger_ns"]) == ("done", station.epoch_ns + 200_000_000)
    assert online(scope) == 1
    scope.write(ROOT, 1, b"")  # a recording that is done begins again
    assert json.loads(scope.read(ScopeGroup.SCOPES, 1, 100_000))["state"] == "recording"


def test_the_record_length_is_written_offline(station: Station, scope: Any, refused: Any) -> None:
    assert struct.unpack("<d", scope.read(VIEW_GROUP, LENGTH, 8)) == (0.5,)
    scope.put(VIEW_GROUP, LENGTH, "<d", 0.25)
    for wrong in (0.0, -1.0, 3600.001, float("nan"), float("inf")):
        with refused(0x70B):
            scope.put(VIEW_GROUP, LENGTH, "<d", wrong)
    scope.write(ROOT, 1, b"")
    with refused(0x712):
        scope.put(VIEW_GROUP, LENGTH, "<d", 1.0)
    station.advance(2.0)
    state = json.loads(scope.read(ScopeGroup.SCOPES, 1, 100_000))
    assert [group["capacity"] for group in state["channel_groups"]] == [125, 25]


@pytest.mark.parametrize("name", [b"Test.dat", rb"D:\TwinCAT\Scope\Data\Test.dat" + b"\0"])
def test_data_are_exported_as_text(
    station: Station, scope: Any, refused: Any, folder: Path, name: bytes
) -> None:
    """With or without NUL; a drive and its folders begin at the one folder."""
    with refused(0x712):
        scope.write(VIEW_GROUP, EXPORT, name)
    scope.write(ROOT, 1, b"")
    station.advance(1.0)
    scope.write(VIEW_GROUP, EXPORT, name)
    written = folder / ("Test.dat" if b":" not in name else "TwinCAT/Scope/Data/Test.dat")
    lines = written.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "Name\tpress"
    times = [int(line.split("\t")[1]) for line in lines[2:4]]
    assert times[1] - times[0] == 4_980_000  # 250 samples of 2 ms in units of 100 ns


def test_the_end_of_the_name_may_request_the_binary_form(
    station: Station, scope: Any, folder: Path
) -> None:
    scope.write(ROOT, 1, b"")
    station.advance(1.0)
    scope.write(VIEW_GROUP, EXPORT, b"a.scope")
    assert len(ScopeData.load(folder / "a.scope")["Axes.X.ActPos"]) == 250


def test_a_view_that_was_exported_is_loaded(
    station: Station, scope: Any, refused: Any, folder: Path
) -> None:
    scope.write(VIEW_GROUP, EXPORT_VIEW, b"views/press.scp\0")
    scope.put(VIEW_GROUP, LENGTH, "<d", 3.0)
    scope.write(ROOT, 1, b"")
    station.advance(0.1)
    scope.write(LOAD, 1, b"views\\press.scp")
    assert online(scope) == 0
    assert struct.unpack("<d", scope.read(VIEW_GROUP, LENGTH, 8)) == (0.5,)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (None, 0x70C),
        (b"TwinCAT Scope 2 project", 0x706),
        (b'{"channels": ["MAIN.nNothing"]}', 0x706),
        (b'{"record_length": 0}', 0x706),
    ],
)
def test_a_file_that_is_none_of_ours_is_refused(
    scope: Any, refused: Any, folder: Path, content: bytes | None, code: int
) -> None:
    if content is not None:
        (folder / "a.scp").write_bytes(content)
    with refused(code):
        scope.write(LOAD, 1, b"a.scp")
    assert struct.unpack("<d", scope.read(VIEW_GROUP, LENGTH, 8)) == (0.5,)


@pytest.mark.parametrize("name", [b"../a.scp", b"C:\\..\\..\\a.scp", b"//host/a.scp", b"a\0b"])
def test_no_file_outside_the_folder_is_touched(
    station: Station, scope: Any, refused: Any, tmp_path: Path, name: bytes
) -> None:
    (tmp_path / "a.scp").write_text("{}")
    scope.write(ROOT, 1, b"")
    station.advance(0.1)
    for group, offset in ((LOAD, 1), (VIEW_GROUP, EXPORT), (VIEW_GROUP, EXPORT_VIEW)):
        with refused(0x70C):
            scope.write(group, offset, name)
    with refused(0x70B):
        scope.write(LOAD, 1, b"\0")


# the modern face -------------------------------------------------------------------------------


def command(scope: Any, number: int, text: str) -> Any:
    return json.loads(scope.exchange(ScopeGroup.SCOPES, number, 1 << 20, text.encode()))


def test_a_client_makes_a_scope_of_its_own(
    station: Station, scope: Any, client_of: Any, refused: Any
) -> None:
    definition = {"name": "mine", "channels": ["MAIN.nCounter"], "record_length": 0.05}
    assert command(scope, 0, json.dumps(definition)) == {"scope": 2}
    other = client_of(station.router, 14000)
    listed = json.loads(other.read(ScopeGroup.SCOPES, 0, 10_000))
    assert [(each["number"], each["own"], each["state"]) for each in listed] == [
        (1, False, "offline"), (2, False, "offline"),
    ]  # fmt: skip
    with refused(0x723):
        other.exchange(ScopeGroup.SCOPES, 2, 100, b"start")
    assert command(scope, 2, "start")["state"] == "recording"
    station.advance(0.2)
    request = SAMPLES_REQUEST.pack(0, 0)
    [chunk] = chunks_in(scope.exchange(ScopeGroup.SAMPLES, 2, 10_000, request), {0: 1})
    assert (chunk.first, chunk.size) == (15, 5)
    [chunk] = chunks_in(scope.exchange(ScopeGroup.SAMPLES, 2, 16 + 17, request), {0: 1})
    assert (chunk.first, chunk.size) == (15, 2)
    assert command(scope, 2, "trigger")["state"] == "triggered"
    station.advance(0.1)
    assert command(scope, 2, "stop")["state"] == "offline"
    command(scope, 2, '"close"')
    with refused(0x70C):
        scope.exchange(ScopeGroup.SCOPES, 2, 100, b"start")


@pytest.mark.parametrize(
    ("number", "text", "message"),
    [
        (0, "{", "expected a JSON document"),
        (0, '{"channels": ["MAIN.nCounte"]}', "did you mean 'MAIN.nCounter'?"),
        (0, '{"channels": ["MAIN.nCounter@3ms"]}', "in whole ticks of 2 ms, got 3 ms"),
        (1, "halt", "expected start, stop, trigger, close, progress, got 'halt'"),
        (1, "close", "scope 1 is the station's own and stays"),
    ],
)
def test_what_cannot_be_done_is_reported(scope: Any, number: int, text: str, message: str) -> None:
    assert message in command(scope, number, text)["error"]


def test_wrong_requests_have_their_codes(scope: Any, refused: Any) -> None:
    for code, group, number, data in (
        (0x70C, ScopeGroup.SCOPES, 9, b"start"),
        (0x712, ScopeGroup.SCOPES, 1, b"trigger"),
        (0x705, ScopeGroup.SAMPLES, 1, b""),
        (0x70C, ScopeGroup.SAMPLES, 1, SAMPLES_REQUEST.pack(0, 0)),
        (0x70C, ScopeGroup.SAMPLES, 9, SAMPLES_REQUEST.pack(0, 0)),
        (0x705, ScopeGroup.SCOPES, 0, bytes(5_000_000)),
    ):
        with refused(code):
            scope.exchange(group, number, 100, data)


def test_a_client_that_is_gone_leaves_nothing(station: Station, scope: Any, client_of: Any) -> None:
    definition = json.dumps({"channels": ["MAIN.nCounter"]})
    assert command(scope, 0, definition) == {"scope": 2}
    command(scope, 2, "start")
    station.router.unregister(scope.address.port)
    other = client_of(station.router, 14000)
    assert len(json.loads(other.read(ScopeGroup.SCOPES, 0, 10_000))) == 1


def test_a_client_that_opens_and_closes_for_ever_is_slowed_down(
    station: Station, scope: Any, client_of: Any, refused: Any
) -> None:
    """0x708 beyond 256 at once and 32 a second; others go on, and later it does too."""
    definition = json.dumps({"channels": ["MAIN.nCounter"]})

    def turn(client: Any) -> None:
        number = command(client, 0, definition)["scope"]
        command(client, number, "close")

    for _ in range(256):
        turn(scope)
    with refused(0x708):
        turn(scope)
    turn(client_of(station.router, 14000))
    station.advance(0.1)
    for _ in range(3):
        turn(scope)
    with refused(0x708):
        turn(scope)


def test_progress_reports_counts_alone(station: Station, scope: Any) -> None:
    scope.write(ROOT, 1, b"")
    station.advance(0.1)
    assert command(scope, 1, "progress") == {
        "state": "recording",
        "channel_groups": [{"count": 50, "oldest": 0}, {"count": 10, "oldest": 0}],
    }
