"""Block search: what runs on the way, where the axes have to be, what is left."""

import pytest

from achse.codes import NcError
from achse.gcode.canon import ArcMove, DwellTime, LineMove, MFunction
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.interpretation.search import BlockSearch, DryRun, SearchMode
from achse.gcode.text.program import PartProgram

TEXT = """N10 G1 X10 F600 M7
N20 G04 X1
N30 R1=R1+1
N40 G2 X20 Y10 I10 J0
N50 G1 X40
M30"""


def run(search: BlockSearch, text: str = TEXT) -> tuple[Interpreter, list[object]]:
    interpreter = Interpreter(PartProgram(text, "part.nc"), MachineData())
    interpreter.search(search)
    results: list[object] = list(interpreter)
    return interpreter, results


@pytest.mark.parametrize(
    ("dry_run", "stored"),
    [
        (DryRun.SKIP_ALL, []),
        (DryRun.SKIP_MOTION, [MFunction, DwellTime]),
        (DryRun.SKIP_DWELL_AND_MOTION, [MFunction]),
        (DryRun.DISABLED, [MFunction, LineMove, DwellTime]),
    ],
)
def test_what_runs_on_the_way(dry_run: DryRun, stored: list[type]) -> None:
    interpreter, result = run(BlockSearch(SearchMode.BLOCK_NUMBER, 40, dry_run))
    assert [type(each) for each in result] == stored
    assert interpreter.state is RunState.FOUND
    assert interpreter.data.registers[1] == 1.0
    assert interpreter.search_result is not None
    assert interpreter.search_result.position == (10.0, 0.0, 0.0)
    interpreter.go_ahead()
    assert [type(each) for each in interpreter][:2] == [ArcMove, LineMove]


def test_the_rest_of_a_block() -> None:
    interpreter, _ = run(BlockSearch(SearchMode.BLOCK_NUMBER, 40, percent=50.0))
    assert interpreter.search_result is not None
    x, y, _ = interpreter.search_result.position
    assert (x, y) == pytest.approx((20.0 - 7.0710678 - 0.0, 7.0710678), abs=1e-6)
    assert interpreter.search_result.remaining == 50.0
    interpreter.go_ahead()
    arc = next(iter(interpreter))
    assert isinstance(arc, ArcMove)
    assert arc.start == interpreter.search_result.position
    assert arc.at(1.0) == pytest.approx((20.0, 10.0, 0.0))


def test_by_counter_in_a_loop() -> None:
    text = "N10 G91 X1 F600\nN20 @620 R1\n@124 R1 K5 K-10\nM30"
    interpreter, _ = run(BlockSearch(SearchMode.ENTRY_COUNTER, 7), text)
    assert interpreter.search_result is not None
    assert interpreter.search_result.position == (2.0, 0.0, 0.0)
    assert interpreter.search_result.origin.counter == 7


def test_a_block_that_never_runs() -> None:
    with pytest.raises(GcodeError) as error:
        run(BlockSearch(SearchMode.BLOCK_NUMBER, 99))
    assert error.value.code is NcError.BLOCK_NOT_FOUND
    with pytest.raises(ValueError, match="percent"):
        BlockSearch(SearchMode.BLOCK_NUMBER, 1, percent=101.0)


def test_a_search_begins_before_the_program() -> None:
    interpreter = Interpreter(PartProgram("X1 F600"))
    interpreter.advance()
    with pytest.raises(RuntimeError):
        interpreter.search(BlockSearch(SearchMode.BLOCK_NUMBER, 1))
