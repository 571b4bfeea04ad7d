"""Elements of the programmed contour, in coordinates of the workpiece, before they become moves."""

from dataclasses import dataclass

from achse.gcode.canon import Origin
from achse.gcode.vectors import PathPoint


@dataclass(frozen=True, slots=True)
class MoveFacts:
    """Properties of a block's move beside the geometry. Velocities in mm/s."""

    origin: Origin
    auxiliary: tuple[float, ...]
    velocity: float
    start_velocity: float
    rapid: bool
    exact_stop: bool
    delete_distance: bool


@dataclass(slots=True)
class ContourElement:
    """A line, or with `normal` an arc or helix; see `ArcMove` for its geometry."""

    facts: MoveFacts
    start: PathPoint
    end: PathPoint
    centre: PathPoint = (0.0, 0.0, 0.0)
    normal: PathPoint | None = None
    angle: float = 0.0
    rise: float = 0.0
    scale: float = 1.0
    """Factor on the velocity, so that the feed is right at the contour (CFC, CFIN)."""
