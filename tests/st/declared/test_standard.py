"""The library that every project can name."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from achse import libraries
from achse.iec import StructType
from achse.native.backend.cache import ObjectCache
from achse.st.check import check
from achse.st.declare import declare
from achse.st.declared.standard import library_files
from achse.st.lexis.source import Source
from achse.st.syntax.parser import Parsed, parse


@pytest.fixture
def parsed_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Library files in the order they are parsed, from an empty cache on: those of two folders."""
    paths: list[str] = []
    files = library_files()

    def noted(source: Source, **options: Any) -> Parsed:
        paths.append(source.path)
        return parse(source, **options)

    monkeypatch.setattr("achse.st.declared.standard.parse", noted)
    monkeypatch.setenv("ACHSE_CACHE_DIR", str(tmp_path / "cache"))
    few = [
        each for each in libraries.sources() if each[0].startswith(("language/", "tc2_standard"))
    ]
    monkeypatch.setattr(libraries, "sources", lambda: few)
    library_files.cache_clear()
    yield paths
    library_files.cache_clear()
    monkeypatch.undo()
    assert len(library_files()) == len(files)


def test_a_file_is_parsed_once_a_project_names_a_unit_of_it(parsed_files: list[str]) -> None:
    every = [source.path for source in (file.source for file in library_files())]
    assert parsed_files == every  # what they declare is not known yet
    parsed_files.clear()
    library_files.cache_clear()
    check(declare([parse("PROGRAM P VAR n : INT; END_VAR n := n + 1; END_PROGRAM")]))
    assert parsed_files == []
    check(declare([parse("PROGRAM P VAR t : TON; END_VAR t(IN := TRUE); END_PROGRAM")]))
    assert parsed_files == ["tc2_standard/timers.st"]
    check(declare([parse("PROGRAM P VAR t : TOF; r : R_TRIG; END_VAR END_PROGRAM")]))
    assert parsed_files == ["tc2_standard/timers.st", "tc2_standard/edges.st"]


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b"[[1]]", b'"x"', b"\xff", b"[[[]]]"])
def test_a_list_of_units_that_is_damaged_is_made_again(
    parsed_files: list[str], tmp_path: Path, content: bytes
) -> None:
    expected = [file.outlines for file in library_files()]
    (cache_file,) = tmp_path.glob("cache/*.o")
    ObjectCache("libraries", cache_file.stem.removeprefix("libraries-")).save(content)
    parsed_files.clear()
    library_files.cache_clear()
    assert [file.outlines for file in library_files()] == expected
    assert len(parsed_files) == len(expected)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders of a user are the user's")
@pytest.mark.parametrize("mode", [0o722, 0o770, 0o777])
def test_a_list_of_units_that_others_may_have_written_is_not_loaded(
    parsed_files: list[str], tmp_path: Path, mode: int
) -> None:
    library_files()
    (tmp_path / "cache").chmod(mode)
    parsed_files.clear()
    library_files.cache_clear()
    assert len(library_files()) == len(parsed_files)


def test_another_parser_lists_the_units_again(
    parsed_files: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    library_files()
    parsed_files.clear()
    library_files.cache_clear()
    monkeypatch.setattr("achse.st.declared.standard._READERS", ())
    assert len(library_files()) == len(parsed_files)


@pytest.mark.parametrize(
    ("name", "size", "members"),
    [
        # 8 bytes table pointer, IN at 8, PT at 12, Q at 16, ET at 20, M at 24, StartTime at 28.
        ("TON", 32, {"IN": 8, "PT": 12, "Q": 16, "ET": 20, "M": 24, "StartTime": 28}),
        ("TOF", 32, {"M": 24}),
        ("TP", 32, {"ET": 20, "StartTime": 24}),
        ("LTON", 56, {"PT": 16, "ET": 32, "StartTime": 48}),
        ("R_TRIG", 16, {"CLK": 8, "Q": 9, "M": 10}),
        ("CTUD", 24, {"CU": 8, "LOAD": 11, "PV": 12, "QD": 15, "CV": 16, "MD": 19}),
        ("GUID", 16, {"Data4": 8}),
        ("AMSADDR", 8, {"port": 6}),
        # Six numbers up to 20, a class, 80 bytes of text, three numbers of 4, an area, 40 and 80.
        ("__SYSTEM.VAR_INFO", 240, {"BitNo": 12, "TypeClass": 20, "TypeName": 24, "Symbol": 120}),
        ("__SYSTEM.AnyType", 24, {"pvalue": 8, "diSize": 16}),
    ],
)
def test_layouts(name: str, size: int, members: dict[str, int]) -> None:
    text = f"PROGRAM P VAR x : {name}; END_VAR END_PROGRAM"
    (variable,) = declare([parse(text)]).programs["p"].__iec__.members
    assert isinstance(variable.type, StructType)
    assert variable.type.size == size
    for member, offset in members.items():
        assert variable.type.member(member).offset == offset


def test_constants() -> None:
    text = "PROGRAM P VAR x : LREAL := PI; s : T_MaxString; END_VAR END_PROGRAM"
    x, s = declare([parse(text)]).programs["p"].__iec__.members
    assert x.initial == pytest.approx(3.141592653589793)
    assert s.type.size == 256


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("__SYSTEM.TYPE_CLASS := __SYSTEM.TYPE_CLASS.TYPE_BITCONST", 38),
        ("__SYSTEM.MEMORY_AREA := __SYSTEM.MEMORY_AREA.MEM_LOCAL", 5),
        ("__SYSTEM.ExceptionCode := __SYSTEM.ExceptionCode.RTSEXCPT_DIVIDEBYZERO", 0x102),
    ],
)
def test_values_of_system_enumerations(text: str, value: int) -> None:
    (x,) = (
        declare([parse(f"PROGRAM P VAR x : {text}; END_VAR END_PROGRAM")])
        .programs["p"]
        .__iec__.members
    )
    assert x.initial == value
    assert x.type.size == 4


def test_inputs_of_any_type_are_descriptions_of_what_is_passed() -> None:
    text = "FUNCTION_BLOCK FB VAR_INPUT a : ANY; b : ANY_NUM; END_VAR END_FUNCTION_BLOCK"
    block = declare([parse(text)]).types["fb"]
    assert isinstance(block, StructType)
    assert block.size == 8 + 2 * 24
    declare([parse("FUNCTION F : INT VAR_INPUT a : ANY; END_VAR END_FUNCTION")])


def test_lists_of_libraries_may_bear_the_name_that_projects_know() -> None:
    text = "PROGRAM P VAR a : BOOL; n : DWORD; END_VAR a := Constants.bLittleEndian;"
    text += " n := __SYSTEM.Constants.CompilerVersionNumeric; END_PROGRAM"
    assert check(declare([parse(Source(text, "P.st"))])).faults == ()
