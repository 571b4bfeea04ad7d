"""Tables in files, as clients write them."""

from pathlib import Path

import pytest
import typer
from hypothesis import given
from hypothesis import strategies as st

from achse.cli.axes.table_files import read_table, written
from achse.client.nc import FunctionPoint

NUMBER = st.floats(allow_nan=False, allow_infinity=False)
WORD = st.integers(0, 65535)
WORDS = NUMBER, NUMBER, WORD, NUMBER, NUMBER, NUMBER, WORD


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "table.csv"


def test_cams(file: Path) -> None:
    file.write_text("\ufeff2\t2\n0\t0\n1\t0,5\n", encoding="utf-8")
    assert read_table(file) == [(0.0, 0.0), (1.0, 0.5)]


def test_motion_functions(file: Path) -> None:
    file.write_text("master,slave,law\n0,0,12\n90,30,1\n")
    assert read_table(file) == [FunctionPoint(0.0, 0.0, 12), FunctionPoint(90.0, 30.0, 1)]
    file.write_text("0 0 15 0.5 0.25 0.125\n90 30 0 0 0 0\n")
    assert read_table(file)[0] == FunctionPoint(0.0, 0.0, 15, 0.5, 0.25, 0.125)


@pytest.mark.parametrize("text", ["", "1 2", "a b c", "0 0\n1 x\n", "0 0 -1\n1 1 1\n"])
def test_what_is_no_table_ends_the_command(
    file: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text(text)
    with pytest.raises(typer.Exit):
        read_table(file)
    assert "expected" in capsys.readouterr().err


def test_what_cannot_be_read(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit):
        read_table(file)
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(typer.Exit):
        read_table(file)
    assert capsys.readouterr().err.count("table.csv") == 2


@given(st.lists(st.tuples(NUMBER, NUMBER), min_size=2, max_size=9))
def test_a_cam_is_read_as_it_was_written(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, float]]
) -> None:
    file = tmp_path_factory.mktemp("tables") / "cam.csv"
    file.write_text(written(rows))
    assert read_table(file) == rows


@given(
    st.lists(
        st.builds(FunctionPoint, *WORDS),
        min_size=2,
        max_size=9,
    )
)
def test_a_motion_function_is_read_as_it_was_written(
    tmp_path_factory: pytest.TempPathFactory, points: list[FunctionPoint]
) -> None:
    file = tmp_path_factory.mktemp("tables") / "function.csv"
    file.write_text(written(points))
    assert read_table(file) == points
