""".tpy read: TwinCAT 2 names, groups and places."""

import contextlib
import random

import pytest

from achse.iec import Address, StructType
from achse.iec.structs import RecordKind
from achse.iec.variables import Section
from achse.st.lexis.source import SourceError
from achse.st.symbolfiles import FileTask, read_tpy


def test_name_port_and_tasks(tpy: bytes) -> None:
    file = read_tpy(tpy, "pool.tpy")
    assert (file.name, file.port, file.pointer_size) == ("Pool", 811, 4)
    assert file.tasks == [FileTask("Standard", 20_000_000, 3, ("prgMain",))]


def test_variables_lie_where_group_and_offset_say(tpy: bytes) -> None:
    file = read_tpy(tpy, "pool.tpy")
    assert {item.name: item.declared.address for item in file.variables} == {
        ".bPump": Address("M", "X", 3, 3),
        ".nPower": Address("M", "", 6),
        "prgMain.fbTimer": Address("D", "", 9510),
        "prgMain.eMode": Address("Q", "", 2),
        ".CODES": Address("D", "", 9600),
    }
    by_name = {item.name: item for item in file.variables}
    assert by_name[".CODES"].declared.constant
    assert by_name[".bPump"].is_global
    assert by_name["prgMain.eMode"].declared.comment == "summer"


def test_function_blocks_keep_the_layout_of_the_file(tpy: bytes) -> None:
    timer = next(type for type in read_tpy(tpy, "pool.tpy").types if type.name == "TON")
    assert isinstance(timer, StructType)
    assert timer.kind is RecordKind.FUNCTION_BLOCK
    assert timer.size == 18
    assert [(m.name, m.offset, m.section) for m in timer.members] == [
        ("IN", 0, Section.INPUT),
        ("PT", 2, Section.LOCAL),
    ]
    assert timer.members[0].comment == "starts the timer"


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("<IGroup>16448<", "<IGroup>17<", "expected <IGroup> one of 16416"),
        ("<IOffset>9510<", "<IOffset>none<", "<IOffset>: expected a whole number"),
        ("PlcProjectInfo", "TcModuleClass", "expected <PlcProjectInfo>"),
        ("<IOffset>9510<", "<IOffset>4294967295<", "lies beyond"),
    ],
)
def test_a_fault_is_named_with_file_and_line(tpy: bytes, old: str, new: str, fault: str) -> None:
    with pytest.raises(SourceError, match=r"^pool\.tpy:\d+:\d+: .*" + fault):
        read_tpy(tpy.decode().replace(old, new).encode(), "pool.tpy")


def test_mutilated_files_give_located_errors_only(tpy: bytes) -> None:
    chance = random.Random(11)
    for _ in range(300):
        data = bytearray(tpy)
        start = chance.randrange(len(data))
        data[start : start + chance.randrange(30)] = chance.randbytes(chance.randrange(4))
        with contextlib.suppress(SourceError):
            read_tpy(bytes(data), "f.tpy").units()
