"""Statements of the typed form hold what a generator needs, without the tree."""

from typing import Any

from achse.iec.elementary import BOOL, INT
from achse.iec.structs import StructType
from achse.iec.variables import Variable
from achse.st.typed.expressions import Computed, Known, Operator, Read, Stored
from achse.st.typed.places import FrameBase, InstanceBase, Storage
from achse.st.typed.statements import CountedLoop, Do, LifeEvent, LifeStep, LoopExit
from achse.st.typed.text import lines_of

COUNTER = Storage(FrameBase(), 0, INT, name="i")


def test_a_counted_loop_has_its_test_and_its_step_as_values() -> None:
    loop = CountedLoop(
        Stored(COUNTER, Known(1, INT), INT),
        Computed(Operator.GT, (Read(COUNTER, INT), Known(3, INT)), BOOL),
        Stored(COUNTER, Computed(Operator.ADD, (Read(COUNTER, INT), Known(1, INT)), INT), INT),
        (LoopExit(),),
    )
    assert list(lines_of((loop,))) == [
        "FOR i := 1; UNTIL GT.BOOL(i, 3); i := ADD.INT(i, 1)",
        "    EXIT;",
    ]


def test_lifecycle_step_has_its_number_of_records() -> None:
    axis: StructType[Any] = StructType("ST_Axis", [Variable(INT, name="nNumber")])
    storage = Storage(InstanceBase(), 8, axis, name="aAxes")
    value = Do(Stored(COUNTER, Known(1, INT), INT))
    step = LifeStep(LifeEvent.CREATE, storage, axis, 4, axis.size, (), (value,))
    assert list(lines_of((step,))) == ["CREATE aAxes : ST_Axis * 4", "    i := 1;"]
