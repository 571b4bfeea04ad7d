"""One table: what it may be, when it is a function, how it is read."""

import random
from array import array

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import TableSubType, TableType
from achse.motion.tables.errors import TableError
from achse.motion.tables.table import MOTION_POINT, Table, TableScaling


def table(
    numbers: list[float],
    sub_type: TableSubType = TableSubType.MONOTONIC_CYCLIC,
    columns: int = 2,
    main_type: TableType = TableType.CAMMING,
) -> Table:
    result = Table(7, main_type, sub_type, len(numbers) // columns, columns)
    result.values = array("d", numbers)
    return result


LIFTING = [0.0, 0.0, 90.0, 30.0, 360.0, 100.0]


def test_every_kind_has_its_sub_types() -> None:
    allowed = {
        TableType.CAMMING: {1, 2, 3, 4},
        TableType.CHARACTERISTIC: {1, 3},
        TableType.MOTION_FUNCTION: {3, 4},
    }
    for main_type, sub_types in allowed.items():
        for sub_type in range(7):
            if sub_type in sub_types:
                assert Table(1, main_type, sub_type, 2, 1).element_count == 2
            else:
                with pytest.raises(TableError) as caught:
                    Table(1, main_type, sub_type, 2, 1)
                assert caught.value.error is NcError.TABLE_SUB_TYPE


def test_period_stroke_and_continuation() -> None:
    cam = table(LIFTING)
    assert (cam.master_period, cam.slave_stroke, cam.cyclic) == (360.0, 100.0, True)
    assert cam.read(450.0) == pytest.approx((130.0, 70.0 / 270.0, 0.0))
    assert cam.read(-270.0)[0] == pytest.approx(-70.0)
    cam = table(LIFTING, TableSubType.MONOTONIC_LINEAR)
    with pytest.raises(TableError, match="450 above 360"):
        cam.read(450.0)


def test_one_column_is_over_the_numbers_of_its_rows() -> None:
    cam = table([5.0, 7.0, 6.0], TableSubType.EQUIDISTANT_LINEAR, 1)
    assert (cam.step_width, cam.master_period) == (1.0, 2.0)
    assert cam.points() == [(0.0, 5.0), (1.0, 7.0), (2.0, 6.0)]
    with pytest.raises(TableError, match="1 column"):
        table([5.0, 7.0], TableSubType.MONOTONIC_LINEAR, 1).checked()
    with pytest.raises(TableError, match="1 column"):
        table([5.0, 7.0], TableSubType.EQUIDISTANT_LINEAR, 1, TableType.CHARACTERISTIC).checked()


def test_columns_beyond_the_second_are_kept_only() -> None:
    cam = table([0.0, 1.0, 99.0, 5.0, 2.0, -99.0], columns=3)
    assert cam.points() == [(0.0, 1.0), (5.0, 2.0)]


@pytest.mark.parametrize(
    ("numbers", "sub_type", "error"),
    [
        ([0.0, 0.0, 0.0, 1.0], TableSubType.MONOTONIC_CYCLIC, NcError.TABLE_NOT_MONOTONIC),
        ([0.0, 0.0, -1.0, 1.0], TableSubType.MONOTONIC_LINEAR, NcError.TABLE_NOT_MONOTONIC),
        ([0.0, 0.0, 1.0, 1.0, 3.0, 1.0], TableSubType.EQUIDISTANT_CYCLIC, NcError.TABLE_STEP_WIDTH),
        ([0.0, 0.0, 1.0, 1e10], TableSubType.MONOTONIC_LINEAR, NcError.TABLE_PARAMETER),
        ([0.0, 0.0, 1e10, 1.0], TableSubType.MONOTONIC_LINEAR, NcError.TABLE_PARAMETER),
    ],
)
def test_what_is_no_function(numbers: list[float], sub_type: TableSubType, error: NcError) -> None:
    with pytest.raises(TableError) as caught:
        table(numbers, sub_type).checked()
    assert caught.value.error is error


def test_a_scaling_is_for_a_range_of_places_or_for_all() -> None:
    cam = table(LIFTING)
    cam.scaling = TableScaling(2.0, 10.0, 0.5, 1.0, 3.0)
    assert cam.points() == [(10.0, 1.0), (55.0, 181.0), (190.0, 601.0)]
    cam.changed()
    cam.scaling = TableScaling(1.0, 0.0, 1.0, 5.0, 1.0, 80.0, 100.0)
    assert cam.points() == [(0.0, 0.0), (90.0, 35.0), (360.0, 100.0)]


def test_points_of_a_motion_function_have_places_too() -> None:
    result = Table(7, TableType.MOTION_FUNCTION, 3, 2, 1)
    assert (result.of_points, result.size, len(result.motion)) == (True, 14, 112)
    MOTION_POINT.pack_into(result.motion, 0, 1, 15, 0, 1, 0, 0.0, 0.0, 0.0, 0.0, 0.0)
    MOTION_POINT.pack_into(result.motion, 56, 2, 0, 0, 1, 0, 180.0, 50.0, 0.0, 0.0, 0.0)
    assert result.points() == [(0.0, 0.0), (180.0, 50.0)]


@pytest.mark.parametrize("seed", range(60))
def test_few_changed_rows_are_looked_at_as_the_whole_table(seed: int) -> None:
    """Any numbers into any rows: the same function, or the same refusal, as looked at whole."""
    dice = random.Random(seed)
    equidistant, columns = dice.random() < 0.5, dice.choice((2, 2, 3, 1))
    equidistant = equidistant or columns == 1
    kind = TableSubType.EQUIDISTANT_LINEAR if equidistant else TableSubType.MONOTONIC_LINEAR
    numbers = [dice.uniform(-9.0, 9.0) for _ in range(64 * columns)]
    if columns > 1:
        numbers[::columns] = [10.0 * row for row in range(64)]
    cam = table(numbers, kind, columns)
    if not equidistant and dice.random() < 0.5:
        cam.scaling = TableScaling(1.5, 3.0, 2.0, -1.0, 0.5, 0.0, dice.choice((0.0, 1e3)))
    cam.checked()
    for _ in range(40):
        low = dice.randrange(60)
        high = low + dice.randint(1, 4)
        for at in range(low * columns, high * columns):
            place = at % columns == 0 and columns > 1
            if place:
                cam.values[at] = 10.0 * (at // columns)
                if dice.random() < 0.1:
                    cam.values[at] += dice.choice((1e-12, 9.0, 10.0, -25.0))
            else:
                cam.values[at] = dice.choice((dice.uniform(-9.0, 9.0), 1e9))
                if dice.random() < 0.02:
                    cam.values[at] = 1e10
        cam.changed(low, high)
        anew = table(list(cam.values), kind, columns)
        anew.scaling = cam.scaling
        assert _function_or_code(cam) == _function_or_code(anew)


def _function_or_code(cam: Table) -> object:
    try:
        return cam.checked()
    except TableError as fault:
        return fault.error
