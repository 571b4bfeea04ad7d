"""Work of a whole run that a second process does while the tests are collected.

First the kernels are compiled (tests/prebuilt.py), then the checks run that read the code without
running it; tests/house/test_checks.py reports them. Collecting keeps one processor busy only.
Each result comes through a pipe, which all workers inherit: what is read at its end is the answer.
"""

import os
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Iterable
from pathlib import Path

__all__ = ["CHECKS", "Background", "result_of"]

ROOT = Path(__file__).parents[1]

LINT_IMPORTS = str(Path(sysconfig.get_path("scripts")) / "lint-imports")

CHECKS = {
    "types": [sys.executable, "-m", "mypy", "--no-error-summary"],
    "lint": [sys.executable, "-m", "ruff", "check", "--output-format=concise"],
    "format": [sys.executable, "-m", "ruff", "format", "--check"],
    "layers": [LINT_IMPORTS, "--no-logo"],
}

KERNELS = "kernels"
"""Name of the pipe that ends when the kernels are compiled."""

RESULTS = "ACHSE_TESTS_CHECKS"
"""Environment variable: the pipes of the checks, `types=5,lint=7`."""


def run_check(command: list[str]) -> tuple[int, str]:
    """Return exit code and output of a check of this tree."""
    run = subprocess.run(
        command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    return run.returncode, run.stdout


def result_of(check: str) -> tuple[int, str]:
    """Return exit code and output of a check: of the background, or of a run of its own."""
    pipes = dict(pair.split("=") for pair in os.environ.get(RESULTS, "").split(",") if pair)
    if check in pipes:
        with open(int(pipes[check]), encoding="utf-8", closefd=False) as pipe:
            code, _, output = pipe.read().partition("\n")
        if code:  # else it has ended early, or this test runs once more
            return int(code), output
    return run_check(CHECKS[check])


class Background:
    """The process, and the reading ends of its pipes."""

    def __init__(self, checks: Iterable[str]) -> None:
        pipes = {name: os.pipe() for name in (KERNELS, *checks)}
        self.readers = {name: ours for name, (ours, _) in pipes.items()}
        writers = {name: theirs for name, (_, theirs) in pipes.items()}
        words = [f"{name}={number}" for name, number in writers.items()]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.background", *words],
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=tuple(writers.values()),
            start_new_session=True,
        )
        for number in writers.values():
            os.close(number)
        os.environ[RESULTS] = ",".join(f"{name}={self.readers[name]}" for name in checks)

    def wait_for_kernels(self) -> None:
        """Return when the kernels are compiled, or the process has ended."""
        os.read(self.readers[KERNELS], 1)

    def end(self) -> None:
        """End the process, and the check that it runs; a second call does nothing."""
        os.environ.pop(RESULTS, None)
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGTERM)
        self.process.wait()
        while self.readers:
            os.close(self.readers.popitem()[1])


def main(words: list[str]) -> None:
    """Compile the kernels, then run the checks; each pipe is closed when its result is in it."""
    pipes = {name: int(number) for name, _, number in (word.partition("=") for word in words)}
    for number in pipes.values():
        os.set_inheritable(number, False)
    from tests.prebuilt import build

    build()
    os.close(pipes[KERNELS])
    for name, command in CHECKS.items():
        if name in pipes:
            code, output = run_check(command)
            with open(pipes[name], "w", encoding="utf-8") as pipe:
                pipe.write(f"{code}\n{output}")


if __name__ == "__main__":
    main(sys.argv[1:])
