"""The error of a plant."""

from achse.station.plants.errors import PlantError


def test_plant_error_is_no_error_of_a_configuration() -> None:
    assert not issubclass(PlantError, ValueError)
