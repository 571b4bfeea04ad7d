"""A PLC with all blocks of Tc2_NCI and Tc2_NcFifoAxes, a mill, a FIFO, and what blocks ask for."""

from pathlib import Path
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame
from achse.motion.channels.program_channel import ProgramChannel
from achse.plc import PlcRuntime
from achse.st.declared.standard import standard_libraries
from achse.st.syntax.units import FunctionBlock
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.front_end import FrontEnd

CYCLE_S = 0.01

PROGRAM = """PROGRAM MAIN
VAR
    fromNci AT %I* : NCTOPLC_NCICHANNEL_REF;
    toNci AT %Q* : PLCTONC_NCICHANNEL_REF := (ChnAxesOvr := 1000000);
    unlinked : NCTOPLC_NCICHANNEL_REF;
    bLinked : BOOL := TRUE;
    tool : ToolDesc;
    shift : ZeroShiftDesc;
    places : NCI_EXT3DGROUP;
    axes : ARRAY [1..4] OF PLCTONC_AXLESTRUCT;
    numbers : ARRAY [0..999] OF LREAL;
    ids : ARRAY [0..2] OF UDINT;
    {declared}
END_VAR
{pointers}
IF bLinked THEN
{calls}
ELSE
{unlinked}
END_IF
END_PROGRAM
"""

REFERENCES = {
    "NCTOPLC_NCICHANNEL_REF": "fromNci",
    "PLCTONC_NCICHANNEL_REF": "toNci",
    "ToolDesc": "tool",
    "ZeroShiftDesc": "shift",
    "NCI_EXT3DGROUP": "places",
}

FOLDERS = ("tc2_nci/", "tc2_ncfifoaxes/")

Request = tuple[str, int, int, bytes | int]


def units() -> dict[str, Any]:
    """What both libraries declare, by name."""
    return {
        unit.name: unit
        for parsed in standard_libraries()
        if parsed.source.path.startswith(FOLDERS)
        for unit in parsed.units
        if hasattr(unit, "name")
    }


ENDLESS = ("ItpGetGeoInfoAndHParam", "ItpGetGeoInfoAndHParamEx")
"""Blocks without an edge: they ask all the time, so each has a program of its own."""


def blocks() -> list[str]:
    """The names of their public blocks that ask at an edge."""
    return sorted(
        name
        for name, unit in units().items()
        if isinstance(unit, FunctionBlock) and not name.startswith("_") and name not in ENDLESS
    )


def inputs_of(name: str) -> list[str]:
    """The inputs of a block."""
    return [
        each.name
        for block in units()[name].blocks
        if block.section == "VAR_INPUT"
        for variable in block.variables
        for each in variable.names
    ]


def _pointers(name: str) -> list[str]:
    return [
        f"a{name}.{each} := ADR(numbers);"
        for each in inputs_of(name)
        if each in ("pAddr", "AdrDataArray")
    ]


def _call(name: str, from_nci: str) -> str:
    arguments = []
    for block in units()[name].blocks:
        if block.section == "VAR_IN_OUT":
            for variable in block.variables:
                value = REFERENCES[variable.type.name]
                value = from_nci if value == "fromNci" else value
                arguments += [f"{each.name} := {value}" for each in variable.names]
    return f"    a{name}({', '.join(arguments)});"


class NciBench:
    """Blocks are instances `aItpStartStopEx`, called each 10 ms."""

    def __init__(self, folder: Path) -> None:
        names = blocks()
        text = PROGRAM.format(
            declared="\n    ".join(f"a{name} : {name};" for name in names),
            pointers="\n".join(line for name in names for line in _pointers(name)),
            calls="\n".join(_call(name, "fromNci") for name in names),
            unlinked="\n".join(_call(name, "unlinked") for name in names),
        )
        (folder / "a.st").write_text(text, encoding="utf-8")
        self.programs = folder / "programs"
        self.programs.mkdir()
        rules = [{"number": 8, "handshake": "before"}, {"number": 7, "fast": "before"}]
        document = {
            "plc": [{"sources": "a.st", "code": "plain"}],
            "system": {"root": "programs"},
            "axis": [{"id": n, "name": f"A{n}"} for n in range(1, 7)],
            "channel": [
                {
                    "id": 1,
                    "programs": "programs",
                    "m": rules,
                    "plc": ["MAIN.fromNci", "MAIN.toNci"],
                },
                {"id": 4, "type": "fifo"},
            ],
            "group": [
                {"id": 11, "name": "3D", "channel": 1},
                {"id": 20, "type": "fifo", "channel": 4, "dimension": 2},
            ],
        }
        with FrontEnd.of(text, folder / "a.st").shared():
            self.station = Station(parse(document, "a.toml"), base=folder)
        self.plc: PlcRuntime = self.station.plcs[851]
        self.main: Any = self.plc.instance("MAIN")
        assert self.station.nc is not None
        self.nc = self.station.nc
        channel = self.nc.channels.channel(1)
        assert isinstance(channel, ProgramChannel)
        self.channel = channel
        for n in range(1, 7):
            axis = self.nc.axis(n)
            axis.control_dword, axis.velocity_override = 7, 1_000_000
        self.requested_frames: list[Frame] = []
        deliver = self.station.router.deliver

        def watched(frame: Frame) -> bool:
            if AmsAddress(frame.source).port == 851 and not frame.flags & 1:
                self.requested_frames.append(frame)
            return deliver(frame)

        self.answered = deliver
        self.station.router.deliver = watched  # type: ignore[method-assign]
        self.call(3)

    def call(self, count: int = 1) -> None:
        self.station.advance(count * CYCLE_S)
        assert self.plc.failure == ""

    def until(self, state: int, most: int = 2000) -> None:
        """Until the interpreter is in a state."""
        for _ in range(most):
            if self.main["fromNci"]["ItpState"] == state:
                return
            self.call()
        raise AssertionError(f"state {self.channel.state!r}, wanted {state}")

    def shown(self, name: str) -> tuple[bool, bool, int]:
        """bBusy, bErr, and the number of the error."""
        block = self.main[f"a{name}"]
        number = block["iErrId"] if name.startswith("FiFo") else block["nErrId"]
        return block["bBusy"], block["bErr"], number

    def fire(self, name: str, edge: str = "bExecute", /, **inputs: Any) -> int:
        """A rising edge, until bBusy is gone; the number of the error."""
        block = self.main[f"a{name}"]
        block[edge] = False
        self.call()
        for key, value in inputs.items():
            block[key] = value
        self.requested_frames.clear()
        block[edge] = True
        self.call()
        for _ in range(200):
            if not self.shown(name)[0]:
                break
            self.call()
        busy, error, number = self.shown(name)
        assert not busy
        assert error == (number != 0)
        block[edge] = False
        self.call()
        return number

    def requests(self) -> list[Request]:
        """Command, group, offset, and the data or the length that was asked for."""
        requests: list[Request] = []
        for frame in self.requested_frames:
            group, offset, size = (
                int.from_bytes(frame.data[n : n + 4], "little") for n in (0, 4, 8)
            )
            assert AmsAddress(frame.target).port == 500
            if frame.command == Command.READ:
                requests.append(("R", group, offset, size))
            elif frame.command == Command.WRITE:
                requests.append(("W", group, offset, bytes(frame.data[12:])))
            else:
                requests.append(("RW", group, offset, bytes(frame.data[16:])))
        self.requested_frames.clear()
        return requests

    def write(self, name: str, text: str) -> None:
        (self.programs / name).write_text(text, encoding="ascii")


@pytest.fixture
def nci(tmp_path: Path) -> NciBench:
    return NciBench(tmp_path)
