"""Numbers of a kernel in instructions of the back end."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from achse.native.backend import F64, I64, ModuleBuilder, Operand
from achse.native.declare import RecordLayout
from achse.native.kernels.arithmetic import Arithmetic, TranslationError
from achse.native.kernels.kinds import BOOL, INT, REAL, KernelValue, RecordReference, Several

ONE, X = Operand(I64, "1"), Operand(F64, "%x")


def nothing() -> None:
    """Stands for the function that is translated."""


@pytest.fixture
def writer() -> Arithmetic:
    code = ModuleBuilder().function("nothing")
    unit = SimpleNamespace(checked=False)
    return Arithmetic(cast(Any, unit), cast(Any, nothing), code)


def test_a_value_becomes_a_wider_one(writer: Arithmetic) -> None:
    yes = KernelValue(BOOL, (writer.code.constant(BOOL.machine, True),))
    several = writer.several([yes, KernelValue(INT, (ONE,))])
    wide = writer.convert(several, Several((INT, REAL)), cast(Any, None))
    assert wide.kind == Several((INT, REAL))
    assert [operand.type for operand in wide.operands] == [I64, F64]
    assert [line.split(" = ")[1] for line in writer.code.text().splitlines()[2:4]] == [
        "zext i1 true to i64",
        "sitofp i64 1 to double",
    ]


def test_a_value_does_not_become_another(writer: Arithmetic) -> None:
    record = KernelValue(RecordReference(RecordLayout("wheel", {}, 1)), (Operand(I64, "%r"),))
    for value, kind in (
        (record, INT),
        (KernelValue(REAL, (X,)), INT),
        (KernelValue(INT, (ONE,)), BOOL),
    ):
        with pytest.raises(TranslationError, match=r"test_arithmetic\.py:\d+: nothing: .* where"):
            writer.convert(value, kind, cast(Any, None))


def test_parts_are_what_several_was_made_of(writer: Arithmetic) -> None:
    members = [KernelValue(INT, (ONE,)), KernelValue(REAL, (X,))]
    assert writer.parts(writer.several(members)) == members
