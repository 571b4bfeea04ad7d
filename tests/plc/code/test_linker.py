"""The linker: names that stay, rows of records."""

from achse.iec.elementary import INT
from achse.plc.code.linker import Linker
from achse.plc.code.placement import Placement
from achse.plc.memory import Memory
from achse.st.typed.project import TypedProject


def test_names_and_constants_stay() -> None:
    linker = Linker(
        TypedProject({}, {}, {}, {}, {}, left_out={"f": "why"}), Placement(Memory(), ())
    )
    assert linker.name_of("main") == linker.name_of("main") != linker.name_of("other")
    assert linker.constant((1, 2)) == linker.constant((1, 2)) != linker.constant((1, 3))
    assert linker.constant(INT) == linker.constant(INT)
    assert linker.constants[linker.constant(b"x")] == b"x"
    assert linker.routine("f") == "f: why"
