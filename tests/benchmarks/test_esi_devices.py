"""A survey of ESI files."""

from collections.abc import Callable
from pathlib import Path

from achse.drive import Drive
from achse.ethercat.description import describe
from achse.ethercat.esi import build_esi


def test_device_of_a_file_gets_to_op(run_benchmark: Callable[..., str], tmp_path: Path) -> None:
    text = build_esi(describe(Drive()), vendor="nobody")
    (tmp_path / "drive.xml").write_text(text, encoding="utf-8")
    (tmp_path / "torn.xml").write_text(text[:100], encoding="utf-8")
    printed = run_benchmark("esi_devices.py", str(tmp_path))
    assert "torn.xml: : not read: " in printed
    assert "2 files, 2 devices, 1 in Op" in printed
