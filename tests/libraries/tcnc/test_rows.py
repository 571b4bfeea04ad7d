"""Every row of the manual's tables: blocks, functions, structures and choices of TcNC.

Tables: `tests/data/tcnc_*.tsv` (004 §3 … §6). Where the manual misprints, `MISPRINTS` says what is
meant.
"""

import re
import struct
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from achse.codes.axis import ControlBit, HomingState, MotionState, OperationModeBit, StateBit
from achse.codes.nc.choices import AxisType, ControllerType, DriveType
from achse.codes.nc.structures import FROM_PLC, TO_PLC
from achse.devices.nc import NcDevice
from achse.devices.nc.axes.structures import NC_TO_PLC_TC2, PLC_TO_NC
from achse.iec import StructType, resolved
from achse.motion.couplings.masters import MASTER, MASTER_AND_SLAVE, SINGLE, SLAVE
from achse.st.declared.standard import standard_libraries
from achse.st.syntax.units import Function, FunctionBlock, TypeDeclaration
from achse.station import Station
from achse.station.configuration.station_file import parse

DATA = Path(__file__).parents[2] / "data"


def _table(name: str) -> list[list[str]]:
    lines = (DATA / name).read_text(encoding="utf-8").splitlines()
    width = len(lines[0].split("\t"))
    return [(line.split("\t") + [""] * width)[:width] for line in lines[1:]]


BLOCKS = _table("tcnc_blocks.tsv")
ENUMS = _table("tcnc_enums.tsv")
STRUCTS = _table("tcnc_structs.tsv")

MISPRINTS = {
    ("FB_WritePositionCorrection", "AxisRefOut"): "PLCTONC_AXLESTRUCT",
    ("FB_WritePositionCorrection", "Busy"): "BOOL",
}
"""Types as they are meant."""

FURTHER = {
    "AXACT": ["TMOUT"],  # TMOU is printed; the other blocks spell it so
    "FB_WritePositionCorrection": ["CorrectionLength"],  # CorrectionLenght is printed
}
"""Inputs in the spelling that the texts and samples have, behind the printed ones."""

SECTIONS = {"in": "VAR_INPUT", "out": "VAR_OUTPUT", "inout": "VAR_IN_OUT"}


@cache
def _units() -> dict[str, Any]:
    return {
        unit.name: unit
        for parsed in standard_libraries()
        if parsed.source.path.startswith("tcnc/")
        for unit in parsed.units
    }


def _type(spec: Any) -> str:
    """A type as it is printed."""
    if (target := getattr(spec, "target", None)) is not None:
        return f"POINTER TO {_type(target)}"
    if (length := getattr(spec, "length", None)) is not None:
        return f"{spec.family}({length.text})"
    if (ranges := getattr(spec, "dimensions", None) or getattr(spec, "bounds", None)) is not None:
        first, last = ranges[0].low.text, ranges[0].high.text
        return f"ARRAY[{first}..{last}] OF {_type(spec.element)}"
    return str(getattr(spec, "name", None) or spec.family)


def _variables(unit: Any, section: str) -> list[tuple[str, str]]:
    return [
        (name.name, _type(each.type))
        for block in unit.blocks
        if block.section == section
        for each in block.variables
        for name in each.names
    ]


@pytest.mark.parametrize("name", sorted({row[0] for row in BLOCKS}))
def test_a_block_or_function_as_printed(name: str) -> None:
    unit: Any = _units()[name]
    rows = [row[1:] for row in BLOCKS if row[0] == name]
    assert isinstance(unit, FunctionBlock if rows[0][0] == "FB" else Function)
    for direction, section in SECTIONS.items():
        printed = [
            (parameter, MISPRINTS.get((name, parameter), type))
            for _, where, parameter, type in rows
            if where == direction and parameter != "return"
        ]
        here = _variables(unit, section)
        further = FURTHER.get(name, []) if direction == "in" else []
        assert here[: len(printed)] == printed
        assert [each for each, _ in here[len(printed) :]] == further
    for _, _, parameter, type in rows:
        if parameter == "return":
            assert _type(getattr(unit, "returns")) == type  # noqa: B009


def test_eleven_blocks_and_33_functions() -> None:
    named = {(row[0], row[1]) for row in BLOCKS}
    kinds = [kind for _, kind in named]
    assert (kinds.count("FB"), kinds.count("function")) == (11, 33)
    public = {
        name
        for name, unit in _units().items()
        if isinstance(unit, Function | FunctionBlock) and not name.startswith("_")
    }
    assert public == {name for name, _ in named}


