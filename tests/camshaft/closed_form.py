"""Where way cams are on, told by a closed form."""

__all__ = ["EDGE", "closed_form"]

EDGE = 1e-6
"""This near to an edge, in 0.1 degree, rounding decides."""


def closed_form(start: float, end: float, place: float) -> bool | None:
    """Whether a way cam is on; None at its edges."""
    into, length = (place - start) % 3600, (end - start) % 3600
    if min(into, 3600 - into, abs(into - length), abs(into - length - 3600)) < EDGE:
        return None
    return into < length
