"""Errors of plants."""


class PlantError(Exception):
    """A unit that cannot be read or started, or that has failed: the sentence says why."""
