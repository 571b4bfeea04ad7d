"""What a process that serves stations asks of Python and of the system."""

import asyncio
import sys

import pytest

from achse.cli.process import loop_factory, raise_file_limit


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limit")
def test_as_many_files_as_the_system_lets() -> None:
    import resource

    raise_file_limit()
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    assert soft == hard


def test_a_loop_runs() -> None:
    async def answer() -> int:
        return 7

    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        assert runner.run(answer()) == 7
