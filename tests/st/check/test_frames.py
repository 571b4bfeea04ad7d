"""Frames lay their variables out as structures do."""

from achse.iec.elementary import BIT, DINT, INT, LREAL
from achse.iec.layout import TC3_X64
from achse.iec.variables import Variable
from achse.st.check.frames import VariableFrame
from achse.st.typed.places import FrameBase, Storage


def test_variables_are_aligned_and_keep_their_initial_values() -> None:
    frame = VariableFrame("F", TC3_X64)
    first = frame.add(Variable(INT, 7, name="a"))
    second = frame.add(Variable(LREAL, 1.5, name="b"))
    third = frame.temporary(DINT)
    structure = frame.structure()
    assert [item.offset for item in (first, second, third)] == [0, 8, 16]
    assert (structure.size, structure.alignment) == (24, 8)
    assert structure.default[:2] == b"\x07\x00"
    assert structure.member("b").offset == 8
    assert frame.find("a") is first
    assert frame.addressed == {"__t1"}


def test_a_bit_has_a_byte_of_its_own() -> None:
    frame = VariableFrame("F", TC3_X64)
    frame.add(Variable(BIT, name="x"))
    variable = frame.add(Variable(BIT, name="y"))
    assert frame.storage(variable, 3) == Storage(FrameBase(), 1, variable.type, name="y")
    assert variable.bit is None
