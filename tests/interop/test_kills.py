"""A station that is killed at any moment goes on from a whole snapshot of its last cycles."""

import random
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.station.persistence.persistent_image import PersistentLayout
from achse.station.persistence.snapshot_file import SnapshotFile
from tests import warm_commands as warm

PROGRAM = """
PROGRAM MAIN
VAR PERSISTENT
    nFirst : LINT; aBulk : ARRAY [0..32767] OF LINT; nMiddle : LINT;
    aMore : ARRAY [0..32767] OF LINT; nLast : LINT;
END_VAR
VAR RETAIN nTotal : LINT; END_VAR
nTotal := nTotal + 1;
nFirst := nTotal; nMiddle := nTotal; nLast := nTotal;
END_PROGRAM
"""
"""256 kB, four times in the data: a snapshot is many pages, and a kill may come between two."""

PLC = """
[[plc]]
port = {port}
sources = "program.st"
[[plc.task]]
name = "PlcTask"
cycle = "10ms"
programs = ["MAIN"]
"""

STATION = """
[system]
persistent_data = "kept.json"
[[axis]]
id = 1
name = "X"
persistent_data_enable = true
"""

KILLS, KILLS_DEEP = 4, 200


def cycles_kept(file: Path) -> tuple[int, bool]:
    """Return the cycle that both PLCs had, and True if a newer snapshot is torn."""
    result = SnapshotFile(file).read()
    assert result is not None
    snapshot, is_torn = result
    values = PersistentLayout.decode(snapshot.layout).values(snapshot.content)
    names = ("MAIN.nTotal", "MAIN.nFirst", "MAIN.nMiddle", "MAIN.nLast")
    (count,) = {
        int.from_bytes(plc[name].data, "little") for plc in values.plcs.values() for name in names
    }
    assert values.plcs.keys() == {851, 852}
    assert values.axes.keys() == {1}
    return count, is_torn


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_killed_station_loses_its_last_cycles_only(
    tmp_path: Path,
    warm_commands: warm.WarmCommands,
    many: Callable[[int], int],
    record_property: Callable[[str, Any], None],
) -> None:
    """Each goes on from where the one before was killed. Both PLCs are of one cycle."""
    (tmp_path / "program.st").write_text(PROGRAM)
    plcs = "".join(PLC.replace("{port}", str(port)) for port in (851, 852))
    (tmp_path / "station.toml").write_text(STATION + plcs)
    file = tmp_path / "kept.json.snapshot"
    moments = random.Random(27)
    count, torn, lost = 0, 0, []
    for _ in range(KILLS_DEEP if many(1) > 1 else KILLS):
        process = warm_commands.popen(
            *("run", str(tmp_path / "station.toml"), "--tcp-port", "0"), **warm.PIPES
        )
        try:
            assert process.stdout is not None
            ready = process.stdout.readline()
            facts = dict(pair.split("=", 1) for pair in ready.split()[2:])
            before = file.stat().st_mtime_ns if file.exists() else 0
            with achse.blocking.connect(facts["tcp"], source="192.0.2.78.1.1:40000") as client:
                seen = client.read("MAIN.nTotal")
                assert seen >= count
                while not file.exists() or file.stat().st_mtime_ns == before:
                    seen = client.read("MAIN.nTotal")
                for _ in range(moments.randrange(400)):
                    seen = client.read("MAIN.nTotal")
                process.kill()
        finally:
            process.kill()
            process.communicate()
        count, is_torn = cycles_kept(file)
        lost.append(seen - count)
        torn += is_torn
    record_property("most cycles lost", max(lost))
    print(f"{len(lost)} kills, {torn} writes cut, most cycles lost {max(lost)}: {sorted(lost)}")
    assert not (tmp_path / "kept.json").exists(), "no run came to its end"