@cache
def _declared() -> dict[str, StructType[Any]]:
    """The structures as a PLC has them."""
    names = ("NCTOPLC_AXLESTRUCT", "NCTOPLC_AXLESTRUCT2", "PLCTONC_AXLESTRUCT",
             "ST_CompensationDesc", "ST_CompensationElement")  # fmt: skip
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        variables = " ".join(f"v{n} : {name};" for n, name in enumerate(names))
        text = f"PROGRAM MAIN VAR {variables} END_VAR END_PROGRAM"
        (Path(folder) / "a.st").write_text(text, encoding="utf-8")
        document = {"plc": [{"sources": "a.st"}]}
        station = Station(parse(document, "a.toml"), base=Path(folder))
    placed = {each.name: each.variable.type for each in station.plcs[851].variables}
    types = {name: resolved(placed[f"MAIN.v{n}"]) for n, name in enumerate(names)}
    assert all(isinstance(each, StructType) for each in types.values())
    return types  # type: ignore[return-value]


SIZES = {"UINT32": 4, "INT32": 4, "UINT16": 2, "REAL64": 8, "DWORD": 4, "LREAL": 8, "DINT": 4,
         "UDINT": 4, "UINT": 2, "BOOL": 1}  # fmt: skip
CODES = {"UINT32": "DWORD", "INT32": "DINT", "UINT16": "UINT", "REAL64": "LREAL"}


@pytest.mark.parametrize(
    ("struct_name", "size"),
    [("NCTOPLC_AXLESTRUCT", 128), ("NCTOPLC_AXLESTRUCT2", 128), ("PLCTONC_AXLESTRUCT", 128),
     ("ST_CompensationDesc", 25), ("ST_CompensationElement", 16)],
)  # fmt: skip
def test_a_structure_byte_by_byte(struct_name: str, size: int) -> None:
    """Names, types, order and offsets; rows that only newer names have are looked at below."""
    type = _declared()[struct_name]
    assert type.size == size
    printed = [row for row in STRUCTS if row[0] == struct_name and row[2] == "-" and row[4]]
    names = [row[4] for row in printed]
    own = [field.name for field in type.fields]
    if struct_name == "PLCTONC_AXLESTRUCT":  # the declaration ends with hidden bytes 72 … 127
        assert (own[-1], names[-1]) == ("nReserved_HIDDEN", "nReserved")
        assert (type.fields[-1].offset, type.fields[-1].type.size) == (72, 56)
        own, names, printed = own[:-1], names[:-1], printed[:-1]
    assert own == names
    for field, (_, place, _, kind, _, _) in zip(type.fields, printed, strict=False):
        first, last = (*map(int, place.split("-")),) if place else (field.offset, None)
        assert field.offset == first
        if last is not None:
            assert field.type.size == last - first + 1
        if kind in SIZES:
            assert field.type.size == SIZES[kind]
            assert field.type.name == (
                "DWORD"
                if field.name.startswith("n") and kind == "UINT32"
                else CODES.get(kind, kind)
            )
        else:
            assert field.type.name == kind


BIT_NAMES = {
    "Protected": "PROTECTED",
    "NewTargetPos": "NEW_TARGET_POSITION",
    "ExtSetPointGenEnabled": "EXTERNAL_SETPOINT_ENABLED",
    "CmdBuffered": "COMMAND_BUFFERED",
    "PTPmode": "PTP_MODE",
    "PosAreaMonitoring": "POSITION_AREA_MONITORING",
    "TargetPosMonitoring": "TARGET_POSITION_MONITORING",
    "PEHTimeMonitoring": "PEH_TIME_MONITORING",
    "BacklashComp": "BACKLASH_COMPENSATION",
    "PosLagMonitoring": "POSITION_LAG_MONITORING",
    "VeloLagMonitoring": "VELOCITY_LAG_MONITORING",
    "PosCorrection": "POSITION_CORRECTION",
}
UNUSED = {
    ("NCTOPLC_AXLESTRUCT2", "0-3", 15): StateBit.PHASING_ACTIVE,
    ("NCTOPLC_AXLESTRUCT2", "0-3", 18): StateBit.DRIVE_LIMIT_ACTIVE,
    ("NCTOPLC_AXLESTRUCT2", "36-39", 22): OperationModeBit.ALLOW_COMMANDS_WITH_EXTERNAL_SETPOINT,
}
"""Not implemented, or reserved, in TwinCAT 2; the library of TwinCAT 3 names them."""
OUR_OWN_WORD = {("PLCTONC_AXLESTRUCT", 9), ("PLCTONC_AXLESTRUCT", 30), ("PLCTONC_AXLESTRUCT", 31)}
"""Not implemented, or internal, in the manual too."""


