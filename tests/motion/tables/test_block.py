"""One table as a block in memory."""

from array import array

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes.nc.choices import TableSubType, TableType
from achse.motion.states import CamInterpolation
from achse.motion.tables import Table
from achse.motion.tables.block import LEAST_ROWS, block_size, write_block
from achse.motion.tables.memory import BEGIN, COUNT, CYCLIC, HEADER, PERIOD, SPAN, STEP, STROKE


def table_of(places: list[float], values: list[float], *, equidistant: bool) -> Table:
    sub_type = TableSubType.EQUIDISTANT_LINEAR if equidistant else TableSubType.MONOTONIC_LINEAR
    table = Table(7, TableType.CAMMING, sub_type, len(places), 2)
    table.values = array("d", (each for row in zip(places, values, strict=True) for each in row))
    table.changed()
    return table


def block_of(table: Table, interpolation: int, offset: int) -> "array[float]":
    numbers = array("d", [float("nan")]) * (offset + block_size(table) + 1)
    write_block(table, interpolation, numbers, offset, 0, table.row_count)
    return numbers


def test_the_header_says_what_the_table_is() -> None:
    numbers = block_of(table_of([10.0, 20.0, 30.0], [0.0, 5.0, 8.0], equidistant=True), 0, 3)
    header = {name: numbers[3 + name] for name in (COUNT, BEGIN, PERIOD, STROKE, CYCLIC, STEP)}
    assert header == {COUNT: 3, BEGIN: 10.0, PERIOD: 20.0, STROKE: 8.0, CYCLIC: 0.0, STEP: 10.0}
    assert len(numbers) == 3 + HEADER + 3 * SPAN + 1


@given(
    interpolation=st.sampled_from(CamInterpolation),
    equidistant=st.booleans(),
    steps=st.lists(st.floats(0.1, 50.0), min_size=3, max_size=40),
    data=st.data(),
)
def test_changed_rows_alone_make_the_block_of_the_whole_table(
    interpolation: CamInterpolation, equidistant: bool, steps: list[float], data: st.DataObject
) -> None:
    """And not one number beyond the block is touched."""
    equidistant |= interpolation is CamInterpolation.FOUR_POINTS
    if equidistant:
        steps = [steps[0]] * len(steps)
    places = [0.0]
    for step in steps:
        places.append(places[-1] + step)
    value = st.floats(-100.0, 100.0)
    values = data.draw(st.lists(value, min_size=len(places), max_size=len(places)))
    table = table_of(places, values, equidistant=equidistant)
    assert len(places) >= LEAST_ROWS.get(interpolation, 2)
    offset = data.draw(st.integers(0, 50))
    numbers = block_of(table, interpolation, offset)
    low = data.draw(st.integers(0, len(places) - 1))
    high = data.draw(st.integers(low + 1, len(places)))
    for row in range(low, high):
        table.values[2 * row + 1] = data.draw(value)
    table.changed(low, high)
    write_block(table, interpolation, numbers, offset, low, high)
    whole = block_of(table, interpolation, offset)
    assert numbers[offset:-1] == pytest.approx(whole[offset:-1], rel=1e-9, abs=1e-9)
    assert all(each != each for each in (*numbers[:offset], numbers[-1]))
