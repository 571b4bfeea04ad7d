"""`achse axis`: what a user commands, and what is printed."""

import json
from collections.abc import Callable
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Document = Callable[..., Any]
Cli = Callable[..., Any]


def test_the_axes_are_listed(lines: Lines, document: Document) -> None:
    listed = [line.split() for line in lines("axis", "show")]
    assert [words[:2] for words in listed] == [["1", "X"], ["2", "Y"], ["3", "C"]]
    assert all(words[-1] in ("Disabled", "Standstill") for words in listed)
    assert [(axis["id"], axis["name"], axis["unit"]) for axis in document("axis", "show")] == [
        (1, "X", "mm"),
        (2, "Y", "mm"),
        (3, "C", "degree"),
    ]


def test_one_axis_is_shown_by_its_state(lines: Lines) -> None:
    title, *facts = lines("axis", "show", "y")
    assert title.startswith("2 Y: ")
    labels = [line[:17].strip() for line in facts]
    assert labels == ["position", "velocity", "following error", "override", "error", "flags"]
    assert "not moving" in facts[-1]


def test_one_axis_as_json_has_its_online_structure(document: Document) -> None:
    [one] = document("axis", "show", "3")
    assert one["name"] == "C"
    assert one["error_code"] == 0


def test_enable_with_an_override_and_disable(lines: Lines, document: Document) -> None:
    assert lines("axis", "enable", "Y", "--override", "50")[0].endswith("Standstill")
    [axis] = document("axis", "show", "Y")
    assert axis["velocity_override"] == 500_000
    assert "operational" in axis["flags"]
    assert lines("axis", "disable", "Y")[0].endswith("Disabled")


def test_a_move_is_reported(lines: Lines) -> None:
    lines("axis", "enable", "X")
    [line] = lines("axis", "move", "X", "--to", "-50", "--velocity", "100")
    assert line.startswith("X: 0.000 → -50.0")
    assert "peak velocity" in line
    assert "mm/s" in line


def test_a_move_is_drawn_on_demand(lines: Lines) -> None:
    lines("axis", "enable", "X")
    picture = lines("axis", "move", "X", "--by", "20", "-v", "100", "--plot")
    assert [line.strip() for line in picture if line.strip().startswith(("pos", "velo"))] == [
        "position mm",
        "velocity mm/s",
    ]
    assert max(map(len, picture[:-1])) <= 100
    assert picture[-2].endswith(" s")


def test_a_move_as_json_has_its_trace(document: Document) -> None:
    document("axis", "enable", "Y")
    course = document("axis", "move", "Y", "--relative", "30", "-v", "200", "--jerk", "20000")
    assert course["done"]
    assert course["start_type"] == "RELATIVE"
    assert course["target"] - course["begin"] == pytest.approx(30.0)
    trace = course["trace"]
    assert len({len(column) for column in trace.values()}) == 1
    assert trace["set_position"][-1] == pytest.approx(course["target"])
    assert max(trace["set_velocity"]) <= 200.0 * (1 + 1e-6)
    assert trace["time"] == sorted(trace["time"])


def test_the_time_of_a_move_is_that_of_its_profile(document: Document) -> None:
    """Rest to rest over d at v, with a reached in a/j: d/v + v/a + a/j; then the window's time."""
    document("axis", "enable", "Y")
    velocity, acceleration, jerk = 100.0, 1000.0, 50_000.0
    course = document(
        *("axis", "move", "Y", "--by", "100", "-v", "100"),
        *("--acceleration", "1000", "--deceleration", "1000", "--jerk", "50000"),
    )
    profile = 100 / velocity + velocity / acceleration + acceleration / jerk
    velocities = course["trace"]["set_velocity"]
    moving = sum(velocity != 0 for velocity in velocities) * 0.01
    assert moving == pytest.approx(profile, abs=0.021)


def test_a_modulo_move_goes_the_way_requested(document: Document) -> None:
    document("axis", "enable", "C")
    there = document("axis", "move", "C", "--to", "90", "-v", "720", "--modulo", "+")
    back = document("axis", "move", "C", "--to", "80", "-v", "720", "--modulo", "-")
    short = document("axis", "move", "C", "--to", "85", "-v", "720", "--modulo", "shortest")
    assert [move["target"] - move["begin"] for move in (there, back, short)] == pytest.approx(
        [90, -10, 5], abs=0.1
    )


