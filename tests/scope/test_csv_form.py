"""The vendor's text form: header, metadata in their order, columns, blanks at the end."""

import csv
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.scope.csv_form import csv_text, write_csv
from achse.scope.data import ScopeBlock, ScopeData
from tests.scope.conftest import recording

KEYS = [
    "Name", "SymbolComment", "Data-Type", "SampleTime[ms]", "VariableSize", "SymbolBased",
    "IndexGroup", "IndexOffset", "SymbolName", "NetID", "Port", "Offset", "ScaleFactor", "BitMask",
    "Unit", "Unit ScaleFactor", "Unit Offset",
]  # fmt: skip
"""As in the files of scope 3.4 (camshaft_scope_facts B.3)."""


def test_the_head_has_name_and_times() -> None:
    lines = csv_text(recording(), "press.csv").split("\n")
    assert lines[:6] == [
        "Name\tpress 1",
        "File\tpress.csv",
        "Starttime of export\t134116992000000000\t2026-01-01\t00:00:00.000",
        "Endtime of export\t134116992000100000\t2026-01-01\t00:00:00.010",
        "",
        "",
    ]


def test_the_metadata_have_a_line_per_key_and_a_cell_per_column() -> None:
    lines = csv_text(recording()).split("\n")[6:]
    assert [line.split("\t")[0] for line in lines[: len(KEYS)]] == KEYS
    assert lines[len(KEYS)] == ""
    for key, line in zip(KEYS, lines, strict=False):
        cells = line.split("\t")
        assert (cells[0], cells[11], cells[13], len(cells)) == (key, key, key, 15)
    last = {key: line.split("\t")[14] for key, line in zip(KEYS, lines, strict=False)}
    assert last == {
        "Name": "level", "SymbolComment": "a b", "Data-Type": "INT16", "SampleTime[ms]": "4",
        "VariableSize": "2", "SymbolBased": "False", "IndexGroup": "16416", "IndexOffset": "8",
        "SymbolName": "", "NetID": "Local", "Port": "851", "Offset": "-1", "ScaleFactor": "0.5",
        "BitMask": "0xffffffffffffffff", "Unit": "mm", "Unit ScaleFactor": "1", "Unit Offset": "0",
    }  # fmt: skip


def test_columns_that_end_early_have_blanks() -> None:
    lines = csv_text(recording()).split("\n")[7 + len(KEYS) :]
    assert lines[-2:] == ["EOF", ""]
    rows = [line.split("\t") for line in lines[:-2]]
    assert [row[0] for row in rows] == ["0.0", "2.0", "4.0", "6.0", "8.0", "10.0"]
    assert [row[12] for row in rows] == ["1e-10", "-0.001", "10000.0", "-100000000000.0", " ", " "]
    assert [row[11] for row in rows] == ["0.0", "2.0", "4.0", "6.0", " ", " "]
    assert [row[13] for row in rows] == ["1.0", "5.0", "9.0", " ", " ", " "]
    assert [row[1] for row in rows] == ["0", "1"] * 3


def test_lines_of_a_file_end_as_in_the_field(tmp_path: Path) -> None:
    write_csv(recording(), tmp_path / "a.csv")
    content = (tmp_path / "a.csv").read_bytes()
    assert content.count(b"\r\n") == content.count(b"\n")
    assert content.decode().replace("\r\n", "\n") == csv_text(recording(), "a.csv")


def test_a_channel_without_samples_has_no_column() -> None:
    whole = recording()
    block = whole.blocks[1]
    none = ScopeBlock(0, 1, block.channels, block.types, (0,), b"")
    text = csv_text(ScopeData("a", (whole.blocks[0], none)))
    assert "level" not in text
    assert csv_text(ScopeData("a", ())).endswith("EOF\n")


TEXTS = st.one_of(
    st.text(st.sampled_from("=+-@\t\r\n ,;|\"'a1.e\uff1d\uff0b\uff0d\uff20\xa0"), max_size=8),
    st.text(st.characters(exclude_categories=["Cs"]), max_size=8),
)
SIGNS = ("=", "+", "-", "@", "\uff1d", "\uff0b", "\uff0d", "\uff20", "\t", "\r")


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


@given(texts=st.tuples(*[TEXTS] * 6), separator=st.sampled_from("\t,;|"), quoted=st.booleans())
def test_cells_are_no_formulas_whatever_names_and_units_are(
    texts: tuple[str, ...], separator: str, quoted: bool
) -> None:
    """As spreadsheets read them: with each separator, quotes dropped or not."""
    name, file, channel_name, symbol, comment, unit = texts
    whole = recording()
    block = whole.blocks[1]
    channel = replace(
        block.channels[0], name=channel_name, symbol=symbol, comment=comment, unit=unit
    )
    data = replace(whole, name=name, blocks=(whole.blocks[0], replace(block, channels=(channel,))))
    text = csv_text(data, file)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.csv"
        write_csv(data, path)
        assert path.read_text("utf-8").split("\n")[6:] == text.split("\n")[6:]
    heads = text.split("\n")[: 6 + len(KEYS)]
    assert [line.split("\t")[0] for line in heads[6:]] == KEYS
    style: Literal[0, 3] = csv.QUOTE_MINIMAL if quoted else csv.QUOTE_NONE
    for line in heads:
        for cell in next(csv.reader([line], delimiter=separator, quoting=style), []):
            start = cell.strip()
            in_numbers = all(map(is_number, filter(None, start.split("\t"))))
            assert in_numbers or not start.startswith(SIGNS), line


@pytest.mark.parametrize("text", ["-1.5", "+2", "-1e-3", "3.", "-.5", "1E+6", "a-b", "m/s", "'=1"])
def test_numbers_and_harmless_texts_stay(text: str) -> None:
    whole = recording()
    channel = replace(whole.blocks[1].channels[0], name=text, unit=text)
    blocks = (whole.blocks[0], replace(whole.blocks[1], channels=(channel,)))
    lines = csv_text(replace(whole, blocks=blocks)).split("\n")[6:]
    assert [lines[KEYS.index(key)].split("\t")[14] for key in ("Name", "Unit")] == [text, text]
