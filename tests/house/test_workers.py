"""The runner of tests: what workers report is what one process reports."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

SHARED = """
import os
import pytest

@pytest.fixture(scope="session")
def once(tmp_path_factory):
    with open(os.environ["LOG"], "a") as log:
        log.write(f"made {os.getpid()}\\n")
    yield
    with open(os.environ["LOG"], "a") as log:
        log.write(f"ended {os.getpid()}\\n")
"""

TESTS = """
import gc, os, signal, tempfile
import pytest

@pytest.mark.parametrize("number", range(6))
def test_number(once, number, tmp_path):
    print("number", number)
    if number == 3 and os.environ.get("KILL"):
        tempfile.mkdtemp(prefix="achse-left-")
        os.kill(os.getpid(), signal.SIGKILL)
    gc.unfreeze()
    assert gc.get_freeze_count() or not os.environ["FORKED"], "what is shared stays so"
    assert number != 4

@pytest.mark.skip(reason="skipped here")
def test_skipped():
    pass
"""

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes cannot fork here")


def run(folder: Path, *arguments: str, kill: bool = False) -> str:
    """Return what pytest prints for three files of tests."""
    for name in ("test_a.py", "test_b.py", "test_c.py"):
        (folder / name).write_text(TESTS, encoding="utf-8")
    (folder / "conftest.py").write_text(SHARED, encoding="utf-8")
    (folder / "pytest.ini").write_text("[pytest]\n", encoding="utf-8")
    environment = os.environ | {
        "PYTHONPATH": str(Path(__file__).parents[2]),
        "LOG": str(folder / "log"),
        "KILL": "yes" if kill else "",
        "FORKED": "yes" if "--workers" in arguments else "",
        "COLUMNS": "120",
    }
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "tests.workers",
        "-p",
        "no:achse.testing.plugin",
    ]
    ended = subprocess.run(
        [*command, "-p", "no:cacheprovider", "-rA", *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    return ended.stdout + ended.stderr


def outcomes(printed: str) -> set[str]:
    return set(re.findall(r"^(?:PASSED|FAILED|SKIPPED) \S+", printed, re.MULTILINE))


def test_workers_report_what_one_process_reports(tmp_path: Path) -> None:
    alone = run(tmp_path)
    (tmp_path / "log").unlink()
    forked = run(tmp_path, "--workers", "2")
    assert outcomes(forked) == outcomes(alone)
    assert "3 failed, 15 passed, 3 skipped" in forked
    assert forked.count("number 4") == alone.count("number 4")
    # Session fixtures are made and ended once in each worker.
    lines = (tmp_path / "log").read_text(encoding="utf-8").splitlines()
    tests = [line.split()[1] for line in lines if line.startswith("made")]
    ended = [line.split()[1] for line in lines if line.startswith("ended")]
    assert sorted(tests) == sorted(ended)
    assert len(set(tests)) == len(tests) <= 2


def test_lost_worker_fails_its_test_only(tmp_path: Path) -> None:
    printed = run(tmp_path, "--workers", "2", kill=True)
    assert "7 failed, 12 passed, 3 skipped" in printed
    assert (
        len(re.findall(r"(?:achse-left-\w+(?:, )?){3} stayed in the temporary folder", printed))
        >= 1  # twice where pytest shows messages whole, as in CI
    )
    assert printed.count("the worker ended during this test, exit code -9") >= 3


def test_first_failure_ends_the_run(tmp_path: Path) -> None:
    printed = run(tmp_path, "--workers", "1", "-x")
    assert "1 failed, 4 passed" in printed


def test_shuffled_order_belongs_to_the_seed(tmp_path: Path) -> None:
    def order(seed: str) -> list[str]:
        printed = run(tmp_path, "--shuffle", seed, "-v")
        return re.findall(r"^(\S+::\S+)", printed, re.MULTILINE)

    first, again, other = map(order, "112")
    assert first == again != other
    assert sorted(first) == sorted(other)
