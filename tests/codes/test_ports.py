"""AMS ports of services: each number once."""

from achse.codes import ports
from tests.public_names import public_names


def test_each_port_has_a_number_of_its_own() -> None:
    numbers = [getattr(ports, name) for name in public_names(ports)]
    assert len(set(numbers)) == len(numbers)
    assert all(0 < number < 0x8000 for number in numbers)
