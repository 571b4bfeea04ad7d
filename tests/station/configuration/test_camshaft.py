"""[[camshaft]]: what can be said, and what is refused."""

from typing import Any

import pytest

from achse.camshaft import CamEncoder
from achse.station.configuration.camshaft import CamConfig, CamshaftConfig
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError


def config_of(**keys: Any) -> CamshaftConfig:
    return parse({"camshaft": [keys]}, "station.toml").camshaft[0]


def test_defaults() -> None:
    config = config_of()
    assert config.what_encoder() == CamEncoder()
    parameters = config.parameters()
    assert parameters["active"] == 1
    assert parameters["and_mask"] == 0xFFFF_FFFF
    assert parameters.keys() >= {"zero_point", "set_rate", "coupled", "shaft_time"}
    assert "encoder_error" not in parameters


def test_cams_have_numbers_and_values() -> None:
    config = config_of(
        cam=[
            {"type": "way", "end": 90},
            {"number": 7, "type": "multi_cycle", "hysteresis": 20, "backward": False},
            {"type": "brake"},
        ]
    )
    assert [number for number, _ in config.numbered()] == [1, 7, 8]
    cam: CamConfig = config.cam[1]
    values = cam.values()
    assert (values["type"], values["hysteresis_on"], values["backward"]) == (4, 1, 0)
    assert config.cam[0].values()["hysteresis_on"] == 0


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"axis": "X", "encoder": "MAIN.n"}, "either axis or encoder"),
        ({"units_per_turn": 360}, "goes with axis"),
        ({"input": {"set_rat": "MAIN.n"}}, "did you mean 'set_rate'"),
        ({"output": {"brake_enable": "MAIN.n"}}, "has no word 'brake_enable'"),
        ({"cam": [{"type": "way"}, {"type": "way", "number": 1}]}, "each of 1..128 once"),
        ({"cam": [{"type": "way", "number": 128}, {"type": "way"}]}, "each of 1..128 once"),
        ({"cam": [{"type": "way", "start": 360}]}, "expected 359 or less"),
        ({"cam": [{"type": "ways"}]}, "'way', 'time', 'brake'"),
        ({"cams": []}, "no such key; did you mean 'cam'"),
        ({"increments": 0}, "expected more than 0,"),
        ({"set_rate": 2001}, "expected 2000 or less"),
        ({"axis": "X", "encoder_range": 4096}, "an axis does not begin again"),
        ({"cam": [{"type": "way", "name": "A"}, {"type": "way", "name": "a"}]}, "each once"),
        ({"cam": [{"type": "way", "name": "Cam5"}]}, "'cam5' is what the controller has"),
        ({"cam": [{"type": "way", "name": "a.b"}]}, "no dots"),
        ({"cam": [{"type": "way", "name": "\0"}]}, "without control characters"),
        ({"name": " Press"}, "no dots and no blanks"),
    ],
)
def test_what_cannot_be(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=r"camshaft\[1\]") as refusal:
        config_of(**keys)
    assert message in str(refusal.value)


def test_there_are_four_at_most() -> None:
    with pytest.raises(ConfigError, match="at most 4"):
        parse({"camshaft": [{}] * 5}, "station.toml")