def test_an_endless_move_runs_until_it_is_stopped(lines: Lines, document: Document) -> None:
    lines("axis", "enable", "Y")
    course = document("axis", "move", "Y", "--endless", "-", "-v", "50")
    assert course["done"]
    assert course["trace"]["set_velocity"][-1] == pytest.approx(-50.0)
    assert document("axis", "show", "Y")[0]["state"] == "ContinuousMotion"
    assert lines("axis", "stop", "Y", "--deceleration", "5000", "--jerk", "50000")[0].endswith(
        "Standstill"
    )


def test_no_wait_gives_the_number_of_the_command(lines: Lines) -> None:
    lines("axis", "enable", "X")
    [line] = lines("axis", "move", "X", "--by", "5", "-v", "10", "--no-wait")
    assert line.startswith("X: command ")
    assert lines("axis", "stop", "X")[0].split()[1] == "X"


def test_a_refused_move_is_reported_by_name(cli: Cli) -> None:
    cli("axis", "disable", "X")
    result = cli("axis", "move", "X", "--to", "1", "-v", "10", exit_code=1)
    assert result.stdout == ""
    assert "X, universal axis start: 0x4260 CONTROLLER_ENABLE_MISSING" in result.stderr


def test_an_error_is_shown_and_reset(lines: Lines) -> None:
    lines("axis", "enable", "Y")
    external = ("0x4202", "0x19", "17744", "--type", "UDINT", "--port", "501")
    lines("ads", "raw", *external)
    [listed] = lines("axis", "show")[1:2]
    assert "ErrorStop" in listed
    assert "0x4550" in listed
    assert any("0x4550" in line for line in lines("axis", "show", "Y"))
    assert "ErrorStop" not in lines("axis", "reset", "Y")[0]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ((), "one of --to, --by and --endless"),
        (("--to", "1", "--by", "1"), "one of --to, --by and --endless"),
        (("--by", "1", "--modulo", "+"), "--modulo goes with --to"),
        (("--to", "far"), "--to"),
        (("--endless", "up"), "up"),
    ],
)
def test_bad_usage_of_move(cli: Cli, arguments: tuple[str, ...], complaint: str) -> None:
    result = cli("axis", "move", "X", "-v", "1", *arguments, exit_code=2)
    assert complaint in result.stderr


def test_half_a_ramp_is_none(cli: Cli) -> None:
    assert "go together" in cli("axis", "stop", "X", "--jerk", "1", exit_code=2).stderr


def test_watch_prints_samples(lines: Lines, cli: Cli) -> None:
    watched = lines("axis", "show", "X", "--watch", "-n", "3", "-c", "0.01")
    assert len(watched) == 3
    assert all(" X " in line and " mm/s " in line for line in watched)
    result = cli("axis", "show", "X", "--watch", "-n", "2", "-c", "0.01", "--json")
    samples = [json.loads(line) for line in result.stdout.splitlines()]
    assert [sample["axis_id"] for sample in samples] == [1, 1]
    assert lines("axis", "show", "X", "--watch", "--for", "0") == []


def test_near_axes_are_offered(cli: Callable[..., Any]) -> None:
    stderr = cli("axis", "show", "XX", exit_code=1).stderr
    assert "no such axis" in stderr


def test_a_move_without_velocity_has_that_of_the_axis(
    cli: Callable[..., Any], lines: Callable[..., list[str]], document: Callable[..., Any]
) -> None:
    cli("axis", "enable", "Y")
    [shown] = list(document("axis", "show", "Y", "rapid_traverse_velocity"))
    [largest] = list(document("axis", "show", "Y", "max_velocity"))
    expected = min(shown["value"], largest["value"]) or largest["value"]
    line, moved = lines("axis", "move", "Y", "--by", "50")
    assert line.startswith(f"Y: {expected:g} mm/s, its ")
    assert moved.startswith("Y: ")
    course = document("axis", "move", "Y", "--by", "50")
    assert course["velocity"] == expected


def test_a_move_of_an_axis_without_enable_says_what_to_do(cli: Callable[..., Any]) -> None:
    cli("axis", "disable", "Y")
    stderr = cli("axis", "move", "Y", "--to", "1", "--velocity", "10", exit_code=1).stderr
    assert "motion; `achse axis enable` switches axes on" in stderr
