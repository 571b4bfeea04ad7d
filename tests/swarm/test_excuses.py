"""Excuses: those that were used are listed with their counts and reasons."""

import random

from achse.swarm.excuses import EXCUSES, excuse_rows


def test_only_used_excuses_are_listed() -> None:
    dice = random.Random(3)
    counts = {name: dice.choice((0, dice.randrange(1, 99))) for name in EXCUSES}
    lines = excuse_rows(counts)
    used = [name for name, count in counts.items() if count]
    assert len(lines) == len(used)
    for name, line in zip(used, lines, strict=True):
        assert line == f"  excused {counts[name]} times, {name}: {EXCUSES[name]}"
