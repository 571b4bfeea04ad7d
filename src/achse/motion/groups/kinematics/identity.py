"""Axes that are the places themselves."""

from collections.abc import MutableSequence, Sequence


def forward(numbers: Sequence[float], axes: Sequence[float], places: MutableSequence[float]) -> int:
    """Each place is its axis."""
    for n in range(len(axes)):
        places[n] = axes[n]
    return 1


def inverse(numbers: Sequence[float], places: Sequence[float], axes: MutableSequence[float]) -> int:
    """Each axis is its place."""
    for n in range(len(places)):
        axes[n] = places[n]
    return 1
