"""A typed project finds its blocks by the number that instances hold."""

from typing import Any

from achse.iec.structs import RecordKind, StructType
from achse.st.lexis.source import Source
from achse.st.typed.project import Routine, RoutineKind, TypedBlock, TypedProject

MOTOR: StructType[Any] = StructType("FB_Motor", [], kind=RecordKind.FUNCTION_BLOCK)
FRAME: StructType[Any] = StructType("FB_Motor.Start", [])


def test_blocks_are_found_by_the_number_in_their_header() -> None:
    block = TypedBlock(MOTOR, number=3, table={"start": "fb_motor.start"})
    project = TypedProject({}, {"fb_motor": block}, {}, {}, {})
    assert project.block_numbered == {3: block}


def test_a_routine_knows_file_and_line_of_its_nodes() -> None:
    source = Source("METHOD Start\nx := 1;", "FB_Motor.st")
    routine = Routine(
        "fb_motor.start",
        "FB_Motor.Start",
        RoutineKind.METHOD,
        "fb_motor",
        source,
        7,
        MOTOR,
        (),
        None,
        FRAME,
        (),
        (),
    )
    assert str(routine.locate(15)) == "FB_Motor.st:2:3"
