"""Words of a block: technology, dwell, settings, and values that are refused."""

import pytest

from achse.codes import NcError
from achse.gcode.canon import (
    DwellTime,
    PathParameter,
    PathSetting,
    ProgramMessage,
    Technology,
    TechnologyWord,
)
from achse.gcode.interpretation.machine_data import MachineData
from tests.gcode.programs import commands, refused


def test_technology_words_dwell_settings_and_messages() -> None:
    result = commands(
        "S1000 T5 H-7\nG04 X0.5\nG4 F2\n#set paramVertexSmoothing(2;1;R1)#\nDYNOVR=0.5\n"
        '#MSG(ITP;LOG;"Hi")#\n#skip VirtualMovements(3)#\nM30'
    )
    words = [each for each in result if isinstance(each, TechnologyWord)]
    assert [(each.word, each.value) for each in words] == [
        (Technology.SPINDLE, 1000.0),
        (Technology.TOOL, 5.0),
        (Technology.AUXILIARY, -7.0),
    ]
    assert [each.seconds for each in result if isinstance(each, DwellTime)] == [0.5, 2.0]
    settings = [each for each in result if isinstance(each, PathSetting)]
    assert [(each.parameter, each.values) for each in settings] == [
        (PathParameter.VERTEX_SMOOTHING, (2.0, 1.0, 0.0)),
        (PathParameter.DYNAMIC_OVERRIDE, (0.5,)),
        (PathParameter.SKIP_VIRTUAL_MOVEMENTS, (3.0,)),
    ]
    assert [each.text for each in result if isinstance(each, ProgramMessage)] == ["Hi"]


@pytest.mark.parametrize(
    "wrong",
    [
        "#set paramFoo(1)#",
        "#set paramVertexSmoothing(9;1;1)#",
        "#set paramVeloJump(1;2)#",
        "#get PathAxesPos(R1;R2)#",
        "#get PathAxesPos(1;2;3)#",
        "#skip Foo(1)#",
        "DYNOVR=0",
        "DYNOVR=1.5",
        "G04",
        "G04 X-1",
        "G17 P5",
        "D300",
        "D1.5",
        "L1.5",
        "L1 P-1",
    ],
)
def test_wrong_values(wrong: str) -> None:
    assert refused(wrong).code is NcError.PROGRAM_SYNTAX_RUNNING


def test_rotation_of_r_parameters() -> None:
    data = MachineData()
    commands("R1=10\nROT Z90\nCalcRot(R1;R2;R3)\nR4=R2\nCalcInvRot(R1;R2;R3)\nM30", data)
    assert data.registers.own[4] == pytest.approx(10.0)
    assert data.registers.own[1:4] == pytest.approx([10.0, 0.0, 0.0])
