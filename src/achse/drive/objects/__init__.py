"""The object dictionary of the drive, one row per entry."""

from achse.drive.objects.dictionary import DICTIONARY, OBJECTS, ROWS, find
from achse.drive.objects.row import EntryAccess, ObjectRow

__all__ = ["DICTIONARY", "OBJECTS", "ROWS", "EntryAccess", "ObjectRow", "find"]
