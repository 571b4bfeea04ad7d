"""`achse swarm`: seeds, a failure that is kept, invariants of a user, mistakes."""

import json
import signal
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.motion import draw_motion_world

SHORT = next(seed for seed in range(1, 400) if len(draw_world(seed).acts) < 40 and seed % 16 > 1)
STATION = '[[axis]]\nid = 1\nname = "X"\n'
MINE = """
def check_never_enabled(station):
    assert not station.nc.axis(1).control_dword, "enabled"
"""


def run(*arguments: str, exit_code: int = 0) -> Any:
    result = CliRunner().invoke(app, ("swarm", *arguments), env={"COLUMNS": "100"})
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def test_seeds_are_summed_up() -> None:
    stdout = run("--seed", str(SHORT), "--runs", "1").stdout
    assert stdout.startswith(f"1 seeds from {SHORT}, 0 failed; ")
    facts = json.loads(run("--seed", str(SHORT), "--runs", "1", "--json").stdout)
    assert (facts["seeds"], facts["failed"], facts["first"]) == (1, 0, SHORT)


def test_rows_are_printed_as_seeds_end() -> None:
    lines = run("--seed", str(SHORT), "--runs", "1", "--rows").stdout.splitlines()
    assert lines[0].startswith(f"seed {SHORT} holds station_s=")


def test_motion_alone_is_drawn_summed_up_and_replayed() -> None:
    seed = next(s for s in range(100) if 0 < len(draw_motion_world(s).acts) < 40)
    facts = json.loads(run("--motion", "--seed", str(seed), "--runs", "1", "--json").stdout)
    assert (facts["seeds"], facts["failed"], facts["samples"]) == (1, 0, 0)
    assert facts["moves"] > 0
    output = run("--motion", "--seed", str(seed), "--replay").stdout.splitlines()
    assert output[-1].startswith(f"seed {seed}: no violation in ")


def test_plans_alone_are_summed_up_and_replayed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.swarm.plans.player.CHAINS_OF_A_SEED", 100)
    facts = json.loads(run("--plans", "--seed", "3", "--runs", "2", "--json").stdout)
    assert (facts["seeds"], facts["failed"], facts["machine_years"]) == (2, 0, 0.0)
    assert facts["moves"] > 80
    stdout = run("--plans", "--seed", "3", "--replay").stdout
    assert stdout.startswith("seed 3: no violation in ")
    stdout = run("--plans", "--motion", exit_code=1).output
    assert "--plans has no cycles: expected no --motion" in " ".join(stdout.split())


def test_replay_is_a_page_for_the_browser(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    seed = next(s for s in range(100) if 0 < len(draw_motion_world(s).acts) < 40)
    output = run("--motion", "--seed", str(seed), "--replay", "--scope").stdout.splitlines()
    assert output[-1].startswith(f"seed-{seed}.html: the last ")
    assert output[-2] in (tmp_path / f"seed-{seed}.html").read_text(encoding="utf-8")


def test_replay_shows_acts_and_digest() -> None:
    output = run("--seed", str(SHORT), "--replay").stdout.splitlines()
    assert output[0].split() == ["0.000", "s", "client", "0", "dial"]
    assert output[-1].startswith(f"seed {SHORT}: no violation in ")


def test_violated_invariant_of_a_user_is_kept_as_a_small_test(tmp_path: Path) -> None:
    (tmp_path / "station.toml").write_text(STATION)
    (tmp_path / "mine.py").write_text(MINE)
    file = tmp_path / "test_found.py"
    output = run(
        *(str(tmp_path), "--invariants", str(tmp_path / "mine.py"), "--seed", "3", "--runs", "2"),
        *("--keep", str(file)),
        exit_code=1,
    ).stdout
    assert "failed: check_never_enabled: at " in output
    assert f"  achse swarm {tmp_path} --seed " in output
    assert f" --replay --invariants {tmp_path / 'mine.py'}\n" in output
    assert "acts" in output.splitlines()[-1]
    source = file.read_text()
    assert source.count('"kind": ') <= 4
    namespace: dict[str, Any] = {}
    exec(compile(source, "kept", "exec"), namespace)
    with pytest.raises(AssertionError):
        namespace["test_check_never_enabled_holds"]()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("seeds", [1, 2])
def test_a_signal_ends_a_campaign_with_its_sums(
    monkeypatch: pytest.MonkeyPatch, number: signal.Signals, seeds: int
) -> None:
    """The seed that runs is counted; one after which nobody interrupts is followed by others."""

    def interrupted(*, seed: int, **_: object) -> dict[str, Any]:
        if seed + 1 == seeds:
            signal.raise_signal(number)
        return {"world": seed, "invariant": "", "what": "", "moves": 3}

    monkeypatch.setattr("achse.swarm.campaign.run", interrupted)
    stdout = run("--seed", "5", "--runs", "9", "--json", exit_code=128 + number).stdout
    facts = json.loads(stdout)
    assert (facts["seeds"], facts["moves"]) == (seeds, 3 * seeds)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "expected a station.toml"),
        (["--workers", "2", "--for", "1"], "--workers needs --runs"),
        (["--scope"], "--scope needs --replay"),
        ([".", "--motion"], "--motion draws its own axes"),
    ],
)
def test_mistakes_are_named(arguments: list[str], message: str) -> None:
    assert message in run(*arguments, exit_code=1).stderr
