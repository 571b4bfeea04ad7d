"""The object dictionary of the drive, one row per entry."""

from achse.drive.objects.dictionary import DICTIONARY, OBJECTS, ROWS, find
from achse.drive.objects.row import Access, ObjectRow

__all__ = ["DICTIONARY", "OBJECTS", "ROWS", "Access", "ObjectRow", "find"]
