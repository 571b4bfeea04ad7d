"""The client's services: layouts, places, names that are nearly right."""

import pytest

from achse.ams import DecodeError
from achse.client.nc.services import (
    CYCLIC,
    FUNCTIONS,
    PARAMETERS,
    STATES,
    NcLayout,
    UnknownService,
    named,
    nearest_service,
    services,
)


@pytest.mark.parametrize(
    ("text", "values", "data"),
    [
        ("UINT16", (0x1234,), "3412"),
        ("REAL64", (1.0,), "000000000000f03f"),
        ("VOID", (), ""),
        ("STRING[4]", ("Xé",), "58e90000"),
        ("{a:UINT32; 4 unused; b:REAL64}", (1, 1.0), "0100000000000000000000000000f03f"),
        ("{UINT16; UINT16}", (1, 2), "01000200"),
    ],
)
def test_layouts_by_their_text(text: str, values: tuple[object, ...], data: str) -> None:
    layout = NcLayout(text)
    assert layout.encode(*values).hex() == data
    assert layout.size == len(data) // 2
    decoded = layout.decode(bytes.fromhex(data))
    if layout.names:
        assert tuple(decoded.values()) == values
    elif len(values) == 2:
        assert decoded == values
    else:
        assert decoded == (values[0] if values else None)


def test_a_text_is_cut_before_its_nul() -> None:
    assert NcLayout("STRING[4]").encode("abcdef") == b"abc\0"


@pytest.mark.parametrize("values", [(), (1, 2), ("x",), (1 << 40,), (-1,), (1.5,), (None,)])
def test_what_does_not_fit_is_a_value_error(values: tuple[object, ...]) -> None:
    with pytest.raises(ValueError, match=r"UINT32|expected"):
        NcLayout("UINT32").encode(*values)


def test_another_length_is_a_decode_error() -> None:
    with pytest.raises(DecodeError, match="4 bytes, got 3"):
        NcLayout("UINT32").decode(b"123")


@pytest.mark.parametrize("name", ["max_velocity", "Max Velocity", " max-velocity "])
def test_spaces_dashes_and_case_do_not_count(name: str) -> None:
    service = named((PARAMETERS,), name)
    assert (service.group, service.offset, service.access) == (0x4000, 0x27, "R W")
    assert service.unit_of("degree") == "degree/s"
    assert service.unit_of("") == service.unit


@pytest.mark.parametrize("name", ["max velocty", "", "\0", "x" * 1000])
def test_unknown_names_say_what_is_near(name: str) -> None:
    with pytest.raises(UnknownService, match="no service") as caught:
        named((PARAMETERS, STATES), name)
    assert ("did you mean max_velocity" in str(caught.value)) == (name == "max velocty")
    assert isinstance(caught.value, LookupError)


def test_choices_become_enumerations() -> None:
    kind = named((PARAMETERS,), "encoder_reference_mode").choices
    assert kind is not None
    assert kind(2).name == "HARDWARE_SYNC"
    assert kind.__name__ == "ReferenceMode"


def test_sub_elements_are_in_the_high_byte_of_the_offset() -> None:
    assert named((STATES,), "set_position").place(3, 2) == (0x4103, 0x20_000A)
    with pytest.raises(ValueError, match="sub-element 1"):
        named((PARAMETERS,), "max_velocity").place(3, 1)
    with pytest.raises(ValueError, match="sub-element 16"):
        named((STATES,), "set_position").place(3, 16)


def test_all_that_the_api_is_made_of_is_there() -> None:
    for name in ("universal_axis_start", "stop", "parameterized_stop", "reset", "home"):
        assert name in services()[FUNCTIONS]
    cyclic = services()[CYCLIC]["nc_to_plc_structure"]
    assert [layout.size for layout in cyclic.layouts] == [128, 256]


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("max velocty", "; did you mean max_velocity?"),
        ("Offset", "; did you mean position_offset?"),
        ("velocity", "; names with it: max_velocity, jog_velocity_slow"),
        ("xyz", ""),
        ("n", "; names with it: n_0, n_1, n_2, n_3, n_4, n_5, n_6, n_7 and 2 more"),
    ],
)
def test_a_word_of_many_names_is_not_guessed(name: str, hint: str) -> None:
    known = ["max_velocity", "jog_velocity_slow", "position_offset", *(f"n_{n}" for n in range(10))]
    assert nearest_service(name, known) == hint
