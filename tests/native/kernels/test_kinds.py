"""Kinds of values."""

from achse.native.backend import types
from achse.native.declare import RecordLayout
from achse.native.kernels.kinds import (
    BOOL,
    INT,
    REAL,
    RecordReference,
    Row,
    RowTables,
    Several,
    described,
    joined,
    machine_types,
)

WHEEL = RecordReference(RecordLayout("wheel", {}, 4))


def test_numbers_join_to_the_wider() -> None:
    assert joined(BOOL, INT) == INT
    assert joined(REAL, INT) == REAL
    assert joined(INT, INT) == INT


def test_tuples_join_member_by_member() -> None:
    assert joined(Several((INT, REAL)), Several((REAL, BOOL))) == Several((REAL, REAL))
    assert joined(Several((INT, WHEEL)), Several((INT, INT))) is None
    assert joined(Several((INT,)), Several((INT, INT))) is None


def test_other_kinds_do_not_join() -> None:
    assert joined(WHEEL, INT) is None
    assert joined(Row(INT), Row(REAL)) is None
    assert joined(Row(WHEEL), Row(WHEEL)) == Row(WHEEL)


def test_values_lie_flat() -> None:
    several = machine_types(Several((INT, Row(WHEEL), BOOL)))
    assert several == (types.I64, types.ADDRESS, types.I64, types.BOOL)
    assert machine_types(WHEEL) == (types.ADDRESS,)
    tables = RowTables("Rows", (("wheels", Row(WHEEL)), ("marks", Row(REAL))))
    assert machine_types(tables) == (types.ADDRESS, types.I64) * 2


def test_kinds_have_words() -> None:
    assert [described(kind) for kind in (BOOL, WHEEL, Row(INT), Several((INT,)))] == [
        *("a bool", "a wheel", "a sequence", "a tuple")
    ]
