"""Our master over a cable: drives of another process, and slaves that others wrote."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.drive import Drive
from achse.drive.identity import PRODUCT, VENDOR

SIMULATOR = os.environ.get("ACHSE_KICKCAT_SIMULATOR") or shutil.which("network_simulator")
"""KickCAT's network simulator, built from its source; its slaves lie in `slave_configs` there."""
OP = 8


@pytest.mark.parametrize("count", [1, 8])
def test_drives_of_another_process_are_found_and_moved(bus: Any, count: int) -> None:
    bus.drives("--count", count)
    report = bus.master("achse_master.py", 500, 200)
    assert (report["count"], report["trouble"]) == (count, [""] * count)
    assert report["identity"] == [[VENDOR, PRODUCT]] * count
    assert report["states"] == [OP] * count, report["events"]
    assert report["operational"] == 500
    assert report["delays"] == [300 * number for number in range(count)]
    assert report["enabled"] == list(range(count))
    assert all(moved > 1000 for moved in report["moved"])


def test_coe_over_ads_is_what_sdo_gives_on_the_wire(
    bus: Any, witness: Callable[[str], None], tmp_path: Path
) -> None:
    """All objects of a drive, read by pysoem, by our master's ADS device, and by pysoem again.

    What moves by itself, as temperatures and times, has to be between the two looks.
    """
    witness("pysoem")
    bus.drives("--count", 1)
    before = bus.master("pysoem_objects.py", "values")["values"]
    file = tmp_path / "entries.json"
    file.write_text(json.dumps([each[:2] for each in before]))
    ours = bus.master("achse_objects.py", file)
    after = bus.master("pysoem_objects.py", "values")["values"]
    assert {index for index, _, _ in before} == {each.index for each in Drive().objects()}
    assert len(before) >= 203
    assert [each[:2] for each in ours] == [each[:2] for each in before]
    for (index, subindex, value), (*_, first), (*_, last) in zip(ours, before, after, strict=True):
        assert len(value) in (len(first), len(last)), f"{index:04X}:{subindex:02X}"
        low, high = sorted(int.from_bytes(bytes.fromhex(each), "little") for each in (first, last))
        number = int.from_bytes(bytes.fromhex(value), "little")
        assert low <= number <= high, f"{index:04X}:{subindex:02X}"


def simulate(bus: Any, *slaves: str) -> None:
    """Let KickCAT's simulator be the slaves' side, in real time as ours; skips where it is not."""
    if SIMULATOR is None:
        pytest.skip("KickCAT's network_simulator is not here (ACHSE_KICKCAT_SIMULATOR names it)")
    folder = Path(
        os.environ.get("ACHSE_KICKCAT_SLAVES", str(Path(SIMULATOR).parent / "slave_configs"))
    )
    missing = [each for each in slaves if not (folder / each).exists()]
    if missing:
        pytest.skip(f"no {missing[0]} in {folder} (ACHSE_KICKCAT_SLAVES names its folder)")
    ready = bus.serve(
        *("sh", "-c", 'cd "$1"; shift; exec "$@"', "sh", folder),
        *(*bus.first, "stdbuf", "-oL", SIMULATOR, "-i", "cable1", "-s", *slaves),
    )
    assert ready.startswith("Start EtherCAT network simulator"), ready


def test_drives_of_kickcat_are_found_and_moved(bus: Any) -> None:
    """Three of its simulated drives with motors: other registers, EEPROM, objects than ours."""
    simulate(bus, *["ecat402-drive.json"] * 3)
    report = bus.master("achse_master.py", 300, 200)
    assert (report["count"], report["trouble"]) == (3, [""] * 3)
    assert report["identity"] == [[0x29C, 0x03B1_1002]] * 3
    assert report["states"] == [OP] * 3, report["events"]
    assert report["operational"] == 300
    assert report["enabled"] == [0, 1, 2]


def test_slaves_of_several_kinds_share_a_bus(bus: Any) -> None:
    """Two of its slaves by their EEPROM images, whose objects tell the mapping, and a drive."""
    kinds = ("freedom-k64f.json", "xmc4800.json", "ecat402-drive.json")
    simulate(bus, *kinds)
    report = bus.master("achse_master.py", 300, 200)
    assert (report["count"], report["trouble"]) == (3, [""] * 3)
    assert report["identity"] == [[0x79A, 0xDEFEDE], [0x1337, 0x4800], [0x29C, 0x03B1_1002]]
    assert report["states"] == [OP] * 3, report["events"]
    assert report["enabled"] == [2]
    assert report["moved"][0] > 1000


def test_station_moves_unmodified_drives_of_kickcat(bus: Any) -> None:
    """They have neither bit 9 nor bit 10 nor bit 12 of 6041h; without the keys it says so."""
    simulate(bus, *["ecat402-drive.json"] * 2)
    errors = bus.master("achse_foreign_drives.py")
    assert all("bit 12 of 6041h is 0" in each for each in errors), errors
    positions = bus.master("achse_foreign_drives.py", "following_bit", "remote_bit", "reached_bit")
    assert positions == pytest.approx([50.0, 50.0], abs=2.0)
