"""A survey of ESI files, and the time of a line of their devices."""

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


def test_frames_of_a_line_have_a_time(run_benchmark: Callable[..., str], tmp_path: Path) -> None:
    identity = describe(Drive())
    (tmp_path / "drive.xml").write_text(build_esi(identity, vendor="nobody"), encoding="utf-8")
    printed = run_benchmark("esi_line.py", str(tmp_path), f"{identity.name}*3", "2")
    assert "3 slaves, " in printed
    assert " ms a frame, " in printed
