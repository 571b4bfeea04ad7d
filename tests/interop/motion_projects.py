"""Runs public projects that move axes, unmodified, and writes down what they did.

    python -m tests.interop.motion_projects FOLDER docs/coverage/motion-projects.md

FOLDER is that of `tests.interop.survey`. Each project gets virtual axes, linked by `plc` of
`[[axis]]`. What an operator or a client would write is written to its variables; nothing in it is
changed. The page is written again after each project.
"""

import struct
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from achse.motion import Axis, StateBit
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.conftest import RouterClient

__all__ = ["PROJECTS", "MotionProject", "page_of", "witness"]

_NEAR = 1e-6

Report = Iterator[tuple[str, str]]
"""What was asked for, and what came of it."""


class Cell:
    """A station with the project, its variables by path: `plc["GVL.axes[1].bEnable"]`."""

    def __init__(self, project: Path, axes: Sequence[str]) -> None:
        document: dict[str, Any] = {
            "plc": [{"sources": project.name}],
            "axis": [{"id": n, "name": f"A{n}", "plc": name} for n, name in enumerate(axes, 1)],
        }
        self.station = Station(parse(document, "motion.toml"), base=project.parent)
        self.plc = self.station.plcs[851]

    def axis(self, number: int) -> Axis:
        assert self.station.nc is not None
        return self.station.nc.axis(number)

    def run(self, seconds: float) -> None:
        self.station.advance(seconds)
        if self.plc.failure:
            raise RuntimeError(self.plc.failure.strip().splitlines()[-1])

    def until(self, reached: Callable[[], bool], seconds: float) -> bool:
        """Whether it came to that within the time."""
        for _ in range(round(seconds / 0.05)):
            if reached():
                return True
            self.run(0.05)
        return reached()

    def instance(self, name: str) -> Any:
        return self.plc.instance(name)


def _powered(axis: Axis) -> bool:
    return bool(axis.state_dword & StateBit.OPERATIONAL)


def _homed(axis: Axis) -> bool:
    return bool(axis.state_dword & StateBit.HOMED)


def _said(reached: bool, axis: Axis) -> str:
    place = f"at {axis.set_position:.3f}"
    error = f", axis error 0x{axis.error_code:X}" if axis.error_code else ""
    return f"{'yes' if reached else 'no'}, {place}{error}"


def slits(cell: Cell) -> Report:
    """Eight axes: four blades follow two gaps and two centres by MC_GearInMultiMaster."""
    main, lists = cell.instance("MAIN"), cell.instance("GVL")
    axes = lists["axes"]
    ready = cell.until(lambda: main["iState"] == 14, 10.0)
    yield (
        "its own start: gear out, power, set positions, couple four blades",
        (
            f"{'done' if ready else 'stuck'} in state {main['iState']},"
            f" powered {sum(_powered(cell.axis(n)) for n in range(1, 9))} of 8,"
            f" coupled {sum(bool(cell.axis(n).coupling.law) for n in range(1, 5))} of 4"
        ),
    )

    def command(number: int, name: str, **inputs: Any) -> None:
        one = axes[number]
        for key, value in inputs.items():
            one[key] = value
        one["eCommand"] = COMMANDS[name]
        one["bExecute"] = True

    command(5, "MoveAbsolute", fPosition=10.0, fVelocity=5.0)
    gap = cell.until(lambda: abs(cell.axis(5).set_position - 10.0) < _NEAR, 10.0)
    blades = ", ".join(f"{cell.axis(n).set_position:.3f}" for n in range(1, 5))
    yield (
        "open the vertical gap to 10 (MC_MoveAbsolute, buffered)",
        (f"{_said(gap, cell.axis(5))}; blades {blades}"),
    )
    main["bDisableMC"] = True
    free = cell.until(lambda: main["iState"] == 100, 5.0)
    yield "leave the masters (MC_GearOut)", f"{'yes' if free else 'no'}, state {main['iState']}"
    main["bSimulate"][3] = True
    stage = main["simulated"][3]
    stage["fLowLim"], stage["fHighLim"] = -100.0, 100.0
    stage["fLowAbs"], stage["fHighAbs"] = 4.0, 6.0
    axes[3]["fHomePosition"] = 0.0
    command(3, "HomeStepAbsoluteSwitch", fHomeVelocity=2.0)
    cell.run(0.5)
    is_there = cell.until(lambda: bool(axes[3]["bDone"]) and not axes[3]["bBusy"], 30.0)
    yield "home blade 3 to its switch (MC_StepAbsoluteSwitch)", _said(is_there, cell.axis(3))
    command(3, "HomeFinish", fHomeDistance=0.0)
    cell.run(1.0)
    yield "end of the homing (MC_FinishHoming)", _said(_homed(cell.axis(3)), cell.axis(3))


COMMANDS = {"MoveAbsolute": 17, "HomeFinish": 40, "HomeStepAbsoluteSwitch": 43}
"""Values of its eMcCommand."""


