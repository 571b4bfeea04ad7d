"""Names that may have been meant by a misspelt one: `did you mean 'MAIN.nCounter'?`."""

from collections.abc import Iterable
from difflib import get_close_matches
from functools import lru_cache

_MANY = 5000
"""Of more names than that only those are compared that share a part with the one written."""

_LIKENESS = 0.7
_ROUNDING = 1e-9


def nearest(name: str, known: Iterable[str], most: int = 3) -> list[str]:
    """Return the names of `known` that `name` may be meant for, the likeliest first, without
    case."""
    folded: dict[str, str] = {}
    for each in known:
        folded.setdefault(each.casefold(), each)
    wanted = name.strip().casefold()
    if wanted in folded:
        return [folded[wanted]]
    last = wanted.rpartition(".")[2]
    ends = [text for key, text in folded.items() if last and key.endswith(f".{wanted}")]
    if ends:
        return sorted(ends, key=len)[:most]
    keys = list(folded)
    if len(keys) > _MANY:
        parts = {part for part in wanted.split(".") if part}
        keys = [key for key in keys if not parts.isdisjoint(key.split("."))][:_MANY]
    return [folded[key] for key in get_close_matches(wanted, keys, most, _LIKENESS)]


def closest(name: str, known: Iterable[str], likeness: float) -> str | None:
    """Return the name of `known` that is most like another, by `difflib`; None if none is as like.

    Names that cannot be are left out first, by their length and their letters: a file with
    thousands of unknown names would take minutes else.
    """
    letters, length = _letters(name), len(name)
    if not length:
        return None
    least = likeness - _ROUNDING
    shortest, longest = least * length / (2 - least), (2 - least) * length / least
    keys = []
    for key in known:
        size = len(key)
        if shortest <= size <= longest:
            own = _letters(key)
            # letters that one of them alone has match nothing
            same = min(length - (letters & ~own).bit_count(), size - (own & ~letters).bit_count())
            if 2 * same >= least * (length + size):
                keys.append(key)
    matches = get_close_matches(name, keys, 1, likeness) if keys else []
    return matches[0] if matches else None


@lru_cache(1 << 16)
def _letters(name: str) -> int:
    """Return the letters of a name, a bit for each of 64 groups of them."""
    letters = 0
    for letter in name:
        letters |= 1 << (ord(letter) & 63)
    return letters


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`; did you mean 'a' or 'b'?`, or nothing if no name is near."""
    near = nearest(name, known)
    return f"; did you mean {' or '.join(map(repr, near))}?" if near else ""
