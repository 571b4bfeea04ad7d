"""The functions of a unit, called by importers that make mistakes: both versions of FMI."""

import ctypes
import io
import math
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.fmu import Export
from achse.fmu.compiler import binary_name, platform_folder
from achse.fmu.model import UnitFile
from tests.fmu import conftest

compiler, unit = conftest.compiler, conftest.unit
"""Fixtures: a compiler, and a unit made with it."""

OK, ERROR = 0, 3
LOG3 = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
LOG2 = ctypes.CFUNCTYPE(
    None, *(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int), *[ctypes.c_char_p] * 3
)
"""The format is "%s", and its argument follows."""


class Callbacks2(ctypes.Structure):
    _fields_ = (
        ("logger", LOG2),
        ("allocate", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
        ("finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    )


class Unit:
    """The unpacked unit and its library."""

    def __init__(self, unit: Export, folder: Path) -> None:
        with zipfile.ZipFile(io.BytesIO(unit.archive)) as archive:
            archive.extractall(folder)
        binary = folder / "binaries" / platform_folder(3) / binary_name("cell")
        self.library = ctypes.CDLL(str(binary))
        self.library.fmi3InstantiateCoSimulation.restype = ctypes.c_void_p
        self.library.fmi2Instantiate.restype = ctypes.c_void_p
        self.resources = folder / "resources"
        file = UnitFile.read(self.resources)
        self.token = file.token
        self.references = {each.name: number for number, each in enumerate(file.variables)}


class Instance:
    """An instance, whose calls have the version's prefix: `call("DoStep", …)` is its status."""

    def __init__(self, unit: Unit, fmi: int) -> None:
        self.unit, self.fmi = unit, fmi
        self.lines: list[str] = []
        token, place = unit.token.encode(), str(unit.resources).encode()
        if fmi == 3:
            self._log: Any = LOG3(lambda _, __, ___, text: self.lines.append(text.decode()))
            handle = unit.library.fmi3InstantiateCoSimulation(
                *(b"cell", token, place, False, False, False, False, None),
                *(ctypes.c_size_t(0), None, self._log, None),
            )
        else:
            logger = LOG2(lambda *each: self.lines.append(each[-1].decode()))
            self._log = Callbacks2(logger)
            uri = unit.resources.as_uri().encode()
            handle = unit.library.fmi2Instantiate(
                b"cell", 1, token, uri, ctypes.byref(self._log), 0, 0
            )
        assert handle is not None, self.lines
        self.handle = ctypes.c_void_p(handle)

    def call(self, name: str, *arguments: Any) -> int:
        status: int = getattr(self.unit.library, f"fmi{self.fmi}{name}")(self.handle, *arguments)
        return status

    def enter(self, start: float = 0.0, stop: float | None = None) -> int:
        """Enter initialization mode."""
        has_stop, end = stop is not None, ctypes.c_double(stop or 0.0)
        times = False, ctypes.c_double(0.0), ctypes.c_double(start), has_stop, end
        if self.fmi == 3:
            return self.call("EnterInitializationMode", *times)
        return self.call("SetupExperiment", *times) or self.call("EnterInitializationMode")

    def leave(self) -> int:
        return self.call("ExitInitializationMode")

    def step(self, at: float, by: float) -> int:
        times = ctypes.c_double(at), ctypes.c_double(by), True
        return self.call("DoStep", *times, *([None] * 4 if self.fmi == 3 else []))

    def _values(
        self, verb: str, kind: str, names: list[str], values: Any, count: int | None
    ) -> int:
        references = (ctypes.c_uint32 * len(names))(*(self.unit.references[each] for each in names))
        sizes = [ctypes.c_size_t(len(values) if count is None else count)] if self.fmi == 3 else []
        return self.call(f"{verb}{kind}", references, ctypes.c_size_t(len(names)), values, *sizes)

    def set_floats(self, values: dict[str, float], count: int | None = None) -> int:
        """Float64, or Real."""
        numbers = (ctypes.c_double * len(values))(*values.values())
        return self._values(
            "Set", "Float64" if self.fmi == 3 else "Real", [*values], numbers, count
        )

    def get_floats(self, *names: str) -> list[float] | int:
        numbers = (ctypes.c_double * len(names))()
        kind = "Float64" if self.fmi == 3 else "Real"
        return self._values("Get", kind, [*names], numbers, None) or list(numbers)

    def get_text(self, name: str) -> str:
        texts = (ctypes.c_char_p * 1)()
        assert self._values("Get", "String", [name], texts, None) == OK
        return (texts[0] or b"").decode()

    def free(self) -> None:
        self.call("FreeInstance")


@pytest.fixture(scope="module")
def cell(
    unit: Export, tmp_path_factory: pytest.TempPathFactory, warm_commands: Any
) -> Iterator[Unit]:
    """The unit, whose stations are forked from a warm process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ACHSE_PYTHON", str(warm_commands.python))
        yield Unit(unit, tmp_path_factory.mktemp("unit"))


@pytest.fixture(scope="module", params=[3, 2])
def stepping(request: pytest.FixtureRequest, cell: Unit) -> Iterator[Instance]:
    """An instance in step mode at 0 s, which no test leaves elsewhere: a reset takes its time."""
    instance = Instance(cell, request.param)
    assert (instance.enter(), instance.leave()) == (OK, OK)
    yield instance
    instance.free()


@pytest.fixture
def fresh(stepping: Instance) -> Iterator[Instance]:
    """The instance as after its instantiation; in step mode again afterwards."""
    assert stepping.call("Reset") == OK
    yield stepping
    assert (stepping.call("Reset"), stepping.enter(), stepping.leave()) == (OK, OK, OK)


def test_calls_out_of_order_are_errors(fresh: Instance) -> None:
    prefix = f"fmi{fresh.fmi}"
    assert fresh.leave() == ERROR
    assert f"{prefix}ExitInitializationMode: expected initialization mode" in fresh.lines[-1]
    assert fresh.step(0.0, 0.01) == ERROR
    assert fresh.lines[-1] == "step: expected step mode, the mode is: instantiated"
    assert fresh.call("Terminate") == ERROR
    assert fresh.enter() == OK
    assert fresh.enter() == ERROR
    assert fresh.step(0.0, 0.01) == ERROR
    assert fresh.leave() == OK
    assert fresh.leave() == ERROR
    assert fresh.step(0.0, 0.01) == OK
    assert fresh.call("Terminate") == OK
    assert fresh.call("Terminate") == ERROR
    assert fresh.step(0.01, 0.01) == ERROR
    assert fresh.set_floats({"MAIN.fGain": 1.0}) == ERROR
    assert "the unit is terminated" in fresh.lines[-1]
    assert fresh.get_floats("MAIN.fGain") == [2.5]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(stepping: Instance, value: float) -> None:
    digest = stepping.get_text("station.digest")
    assert stepping.set_floats({"MAIN.fGain": value}) == ERROR
    assert "expected a finite number, got" in stepping.lines[-1]
    assert stepping.get_floats("MAIN.fGain") == [2.5]
    assert stepping.get_text("station.digest") == digest


def test_extreme_numbers_pass(stepping: Instance) -> None:
    for value in (1.7976931348623157e308, 5e-324, -0.0, 2.5):
        assert stepping.set_floats({"MAIN.fGain": value}) == OK
        assert stepping.step(0.0, 0.0) == OK
        (number,) = stepping.get_floats("MAIN.fGain")  # type: ignore[misc]
        assert struct.pack("<d", number) == struct.pack("<d", value)


def test_real_beyond_a_float_is_refused(stepping: Instance) -> None:
    if stepping.fmi == 2:
        assert stepping.set_floats({"MAIN.fLevel": 1e39}) == ERROR
        assert "expected -3.40282e+38 to 3.40282e+38" in stepping.lines[-1]
        return
    number = (ctypes.c_float * 1)(math.nan)
    assert stepping._values("Set", "Float32", ["MAIN.fLevel"], number, None) == ERROR


def test_a_call_sets_all_values_or_none(stepping: Instance) -> None:
    for other, value in (("time", 0.0), ("MAIN.fGain", math.nan)):
        values = {"MAIN.fGain": 9.0} | {other: value}
        if other == "MAIN.fGain":
            references = (ctypes.c_uint32 * 2)(*[stepping.unit.references[other]] * 2)
            numbers = (ctypes.c_double * 2)(9.0, math.nan)
            kind = "SetFloat64" if stepping.fmi == 3 else "SetReal"
            count = [ctypes.c_size_t(2)] if stepping.fmi == 3 else []
            assert stepping.call(kind, references, ctypes.c_size_t(2), numbers, *count) == ERROR
        else:
            assert stepping.set_floats(values) == ERROR
        assert stepping.get_floats("MAIN.fGain") == [2.5]


@pytest.mark.parametrize("count", [0, 2, 2**63])
def test_other_numbers_of_values_are_refused(stepping: Instance, count: int) -> None:
    if stepping.fmi == 2:
        pytest.skip("FMI 2.0 has no arrays")
    assert stepping.set_floats({"MAIN.fGain": 1.0}, count) == ERROR
    assert stepping.lines[-1] == f"expected 1 values, got {count}"


def test_missing_arrays_are_refused(stepping: Instance) -> None:
    kinds = ("Float64", "Int16", "String") if stepping.fmi == 3 else ("Real", "Integer", "String")
    for kind in kinds:
        for verb in ("Get", "Set"):
            count = [ctypes.c_size_t(1)] if stepping.fmi == 3 else []
            assert stepping.call(f"{verb}{kind}", None, ctypes.c_size_t(1), None, *count) == ERROR
            assert "got NULL" in stepping.lines[-1]


def test_wrong_times_are_refused(fresh: Instance) -> None:
    for start, stop in ((math.nan, None), (math.inf, None), (1.0, 0.5), (0.0, math.nan)):
        assert fresh.enter(start, stop) == ERROR
        assert "start: expected a finite time" in fresh.lines[-1]


@pytest.mark.parametrize(
    ("at", "by"),
    [(math.nan, 0.01), (0.0, math.nan), (0.0, math.inf), (0.0, 1e300), (0.0, -5e-324), (5.0, 0.1)],
)
def test_wrong_steps_are_refused(stepping: Instance, at: float, by: float) -> None:
    assert stepping.step(at, by) == ERROR
    assert stepping.step(0.0, 5e-324) == OK


def test_truth_has_one_bit(stepping: Instance) -> None:
    if stepping.fmi == 3:
        value: Any = (ctypes.c_uint8 * 1)(0x82)
    else:
        value = (ctypes.c_int * 1)(0x100)
    assert stepping._values("Set", "Boolean", ["MAIN.bGo"], value, None) == OK
    assert stepping._values("Get", "Boolean", ["MAIN.bGo"], value, None) == OK
    assert value[0] == 1


def test_states_keep_their_mode(fresh: Instance) -> None:
    get, put = ("GetFMUState", "SetFMUState") if fresh.fmi == 3 else ("GetFMUstate", "SetFMUstate")
    first, second = ctypes.c_void_p(), ctypes.c_void_p()
    assert fresh.enter() == OK
    assert fresh.call(get, ctypes.byref(first)) == OK
    assert fresh.leave() == OK
    assert fresh.call(get, ctypes.byref(second)) == OK
    assert fresh.call(put, first) == OK
    assert fresh.step(0.0, 0.01) == ERROR
    assert fresh.call(put, second) == OK
    assert fresh.step(0.0, 0.01) == OK
    free = put.replace("Set", "Free")
    assert fresh.call(free, ctypes.byref(first)) == OK
    assert fresh.call(free, ctypes.byref(first)) == OK
    assert fresh.call(put, ctypes.c_void_p(8)) == ERROR
    assert fresh.call(get, None) == ERROR


@settings(max_examples=20)
@given(data=st.binary(max_size=64), magic=st.booleans())
def test_any_serialised_bytes_are_refused(stepping: Instance, data: bytes, magic: bool) -> None:
    data = magic * b"achse unit state 1\n" + data
    name = "DeserializeFMUState" if stepping.fmi == 3 else "DeSerializeFMUstate"
    state = ctypes.c_void_p()
    size = ctypes.c_size_t(len(data))
    assert stepping.call(name, data, size, ctypes.byref(state)) == ERROR
    assert "state: " in stepping.lines[-1]
    assert state.value is None


def test_instance_is_freed_once(cell: Unit, stepping: Instance) -> None:
    instance = Instance(cell, stepping.fmi)
    assert (instance.enter(), instance.leave(), instance.step(0.0, 0.01)) == (OK, OK, OK)
    assert instance.call("Terminate") == OK  # in the middle of a run
    instance.free()
    instance.free()
    for handle in (instance.handle, ctypes.c_void_p(None), ctypes.c_void_p(8)):
        instance.handle = handle
        statuses = [
            *(instance.step(0.0, 0.01), instance.set_floats({"MAIN.fGain": 1.0}), instance.enter()),
            *(
                instance.get_floats("MAIN.fGain"),
                instance.call("Reset"),
                instance.call("Terminate"),
            ),
        ]
        assert statuses == [ERROR] * len(statuses)
        instance.free()
    assert stepping.step(0.0, 5e-324) == OK
