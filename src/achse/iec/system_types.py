"""Types that PLC programs name without any library: what the system shows of tasks and itself.

Source: symbol files of TwinCAT 3 projects.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from achse.iec.elementary import BOOL, BYTE, DWORD, LINT, PVOID, UDINT, UINT
from achse.iec.layout import MemberOffset, TypeLayout
from achse.iec.strings import STRING
from achse.iec.structs import StructType
from achse.iec.times import DT
from achse.iec.types import IecType
from achse.iec.variables import Variable


def _structure(
    name: str, size: int, rows: Sequence[tuple[int, str, IecType[Any]]]
) -> StructType[Any]:
    """Return a structure with members at given offsets; the gaps are reserved."""
    members = [Variable[Any, Any](type, name=member) for _, member, type in rows]
    return StructType(
        name,
        members,
        layout=TypeLayout(size, 8, tuple(MemberOffset(offset) for offset, _, _ in rows)),
    )


APP_INFO = _structure(
    "PLC.PlcAppSystemInfo",
    256,
    [
        (0, "ObjId", UDINT),
        (4, "TaskCnt", UDINT),
        (8, "OnlineChangeCnt", UDINT),
        (12, "Flags", DWORD),
        (16, "AdsPort", UINT),
        (18, "BootDataLoaded", BOOL),
        (19, "OldBootData", BOOL),
        (20, "AppTimestamp", DT),
        (24, "KeepOutputsOnBP", BOOL),
        (25, "ShutdownInProgress", BOOL),
        (26, "LicensesPending", BOOL),
        (27, "BSODOccured", BOOL),
        (28, "LoggedIn", BOOL),
        (29, "PersistentStatus", BYTE),
        (32, "TComSrvPtr", PVOID),
        (64, "AppName", STRING(63)),
        (128, "ProjectName", STRING(63)),
    ],
)
"""Type of `_AppInfo`."""

TASK_INFO = _structure(
    "PLC.PlcTaskSystemInfo",
    128,
    [
        (0, "ObjId", UDINT),
        (4, "CycleTime", UDINT),
        (8, "Priority", UINT),
        (10, "AdsPort", UINT),
        (12, "CycleCount", UDINT),
        (16, "DcTaskTime", LINT),
        (24, "LastExecTime", UDINT),
        (28, "FirstCycle", BOOL),
        (29, "CycleTimeExceeded", BOOL),
        (30, "InCallAfterOutputUpdate", BOOL),
        (31, "RTViolation", BOOL),
        (64, "TaskName", STRING(63)),
    ],
)
"""Type of the elements of `_TaskInfo`; times in 100 ns, DcTaskTime in ns."""

SYSTEM_TYPES: Mapping[str, IecType[Any]] = {
    "plctasksysteminfo": TASK_INFO,
    "plcappsysteminfo": APP_INFO,
}
"""These types by name, in lower case."""
