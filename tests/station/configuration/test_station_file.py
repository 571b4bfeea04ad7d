from pathlib import Path
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.station_file import load, parse
from achse.station.configuration.types import ConfigError


def faults(document: dict[str, object]) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(document, "a.toml")
    return str(caught.value).splitlines()


def test_an_empty_document_is_a_router_without_devices() -> None:
    config = parse({}, "a.toml")
    assert config.router.net_id is None
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
        "a.toml: router.tcp_port: expected 65535 or less, got 70000",
        "a.toml: plc[1].task[2].cycles: no such key; did you mean 'cycle'?",
        "a.toml: axis[2].id: expected 1 or more, got 0",
        "a.toml: colour: no such key",
    ]


def test_ids_names_and_ports_are_given_once() -> None:
    (line,) = faults({"plc": [{"port": 851}, {"port": 852, "also": [851]}]})
    assert line == "a.toml: plc.port: each once, got 851 more than once"
    axes = [{"id": 1, "name": "Feed"}, {"id": 2, "name": "FEED"}]  # one name for a symbol
    assert faults({"axis": axes}) == ["a.toml: axis.name: each once, got FEED, Feed more than once"]
    (line,) = faults({"axis": [{"id": 1, "name": "X"}, {"id": 1, "name": "Y"}]})
    assert "axis.id" in line


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


def test_a_station_from_a_file_is_loaded() -> None:
    name: Any = "station.toml"
    with pytest.raises(TypeError, match=r"got 'station\.toml'; Station\.load\(file\) reads a file"):
        Station(name)


def test_interfaces_of_buses_are_replaced(tmp_path: Path) -> None:
    file = tmp_path / "station.toml"
    file.write_text('[[bus]]\nname = "A"\n[[bus]]\nname = "B"\ninterface = "eth1"\n')
    config = load(file, interfaces={"A": "eth0"})
    assert [bus.interface for bus in config.bus] == ["eth0", "eth1"]
    with pytest.raises(ConfigError, match=r"no bus 'C'; buses: A, B"):
        load(file, interfaces={"C": "eth0"})
    with pytest.raises(ConfigError, match=r"which bus\? Expected BUS=INTERFACE; buses: A, B"):
        load(file, interfaces={"": "eth0"})
    file.write_text("[[bus]]\n")
    assert load(file, interfaces={"": "eth2"}).bus[0].interface == "eth2"
