"""The station of a unit: image, inputs, journal."""

import struct
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.fmu.errors import ExportError
from achse.fmu.model import Model, ModelError, UnitFile, as_unit
from achse.fmu.protocol import ROW
from achse.fmu.variables import UnitVariable, ValueType, VariableChoice, chosen_variables
from achse.station import Station
from achse.station.configuration.station_file import load

MS = 1_000_000


@pytest.fixture
def unit(station_file: Path) -> UnitFile:
    choice = VariableChoice(parameters=["MAIN.fGain", "MAIN.sText"], locals=["MAIN.*"])
    variables = chosen_variables(Station.load(station_file), choice)
    return UnitFile("{token}", station_file.name, variables)


def place_of(model: Model, name: str) -> slice:
    reference = [each.name for each in model.unit.variables].index(name)
    *_, offset, size = ROW.unpack(model.rows[reference])
    return slice(offset, offset + size)


def inputs_with(model: Model, **values: bytes) -> bytes:
    """Return the inputs of a model with the values of `MAIN.name`."""
    inputs = bytearray(model.image[: model.input_size])
    for name, data in values.items():
        inputs[place_of(model, f"MAIN.{name}")] = data
    return bytes(inputs)


def test_unit_file_is_read_as_it_was_written(unit: UnitFile, tmp_path: Path) -> None:
    (tmp_path / "unit.json").write_text(unit.text(), encoding="utf-8")
    assert UnitFile.read(tmp_path) == unit


def test_inputs_act_and_outputs_show(unit: UnitFile, tmp_path: Path) -> None:
    model = Model(tmp_path, unit)
    model.apply(
        inputs_with(
            model,
            bGo=b"\1",
            fLevel=struct.pack("<f", 4.0),
            aIn=struct.pack("<3h", 1, 20, 3),
            fGain=struct.pack("<d", 0.5),
            sText="ÄÖ".encode().ljust(42, b"\0"),
        )
    )
    model.go_to(10 * MS)
    assert model.image[place_of(model, "MAIN.bOut")] == b"\1"
    assert model.image[place_of(model, "MAIN.fOut")] == struct.pack("<f", 22.0)
    assert model.station.plcs[851].instance("MAIN")["sText"] == "ÄÖ"


def test_steps_end_with_the_last_whole_cycle(unit: UnitFile, tmp_path: Path) -> None:
    model, station = Model(tmp_path, unit), Station.load(tmp_path / unit.station)
    for time_ns in (1 * MS, 3 * MS, 9_999_999, 25 * MS):
        model.go_to(time_ns)
        station.advance((time_ns - time_ns % station.tick_ns - station.time_ns) / 1e9)
        assert model.station.digest() == station.digest()
    assert station.time_ns == 24 * MS


@settings(
    max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    steps=st.lists(st.tuples(st.integers(0, 30 * MS), st.integers(-(2**15), 2**15 - 1)), max_size=8)
)
def test_packed_state_goes_on_like_the_original(
    unit: UnitFile, tmp_path: Path, steps: list[tuple[int, int]]
) -> None:
    model = Model(tmp_path, unit)
    now = 0
    for step, speed in steps:
        model.apply(inputs_with(model, nSpeed=struct.pack("<h", speed if speed != 10 else 0)))
        now += step
        model.go_to(now)
    twin, elapsed = Model.unpack(tmp_path, unit, model.pack(1.25))
    assert elapsed == 1.25
    assert twin.image == model.image
    for each in (model, twin):
        each.apply(inputs_with(each, bGo=b"\1"))
        each.go_to(now + 50 * MS)
    assert twin.station.digest() == model.station.digest()


@pytest.mark.parametrize(
    ("damage", "complaint"),
    [
        (lambda data: b"", "expected bytes of a serialised state"),
        (lambda data: data[:30], "one of another unit"),
        (lambda data: data.replace(b"{token}", b"{other}"), "one of another unit"),
        (lambda data: data[:-9], "expected digest"),
        (lambda data: data[:-20] + bytes(20), "damaged"),
    ],
)
def test_damaged_state_is_refused(
    unit: UnitFile, tmp_path: Path, damage: object, complaint: str
) -> None:
    assert callable(damage)
    model = Model(tmp_path, unit)
    model.go_to(30 * MS)
    with pytest.raises(ModelError, match=complaint):
        Model.unpack(tmp_path, unit, damage(model.pack(0.0)))


def test_inputs_of_another_size_are_refused(unit: UnitFile, tmp_path: Path) -> None:
    model = Model(tmp_path, unit)
    with pytest.raises(ModelError, match=f"expected {model.input_size} bytes, got 3"):
        model.apply(b"abc")


def test_text_that_does_not_fit_is_refused(unit: UnitFile, tmp_path: Path) -> None:
    model = Model(tmp_path, unit)
    gain = struct.pack("<d", 9.0)
    with pytest.raises(ModelError, match=r"MAIN\.sText: .*STRING"):
        model.apply(inputs_with(model, sText=b"x" * 30 + bytes(12), fGain=gain))
    assert model.image[place_of(model, "MAIN.sText")].startswith("Öl".encode() + b"\0")
    assert model.image[place_of(model, "MAIN.fGain")] == gain  # the others are set
    model.go_to(MS)
    again, _ = Model.unpack(tmp_path, unit, model.pack(0.0))  # replayed without what was refused
    assert again.station.digest() == model.station.digest()


def test_variable_of_another_size_requests_an_export(unit: UnitFile, tmp_path: Path) -> None:
    wrong = UnitVariable("MAIN.nCount", "851:MAIN.nCount", ValueType.UINT64, "local", 8)
    with pytest.raises(ExportError, match="expected 8 bytes, got 4: export the unit again"):
        Model(tmp_path, unit._replace(variables=[wrong]))


def test_digest_is_the_station_s(unit: UnitFile, tmp_path: Path) -> None:
    model = Model(tmp_path, unit)
    model.go_to(100 * MS)
    model.show_digest()
    shown = model.image[place_of(model, "station.digest")].rstrip(b"\0").decode()
    station = Station.load(tmp_path / unit.station)
    station.advance(0.1)
    assert shown == station.digest()


def test_station_of_a_unit_writes_no_files(station_file: Path) -> None:
    with station_file.open("a") as file:
        file.write('[system]\npersistent_data = "kept.json"\nroot = "shown"\n')
    system = as_unit(load(station_file)).system
    assert (system.persistent_data, system.root) == (None, None)
