"""Names that somebody may have meant who wrote another: `did you mean 'MAIN.nCounter'?`."""

from collections.abc import Iterable
from difflib import get_close_matches

_MANY = 5000
"""Of more names than that only those are compared that share a part with the one written."""

_LIKENESS = 0.7


def nearest(name: str, known: Iterable[str], most: int = 3) -> list[str]:
    """The names of `known` that `name` may be meant for, the likeliest first, without case."""
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


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`; did you mean 'a' or 'b'?`, or nothing if no name is near."""
    near = nearest(name, known)
    return f"; did you mean {' or '.join(map(repr, near))}?" if near else ""
