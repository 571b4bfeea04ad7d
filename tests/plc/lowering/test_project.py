"""A project as lowering sees it."""

from typing import Any

from achse.iec.elementary import INT
from achse.iec.structs import StructType
from achse.iec.variables import Variable
from achse.plc.lowering.placement import Placement, Spot
from achse.plc.lowering.project import LoweredProject
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.st.typed.places import ImageBase, UnitBase
from achse.st.typed.project import TypedProject, TypedRecord


def test_missing_routine_says_why() -> None:
    typed = TypedProject({}, {}, {}, {}, {}, left_out={"f": "why"})
    project = LoweredProject(typed, Placement(Memory(), ()))
    assert project.routine("f") == "f: why"
    assert project.routine("g") == "g: it has an error"


def test_records_and_spots_are_found_by_their_names() -> None:
    type: StructType[Any] = StructType("T_Rec", {})
    record = TypedRecord(type, create="t_rec.__create")
    variable: Variable[Any, Any] = Variable(INT, name="n")
    placed = PlacedVariable("MAIN.n", variable, Area.DATA, 6, None)
    typed = TypedProject({}, {}, {"t_rec": record}, {}, {})
    project = LoweredProject(typed, Placement(Memory(), [placed]))
    assert project.record(type) is record
    assert project.record(StructType("T_Other", {})) is None
    for _ in range(2):
        assert project.spot(UnitBase("main", variable)) == Spot(Area.DATA, 6)
    assert project.spot(ImageBase("I")) == Spot(Area.INPUT, 0)
