"""Random numbers of a kernel: each is a hash of the seed, the chain and its place in the chain.

Kernel source, in the language of `achse.native`; products stay below 63 bits, so that plain Python
has the same numbers.
"""

from math import exp

from achse.native.declare import Slot, lay_out

_WORD = 0xFFFFFFFF
_PART = 1.0 / 4294967296.0
_LN_10 = 2.302585092994046


class Draws:
    """A stream of random numbers."""

    first_key: int = 0
    second_key: int = 0
    place: int = 0
    """Numbers drawn so far."""


DRAWS = lay_out("draws", (Draws,), Slot)


def _mixed(word: int) -> int:
    """Return a hash of 32 bits."""
    word = word ^ (word >> 16)
    word = (word * 0x21F0AAAD) & _WORD
    word = word ^ (word >> 15)
    word = (word * 0x735A2D97) & _WORD
    return word ^ (word >> 15)


def begin_draws(draws: Draws, low: int, high: int, chain: int) -> None:
    """Begin the stream of a chain; `low` and `high` are the halves of the seed."""
    draws.first_key = _mixed((low + chain * 0x9E3779B9) & _WORD)
    draws.second_key = _mixed((high ^ _mixed(draws.first_key ^ chain)) & _WORD)
    draws.place = 0


def draw(draws: Draws) -> float:
    """Return a number from 0 to 1, 1 excluded."""
    draws.place += 1
    word = _mixed((draws.place + draws.first_key) & _WORD)
    return _PART * _mixed(word ^ draws.second_key)


def chance(draws: Draws, probability: float) -> bool:
    """Return True with this probability."""
    return draw(draws) < probability


def uniform(draws: Draws, low: float, high: float) -> float:
    """Return a number between two."""
    return low + (high - low) * draw(draws)


def decades(draws: Draws, low: float, high: float) -> float:
    """Return a power of ten, its exponent evenly distributed."""
    return exp(_LN_10 * uniform(draws, low, high))


def one_of(draws: Draws, count: int) -> int:
    """Return a whole number from 0 to `count` - 1."""
    return int(count * draw(draws))
