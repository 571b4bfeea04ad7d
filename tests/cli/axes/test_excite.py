"""`achse axis jog` and `achse axis excite` on the demo station's axes."""

from collections.abc import Callable
from math import pi
from typing import Any

import pytest


@pytest.mark.parametrize(
    ("options", "velocity"),
    [((), 100.0), (("--negative",), -100.0), (("--speed", "fast"), 600.0)],
)
def test_jog(
    cli: Callable[..., Any], document: Callable[..., Any], options: tuple[str, ...], velocity: float
) -> None:
    cli("axis", "enable", "X")
    report = document("axis", "jog", "X", *options, "--for", "2")
    assert report["done"]
    assert report["peak_velocity"] == pytest.approx(abs(velocity), rel=0.02)
    trace = report["trace"]["actual_velocity"]
    assert max(trace, key=abs) * velocity > 0.0
    [status] = document("axis", "stop", "X")
    assert status["state"] == "Standstill"


def test_reverse(cli: Callable[..., Any], document: Callable[..., Any]) -> None:
    cli("axis", "enable", "X")
    cli("axis", "move", "X", "--to", "0", "--velocity", "1000")
    report = document(
        "axis", "excite", "X", "--between", "-20", "30", "--velocity", "100",
        "--pause", "0.2", "--for", "6", "--sample-time", "0.02",
    )  # fmt: skip
    assert report["done"]
    assert report["function"] == "start_reversing_positioning"
    assert report["lowest"] == pytest.approx(-20.0, abs=0.5)
    assert report["highest"] == pytest.approx(30.0, abs=0.5)
    assert report["seconds"] > 5.8  # until it is at rest
    assert report["end"] == report["trace"]["actual_position"][-1]
    [status] = document("axis", "stop", "X")
    assert status["state"] == "Standstill"


def test_sine_ends_by_itself(lines: Callable[..., list[str]]) -> None:
    lines("axis", "enable", "Y")
    begin = 0.0
    [line] = lines("axis", "excite", "Y", "--amplitude", "50", "--frequency", "1", "--for", "3")
    words = line.split()
    assert words[0] == "Y:"
    assert float(words[1]) == pytest.approx(begin, abs=0.5)
    assert float(words[3]) == pytest.approx(begin + 50.0 / pi, abs=0.5)
    assert float(words[10]) == pytest.approx(50.0, rel=0.05)


def test_a_sweep(document: Callable[..., Any], cli: Callable[..., Any]) -> None:
    cli("axis", "enable", "Y")
    report = document(
        "axis", "excite", "Y", "--amplitude", "20", "--frequency", "1", "--signal", "2",
        "--sweep", "5", "50", "--for", "2",
    )  # fmt: skip
    assert report["done"]
    assert report["peak_velocity"] > 20.0


def test_torque_keeps_its_velocity_limit(
    cli: Callable[..., Any], document: Callable[..., Any]
) -> None:
    cli("axis", "enable", "C")
    report = document("axis", "excite", "C", "--torque", "-5", "--limit", "90", "--for", "3")
    assert report["done"]
    assert report["peak_velocity"] == pytest.approx(90.0, rel=0.02)
    assert report["lowest"] < report["highest"] - 90.0
    [status] = document("axis", "stop", "C")
    assert status["state"] == "Standstill"


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ((), "one of --between, --amplitude and --torque"),
        (("--torque", "5", "--amplitude", "1"), "one of --between, --amplitude and --torque"),
        (("--between", "0", "9"), "--between needs --velocity"),
        (("--torque", "5"), "--torque needs --limit"),
    ],
)
def test_one_way_of_excitation_is_needed(
    cli: Callable[..., Any], options: tuple[str, ...], complaint: str
) -> None:
    refusal = cli("axis", "excite", "X", *options, exit_code=2).stderr
    assert complaint in " ".join(refusal.replace("│", " ").split())


def test_a_refusal_is_reported_by_name(cli: Callable[..., Any]) -> None:
    cli("axis", "disable", "C")
    result = cli("axis", "excite", "C", "--torque", "5", "--limit", "90", exit_code=1)
    assert "C, start torque control: 0x4260 CONTROLLER_ENABLE_MISSING" in result.stderr