def test_every_bit_of_the_double_words() -> None:
    words = {
        ("NCTOPLC_AXLESTRUCT2", "0-3"): StateBit,
        ("NCTOPLC_AXLESTRUCT2", "36-39"): OperationModeBit,
        ("PLCTONC_AXLESTRUCT", "0-3"): ControlBit,
    }
    rows = [row for row in STRUCTS if row[3] == "BIT" and (row[0], row[1]) in words]
    assert len(rows) == 32 + 18 + 13
    for name, place, bit, _, old, new in rows:
        if (name, place, int(bit) if bit.isdecimal() else -1) in UNUSED:
            mask = UNUSED[name, place, int(bit)]
            assert (old, mask) == ("", 1 << int(bit))
        elif old and (name, int(bit)) not in OUR_OWN_WORD:
            word: Any = words[name, place]
            known = BIT_NAMES.get(new, re.sub(r"(?<=[a-z])(?=[A-Z])", "_", new).upper())
            assert word[known] == 1 << int(bit)
        elif not old:
            first, _, last = bit.partition("-")
            taken = {each.bit_length() - 1 for each in words[name, place]}
            reserved = set(range(int(first), int(last or first) + 1))
            # Bits 8, 12 and 13 are reserved here and have names in TwinCAT 3.
            assert not taken & reserved - {8, 12, 13}


def test_the_newer_names_lie_where_the_older_lie() -> None:
    """What the NC exchanges with TwinCAT 2, under the names since 2.11."""
    for name, members, form in (
        ("NCTOPLC_AXLESTRUCT2", TO_PLC, NC_TO_PLC_TC2), ("PLCTONC_AXLESTRUCT", FROM_PLC, PLC_TO_NC)
    ):  # fmt: skip
        by_name = {each.name: each for each in members}
        if name.startswith("NCTOPLC"):
            by_name["nAxisModeConfirmation"] = by_name["AxisModeConfirmation"]  # a misprint
        rows = [row for row in STRUCTS if row[0] == name and row[2] == "-" and row[5]]
        offset = 0
        for _, place, _, kind, _, new in rows:
            member = by_name[new]
            first, last = map(int, place.split("-"))
            assert SIZES[member.type] == last - first + 1 == SIZES[kind]
            assert first >= offset
            offset = last + 1
        assert form.size == 128
    probe = bytearray(128)
    rows = [row for row in STRUCTS if row[0] == "PLCTONC_AXLESTRUCT" and row[2] == "-" and row[5]]
    for n, row in enumerate(rows, 1):
        first = int(row[1].split("-")[0])
        code = {"UINT32": "<I", "INT32": "<i", "REAL64": "<d"}[row[3]]
        struct.pack_into(code, probe, first, n)
    fields = {each.name: each.field for each in FROM_PLC}
    taken = PLC_TO_NC.decode(bytes(probe))
    assert [taken[fields[row[5]]] for row in rows] == list(range(1, len(rows) + 1))


ENUM_TYPES = {row[0] for row in ENUMS if row[0].startswith("E_")}


@pytest.mark.parametrize("name", sorted(ENUM_TYPES))
def test_an_enumeration_as_printed(name: str) -> None:
    unit = _units()[name]
    assert isinstance(unit, TypeDeclaration)
    here, number = [], -1
    for value in unit.type.values:  # type: ignore[union-attr]
        number = number + 1 if value.value is None else int(value.value.text)  # type: ignore[union-attr]
        here.append((str(number), value.name))
    assert here == [(row[1], row[2]) for row in ENUMS if row[0] == name]


