"""The linker: names that stay."""

from achse.iec.elementary import INT
from achse.plc.code.linker import Linker
from achse.plc.lowering.placement import Placement
from achse.plc.lowering.project import LoweredProject
from achse.plc.memory import Memory
from achse.st.typed.project import TypedProject


def test_names_and_constants_stay() -> None:
    linker = Linker(LoweredProject(TypedProject({}, {}, {}, {}, {}), Placement(Memory(), ())))
    assert linker.name_of("main") == linker.name_of("main") != linker.name_of("other")
    assert linker.constant((1, 2)) == linker.constant((1, 2)) != linker.constant((1, 3))
    assert linker.constant(INT) == linker.constant(INT)
    assert linker.constants[linker.constant(b"x")] == b"x"
