"""`#set …#`: each row by its name, the ranges of its values."""

import pytest

from achse.gcode.canon import PathSetting
from achse.gcode.text.words import PATH_PARAMETERS, PathParameterRow
from tests.gcode.programs import commands, refused


@pytest.mark.parametrize("row", PATH_PARAMETERS.values(), ids=lambda row: row.name)
def test_each_parameter_keeps_to_its_ranges(row: PathParameterRow) -> None:
    low = [str(least) for least, _ in row.ranges]
    setting = commands(f"#set {row.name}({';'.join(low)})#")[0]
    assert isinstance(setting, PathSetting)
    assert setting.parameter is row.parameter
    assert setting.values == tuple(least for least, _ in row.ranges)
    for place in range(len(low)):
        wrong = [*low[:place], "-1", *low[place + 1 :]]
        error = refused(f"#set {row.name}({';'.join(wrong)})#")
        assert error.word == row.name.upper()
        assert error.column == 6
    assert refused(f"#set {row.name}({';'.join([*low, '1'])})#").word == row.name.upper()