def test_numbers_that_the_nc_shows() -> None:
    shown = {
        "HomingState (nCalibrationState)": {int(each) for each in HomingState},
        "CoupleState (nCoupleState)": {SINGLE, MASTER, MASTER_AND_SLAVE, SLAVE},
        "AxisState master, continuous (servo)": set(range(6)) | {41, 42},
        "AxisState master, discrete (high/low speed)": set(range(5)),
        "AxisState slave, continuous (servo)": {0, 11, 12, 13},
    }
    for name, numbers in shown.items():
        assert {int(row[1]) for row in ENUMS if row[0] == name} == numbers
    assert {int(each) for each in MotionState} == set(range(6)) | {11, 12, 13, 41, 42}


def _numbers(name: str) -> list[int]:
    return [int(row[1]) for row in ENUMS if row[0].startswith(name)]


def test_every_start_mode(bench: Any) -> None:
    """How each travels: direction, end and velocity of the axis."""
    on = bench(
        a="AXACT",
        axis={
            "jog_velocity_slow": 11.0, "jog_velocity_fast": 22.0, "rapid_traverse_velocity": 33.0,
            "pulse_distance_positive": 4.0, "pulse_distance_negative": 6.0,
        },
    )  # fmt: skip
    endless = {
        3: 30.0,
        4: -30.0,
        272: 11.0,
        273: -11.0,
        528: 22.0,
        529: -22.0,
        784: 33.0,
        785: -33.0,
    }
    steps = {1: None, 2: 5.0, 5: None, 288: 4.0, 289: -6.0, 544: 0.001, 545: -0.001, 800: 0.01,
             801: -0.01, 1056: 0.1, 1057: -0.1, 1312: 1.0, 1313: -1.0}  # fmt: skip
    assert sorted([*endless, *steps]) == sorted(_numbers("Start mode"))
    for mode in _numbers("Start mode"):
        before = on.axis().set_position
        on.set("a", AXID=1, MODE=mode, TARGPOS=5.0, VELOCITY=30.0, START=True)
        on.call(2)
        assert on.shown("a") == (False, False, 0), mode
        on.call(300)
        if mode in endless:
            assert on.axis().set_velocity == endless[mode]
            on.set("a", STOP=True)
            on.call(100)
        else:
            step = steps[mode]
            while on.main["fromNc1"]["nStateDWord"] >> 8 & 1:
                on.call(20)
            if mode == 5:
                assert on.axis().set_position % 360.0 == pytest.approx(5.0)
            else:
                end = 5.0 if step is None else before + step
                assert on.axis().set_position == pytest.approx(end, abs=1e-9)
        on.set("a", START=False, STOP=False)
        on.call()


def test_every_mode_of_axfnc(bench: Any) -> None:
    """1, 2 and 5 set positions and targets, 1 and 2 drive directly."""
    on = bench(f="AXFNC", a="AXACT")

    def command(edge: str, mode: int, value: float) -> bool:
        on.set("f", AXID=1, MODE=mode, VAL=value, **{edge: True})
        on.call(2)
        refused: bool = on.shown("f")[1]
        on.set("f", **{edge: False})
        on.call(2)
        return not refused

    for mode in _numbers("Set-position mode"):
        assert command("SETPOS", mode, 20.0) is (mode in (1, 2, 5)), mode
    on.call(20)
    assert on.axis().actual_position == pytest.approx(20.0, abs=0.05)
    for mode in _numbers("Drive-output mode"):
        on.set("f", AXID=1, MODE=mode, VAL=10.0, SETDRIVE=True)
        on.call(60)
        assert on.shown("f") == (False, False, 0)
        full = on.axis().drive.reference_velocity
        speed = full / 10.0 if mode == 1 else 10.0
        assert on.axis().actual_velocity == pytest.approx(speed, rel=0.01)
        on.set("f", SETDRIVE=False)
        on.call(200)
        assert on.axis().actual_velocity == pytest.approx(0.0, abs=1e-6)
    for mode in _numbers("New-target mode"):
        on.set("a", AXID=1, MODE=2, TARGPOS=300.0, VELOCITY=200.0, START=True)
        on.call(10)
        target = on.axis().target_position
        there = command("SETTARG", mode, 15.0)
        assert there, mode  # 3 and 4, reserved here, are the endless ones of the NC (002 §7)
        assert on.axis().target_position != target
        on.set("a", START=False, STOP=True)
        on.call(200)
        on.set("a", STOP=False)
        on.call()


