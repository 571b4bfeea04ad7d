"""The linker: names that follow from keys and contents, and stay."""

from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import INT
from achse.iec.strings import StringType
from achse.plc.code.linker import Linker
from achse.plc.lowering.placement import Placement
from achse.plc.lowering.project import LoweredProject
from achse.plc.memory import Memory
from achse.st.typed.project import TypedProject


def new_linker() -> Linker:
    return Linker(LoweredProject(TypedProject({}, {}, {}, {}, {}), Placement(Memory(), ())))


def test_names_and_constants_stay() -> None:
    linker = new_linker()
    assert linker.name_of("main") == linker.name_of("main") != linker.name_of("other")
    assert linker.constant((1, 2)) == linker.constant((1, 2)) != linker.constant((1, 3))
    assert linker.constant(INT) == linker.constant(INT)
    assert linker.constants[linker.constant(b"x")] == b"x"


def test_names_are_the_same_in_another_program() -> None:
    one, other = new_linker(), new_linker()
    other.constant(b"before")
    for value in (INT, b"x", (1, 2), {1: b"one"}):
        assert one.constant(value) == other.constant(value)
    assert one.name_of("fb_motor.__create") == other.name_of("fb_motor.__create")


def test_types_of_equal_names_have_their_own_constants() -> None:
    linker = new_linker()
    types = [StringType(80), StringType(80)]
    names = [linker.constant(type) for type in types]
    assert [linker.constants[name] for name in names] == types
    after = new_linker()
    after.adopt(linker.constants)
    assert [after.constant(type) for type in types] == names
    assert after.constant(StringType(80)) not in names


KEYS = st.text(st.characters(codec="utf-8") | st.sampled_from("._dotu<e"), max_size=6)


@given(KEYS, KEYS)
def test_each_key_has_an_identifier_of_its_own(one: str, other: str) -> None:
    linker = new_linker()
    one, other = one.lower(), other.lower()
    assert linker.name_of(one).isidentifier()
    assert (linker.name_of(one) == linker.name_of(other)) == (one == other)
