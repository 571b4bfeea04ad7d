"""The worked example of the typed form: built by hand, and run by a generator of ten lines."""

from achse.iec.elementary import DINT, INT
from achse.iec.variables import Variable
from achse.st.typed.expressions import (
    Computed,
    Conversion,
    Converted,
    Known,
    Operator,
    Read,
    Stored,
    TypedValue,
)
from achse.st.typed.places import IndexStep, Storage, UnitBase
from achse.st.typed.text import text_of

TOTAL = Storage(UnitBase("MAIN", Variable(INT, name="nTotal")), 0, INT, name="nTotal")
INDEX = Storage(UnitBase("MAIN", Variable(INT, name="i")), 0, INT, name="i")


def wide(value: TypedValue) -> Converted:
    return Converted(value, DINT, Conversion.EXTEND)


STEP = Storage(
    UnitBase("MAIN", Variable(INT, name="aSteps")),
    0,
    INT,
    steps=(IndexStep(wide(Read(INDEX, INT)), Known(0, DINT), Known(9, DINT), INT.size),),
    name="aSteps",
)
SUM = Computed(Operator.ADD, (wide(Read(TOTAL, INT)), wide(Read(STEP, INT))), DINT)
EXAMPLE = Stored(TOTAL, Converted(SUM, INT, Conversion.CUT), INT)
"""`nTotal := nTotal + aSteps[i];`"""


class Runner:
    """Runs the few nodes of the example over the bytes of variables, by name."""

    def __init__(self, memory: dict[str, bytearray]) -> None:
        self.memory = memory

    def offset(self, storage: Storage) -> int:
        return storage.offset + sum(
            (self.value(step.index) - self.value(step.first)) * step.stride
            for step in storage.steps
        )

    def value(self, node: TypedValue) -> int:
        match node:
            case Known(int() as number):
                return number
            case Read(storage, type):
                content: int = type.read(self.memory[storage.name], self.offset(storage))
                return content
            case Converted(operand, type):
                data = self.value(operand).to_bytes(8, "little", signed=True)
                return int.from_bytes(data[: type.size], "little", signed=True)
            case Computed(Operator.ADD, (left, right)):
                return self.value(left) + self.value(right)
            case Stored(storage, value, type):
                stored = self.value(value)
                type.write(self.memory[storage.name], self.offset(storage), stored)
                return stored
        raise AssertionError(node)


def test_the_worked_example_reads_as_the_docstring_says() -> None:
    assert text_of(EXAMPLE) == (
        "nTotal := CUT.INT(ADD.DINT(EXTEND.DINT(nTotal), EXTEND.DINT(aSteps[EXTEND.DINT(i)])))"
    )


def test_the_worked_example_runs() -> None:
    steps = bytearray(20)
    INT.write(steps, 6, 5)
    memory = {"nTotal": bytearray(INT.encode(32766)), "i": bytearray(INT.encode(3))}
    Runner(memory | {"aSteps": steps}).value(EXAMPLE)
    assert INT.decode(memory["nTotal"]) == -32765  # cut to 16 bits


def test_every_operator_and_conversion_is_named_as_it_is_written() -> None:
    for member in (*Operator, *Conversion):
        assert member.value == member.name