def test_every_command_and_type_of_new_targets(bench: Any) -> None:
    """Types 1, 2, 5; commands 1, 2, 3 at once, 9 … 11 from the switch position on, 14 before it."""
    on = bench(n="FB_AxisNewTargPosAndVelo", a="AXACT")
    kinds = _numbers("E_TargPosType")
    for command in _numbers("E_CmdTypeNewTargPosAndVelo"):
        for kind in kinds if command in (1, 3) else kinds[:1]:
            on.set(
                "a",
                AXID=1,
                MODE=1,
                TARGPOS=on.axis().set_position + 200.0,
                VELOCITY=100.0,
                START=True,
            )
            on.call(20)
            here = on.axis().set_position
            goal = here + 300.0 if kind == 1 else 300.0
            on.set(
                "n", iAxisId=1, eCmdType=command, eTargPosType=kind, fTargPos=goal, fVelo=50.0,
                fSwitchPos=here + 60.0, bExecute=True,
            )  # fmt: skip
            on.call(2)
            block = on.main["n"]
            assert block["bErr"] is False, (command, kind, block["iErrId"])
            on.set("n", bExecute=False)
            on.call(150)
            if command in (2, 3, 10, 11, 14) and kind == 1:
                assert on.axis().set_velocity == pytest.approx(50.0)
            on.set("a", START=False, STOP=True)
            on.call(200)
            on.set("a", STOP=False)
            on.call()


def test_every_coupling_type(bench: Any) -> None:
    """The NC takes them, or refuses them for what the axes are, never as unknown."""
    from achse.codes import NcError

    types = {
        1: (2.0,), 2: (200.0, 60.0, 45.0, 0.0), 3: (200.0, 60.0, 45.0, 0.0),
        12: (1.0, 1.0, 0.0, 0.0),
        15: (5.0,), 16: (1.0, 1.0, 3.0), 18: (5.0,),
    }  # fmt: skip
    on = bench(c="AXCPL")
    assert sorted(types) == sorted(_numbers("CPLMODE"))
    for mode, parameters in types.items():
        values = {
            f"CPLPAR{n}": value for n, value in enumerate((*parameters, 0.0, 0.0, 0.0)[:4], 1)
        }
        on.set("c", AXID=2, MASTERID=1, CPLMODE=mode, CPLON=True, **values)
        on.call(2)
        _, refused, code = on.shown("c")
        assert code != NcError.SLAVE_TYPE, mode
        assert refused is (mode == 18), (mode, hex(code))  # without a second encoder
        if not refused:
            assert on.axis(2).coupling.law == mode
        on.set("c", CPLON=False, CPLOFF=not refused)
        on.call(2)
        on.set("c", CPLOFF=False)
        on.call()
        assert on.axis(2).coupling.law == 0


@pytest.mark.parametrize("absolute", _numbers("SLAVEABSOLUT"))
@pytest.mark.parametrize("kind", _numbers("Table type"))
def test_every_type_of_table(bench: Any, kind: int, absolute: int) -> None:
    types = {1: "equidistant_linear", 2: "equidistant_cyclic", 3: "monotonic_linear",
             4: "monotonic_cyclic"}  # fmt: skip
    step = 10.0 if kind < 3 else 15.0
    points = [[0.0, 0.0], [step, 5.0], [20.0, 20.0 if kind % 2 else 0.0]]
    on = bench(
        t="AXCPLTAB",
        a="AXACT",
        table=[{"id": 4, "kind": "cam", "type": types[kind], "points": points}],
    )
    on.set(
        "t", AXID=2, MASTERID=1, TABID=4, SLAVEABSOLUT=absolute, MASTERABSOLUT=absolute, CPLON=True
    )
    on.call(3)
    assert on.shown("t") == (False, False, 0)
    on.set("a", AXID=1, MODE=1, TARGPOS=step, VELOCITY=20.0, START=True)
    on.call(400)
    assert on.axis(2).set_position == pytest.approx(5.0)


def test_compensation_mode_1_and_no_other(bench: Any) -> None:
    on = bench(s="AXSCOM", a="AXACT")
    (mode,) = _numbers("Compensation mode")
    on.set("a", AXID=1, MODE=3, VELOCITY=50.0, START=True)
    on.call(50)
    on.set(
        "s", AXID=1, MODE=mode, ACCP=100.0, ACCM=100.0, VDELTA=20.0, VPROC=50.0, COMPVAL=5.0,
        COMPDIST=60.0, COMP_ON=True,
    )  # fmt: skip
    on.call(2)
    assert on.shown("s") == (False, False, 0)
    on.call(3)
    assert on.main["fromNc1"]["nStateDWord"] >> 13 & 1
    on.set("s", COMP_ON=False, COMP_OFF=True)
    on.call(2)
    assert on.shown("s") == (False, False, 0)


