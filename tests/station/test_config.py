import re
from pathlib import Path

import pytest

from achse.ams import NetId
from achse.station.config import ConfigError, LimitsConfig, RouterConfig, load, parse


def faults(document: dict[str, object]) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(document, "a.toml")
    return str(caught.value).splitlines()


def test_an_empty_document_is_a_router_without_devices() -> None:
    config = parse({}, "a.toml")
    assert config.router.net_id == NetId("127.0.0.1.1.1")
    assert (config.router.host, config.router.tcp_port) == ("127.0.0.1", 48898)
    assert not config.plc
    assert not config.axis


@pytest.mark.parametrize(
    ("text", "nanoseconds"),
    [("2ms", 2_000_000), ("0.25 ms", 250_000), ("62.5us", 62_500), ("1s", 10**9), ("5ns", 5)],
)
def test_durations_carry_their_unit(text: str, nanoseconds: int) -> None:
    assert parse({"nc": {"cycle": text}}, "a.toml").nc.cycle == nanoseconds


@pytest.mark.parametrize(
    "text",
    [
        "2",
        2,
        "ms",
        "2 hours",
        "0.3ns",
        "-1ms",
        "0ms",
        "nanms",
        "infms",
        "1e9999999s",
        "3601s",
        "-infs",
    ],
)
def test_a_wrong_duration_is_located(text: object) -> None:
    (line,) = faults({"nc": {"cycle": text}})
    assert line.startswith("a.toml: nc.cycle: ")
    assert repr(text) in line or "greater than 0" in line


def test_every_fault_is_reported_with_file_key_and_expectation() -> None:
    lines = faults(
        {
            "router": {"net_id": "1.2.3", "tcp_port": 70_000},
            "axis": [{"id": 1, "name": "X"}, {"id": 0, "name": "Y"}],
            "plc": [{"task": [{"cycle": "10ms"}, {"cycles": "10ms"}]}],
            "colour": "red",
        }
    )
    assert lines == [
        "a.toml: router.net_id: a NetId is six numbers 0..255 with dots, got '1.2.3'",
        "a.toml: router.tcp_port: Input should be less than or equal to 65535, got 70000",
        "a.toml: plc[1].task[2].cycles: no such key",
        "a.toml: axis[2].id: Input should be greater than or equal to 1, got 0",
        "a.toml: colour: no such key",
    ]


def test_ids_names_and_ports_are_given_once() -> None:
    (line,) = faults({"plc": [{"port": 851}, {"port": 852, "also": [851]}]})
    assert line == "a.toml: plc.port: each once, got 851 more than once"
    axes = [{"id": 1, "name": "Feed"}, {"id": 2, "name": "FEED"}]  # one name for a symbol
    assert faults({"axis": axes}) == ["a.toml: axis.name: each once, got feed more than once"]
    (line,) = faults({"axis": [{"id": 1, "name": "X"}, {"id": 1, "name": "Y"}]})
    assert "axis.id" in line


def test_a_file_that_is_no_toml_is_named(tmp_path: Path) -> None:
    path = tmp_path / "station.toml"
    path.write_text("[nc\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"station\.toml: no valid TOML: .*line 1"):
        load(path)


@pytest.mark.parametrize(
    ("plc", "key"),
    [({"also": [0]}, "plc[1].also[1]"), ({"also": [801, 70_000]}, "plc[1].also[2]"),
     ({"sources": "a", "symbols": "b.tmc"}, "plc[1]")],
)  # fmt: skip
def test_ports_and_tasks_of_a_plc(plc: dict[str, object], key: str) -> None:
    (line,) = faults({"plc": [plc]})
    assert line.startswith(f"a.toml: {key}: ")


def test_an_axis_may_have_further_encoders_controllers_and_drives() -> None:
    document = {
        "axis": [
            {
                "id": 1, "name": "X", "max_velocity": 100.0, "encoder_ids": [1, 9],
                "element": [{"encoder_scaling_factor": 0.01}],
            }
        ]
    }  # fmt: skip
    (axis,) = parse(document, "a.toml").axis
    assert axis.encoder_ids == (1, 9)
    assert axis.element == ({"encoder_scaling_factor": 0.01},)
    assert axis.parameters == {"max_velocity": 100.0}


def test_every_limit_is_in_the_how_to_with_its_default() -> None:
    page = Path(__file__).parents[2] / "docs/how-to/put-a-station-on-a-network.md"
    rows = [
        line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("| `")
    ]
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert named >= set(LimitsConfig.model_fields)
    assert named - set(LimitsConfig.model_fields) <= set(RouterConfig.model_fields)
    text = " ".join(rows).replace(",", "")
    for name in ("handles", "all_handles", "samples", "taps", "log_lines", "all_log_lines"):
        assert f" {LimitsConfig.model_fields[name].default} " in text.replace("|", " ")
