"""Persistent data outlive the program, if the configuration names a file for them."""

import asyncio
import contextlib
import json
import logging
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.iec import DINT, Program, var
from achse.motion import Nc, commands
from achse.plc import PlcRuntime, PlcState, Task
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.persistence.persistent_data import PersistentData
from achse.station.persistence.persistent_image import PersistentImage
from achse.station.persistence.snapshot_file import Snapshot, SnapshotFile
from tests.station.persistence.failing_disk import FailingDisk, PowerCutError

AXES = [{"id": i, "name": f"{i}", "persistent_data_enable": 2 - i} for i in (1, 2)]


def station(folder: Path, name: str | None = "kept.json", axes: Any = AXES) -> Station:
    document: dict[str, Any] = {"axis": axes}
    if name is not None:
        document["system"] = {"persistent_data": name, "persistent_data_interval": "1ns"}
    return Station(parse(document, ""), base=folder)


def nc_of(built: Station) -> Nc:
    assert built.nc is not None
    return built.nc


def travel(built: Station) -> None:
    """All axes are homed and are at 30 mm."""
    for axis in nc_of(built):
        axis.control_dword = 7
        axis.velocity_override = 1_000_000
        commands.set_homed_flag(axis, 1)
        commands.start(axis, 1, 30.0, 200.0)
    built.advance(3.0)


def shows(built: Station) -> list[tuple[float, int]]:
    return [(round(axis.actual_position, 2), axis.homed) for axis in nc_of(built)]


def test_another_program_goes_on_where_the_axes_stand(tmp_path: Path) -> None:
    first = station(tmp_path)
    travel(first)
    first.save()
    saved = json.loads((tmp_path / "kept.json").read_text())["nc"]["1"]
    assert saved["position"] == nc_of(first).axis(1).actual_position
    second = station(tmp_path)
    assert shows(second) == [(30.0, 1), (0.0, 0)]
    zeros = [axis.sensor.zero * axis.encoder.scaling_factor for axis in nc_of(second)]
    assert zeros == pytest.approx([-30.0, -30.0], abs=1e-3)  # both machines stand where they stood
    second.advance(0.1)
    assert shows(second) == [(30.0, 1), (0.0, 0)]


def test_it_is_as_if_the_station_had_restarted(tmp_path: Path) -> None:
    restarted = station(tmp_path)
    travel(restarted)
    restarted.restart()
    restarted.advance(0.002)
    begun = station(tmp_path)
    restarted.advance(0.6)
    nc_before, nc_after = nc_of(restarted), nc_of(begun)
    nc_after.cycle(nc_before.cycle_count)
    assert nc_after.digest() == nc_before.digest()


async def test_what_ends_a_running_station_keeps_them(tmp_path: Path) -> None:
    first = station(tmp_path)
    async with first.running("127.0.0.1", 0, speed=0):
        travel(first)
        assert not (tmp_path / "kept.json").exists()
    assert shows(station(tmp_path))[0] == (30.0, 1)


def test_a_shutdown_keeps_them(tmp_path: Path) -> None:
    first = station(tmp_path)
    travel(first)
    first.shut_down()
    first.advance(0.01)
    first.save()  # nothing is there any more
    assert shows(station(tmp_path))[0] == (30.0, 1)


def test_without_a_file_they_go_with_the_program(tmp_path: Path) -> None:
    first = station(tmp_path, None)
    travel(first)
    first.save()
    assert list(tmp_path.iterdir()) == []
    assert shows(station(tmp_path, None)) == [(0.0, 0), (0.0, 0)]


