"""Pictures of recordings, moves, cams and paths, for notebooks and files (extra `plot`).

Each function gives a `Picture`: a notebook shows it, `save` writes it, `figure` is matplotlib's.
"""

from achse.plot.figures import (
    Picture,
    PictureError,
    PlotExtraMissing,
    Quantity,
    cam,
    cam_demands,
    moves,
    path,
    recording,
)

__all__ = [
    "Picture",
    "PictureError",
    "PlotExtraMissing",
    "Quantity",
    "cam",
    "cam_demands",
    "moves",
    "path",
    "recording",
]
