"""The process image: every row of the manual has its word."""

import csv
from pathlib import Path

import pytest

from achse.camshaft.image import INPUTS, OUTPUTS, CamInput, CamOutput

ROWS = Path(__file__).parents[1] / "data" / "camshaft_process_image.tsv"

with ROWS.open(encoding="utf-8") as file:
    IMAGE = list(csv.DictReader(file, delimiter="\t"))


def test_the_table_is_whole() -> None:
    assert len(IMAGE) == 35
    assert len(IMAGE) == len(CamInput) + len(CamOutput)


@pytest.mark.parametrize("row", IMAGE, ids=lambda row: f"{row['image']} {row['offset']}")
def test_each_row_is_a_word(row: dict[str, str]) -> None:
    """`+n` with one output group: n = 0."""
    words = {"input": CamInput, "output": CamOutput}[row["image"]]
    offset = int(row["offset"].removesuffix("+n"), 16)
    assert words(offset // 4).name == row["word"]


def test_sizes() -> None:
    assert (INPUTS.size, OUTPUTS.size) == (0x48, 0x44)
