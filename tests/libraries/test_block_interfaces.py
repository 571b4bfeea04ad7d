"""Library blocks have the size and the interface that public symbol files give of the real ones."""

import csv
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from achse.iec.describe import describe_type, types_shown
from achse.iec.layout import TC3_X64, TC3_X86
from achse.iec.structs import StructType
from achse.iec.typetable import TypeTable
from achse.iec.variables import Section
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

_TABLE = Path(__file__).parents[1] / "data" / "block_interfaces.tsv"
_INTERFACE = (Section.INPUT, Section.OUTPUT, Section.IN_OUT)
_MOST_DIFFERENT = 36


class Member(NamedTuple):
    """A member of a block's interface."""

    name: str
    offset: int
    size: int


def _rows() -> list[dict[str, str]]:
    with _TABLE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def _real(row: Mapping[str, str]) -> tuple[int, list[Member]]:
    members = []
    for part in row["members"].split("; ") if row["members"] else ():
        head, _, spot = part.rpartition(" @")
        offset, _, size = spot.partition("+")
        members.append(Member(head.partition(" : ")[0].lower(), int(offset), int(size)))
    return int(row["bytes"]), members


@cache
def _blocks(pointer: int) -> Mapping[str, StructType[Any]]:
    names = sorted({row["block"] for row in _rows() if int(row["pointer"]) == pointer})
    variables = "".join(f"fb{number} : {name};" for number, name in enumerate(names))
    source = Source(f"PROGRAM MAIN VAR {variables} END_VAR END_PROGRAM", "main.st")
    rules = TC3_X64 if pointer == 8 else TC3_X86
    declared = declare([parse(source, name="MAIN")], rules=rules)
    members = declared.programs["main"].__iec__.members
    types = {name: member.type for name, member in zip(names, members, strict=True)}
    assert all(isinstance(type, StructType) for type in types.values())
    return types  # type: ignore[return-value]


def _ours(type: StructType[Any]) -> tuple[int, list[Member]]:
    interface = (member for member in type.shown if member.section in _INTERFACE)
    return type.size, [Member(one.name.lower(), one.offset, one.type.size) for one in interface]


@pytest.mark.parametrize("row", _rows(), ids=lambda row: f"{row['block']}-{row['pointer']}")
def test_block_has_the_interface_of_the_real_one(row: dict[str, str]) -> None:
    ours = _ours(_blocks(int(row["pointer"]))[row["block"]])
    if row["difference"]:
        assert ours != _real(row), "equal: remove the difference from the table"
    else:
        assert ours == _real(row)


def test_differences_get_fewer() -> None:
    assert sum(bool(row["difference"]) for row in _rows()) <= _MOST_DIFFERENT


def test_type_table_of_blocks_has_no_private_types() -> None:
    blocks = _blocks(8).values()
    shown = types_shown(blocks)
    names = {type.name for type in shown}
    assert not {"_ADSREAD", "ST_McOutputs", "_ST_McProbe"} & names
    table = TypeTable(describe_type(type) for type in shown)
    for block in blocks:
        entry = table.entry(block.name)
        assert entry is not None
        assert all(member.type_name for member in entry.members)
        ends = [member.offset + member.size for member in entry.members]
        assert max(ends) <= entry.size
        assert sum(member.size for member in entry.members) <= entry.size
        table.type(block.name)


def test_structure_with_blocks_is_encoded_by_its_visible_members() -> None:
    members = "tOn : TON; fbRise : R_TRIG; fbRead : ADSREAD; n : INT;"
    source = f"TYPE ST : STRUCT {members} END_STRUCT END_TYPE"
    declared = declare([parse(Source(source, "st.st"), name="st")])
    type = declared.types["st"]
    table = TypeTable(describe_type(one) for one in types_shown([type]))
    read = table.type("ST")
    assert isinstance(read, StructType)
    assert [member.offset for member in read.members] == [0, 32, 48, 224]
    entry = table.entry("ADSREAD")
    assert entry is not None
    assert [member.name for member in entry.members][-2:] == ["ERR", "ERRID"]
    data = read.encode({"tOn": {"IN": True}, "fbRise": {"M": True}, "n": 7})
    assert (len(data), data[8], data[42], data[224]) == (232, 1, 1, 7)
