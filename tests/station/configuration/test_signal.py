"""`[[signal]]` tables: errors name the key, what was expected and what came."""

from typing import Any, get_args

import pytest

from achse.station import ConfigError
from achse.station.configuration.signal import SIGNAL_KINDS, SignalConfig
from achse.station.configuration.station_file import parse


def test_each_kind_is_listed() -> None:
    kinds = [
        get_args(model.model_fields["kind"].annotation)[0]
        for model in get_args(get_args(SignalConfig)[0])
    ]
    assert tuple(kinds) == SIGNAL_KINDS


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({}, "signal[1].kind: one of sine, ramp"),
        ({"symbol": "a", "kind": "sin"}, "got 'sin'; did you mean 'sine'?"),
        ({"symbol": "a", "kind": "sine"}, "signal[1].period: expected, but not there"),
        ({"symbol": "", "kind": "noise"}, "signal[1].symbol: "),
        (
            {"symbol": "a", "kind": "sine", "period": 3},
            "signal[1].period: expected a duration",
        ),
        ({"symbol": "a", "kind": "sine", "period": "1s", "offset": "x"}, "signal[1].offset: "),
        ({"symbol": "a", "kind": "sine", "period": "1s", "amplitde": 1}, "'amplitude'"),
        ({"symbol": "a", "kind": "noise", "seed": -1}, "signal[1].seed: "),
        ({"symbol": "a", "kind": "noise", "distribution": "flat"}, "signal[1].distribution: "),
        ({"symbol": "a", "kind": "square", "period": "1s", "duty": 2}, "signal[1].duty: "),
        ({"symbol": "a", "kind": "counter", "step": 0}, "step: a number that is not 0"),
        ({"symbol": "a", "kind": "counter", "last": -1}, "last: a value that step leads to"),
        ({"symbol": "a", "kind": "csv", "file": "f", "time": 1, "period": "1s"}, "either time or"),
        ({"symbol": "a", "kind": "csv"}, "signal[1].file: expected, but not there"),
        ({"symbol": "a", "kind": "expression"}, "signal[1].expression: expected"),
        ({"symbol": "a", "kind": "noise", "amplitude": float("inf")}, "signal[1].amplitude: "),
        (3, "signal[1]: expected a table"),
    ],
)
def test_a_fault_is_reported(table: Any, message: str) -> None:
    with pytest.raises(ConfigError) as fault:
        parse({"signal": [table]}, "station.toml")
    assert message in str(fault.value)
    assert str(fault.value).startswith("station.toml: signal[1]")
