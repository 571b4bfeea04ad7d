"""What blocks of Tc2_MC2 cost: 32 axes with five blocks each, all called every 2 ms.

Each axis has MC_Power, MC_MoveAbsolute, MC_Halt, MC_Reset and MC_ReadStatus; the moves go to and
fro, so that commands leave all the time. The same station without the PLC runs beside, alternating;
the difference is what the PLC takes, as a share of one processor in real time.
Usage: python benchmarks/mc_blocks.py [SECONDS] [ROUNDS]
"""

import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from achse.codes.axis import StartType
from achse.motion import commands
from achse.native.backend import compiler_installed
from achse.station import Station
from achse.station.configuration.station_file import parse

AXES = 32
CYCLE_MS = 2
BLOCKS = 5
ENABLED = 0b111, 1_000_000
"""All enables, override 100 %."""

PROGRAM = """PROGRAM MAIN
VAR
    axes : ARRAY [1..{axes}] OF AXIS_REF;
    power : ARRAY [1..{axes}] OF MC_Power;
    move : ARRAY [1..{axes}] OF MC_MoveAbsolute;
    halt : ARRAY [1..{axes}] OF MC_Halt;
    reset : ARRAY [1..{axes}] OF MC_Reset;
    status : ARRAY [1..{axes}] OF MC_ReadStatus;
    there : ARRAY [1..{axes}] OF BOOL;
    n : INT;
    moves : UDINT;
END_VAR
FOR n := 1 TO {axes} DO
    power[n](Axis := axes[n], Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
    status[n](Axis := axes[n], Enable := TRUE);
    reset[n](Axis := axes[n], Execute := axes[n].NcToPlc.StateDWord.Error);
    halt[n](Axis := axes[n], Execute := FALSE);
    move[n](
        Axis := axes[n], Execute := power[n].Status AND NOT move[n].Done,
        Position := SEL(there[n], 20.0 + n, 0.0), Velocity := 100.0
    );
    IF move[n].Done THEN
        there[n] := NOT there[n];
        moves := moves + 1;
    END_IF
END_FOR
END_PROGRAM
"""


def station_of(folder: Path, blocks: bool) -> Station:
    """32 axes, with the program or without."""
    axes: list[dict[str, Any]] = [
        {"id": n, "name": f"A{n}"} | ({"plc": f"MAIN.axes[{n}]"} if blocks else {})
        for n in range(1, AXES + 1)
    ]
    document: dict[str, Any] = {"axis": axes}
    if blocks:
        (folder / "a.st").write_text(PROGRAM.format(axes=AXES), encoding="utf-8")
        document["plc"] = [
            {"sources": "a.st", "task": [{"cycle": f"{CYCLE_MS} ms", "programs": ["MAIN"]}]}
        ]
    return Station(parse(document, "a.toml"), base=folder)


def move_all(station: Station) -> None:
    """Enable the axes and send each on an endless move: so they have as much to do."""
    assert station.nc is not None
    for n in range(1, AXES + 1):
        axis = station.nc.axis(n)
        axis.control_dword, axis.velocity_override = ENABLED
        station.advance(0.01)
        assert commands.start(axis, StartType.ENDLESS_POSITIVE, 0.0, 100.0) == 0


def share(station: Station, seconds: float) -> float:
    """Processor time of `seconds` of the station, as a share of them."""
    begin = time.process_time()
    station.advance(seconds)
    return (time.process_time() - begin) / seconds


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 4.0
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    with tempfile.TemporaryDirectory() as folder:
        bare, busy = (station_of(Path(folder), blocks) for blocks in (False, True))
        for station in (bare, busy):
            station.advance(1.0)
        move_all(bare)
        without, together = [], []
        for _ in range(rounds):
            without.append(share(bare, seconds / rounds))
            together.append(share(busy, seconds / rounds))
        main_program: Any = busy.plcs[851].instance("MAIN")
        assert busy.plcs[851].failure == ""
        code = "machine code" if compiler_installed() else "plain"
        plc = statistics.median(b - a for a, b in zip(without, together, strict=True))
        print(f"{AXES} axes, {BLOCKS} blocks each, every {CYCLE_MS} ms, {code}:")
        print(f"  the axes alone  {statistics.median(without):7.1%} of a processor")
        print(f"  with the PLC    {statistics.median(together):7.1%}")
        print(f"  so the PLC      {plc:7.1%}, {main_program['moves']} moves done")


if __name__ == "__main__":
    main()
