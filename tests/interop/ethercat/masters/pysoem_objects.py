"""pysoem reads a drive's whole dictionary in every way, and takes wrong steps; JSON on stdout.

`pysoem_objects.py INTERFACE MS WHAT`; WHAT is `dictionary`, `values` or `steps`.
"""

import struct
from collections.abc import Callable
from typing import Any

import pysoem
from pysoem_bus import Report, abort_of, run

VAR = 7
WRITE = 0x38
"""Access bits; a count that can be written says how many entries a list has now."""


def dictionary(master: Any, report: Report) -> None:
    """The dictionary by SDO information; records and arrays whole and entry by entry."""
    master.config_init()
    drive = master.slaves[0]
    objects = drive.od
    report["objects"] = [
        [
            each.index,
            each.name,
            each.object_code,
            each.data_type,
            [
                [entry.name, entry.data_type, entry.bit_length, entry.obj_access]
                for entry in each.entries
            ],
        ]
        for each in objects
    ]
    report["differs"] = differs = []
    report["records"] = 0
    for each in objects:
        if each.object_code == VAR:
            continue
        report["records"] += 1
        whole = drive.sdo_read(each.index, 0, 4096, True)
        count = drive.sdo_read(each.index, 0)
        last = count[0] if each.entries[0].obj_access & WRITE else 0xFF
        parts = [count + b"\0"]
        parts += [
            drive.sdo_read(each.index, subindex)
            for subindex, entry in enumerate(each.entries[1:], 1)
            if subindex <= last and entry.bit_length
        ]
        if whole != b"".join(parts):
            differs.append([hex(each.index), whole.hex(), [part.hex() for part in parts]])


def values(master: Any, report: Report) -> None:
    """What every entry of the dictionary holds, or the abort code it is refused with."""
    master.config_init()
    drive = master.slaves[0]

    def value(index: int, subindex: int) -> str:
        try:
            return str(drive.sdo_read(index, subindex).hex())
        except pysoem.SdoError as refusal:
            return f"{refusal.abort_code:08X}"

    report["values"] = [
        [each.index, subindex, value(each.index, subindex)]
        for each in drive.od
        for subindex in range(max(len(each.entries), 1))
    ]


def steps(master: Any, report: Report) -> None:
    """The mapping procedure with a wrong step at every point; then it still succeeds."""
    master.config_init()
    drive = master.slaves[0]

    def write(index: int, subindex: int, form: str, value: int) -> Callable[[], None]:
        return lambda: drive.sdo_write(index, subindex, struct.pack("<" + form, value))

    refused: dict[str, str] = {}
    report["aborts"] = refused

    def wrong(name: str, index: int, subindex: int, form: str, value: int) -> None:
        refused[name] = abort_of(write(index, subindex, form, value))

    wrong("count while assigned", 0x1600, 0, "B", 0)
    wrong("entry while assigned", 0x1600, 7, "I", 0x607F0020)
    wrong("PDO while assigned", 0x1C12, 1, "H", 0x1601)
    wrong("count of nine while assigned", 0x1600, 0, "B", 9)
    write(0x1C12, 0, "B", 0)()
    wrong("entry while counted", 0x1600, 7, "I", 0x607F0020)
    write(0x1600, 0, "B", 0)()
    wrong("not in the dictionary", 0x1600, 1, "I", 0x50000020)
    wrong("not mappable", 0x1600, 1, "I", 0x605A0010)
    wrong("read-only object received", 0x1600, 1, "I", 0x60640020)
    wrong("wrong length", 0x1600, 1, "I", 0x607A0010)
    wrong("ninth entry", 0x1600, 9, "I", 0x607A0020)
    write(0x1600, 0, "B", 9)()
    wrong("nine objects", 0x1C12, 0, "B", 1)
    write(0x1600, 0, "B", 0)()
    write(0x1600, 1, "I", 0x60400010)()
    write(0x1600, 2, "I", 0x60400010)()
    write(0x1600, 0, "B", 2)()
    wrong("object twice", 0x1C12, 0, "B", 1)
    write(0x1600, 0, "B", 0)()
    wrong("no such PDO", 0x1C12, 1, "H", 0x1604)
    wrong("a PDO of the other direction", 0x1C12, 1, "H", 0x1A00)
    wrong("two PDOs", 0x1C12, 0, "B", 2)
    write(0x1600, 2, "I", 0x607A0020)()
    wrong("count not a byte", 0x1600, 0, "H", 2)
    write(0x1600, 0, "B", 2)()
    write(0x1C12, 1, "H", 0x1600)()
    write(0x1C12, 0, "B", 1)()
    report["mapped"] = [drive.sdo_read(0x1600, sub).hex() for sub in range(3)]


if __name__ == "__main__":
    run({"dictionary": dictionary, "values": values, "steps": steps})
