"""A failure as text, and as a test that runs."""

from pathlib import Path
from typing import Any

import pytest

from achse.swarm.outcome import BrokenInvariant
from achse.swarm.report import commit, failure_lines, source_of_test
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.world import World


def test_failure_names_seed_commit_and_command() -> None:
    lines = failure_lines(77, BrokenInvariant("jerk", "too much"))
    assert lines[0] == f"seed 77 commit {commit()} failed: jerk: too much"
    assert lines[1].strip() == "achse swarm --seed 77 --replay"
    _, command = failure_lines(77, BrokenInvariant("mine", "x"), "my press", "mine.st")
    assert command.strip() == "achse swarm 'my press' --seed 77 --replay --invariants mine.st"


@pytest.mark.parametrize("seed", range(8))
def test_written_test_plays_the_world(seed: int, tmp_path: Path) -> None:
    world = draw_world(seed)
    source = source_of_test(world, BrokenInvariant("samples-in-order", "twice\nand more"))
    namespace: dict[str, Any] = {}
    exec(compile(source, "test", "exec"), namespace)
    import json

    assert World.decode(json.dumps(namespace["WORLD"])).encode() == world.encode()
    assert callable(namespace["test_samples_in_order_holds"])
