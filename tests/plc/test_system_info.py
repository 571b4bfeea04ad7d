"""`TwinCAT_SystemInfoVarList` as bytes."""

import struct

from achse.iec.system_types import APP_INFO, TASK_INFO
from achse.plc import Area, PlcRuntime, Task
from achse.plc.system_info import lists_of_runtime


def runtime(*tasks: Task, **options: object) -> PlcRuntime:
    return PlcRuntime(tasks, **options)  # type: ignore[arg-type]


def content(plc: PlcRuntime, name: str) -> bytes:
    placed = next(one for one in plc.variables if one.name.endswith(name))
    assert placed.area is Area.DATA
    return plc.memory[Area.DATA].read(placed.offset, placed.variable.type.size)


def test_both_structures_have_their_documented_size() -> None:
    assert (APP_INFO.size, TASK_INFO.size) == (256, 128)


def test_app_info_describes_the_application() -> None:
    plc = runtime(
        Task(), Task("Slow"), name="Station", project="Line 5", port=852, timestamp=0x5000_0000
    )
    data = content(plc, "._AppInfo")
    task_count, online_changes = struct.unpack_from("<II", data, 4)
    assert (task_count, online_changes) == (2, 0)
    assert struct.unpack_from("<H", data, 16) == (852,)
    assert struct.unpack_from("<I", data, 20) == (0x5000_0000,)
    assert data[64:128].rstrip(b"\0") == b"Station"
    assert data[128:192].rstrip(b"\0") == b"Line 5"


def test_task_info_follows_its_task() -> None:
    times = iter([0, 1_000_000, 0, 11_000_000, 0, 5_000])
    plc = runtime(
        Task("Fast", cycle_ns=10_000_000, priority=3),
        Task("Slow", cycle_ns=1_000_000_000, port=360),
        stopwatch=lambda: next(times),
    )
    fast, slow = content(plc, "._TaskInfo")[:128], content(plc, "._TaskInfo")[128:]
    assert struct.unpack_from("<IHH", fast, 4) == (100_000, 3, 350)
    assert struct.unpack_from("<IHH", slow, 4) == (10_000_000, 20, 360)
    assert (fast[64:128].rstrip(b"\0"), slow[64:128].rstrip(b"\0")) == (b"Fast", b"Slow")

    expected = [
        # cycle, time of the cycle, time the last one took, first, last exceeded
        (1, 10_000_000, 0, True, False),
        (2, 20_000_000, 10_000, False, False),
        (3, 30_000_000, 110_000, False, True),
    ]
    for row in expected:
        plc.run_due(row[1])
        live = struct.unpack_from("<IqI??", content(plc, "._TaskInfo"), 12)
        assert live == row


def test_names_that_do_not_fit_are_cut() -> None:
    plc = runtime(Task("x" * 100), name="ü" * 70, project="\u4e2d\0tail")
    data = content(plc, "._AppInfo")
    assert data[64:128] == b"\xfc" * 63 + b"\0"
    assert data[128:192].rstrip(b"\0") == b"?"
    assert content(plc, "._TaskInfo")[64:128] == b"x" * 63 + b"\0"


def test_a_check_declares_one_row_for_each_task_and_one_without_any() -> None:
    for names, rows in (((), 1), (("Fast", "Slow"), 2)):
        (unit,) = lists_of_runtime(map(Task, names))
        assert unit.__iec__.name == "TwinCAT_SystemInfoVarList"
        assert unit.__iec__.size >= APP_INFO.size + rows * TASK_INFO.size
        assert unit.__iec__.size < APP_INFO.size + (rows + 1) * TASK_INFO.size
