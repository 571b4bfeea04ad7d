"""Parameters: every row of the manual with offset, size, access and range; complete sets."""

import csv
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
    LISTED = list(csv.DictReader(file, delimiter="\t"))
WHOLE_SETS = {"encoder": 0x200, "controller": 0, "cam": 0}
ROWS = [row for row in LISTED if int(row["offset"], 16) != WHOLE_SETS[row["part"]]]

OF = {
    "encoder": ENCODER_PARAMETERS,
    "controller": CONTROLLER_PARAMETERS,
    "cam": CAM_PARAMETERS,
}
SETS = {"encoder": ENCODER_SET, "controller": CONTROLLER_SET, "cam": CAM_SET}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['part']} {row['offset']}")
def test_each_row_is_a_parameter(row: dict[str, str]) -> None:
    offset = int(row["offset"], 16)
    [parameter] = [each for each in OF[row["part"]] if each.offset == offset]
    assert struct.calcsize(parameter.code) == int(row["bytes"])
    assert parameter.writable == (row["set_by_clients"] == "yes")
    if row["most"]:
        assert (parameter.least, parameter.most) == (int(row["least"]), int(row["most"]))


def test_nothing_else_is_there() -> None:
    for part, parameters in OF.items():
        offsets = {int(row["offset"], 16) for row in ROWS if row["part"] == part}
        assert {each.offset for each in parameters} == offsets


@pytest.mark.parametrize("part", SETS)
def test_a_complete_set_has_its_size(part: str) -> None:
    [size] = [
        int(row["bytes"])
        for row in LISTED
        if row["part"] == part and int(row["offset"], 16) == WHOLE_SETS[part]
    ]
    assert SETS[part].size == size


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
    result: CamSet = SETS[area]
    limited = [
        each
        for each in result.parameters
        if each.writable
        and each.name != "actual_rate"
        and each.most < 2 ** (8 * struct.calcsize(each.code) - 1)
    ]
    wrong = data.draw(st.sampled_from(limited))
    values = {each.name: each.least for each in result.parameters} | {wrong.name: wrong.most + 1}
    with pytest.raises(CamParameterError, match=f"{wrong.name} = {wrong.most + 1}, expected"):
        result.decode(result.encode(values))


def test_check_reports_range_and_unit() -> None:
    start: CamParameter = CAM_PARAMETERS[1]
    assert start.check(359) == 359
    with pytest.raises(CamParameterError, match=r"start = 360, expected 0\.\.359 degree"):
        start.check(360)