def called_over_ads(cell: Cell) -> Report:
    """Four axes with two loops each; a client calls methods (TcRpcEnable) that move them."""
    client = RouterClient(cell.station.router, 851)

    def call(name: str, *values: float) -> None:
        path = f"MAIN.FB_Functions#{name}".encode() + b"\0"
        (handle,) = struct.unpack("<I", client.exchange(0xF003, 0, 4, path))
        indexes, reals = map(int, values[:2]), values[2:]
        client.exchange(0xF005, handle, 1, struct.pack(f"<HH{len(reals)}d", *indexes, *reals))

    cell.run(0.1)
    call("M_EnableAxis", 0, 0)
    on = cell.until(lambda: _powered(cell.axis(1)), 1.0)
    yield "power: M_EnableAxis(0, 0) over ADS (MC_Power)", _said(on, cell.axis(1))
    cell.run(0.2)
    call("M_MoveAbsolute", 0, 0, 25.0, 50.0)
    there = cell.until(lambda: abs(cell.axis(1).set_position - 25.0) < _NEAR, 5.0)
    yield "move: M_MoveAbsolute(0, 0, 25, 50) over ADS", _said(there, cell.axis(1))
    call("M_MoveRelative", 0, 0, -5.0, 50.0)
    there = cell.until(lambda: abs(cell.axis(1).set_position - 20.0) < _NEAR, 5.0)
    yield "move: M_MoveRelative(0, 0, -5, 50) over ADS", _said(there, cell.axis(1))
    yield (
        "home: M_MoveHome",
        (
            "not tried: it calls MC_Home once and never again, so nobody follows the homing;"
            " methods that read parameters wait in a WHILE for an answer that comes after the cycle"
        ),
    )


def buttons(cell: Cell) -> Report:
    """Two axes; each button of its screen is a variable at the Execute of a block."""
    main, axis = cell.instance("MAIN"), cell.axis(1)
    main["MaquinaLigada"] = True
    yield "power (MC_Power)", _said(cell.until(lambda: _powered(axis), 1.0), axis)
    main["bMoverEixo1Abs"] = True
    done = cell.until(lambda: bool(main["fb_MoveAbsolutoEixo1"]["Done"]), 10.0)
    yield "to 250 at 50 (MC_MoveAbsolute)", _said(done, axis)
    main["bMoverEixo1Rel"] = True
    done = cell.until(lambda: bool(main["fb_MoveRelativoEixo1"]["Done"]), 10.0)
    yield "by 10 at 5 (MC_MoveRelative)", _said(done, axis)
    main["bMoverEixo1Velo"] = True
    runs = cell.until(lambda: bool(main["fb_MoveVeloEixo1"]["InVelocity"]), 5.0)
    yield "endlessly at 25 (MC_MoveVelocity)", f"{'yes' if runs else 'no'}, {axis.set_velocity:g}"
    main["bHaltEixo1"] = True
    done = cell.until(lambda: bool(main["fb_HaltEixo1"]["Done"]), 5.0)
    yield "MC_Halt", f"{_said(done, axis)}, MC_MoveVelocity aborted"
    main["lrPosicaoMod"] = 90.0
    main["bMoverEixo1Mod"] = True
    done = cell.until(lambda: bool(main["fb_MoveEixo1Mod"]["Done"]), 20.0)
    yield "to 90 degrees, shortest way (MC_MoveModulo)", _said(done, axis)
    main["bPararEixo1"] = True
    done = cell.until(lambda: bool(main["fb_ParaEixo1"]["Done"]), 5.0)
    yield "MC_Stop", f"{_said(done, axis)}, locked {bool(axis.motion_locked)}"
    main["bPararEixo1"] = False
    free = cell.until(lambda: not axis.motion_locked, 1.0)
    main["MaquinaLigada"] = False
    off = cell.until(lambda: not _powered(axis), 1.0)
    yield "lock released, power off", f"{'yes' if free else 'no'}, {'yes' if off else 'no'}"
    yield "home", "the project has no homing"


@dataclass(frozen=True)
class MotionProject:
    """Where it is, its AXIS_REFs in the order of axes, and what is done with it."""

    repository: str
    project: str
    axes: Sequence[str]
    script: Callable[[Cell], Report]


PROJECTS = (
    MotionProject(
        "ISISComputingGroup+BeckhoffPLCCode",
        "PLC Development/DrivePLC/DrivePLC.plcproj",
        [f"GVL.axes[{n}].Axis" for n in range(1, 9)],
        slits,
    ),
    MotionProject(
        "niallasmith+TwinCAT-ADS-MC",
        "XAE/TwinCAT-ADS-MC/PLC-Project/PLC-Project.plcproj",
        [f"MAIN.Axis[{n}][0]" for n in range(4)],
        called_over_ads,
    ),
    MotionProject(
        "MatheusNespolo+TwinCAT",
        "Motion-Control/MotionControl/MotionControl/MotionControl/MotionControl.plcproj",
        ["GVL_Axes.Axis1", "GVL_Axes.Axis2"],
        buttons,
    ),
)


def witness(folder: Path, each: MotionProject) -> list[tuple[str, str]]:
    """What came of one project; an error is its last line."""
    project = folder / each.repository / each.project
    lines: list[tuple[str, str]] = []
    try:
        lines.extend(each.script(Cell(project, each.axes)))
    except Exception as failure:  # whatever it is, it belongs onto the page
        lines.append(("then", f"{type(failure).__name__}: {failure}"[:300]))
    return lines


def page_of(reports: Mapping[str, Sequence[tuple[str, str]]]) -> str:
    """The page: a table per project."""
    text = (
        "# Public projects that move axes\n\n"
        "Made by `python -m tests.interop.motion_projects`:"
        " unmodified projects with virtual axes.\n"
    )
    for name, lines in reports.items():
        text += f"\n## {name.replace('+', '/')}\n\n| asked | came |\n| --- | --- |\n"
        text += "".join(f"| {question} | {came} |\n" for question, came in lines)
    return text


def main(folder: Path, page: Path) -> None:
    """See the module."""
    reports: dict[str, Sequence[tuple[str, str]]] = {}
    for each in PROJECTS:
        if (folder / each.repository).is_dir():
            reports[each.repository] = witness(folder, each)
            page.write_text(page_of(reports), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]))
