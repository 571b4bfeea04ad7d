"""Rows: layouts as the manuals write them, in both versions of TwinCAT; views at the axis."""

import struct

import pytest

from achse.codes.nc.row import READ, RW, WRITE, NcRow, at_axis, by_name, of_elements, struct_of

ROW = NcRow(0x15, "mask", RW, "UINT32", "INC", "range of the counter", 0, 0xFFFF)


@pytest.mark.parametrize(
    ("layout", "form", "names"),
    [
        ("REAL64", "<d", ()),
        ("VOID", "<", ()),
        ("STRING[31]", "<31s", ()),
        ("{BYTE[6]; UINT16; 2 unused; 3 INT32}", "<6sH2xiii", ()),
        ("{kind:UINT32; 4 unused; position:REAL64}", "<I4xd", ("kind", "position")),
    ],
)
def test_layout_has_a_struct_format(layout: str, form: str, names: tuple[str, ...]) -> None:
    assert struct_of(layout) == (form, names)


@pytest.mark.parametrize("layout", ["REAL64[n]", "LREAL", "{REAL64, REAL64}", "MotionPoint[n]"])
def test_layout_without_a_fixed_size_is_an_error(layout: str) -> None:
    with pytest.raises(ValueError, match="layout"):
        struct_of(layout)


def test_named_fields_are_packed_or_aligned() -> None:
    row = ROW._replace(layout="VOID or {kind:UINT16; position:REAL64; flag:UINT8; end:UINT32}")
    void, packed, aligned = row.layouts
    assert void == "VOID"
    assert struct_of(packed)[0] == "<HdBI"
    assert struct_of(aligned)[0] == "<H6xdB3xI"
    assert struct.calcsize("<H6xdB3xI") == struct.calcsize("@HdBI")


@pytest.mark.parametrize(
    "layout",
    ["{UINT32; REAL64}", "{kind:UINT32; 4 unused; position:REAL64}", "{a:UINT32; b:UINT32}"],
)
def test_other_structures_have_one_form(layout: str) -> None:
    assert ROW._replace(layout=layout).layouts == (layout,)


def test_rows_of_the_axis_are_named_and_placed_by_their_part() -> None:
    rows = (ROW, ROW._replace(offset=0x16, name="encoder_mode"), ROW._replace(offset=0x17))
    first, second = at_axis("encoder_", 0x1_0000, rows, without={0x17}, read_only={0x15})
    assert (first.offset, first.name, first.access) == (0x1_0015, "encoder_mask", READ)
    assert (second.offset, second.name, second.access) == (0x1_0016, "encoder_mode", RW)
    assert first.per_element
    assert second.per_element


def test_rows_of_elements_say_so() -> None:
    assert [row.per_element for row in (*of_elements(ROW), ROW)] == [True, False]
    assert by_name([ROW])["mask"] is ROW


@pytest.mark.parametrize(
    ("least", "most", "choices", "text"),
    [
        (None, None, None, ""),
        (0, None, None, "0.."),
        (None, 1e20, None, "..1e+20"),
        (1, 3, None, "1..3"),
        (0, 5, (0, 5), "(0, 5)"),
    ],
)
def test_range_in_words(
    least: float | None, most: float | None, choices: tuple[int, ...] | None, text: str
) -> None:
    row = ROW._replace(access=WRITE, least=least, most=most, choices=choices)
    assert row.range_text == text
