"""Cost of a step of co-simulation units: a station in a C importer, a unit under an axis.

The C importer (tests/interop/fmu/importer.c) steps two instances of a station with an axis and a
PLC; their digests must be equal to that of `Station.advance`. The unit under an axis is a conveyor
in C. Each step changes the process twice, so a busy machine makes it longer: the processor time of
this side is what stays.
Usage: python benchmarks/units.py [STEPS]
"""

import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

from achse.fmu import export
from achse.fmu.compiler import binary_name, platform_folder
from achse.fmu.model import UnitFile
from achse.station import Station

TESTS = Path(__file__).parents[1] / "tests"

PROGRAM = """
PROGRAM MAIN
VAR nIn AT %IW0 : INT; nOut AT %QW0 : INT; nCount : UDINT; END_VAR
nCount := nCount + 1;
nOut := nIn;
END_PROGRAM
"""
STATION = '[[axis]]\nid = 1\nname = "X"\n[[plc]]\nsources = "main.st"\n'

PLANT = """
[nc]
cycle = "1ms"
[[axis]]
id = 1
name = "X"
[[fmu]]
name = "belt"
file = "conveyor.fmu"
[[fmu.axis]]
axis = "X"
command = "speed"
position = "position"
"""
DESCRIPTION = """<?xml version="1.0"?>
<fmiModelDescription fmiVersion="3.0" modelName="belt" instantiationToken="{belt}">
<CoSimulation modelIdentifier="conveyor"/><ModelVariables>
<Float64 name="speed" valueReference="0" causality="input" start="0"/>
<Float64 name="position" valueReference="1" causality="output"/>
</ModelVariables><ModelStructure/></fmiModelDescription>
"""


def compiled(source: Path, target: Path, *options: str) -> Path:
    command = ["cc", "-O2", *options, str(source), "-o", str(target), "-lm", "-ldl"]
    subprocess.run(command, check=True)
    return target


def export_side(folder: Path, steps: int) -> None:
    """Two instances in a C program."""
    (folder / "main.st").write_text(PROGRAM)
    (folder / "station.toml").write_text(STATION)
    begin = time.perf_counter()
    unit = export(folder / "station.toml")
    print(f"export                    {time.perf_counter() - begin:8.2f} s")
    (folder / "cell.fmu").write_bytes(unit.archive)
    with zipfile.ZipFile(folder / "cell.fmu") as archive:
        archive.extractall(folder / "cell")
    importer = compiled(TESTS / "interop/fmu/importer.c", folder / "importer")
    library = next((folder / "cell" / "binaries").rglob("*.*"))
    token = UnitFile.read(folder / "cell" / "resources").token
    digest = str(len(unit.variables) - 1)
    seconds = []
    for count in (1, steps):
        words = (importer, library, folder / "cell" / "resources", token, digest, count)
        command = list(map(str, words))
        begin = time.perf_counter()
        ended = subprocess.run([*command, "0.01"], check=True, capture_output=True, text=True)
        seconds.append(time.perf_counter() - begin)
    print(f"start of two instances    {seconds[0]:8.2f} s")
    step_s = (seconds[1] - seconds[0]) / (steps - 1) / 2
    print(f"step of 10 ms of a station{step_s * 1e6:8.1f} µs")
    station = Station.load(folder / "station.toml")
    begin = time.perf_counter()
    for _ in range(steps):
        station.advance(0.01)
    print(f"the same by advance       {(time.perf_counter() - begin) / steps * 1e6:8.1f} µs")
    equal = set(ended.stdout.split()[1::2]) == {station.digest()}
    print("digests", "equal" if equal else "DIFFER", station.digest())


def plant_side(folder: Path, steps: int) -> None:
    """A unit under an axis, a step in each cycle of the NC."""
    library = folder / binary_name("conveyor")
    compiled(TESTS / "station/plants/units/conveyor.c", library, "-shared", "-fPIC")
    with zipfile.ZipFile(folder / "conveyor.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, f"binaries/{platform_folder(3)}/{library.name}")
    (folder / "plant.toml").write_text(PLANT)
    begin = time.perf_counter()
    station = Station.load(folder / "plant.toml")
    print(f"start of a plant          {time.perf_counter() - begin:8.2f} s")
    station.advance(0.1)
    begin, own = time.perf_counter(), time.process_time()
    station.advance(steps / 1000)
    whole, own = time.perf_counter() - begin, time.process_time() - own
    print(
        f"cycle with a plant        {whole / steps * 1e6:8.1f} µs, own {own / steps * 1e6:.1f} µs"
    )


def main(steps: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        export_side(Path(name), steps)
        plant_side(Path(name), steps)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:] or ["20000"]))
