"""Nodes of the typed form: all inside of a statement."""

from achse.iec.elementary import BOOL, DINT
from achse.st.typed.expressions import Computed, Known, Operator, Read
from achse.st.typed.nodes import is_node, nodes_in
from achse.st.typed.places import FrameBase, Storage
from achse.st.typed.statements import Conditional, Do, TypedBranch


def test_all_nodes_once() -> None:
    read = Read(Storage(FrameBase(), 4, DINT), DINT)
    one = Known(1, DINT)
    condition = Computed(Operator.LT, (read, one), BOOL)
    inner = Do(one)
    statement = Conditional((TypedBranch(condition, (inner,)),), ())
    nodes = list(nodes_in((statement, statement.branches[0])))
    assert nodes.count(condition) == 2
    assert {type(node) for node in nodes} == {
        *(Conditional, TypedBranch, Computed, Read, Storage, FrameBase, Known, Do)
    }


def test_what_is_no_node() -> None:
    assert not any(map(is_node, (DINT, Operator.LT, 5, "text", ())))
    assert list(nodes_in((DINT, 5))) == []
