"""Servers as processes of their own, for benchmarks that put two of them beside each other."""

import contextlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent


@contextlib.contextmanager
def running(*command: str, ready: str, program: str = sys.executable) -> Iterator[str]:
    """Start `command` with this Python, or another program; yields the line that begins with
    `ready`."""
    with subprocess.Popen(
        [program, *command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        assert process.stdout is not None
        try:
            for line in process.stdout:
                if line.startswith(ready):
                    yield line.strip()
                    break
            else:
                raise SystemExit(f"{command} ended before it was ready")
        finally:
            process.terminate()
            process.wait(10)


@contextlib.contextmanager
def station(host: str, *arguments: str, tcp_port: int = 48898) -> Iterator[int]:
    """The demo station at `host` with NetId HOST.1.1; yields its TCP port."""
    with running(
        "-m", "achse", "run", *arguments, "--host", host, "--tcp-port", str(tcp_port),
        "--net-id", f"{host}.1.1", ready="achse ready",
    ) as line:  # fmt: skip
        yield int(line.partition("tcp=")[2].split()[0].rpartition(":")[2])
