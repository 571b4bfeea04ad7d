"""Parameters: every row of the manual with offset, size, access and range; complete sets."""

import csv
import re
import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.camshaft.parameters import (
    CAM_PARAMETERS,
    CAM_SET,
    CONTROLLER_PARAMETERS,
    CONTROLLER_SET,
    ENCODER_PARAMETERS,
    ENCODER_SET,
    CamParameter,
    CamParameterError,
    CamSet,
)

FILE = Path(__file__).parents[1] / "data" / "camshaft_services.tsv"

with FILE.open(encoding="utf-8") as file:
    ROWS = [
        row
        for row in csv.DictReader(file, delimiter="\t")
        if row["area"] in ("encoder", "controller", "cam") and "[n]" not in row["data_type"]
    ]

OF = {
    "encoder": ENCODER_PARAMETERS,
    "controller": CONTROLLER_PARAMETERS,
    "cam": CAM_PARAMETERS,
}
SETS = {"encoder": ENCODER_SET, "controller": CONTROLLER_SET, "cam": CAM_SET}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['area']} {row['index_offset']}")
def test_each_row_is_a_parameter(row: dict[str, str]) -> None:
    offset = int(row["index_offset"], 16)
    [parameter] = [each for each in OF[row["area"]] if each.offset == offset]
    assert {"UINT8": "B", "UINT32": "I"}[row["data_type"]] == parameter.code
    assert parameter.writable == (row["access"] == "R/W")
    printed = re.fullmatch(r"(\d+(?:\.\d+)?)[-/](\d+(?:\.\d+)?)(?: (ms|s))?", row["range"] or "")
    if printed and parameter.name != "type":  # 0-3 in the range, 4 in the text
        # times are printed in ms or s, and count in ms or 0.1 ms
        scale = {None: 1, "ms": 10, "s": 1000}[printed[3]]
        assert parameter.least == float(printed[1]) * scale
        assert parameter.most == float(printed[2]) * scale


def test_nothing_else_is_there() -> None:
    for area, parameters in OF.items():
        rows = {int(row["index_offset"], 16) for row in ROWS if row["area"] == area}
        extra = {0x201, 0x202, 0x210} if area == "encoder" else set()
        assert {each.offset for each in parameters} == rows | extra


def test_the_sizes_of_complete_sets() -> None:
    assert (ENCODER_SET.size, CONTROLLER_SET.size, CAM_SET.size) == (12, 61, 44)


@given(st.sampled_from(sorted(SETS)), st.data())
def test_a_set_gives_back_what_it_took(area: str, data: st.DataObject) -> None:
    values = {
        each.name: data.draw(st.integers(each.least, each.most), each.name) for each in OF[area]
    }
    taken = SETS[area].decode(SETS[area].encode(values))
    assert taken == {name: values[name] for name in taken}
    missing = values.keys() - taken.keys()
    assert missing == {"encoder": set(), "controller": {"configured_cams", "actual_rate"}}.get(
        area, {"brake_enabled"}
    )


@given(st.sampled_from(sorted(SETS)), st.data())
def test_a_set_with_one_value_outside_is_refused(area: str, data: st.DataObject) -> None:
    found: CamSet = SETS[area]
    limited = [
        each
        for each in found.parameters
        if each.writable
        and each.name != "actual_rate"
        and each.most < 2 ** (8 * struct.calcsize(each.code) - 1)
    ]
    wrong = data.draw(st.sampled_from(limited))
    values = {each.name: each.least for each in found.parameters} | {wrong.name: wrong.most + 1}
    with pytest.raises(CamParameterError, match=f"{wrong.name} = {wrong.most + 1}, expected"):
        found.decode(found.encode(values))


def test_check_tells_range_and_unit() -> None:
    start: CamParameter = CAM_PARAMETERS[1]
    assert start.check(359) == 359
    with pytest.raises(CamParameterError, match=r"start = 360, expected 0\.\.359 degree"):
        start.check(360)
