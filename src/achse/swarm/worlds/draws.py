"""Random numbers by name: each part of a world has a stream of its own.

A stream depends on the seed and its name alone. So a part that is left out, or draws more, changes
nothing of the others.
"""

import random
from collections.abc import Iterator

SEEDS = 1 << 64
"""Number of seeds: 64 bits."""


class Stream(random.Random):
    """The random numbers of one part, by the seed of its world and its name."""

    def __init__(self, seed: int, *name: str | int) -> None:
        super().__init__("/".join(map(str, (seed, *name))))

    def chance(self, probability: float) -> bool:
        """Return True with this probability."""
        return self.random() < probability

    def decades(self, low: float, high: float) -> float:
        """Return a power of ten, its exponent evenly distributed."""
        return float(10.0 ** self.uniform(low, high))

    def rounded(self, value: float, digits: int = 4) -> float:
        """Return `value` in so many digits, so that a written world is short."""
        return float(f"{value:.{digits}g}")


def moments(draws: Stream, rate: float, length_ns: int) -> Iterator[int]:
    """Yield moments at random, so many a second; some in bursts."""
    now = 0.0
    while True:
        gap = draws.expovariate(rate)
        now += gap * (0.01 if draws.chance(0.3) else 1.4)
        if now * 1e9 >= length_ns:
            return
        yield round(now * 1000) * 1_000_000