def test_axes_may_come_and_go(tmp_path: Path) -> None:
    first = station(tmp_path)
    travel(first)
    first.save()
    others = [AXES[0] | {"encoder_ids": [1, 4]}, {"id": 7, "name": "new"}]
    assert shows(station(tmp_path, axes=others)) == [(30.0, 1), (0.0, 0)]


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        "{}",
        "null",
        '{"nc": []}',
        '{"nc": {"x": {"zeros": [0], "position": 0, "homed": 1}}}',
        '{"nc": {"1": {"zeros": [0], "position": 0}}}',
        '{"nc": {"1": {"zeros": [NaN], "position": 0, "homed": 1}}}',
        '{"nc": {"1": {"zeros": [0], "position": "0", "homed": 1}}}',
        '{"nc": {"1": {"zeros": [0], "position": true, "homed": 1}}}',
        '{"nc": {"1": {"zeros": [1e16], "position": 0, "homed": 1}}}',
        '{"nc": {"1": {"zeros": [0], "position": 1' + 400 * "0" + ', "homed": 1}}}',
        '{"nc": {}, "plc": {"851": {"MAIN.p": ["", "", [-1, "MAIN.n", "", 0]]}}}',
        '{"nc": {}, "plc": {"851": {"MAIN.p": ["", "", [0, "MAIN.n", "", -1]]}}}',
        100_000 * "[",
        "\udcff",
    ],
)
def test_a_damaged_file_is_reported_and_put_aside(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, text: str
) -> None:
    (tmp_path / "kept.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    built = station(tmp_path)
    assert "kept.json is damaged, no axis knows its position: " in caplog.text
    assert shows(built) == [(0.0, 0), (0.0, 0)]
    assert [path.name for path in tmp_path.iterdir()] == ["kept.json"]
    built.save()
    assert "kept as" in caplog.text
    assert (tmp_path / "kept.json.damaged").exists()
    caplog.clear()
    station(tmp_path)
    assert caplog.text == ""


def test_a_file_that_cannot_be_written_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    built = station(tmp_path)
    (tmp_path / "kept.json.new").mkdir()
    with caplog.at_level(logging.ERROR):
        built.save()
    assert "kept.json cannot be written: " in caplog.text


@pytest.mark.parametrize("name", ["nowhere/kept.json", ".", "/dev/null"])
def test_a_place_where_no_file_can_be(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError, match=r"system\.persistent_data: expected a file in a folder"):
        station(tmp_path, name)


KEEPING = """
PROGRAM MAIN
VAR PERSISTENT nTotal : DINT; END_VAR
VAR write : WritePersistentData; step : INT; nError : UDINT; END_VAR
nTotal := nTotal + 1;
CASE step OF
0: IF nTotal = 5 THEN write(PORT := 851, START := TRUE); step := 1; END_IF
1: write(); IF NOT write.BUSY THEN nError := write.ERRID; step := 2; END_IF
END_CASE
END_PROGRAM
"""


@pytest.mark.parametrize("code", ["plain", "auto"])
def test_a_program_keeps_its_variables_itself(tmp_path: Path, code: str) -> None:
    (tmp_path / "a.st").write_text(KEEPING)
    document = {
        "plc": [{"sources": "a.st", "code": code}],
        "system": {"persistent_data": "data/kept.json"},
    }
    (tmp_path / "data").mkdir()

    def main() -> tuple[Station, Any]:
        built = Station(parse(document, ""), base=tmp_path)
        return built, built.plcs[851].instance("MAIN")

    first, values = main()
    first.advance(0.1)
    assert (values["step"], values["nError"], values["nTotal"]) == (2, 0, 10)
    second, values = main()  # the power was lost: nothing else was written
    assert values["nTotal"] in (5, 6)
    values["nTotal"] = 4
    (tmp_path / "data" / "kept.json").unlink()
    (tmp_path / "data").rmdir()
    second.advance(0.1)
    assert (values["step"], values["nError"]) == (2, 0x700), "the folder is gone"
    assert second.plcs[851].failure == ""


PLC = """
PROGRAM MAIN
VAR PERSISTENT nTotal : DINT; END_VAR
VAR RETAIN nParts : DINT; END_VAR
VAR n : DINT; END_VAR
nTotal := nTotal + 1; nParts := nParts + 2; n := n + 1;
END_PROGRAM
"""


def test_plc_variables_outlive_restarts_and_programs(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "a.st").write_text(PLC)
    document = {"plc": [{"sources": "a.st"}], "system": {"persistent_data": "kept.json"}}

    def built() -> Station:
        return Station(parse(document, ""), base=tmp_path)

    def values(of: Station) -> tuple[int, int, int]:
        main = of.plcs[851].instance("MAIN")
        return main["nTotal"], main["nParts"], main["n"]

    first = built()
    first.advance(0.1)
    first.restart()
    first.advance(5.0)
    total, parts, count = values(first)
    assert (total, parts) == (count + 10, 2 * count + 20)
    first.save()
    second = built()
    assert values(second) == (total, parts, 0)
    second.advance(0.1)
    second.plcs[851].reset()
    assert values(second) == (total + 10, parts + 20, 0)
    second.plcs[851].reset(origin=True)
    assert values(second) == (0, 0, 0)
    (tmp_path / "a.st").write_text(PLC.replace("nTotal : DINT", "nTotal : LINT"))
    assert values(built()) == (0, parts, 0)
    assert "MAIN.nTotal" in caplog.text
    (tmp_path / "kept.json").write_text('{"nc": {}, "plc": {"851": {"MAIN.nTotal": ["", "x"]}}}')
    assert values(built()) == (0, 0, 0)
    assert "damaged" in caplog.text


def test_plc_without_variables_to_keep_is_not_in_the_file(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("PROGRAM MAIN VAR n : INT; END_VAR n := 1; END_PROGRAM")
    document = {"plc": [{"sources": "a.st"}], "system": {"persistent_data": "kept.json"}}
    Station(parse(document, ""), base=tmp_path).save()
    assert json.loads((tmp_path / "kept.json").read_text()) == {"nc": {}, "plc": {}}


def _leading(folder: Path) -> Station:
    """A station with the program `LEADING`."""
    (folder / "b.st").write_text(LEADING)
    document = {"plc": [{"sources": "b.st"}], "system": {"persistent_data": "kept.json"}}
    return Station(parse(document, ""), base=folder)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The file after eleven cycles of `LEADING`."""
    folder = tmp_path_factory.mktemp("saved")
    first = _leading(folder)
    first.advance(0.1)
    first.save()
    return (folder / "kept.json").read_bytes()


@given(st.data())
@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_whatever_a_file_holds_a_plc_starts(
    tmp_path: Path, saved: bytes, data: st.DataObject
) -> None:
    """Cut, overwritten, or with other rows: values are those of the file or as declared."""
    file, text = tmp_path / "kept.json", saved
    file.write_bytes(text)
    kind = data.draw(st.sampled_from(["whole", "cut", "byte", "row"]))
    if kind == "cut":
        file.write_bytes(text[: data.draw(st.integers(0, len(text) - 3))])
    elif kind == "byte":
        at = data.draw(st.integers(0, len(text) - 1))
        file.write_bytes(text[:at] + data.draw(st.binary(min_size=1, max_size=1)) + text[at + 1 :])
    elif kind == "row":
        whole = json.loads(text)
        rows = whole["plc"]["851"]
        name = data.draw(st.sampled_from(sorted(rows)))
        rows[name] = data.draw(
            st.sampled_from([None, 5, [], ["", ""], ["00", 4], [rows[name][0], "zz"],
                             [rows[name][0], "00"], [*rows[name][:2], [1]],
                             [*rows[name][:2], [0, "MAIN.nothing", "", 5]],
                             [*rows[name][:2], [999, "MAIN.nTotal", "", 5]],
                             [*rows[name][:2], [0, "%M", "", 1 << 70]]])
        )  # fmt: skip
        file.write_text(json.dumps(whole))
    second = _leading(tmp_path)
    plc = second.plcs[851]
    second.advance(0.01)
    assert plc.state is PlcState.RUN, plc.failure
    if kind in ("whole", "cut"):
        assert plc.instance("MAIN")["nTotal"] == (11 if kind == "whole" else 1)
    second.save()
    third = _leading(tmp_path)
    assert third.plcs[851].instance("MAIN")["nTotal"] == plc.instance("MAIN")["nTotal"]


@pytest.mark.parametrize("place", [0, 3])
@pytest.mark.parametrize("wrong", [-1, "0", 0.5, None])
def test_offset_of_a_pointer_is_a_number_from_0(
    tmp_path: Path, saved: bytes, place: int, wrong: object, caplog: pytest.LogCaptureFixture
) -> None:
    document = json.loads(saved)
    document["plc"]["851"]["MAIN.p"][2][place] = wrong
    (tmp_path / "kept.json").write_text(json.dumps(document))
    PersistentData(parse({"system": {"persistent_data": "kept.json"}}, ""), tmp_path)
    assert "kept.json is damaged" in caplog.text
    assert "expected offsets from 0, got [" in caplog.text


LEADING = """
PROGRAM MAIN
VAR PERSISTENT nTotal : DINT; p : POINTER TO DINT; END_VAR
VAR RETAIN sName : STRING(9) := 'x'; END_VAR
VAR n : DINT; END_VAR
nTotal := nTotal + 1; n := n + 1;
IF p = 0 THEN p := ADR(n); END_IF
p^ := p^ + 1;
END_PROGRAM
"""


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.is_file())


async def file_appears(folder: Path, name: str) -> None:
    """Wait for a thread that writes a file, 10 CPU seconds at most."""
    end = time.process_time() + 10.0
    while name not in names(folder):
        assert time.process_time() < end, f"expected {name}, got {names(folder)}"
        await asyncio.sleep(0)


async def test_killed_station_goes_on_from_its_snapshot(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    first = station(tmp_path)
    async with first.running("127.0.0.1", 0, speed=0):
        travel(first)
        await file_appears(tmp_path, "kept.json.snapshot")
        shutil.copytree(tmp_path, killed := tmp_path / "killed")
        assert names(killed) == ["kept.json.snapshot"]
    assert names(tmp_path) == ["kept.json"]
    with caplog.at_level(logging.INFO):
        second = station(killed)
    assert shows(second) == [(30.0, 1), (0.0, 0)]
    assert "the last run was killed: using its snapshot of station time 3.000 s" in caplog.text
    assert "torn" not in caplog.text
    second.save()
    assert names(killed) == ["kept.json"]


async def test_nothing_is_written_while_a_plc_is_at_a_breakpoint_or_nothing_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The station is within a cycle then. `PlcRuntime.is_halted` says so."""
    (tmp_path / "a.st").write_text(PLC)
    system = {"persistent_data": "kept.json", "persistent_data_interval": "1ns"}
    built = Station(parse({"plc": [{"sources": "a.st"}], "system": system}, ""), base=tmp_path)
    async with built.running("127.0.0.1", 0, speed=0):
        for _ in range(50):
            await asyncio.sleep(0)
        assert names(tmp_path) == ["a.st"], "nothing has changed"
        with monkeypatch.context() as patch:
            patch.setattr(PlcRuntime, "is_halted", True)
            built.plcs[851].instance("MAIN")["nTotal"] = 4
            for _ in range(50):
                await asyncio.sleep(0)
            assert names(tmp_path) == ["a.st"]
        await file_appears(tmp_path, "kept.json.snapshot")


async def test_nothing_is_written_while_axes_are_at_standstill(tmp_path: Path) -> None:
    built = station(tmp_path)
    async with built.running("127.0.0.1", 0, speed=0):
        for _ in range(50):
            await asyncio.sleep(0)
        assert names(tmp_path) == []
        travel(built)
        await file_appears(tmp_path, "kept.json.snapshot")


async def test_interval_of_0_writes_at_the_end_only(tmp_path: Path) -> None:
    system = {"persistent_data": "kept.json", "persistent_data_interval": "0s"}
    built = Station(parse({"axis": AXES, "system": system}, ""), base=tmp_path)
    async with built.running("127.0.0.1", 0, speed=0):
        travel(built)
        for _ in range(50):
            await asyncio.sleep(0)
        assert names(tmp_path) == []
    assert names(tmp_path) == ["kept.json"]


@pytest.mark.parametrize("system", [{}, {"persistent_data": "a", "persistent_data_interval": "0s"}])
def test_no_snapshot_is_taken_without_file_or_interval(
    tmp_path: Path, system: dict[str, str]
) -> None:
    def capture() -> PersistentImage:
        raise AssertionError("a snapshot")

    data = PersistentData(parse({"system": system}, ""), tmp_path)
    asyncio.run(data.write_snapshots(capture))


def test_full_disk_leaves_a_snapshot_of_the_end(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    first = station(tmp_path)
    assert first.save()
    travel(first)
    (tmp_path / "kept.json.new").mkdir()
    assert first.save()
    assert "kept.json cannot be written: " in caplog.text
    assert shows(station(tmp_path)) == [(30.0, 1), (0.0, 0)]


def test_online_change_is_in_what_is_saved(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(PLC)
    document = {"plc": [{"sources": "a.st"}], "system": {"persistent_data": "kept.json"}}
    built = Station(parse(document, ""), base=tmp_path)
    built.advance(0.1)
    built.save()
    (tmp_path / "a.st").write_text(PLC.replace("VAR n : DINT", "VAR PERSISTENT n : DINT"))
    built.online_change()
    built.save()
    saved = json.loads((tmp_path / "kept.json").read_text())["plc"]["851"]
    assert saved.keys() == {"MAIN.nTotal", "MAIN.nParts", "MAIN.n"}


class Counts(Program):
    total = var(DINT, persistent=True)
    twice = var(DINT, retain=True)


CONFIG = parse({"system": {"persistent_data": "kept.json", "persistent_data_interval": "1ns"}}, "")


class Run:
    """A process: persistent data and a PLC that has loaded them."""

    def __init__(self, folder: Path, disk: FailingDisk) -> None:
        self.data = PersistentData(CONFIG, folder, disk)
        self.plcs = {851: PlcRuntime([Task("PlcTask", 10_000_000, [Counts])])}
        self.unit = self.plcs[851].unit(Counts)
        self.data.load(None, self.plcs, lambda: True)

    def count(self) -> None:
        self.unit.total += 1
        self.unit.twice += 2

    def snapshot(self) -> None:
        """One snapshot, by the task and the thread that a running station has."""
        calls = 0

        def capture() -> PersistentImage:
            nonlocal calls
            calls += 1
            if calls > 1:
                raise asyncio.CancelledError
            return self.data.capture(None, self.plcs, 0)

        with contextlib.suppress(asyncio.CancelledError):
            asyncio.run(self.data.write_snapshots(capture))

    def save(self) -> None:
        assert self.data.save(None, self.plcs, 0)


class Others(Program):
    total = var(DINT, persistent=True)
    a, b, c = (var(DINT, persistent=True) for _ in range(3))


@pytest.mark.parametrize(
    ("types", "message"),
    [
        ("", ""),
        ("c", "c are gone"),
        ("bc", "b, X.c are gone"),
        ("abc", "a, X.b, X.c are gone"),
        ("abct", "a, X.b, X.c and 1 more are gone"),
    ],
)
def test_log_names_three_variables_that_are_gone(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, types: str, message: str
) -> None:
    rows = {f"X.{name}": ("", b"") for name in types}
    saved = {name: (type, data.hex()) for name, (type, data) in rows.items()}
    document = {"nc": {}, "plc": {"851": saved} if saved else {}}
    (tmp_path / "kept.json").write_text(json.dumps(document))
    Run(tmp_path, FailingDisk())
    expected = f"persistent data of PLC 851: X.{message} or have another type" if message else ""
    assert [record.message for record in caplog.records] == [expected][: len(types)]


def test_plc_that_is_loaded_later_is_saved_with_its_own_variables(tmp_path: Path) -> None:
    run = Run(tmp_path, FailingDisk())
    run.save()
    others = PlcRuntime([Task("PlcTask", 10_000_000, [Others])])
    run.data.load(None, {851: others}, lambda: True)
    image = run.data.capture(None, {851: others}, 0)
    assert image.values().plcs[851].keys() == {"Others.total", "Others.a", "Others.b", "Others.c"}


@given(st.data())
@settings(max_examples=12)
def test_power_cut_loses_what_came_after_the_last_write(data: st.DataObject) -> None:
    """Any runs; cut in any operation of any snapshot or save, with any part of it written."""
    disk = FailingDisk()
    acknowledged = 0
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(data.draw(st.integers(1, 3), label="runs")):
            run = Run(Path(folder), disk)
            assert acknowledged <= run.unit.total, "what was written is there"
            assert run.unit.twice == 2 * run.unit.total, "of one moment"
            disk.left = data.draw(st.none() | st.integers(0, 6))
            cut = data.draw(st.integers(0, 80))
            disk.mix = lambda old, new, cut=cut: new[:cut] + old[cut:]  # type: ignore[misc]
            is_durable = data.draw(st.booleans())
            disk.is_kept = lambda durable=is_durable: durable  # type: ignore[misc]
            for act in data.draw(
                st.lists(st.sampled_from([Run.count, Run.snapshot, Run.save]), max_size=8)
            ):
                try:
                    act(run)
                except PowerCutError:
                    break
                if act is not Run.count:
                    acknowledged = run.unit.total
            latest, disk.left = run.unit.total, None
            assert acknowledged <= Run(Path(folder), disk).unit.total <= latest


@pytest.mark.parametrize("at", ["header", "layout", "both", "last"])
def test_damaged_snapshot_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, at: str
) -> None:
    """The one before the last is used; else the file."""
    disk = FailingDisk()
    run = Run(tmp_path, disk)
    run.save()
    for _ in range(2):
        run.count()
        run.snapshot()
    (path,) = disk.files
    content = bytearray(disk.files[path])
    for offset in {"header": [0], "layout": [60], "both": [4096, 8192], "last": [8192]}[at]:
        content[offset] ^= 1
    disk.files[path] = bytes(content)
    if at == "last":
        assert Run(tmp_path, disk).unit.total == 1
        assert "kept.json.snapshot: the last snapshot is torn, using the one before" in caplog.text
    else:
        assert Run(tmp_path, disk).unit.total == 0
        assert "kept.json.snapshot is damaged: " in caplog.text


def test_snapshot_that_means_something_else_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = SnapshotFile(tmp_path / "kept.json.snapshot")
    for layout in (b"", b"[]", b"{}", b'{"axes": 5}', b'{"axes":[],"plcs":{"1":{"rows":[]}}}'):
        file.write(Snapshot(layout, b"", 0))
        caplog.clear()
        PersistentData(CONFIG, tmp_path)
        assert "kept.json.snapshot is damaged: " in caplog.text
    file.remove()
    file.path.mkdir()
    PersistentData(CONFIG, tmp_path)
    assert "kept.json.snapshot cannot be read: not a regular file; reading " in caplog.text
