"""What drives store outlives the program, in a file people can read."""

import json
from pathlib import Path

import pytest

from achse.drive import PowerState, VirtualDrive
from achse.drive.objects.communication import SAVE
from achse.station.slaves.parameter_file import ParameterFile, ParameterFileError


def test_what_a_drive_stores_another_program_finds(tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    drive = VirtualDrive(store=ParameterFile(path).of(2))
    drive.set(0x6085, 4711)
    drive.set(0x1010, SAVE, 1)
    drive.run(1.0)
    assert json.loads(path.read_text())["2"]["6085:00"] == 4711
    again = ParameterFile(path)
    assert VirtualDrive(store=again.of(2)).get(0x6085) == 4711
    assert VirtualDrive(store=again.of(1)).get(0x6085) != 4711


def test_number_has_the_type_of_its_object(tmp_path: Path) -> None:
    """0x6085 is a U32, 0x3210 a REAL32; JSON of other programs may have either form."""
    path = tmp_path / "kept.json"
    path.write_text('{"1": {"6085:00": 4711.0, "3210:00": 0.5, "3211:00": 2}}')
    values = dict(ParameterFile(path).of(1))
    assert values == {0x608500: 4711, 0x321000: 0.5, 0x321100: 2}
    assert type(values[0x608500]) is int


def test_index_and_subindex_are_hexadecimal(tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    path.write_text('{"1": {"1C32:0B": 5, "1c33:b": 6}}')
    assert dict(ParameterFile(path).of(1)) == {0x1C320B: 5, 0x1C330B: 6}


def test_drive_without_values_is_not_in_the_file(tmp_path: Path) -> None:
    file = ParameterFile(tmp_path / "kept.json")
    file.of(1)
    file.of(2)[0x321012] = 7
    assert json.loads((tmp_path / "kept.json").read_text()) == {"2": {"3210:12": 7}}


def test_deleted_value_is_gone_for_another_program(tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    store = ParameterFile(path).of(1)
    store.update({0x608500: 1, 0x608300: 2})
    del store[0x608500]
    assert dict(ParameterFile(path).of(1)) == {0x608300: 2}


def test_without_a_path_it_lasts_as_long_as_the_program() -> None:
    store = ParameterFile(None).of(1)
    store[0x608500] = 1
    assert dict(store) == {0x608500: 1}
    del store[0x608500]
    assert len(store) == 0


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        '{"1": 5}',
        '{"x": {}}',
        '{"1": {"6085": 1}}',
        '{"1": {"5000:00": 1}}',
        '{"1": {"6085:00": "1"}}',
        '{"1": {"6085:00": -1}}',
        '{"1": {"6085:00": true}}',
    ],
)
def test_a_file_that_is_none_is_reported(tmp_path: Path, text: str) -> None:
    path = tmp_path / "kept.json"
    path.write_text(text)
    with pytest.raises(ParameterFileError, match=r"kept\.json: expected a table"):
        ParameterFile(path)


def test_a_file_that_cannot_be_read_is_reported(tmp_path: Path) -> None:
    with pytest.raises(ParameterFileError):
        ParameterFile(tmp_path)


def test_a_file_that_cannot_be_written_is_an_alarm_of_the_drive(tmp_path: Path) -> None:
    drive = VirtualDrive(store=ParameterFile(tmp_path / "missing" / "kept.json").of(1))
    drive.set(0x1010, SAVE, 1)
    drive.run(1.0)
    assert drive.power_state is PowerState.FAULT
    assert drive.get(0x603F) == 0xFF27
    drive.reset_fault()
