"""Records of the simulated machine: names, ranges, both forms."""

import pytest

from achse.motion.fields.declare import Field, Role
from achse.motion.machine.record import AMPLIFIER, MACHINE, PARAMETERS, PARTS, SENSOR
from achse.native.declare import RecordLayout

LAYOUTS = {"machine": MACHINE, "sensor": SENSOR, "amplifier": AMPLIFIER}


def test_each_parameter_has_a_name_in_a_configuration() -> None:
    named = {(part, field.name) for part, field in PARAMETERS.values()}
    assert named == {
        (part, name) for part, section in PARTS.items() for name in section.__annotations__
    }
    for name, (part, field) in PARAMETERS.items():
        assert name.endswith(field.name) or name == "encoder_simulation_noise_scaling"
        assert LAYOUTS[part].fields[field.name] is field
        assert field.role is Role.PARAMETER


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=list(LAYOUTS))
def test_fields_are_described_and_their_defaults_are_in_range(layout: RecordLayout[Field]) -> None:
    for name, field in layout.fields.items():
        if field.refers is None:
            assert field.doc and field.unit, name  # noqa: PT018
            assert field.least <= field.default <= field.most, name
