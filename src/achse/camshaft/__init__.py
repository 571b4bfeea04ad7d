"""Camshaft controllers: cams that switch outputs by the angle of a shaft (000 §5.5).

Pure: a `CamController` gets the position of its encoder and does one cycle at a time.
"""

from achse.camshaft.controller import CamController, CamEncoder
from achse.camshaft.image import CamInput, CamOutput
from achse.camshaft.parameters import CAMS, CamParameter, CamType

__all__ = [
    "CAMS",
    "CamController",
    "CamEncoder",
    "CamInput",
    "CamOutput",
    "CamParameter",
    "CamType",
]
