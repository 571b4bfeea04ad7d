"""Tables in files, as `achse.motion.tables.text` reads them, for a client that writes them."""

from pathlib import Path

from achse.cli.failure import fail
from achse.client.nc import FunctionPoint
from achse.motion.tables.function import MotionPoint
from achse.motion.tables.text import TableContent, TableTextError, content_of, text_of

Content = list[tuple[float, float]] | list[FunctionPoint]
"""Rows of a cam, or points of a motion function."""


def read_table(file: Path) -> Content:
    """Return the rows or points of a file; whatever is wrong with it ends the command."""
    try:
        content = content_of(file.read_text(encoding="utf-8-sig"))
    except TableTextError as fault:
        place = f"{file}:{fault.line}" if fault.line else f"{file}"
        fail(f"{place}: {fault.message}", name="INVALID_FILE")
    except (OSError, ValueError) as failure:
        fail(f"{file}: {getattr(failure, 'strerror', None) or failure}", name="CANNOT_READ")
    points = [
        FunctionPoint(
            master=each.master_position,
            slave=each.slave_position,
            law=each.function_type,
            velocity=each.slave_velocity,
            acceleration=each.slave_acceleration,
            jerk=each.slave_jerk,
            point_type=each.point_type,
        )
        for each in content
        if isinstance(each, MotionPoint)
    ]
    return points or [each for each in content if not isinstance(each, MotionPoint)]


def written(content: Content) -> str:
    """Return the text of a table."""
    rows: list[tuple[float, float]] = []
    points: list[MotionPoint] = []
    for each in content:
        if isinstance(each, FunctionPoint):
            master, slave, law, velocity, acceleration, jerk, kind = each
            motion = (master, slave, velocity, acceleration, jerk)
            points.append(MotionPoint(0, law, kind, 1, 0, *motion))
        else:
            rows.append(each[:2])
    table_content: TableContent = points or rows
    return text_of(table_content)
