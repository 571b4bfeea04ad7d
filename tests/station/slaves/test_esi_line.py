"""Lines of slaves as people write them: types, counts, modules, files, behaviours."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.master.esi_reader import EsiError
from achse.ethercat.virtual import LoopBack, RecordedSignals
from achse.station.buses.esi_terminals import esi_devices, make_behaviour
from achse.station.slaves.esi_line import EsiLine
from tests.ethercat.virtual.esi_text import ANALOG, DIGITAL_IN, DIGITAL_OUT, esi

OWN = """
from achse.ethercat.virtual import SlaveBehaviour

class Ramp(SlaveBehaviour):
    def step(self, device, elapsed_ns):
        device.set_input("Value", 1 + device.input("Value"))

class NotOne:
    pass
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("esi")
    (place / "digital.xml").write_text(esi(DIGITAL_IN, DIGITAL_OUT))
    (place / "analog.xml").write_text(esi(ANALOG))
    (place / "own.py").write_text(OWN)
    (place / "values.csv").write_text("time,Value\n0,7\n1,8\n")
    return place


@given(
    counts=st.lists(
        st.tuples(st.sampled_from(["DI8", "DO8", "AIO"]), st.integers(1, 4)), min_size=1, max_size=4
    ),
    alias=st.integers(0, 100),
)
def test_slaves_are_as_many_as_written(
    folder: Path, counts: list[tuple[str, int]], alias: int
) -> None:
    line = EsiLine([f"{name}*{n}" for name, n in counts], [folder], alias=alias)
    names = [name for name, n in counts for _ in range(n)]
    assert [each.device.name for each in line.slaves] == names
    assert [each.device.identity.serial_number for each in line.slaves] == list(
        range(1, len(names) + 1)
    )
    assert line.slaves[-1].esc.alias == (alias + len(names) - 1 if alias else 0)


def test_file_of_one_type_is_a_slave(folder: Path) -> None:
    line = EsiLine([str(folder / "analog.xml"), "DI8@0x10000"], [folder])
    assert [each.device.name for each in line.slaves] == ["AIO", "DI8"]
    assert esi_devices(folder) is esi_devices(folder), "files are read once"


def test_behaviours_by_place(folder: Path) -> None:
    line = EsiLine(
        ["AIO*3"],
        [folder],
        ["all=loop-back", f"2={folder / 'values.csv'}", f"3={folder / 'own.py'}:Ramp"],
    )
    first, second, third = (each.device for each in line.slaves)
    assert isinstance(first.behaviour, LoopBack)
    assert isinstance(second.behaviour, RecordedSignals)
    assert second.input("Value") == 7
    third.step(1)
    assert third.input("Value") == 1


@pytest.mark.parametrize(
    ("specs", "behaviours", "message"),
    [
        (["XX"], [], "no device 'XX'"),
        (["DI8*0"], [], "expected 1 to 1000 slaves"),
        (["DI8*100000"], [], "expected 1 to 1000 slaves, got 100000"),
        (["DI8*900", "DI8*200"], [], "1000 slaves at most"),
        (["=*"], [], "expected TYPE"),
        (["DI8=M1"], [], "has no slots"),
        (["DI8"], ["2=loop-back"], "expected 1 to 1 or all"),
        (["DI8"], ["1=jump"], "expected loop-back, FILE.csv or FILE.py:CLASS, got 'jump'"),
        (["DI8"], ["1=none.csv"], "No such file"),
        (["DI8"], ["1=none.py:A"], "No such file"),
    ],
)
def test_line_that_cannot_be_is_reported(
    folder: Path, specs: list[str], behaviours: list[str], message: str
) -> None:
    with pytest.raises(EsiError, match=message):
        EsiLine(specs, [folder], behaviours)


def test_places_and_classes_are_checked(folder: Path) -> None:
    with pytest.raises(EsiError, match=r"0..65535 for each slave"):
        EsiLine(["DI8*2"], [folder], alias=0xFFFF)
    with pytest.raises(EsiError, match="expected a file of one type, got DI8, DO8"):
        EsiLine([str(folder / "digital.xml")])
    with pytest.raises(EsiError, match=r"slave 1 \(DI8\): DI8 has no channel 'Value'"):
        EsiLine(["DI8"], [folder], [f"1={folder / 'values.csv'}"])
    wrong = (("NotOne", "expected a subclass of SlaveBehaviour"), ("No", "AttributeError"))
    for name, text in wrong:
        with pytest.raises(EsiError, match=text):
            make_behaviour(f"own.py:{name}", folder)
    (folder / "bad.csv").write_text("x\n")
    with pytest.raises(EsiError, match=r"bad.csv: expected a first line"):
        make_behaviour("bad.csv", folder)