TWO_SPEEDS = {
    "axis_type": AxisType.DISCRETE_RAPID_CREEP.value, "drive_type": DriveType.RAPID_CREEP.value,
    "controller_type": ControllerType.RAPID_CREEP_POSITION.value,
    "creep_distance_positive": 10.0, "creep_distance_negative": 10.0,
    "brake_distance_positive": 1.0, "brake_distance_negative": 1.0,
}  # fmt: skip


def _drive_bits(name: str) -> dict[tuple[int, str], int]:
    return {
        (int(row[1]), row[4]): 1 << int(row[2])
        for row in STRUCTS
        if row[0].startswith(name) and row[3] == "BIT" and row[4]
    }


def test_the_interface_of_a_two_speed_drive(bench: Any) -> None:
    """004 §6.1, §6.2: which bits are on, and how velocity and override choose the speed."""
    bits = _drive_bits("DRIVE_IF_HIGHLOW")
    assert len(bits) == 12
    on = bench(a="AXACT", axis=TWO_SPEEDS)
    drive = on.axis().drive

    def output() -> tuple[int, int]:
        on.call(20)
        return drive.control_byte, drive.extended_control_byte

    assert output()[0] == bits[8, "bBreak"]
    modes = {
        (3, 60.0, 1_000_000): ("bPlusHigh", "bDirectionPlus", "bVeloHigh"),
        (4, 60.0, 1_000_000): ("bMinusHigh", "bDirectionMinus", "bVeloHigh"),
        (3, 50.0, 1_000_000): ("bPlusLow", "bDirectionPlus", "bVeloLow"),
        (4, 1.0, 1_000_000): ("bMinusLow", "bDirectionMinus", "bVeloLow"),
        (3, 60.0, 500_000): ("bPlusLow", "bDirectionPlus", "bVeloLow"),
        (3, 60.0, 500_001): ("bPlusHigh", "bDirectionPlus", "bVeloHigh"),
    }
    for (mode, velocity, override), (main, direction, speed) in modes.items():
        on.main["toNc1"]["nOverride"] = override
        on.set("a", AXID=1, MODE=mode, VELOCITY=velocity, START=True)
        assert output() == (
            bits[8, main] | bits[8, "bBreakInv"],
            bits[9, direction] | bits[9, speed] | bits[9, "bBreakInv"],
        ), (mode, velocity, override)
        on.set("a", START=False, STOP=True)
        on.call(300)
        on.set("a", STOP=False)
        on.call()
        assert output()[1] == bits[9, "bBreak"]
    on.main["toNc1"]["nOverride"] = 99
    on.set("a", START=True)
    assert output()[0] & (bits[8, "bPlusHigh"] | bits[8, "bPlusLow"]) == 0
    on.set("a", START=False, VELOCITY=0.0)
    on.call(2)
    on.set("a", START=True)
    on.call(2)
    assert on.shown("a")[1]
    start = [row[1] for row in ENUMS if row[0].startswith("Start velocity range")]
    override_rows = [row[1] for row in ENUMS if row[0].startswith("Override range")]
    assert (len(start), len(override_rows)) == (3, 3)


def test_a_structure_of_twelve_bytes(bench: Any) -> None:
    """Both drive interfaces: two outputs, two control bytes, two reserved ones."""
    for name in ("DRIVE_IF_HIGHLOW", "DRIVE_IF_STEPPER"):
        rows = [row for row in STRUCTS if row[0].startswith(name) and row[2] == "-"]
        places = [row[1] for row in rows]
        assert places == ["0-3", "4-7", "8", "9", "10-11"]
    on = bench(a="AXACT", axis=TWO_SPEEDS)
    on.set("a", AXID=1, MODE=3, VELOCITY=60.0, START=True)
    on.call(20)
    (device,) = (each for each in on.station.devices if isinstance(each, NcDevice))
    drive = on.axis().drive
    assert device.read(0x7301, 0x00, 12) == struct.pack(
        "<iiBBH", 0, 0, drive.control_byte, drive.extended_control_byte, 0
    )
