"""`TwinCAT_SystemInfoVarList`: data of the application and its tasks in every PLC."""

import struct
from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from achse.iec import ARRAY, UDINT, GlobalVariables, Variable
from achse.iec.system_types import APP_INFO, TASK_INFO
from achse.plc.program import PlacedVariable
from achse.plc.task import Task

_OBJECT_ID_OF_APP = 0x0850_2000
_OBJECT_ID_OF_FIRST_TASK = 0x0201_0030
"""Object ids as TwinCAT hands them out to the first PLC project and its tasks."""


SYSTEM_LIST = "TwinCAT_SystemInfoVarList"

_LIVE = struct.Struct("<IqI????")
"""CycleCount … RTViolation of a task, in one piece."""
_LIVE_OFFSET = 12
_ONLINE_CHANGES_OFFSET = 8


class _Named(Protocol):
    @property
    def name(self) -> str: ...


def lists_of_runtime(tasks: Iterable[_Named]) -> list[type[GlobalVariables]]:
    """Return the lists that a PLC with such tasks declares by itself, for a check."""
    runtime_tasks = [Task(task.name) for task in tasks] or [Task()]
    return [system_info_list(runtime_tasks, app_name="", project_name="", port=0, timestamp=0)]


def system_info_list(
    tasks: Sequence[Task], *, app_name: str, project_name: str, port: int, timestamp: int
) -> type[GlobalVariables]:
    """Return the list for these tasks: `_AppInfo` and `_TaskInfo[1..n]`.

    `timestamp`: when the application was made, seconds since 1970. Long names are cut to 63
    bytes of cp1252.
    """
    app = {
        "ObjId": _OBJECT_ID_OF_APP,
        "TaskCnt": len(tasks),
        "AdsPort": port,
        "AppTimestamp": timestamp & 0xFFFF_FFFF,
        "AppName": _fitting(app_name),
        "ProjectName": _fitting(project_name),
    }
    rows = [
        {
            "ObjId": _OBJECT_ID_OF_FIRST_TASK + 0x10 * index,
            "CycleTime": min(task.cycle_ns // 100, 0xFFFF_FFFF),
            "Priority": task.priority,
            "AdsPort": task.port,
            "TaskName": _fitting(task.name),
        }
        for index, task in enumerate(tasks)
    ]

    class SystemInfoList(GlobalVariables, name=SYSTEM_LIST):
        _AppInfo = Variable[Any, Any](APP_INFO, app)
        _TaskInfo = Variable[Any, Any](ARRAY(TASK_INFO, (1, len(tasks))), rows)

    return SystemInfoList


class SystemInfo:
    """Keeps the system info in data memory true."""

    __slots__ = ("_data", "_offsets", "_online_changes")

    def __init__(self, data: bytearray, variables: Sequence[PlacedVariable]) -> None:
        """`variables`: those of the list, in `data`."""
        offsets = {placed.variable.name: placed.offset for placed in variables}
        self._data = data
        self._online_changes = offsets["_AppInfo"] + _ONLINE_CHANGES_OFFSET
        self._offsets = offsets["_TaskInfo"] + _LIVE_OFFSET

    def show_task(self, index: int, task: Task) -> None:
        """Show the state of task number `index` (from 0) as its cycle begins."""
        _LIVE.pack_into(
            self._data,
            self._offsets + TASK_INFO.size * index,
            task.cycle_count,
            task.time_ns,
            min(task.last_exec_ns // 100, 0xFFFF_FFFF),
            task.first_cycle,
            task.exceeded,
            False,
            False,
        )

    def show_online_changes(self, count: int) -> None:
        """Write the number of online changes to the application's system information."""
        UDINT.codec.pack_into(self._data, self._online_changes, count & 0xFFFF_FFFF)


def _fitting(text: str) -> str:
    return text.encode("cp1252", "replace")[:63].split(b"\0")[0].decode("cp1252", "replace")
