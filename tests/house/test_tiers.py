"""Two tiers of tests: all, and the quick ones, which leave out files that are known to be slow."""

import subprocess
import sys
from pathlib import Path

SLOW = Path(__file__).parents[1] / "data" / "slow_files.txt"


def test_the_slow_files_exist_and_are_sorted(tracked: list[Path]) -> None:
    names = [line.split()[0] for line in SLOW.read_text(encoding="utf-8").splitlines()]
    assert names == sorted(set(names))
    gone = [name for name in names if Path(name) not in tracked]
    assert not gone, f"take out of {SLOW.name}: {', '.join(gone)}"


def test_the_quick_tier_leaves_slow_files_out(root: Path) -> None:
    slow = SLOW.read_text(encoding="utf-8").split()[0]
    command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider"]
    run = subprocess.run(
        [*command, "-m", "quick", slow, "tests/ams/test_states.py"],
        cwd=root,
        capture_output=True,
        text=True,
    )
    assert "tests/ams/test_states.py::" in run.stdout, run.stdout + run.stderr
    assert f"{slow}::" not in run.stdout
