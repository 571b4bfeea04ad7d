"""Errors are sentences, or objects of code, name and message."""

import io
import json
import os
from pathlib import Path

import pytest
import typer

from achse.ams import AdsError, ConnectionLost, DecodeError, DeviceError
from achse.cli.failure import (
    dumped,
    errors_in_json,
    fail,
    fail_by,
    in_json,
    name_of,
    print_failure,
    wants_json,
)
from achse.client.nc.errors import UnknownAxis
from tests.warm_commands import WarmCommands


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["ads", "state", "--json"], True),
        (["ads", "read", "--", "--json"], False),
        (["ads", "state"], False),
        ([], False),
    ],
)
def test_json_is_requested_before_the_two_dashes(words: list[str], wanted: bool) -> None:
    assert wants_json(words) is wanted


def test_an_error_is_a_sentence_or_one_object(capsys: pytest.CaptureFixture[str]) -> None:
    print_failure("no way", name="NO_WAY")
    assert capsys.readouterr().err == "no way\n"
    with errors_in_json(True):
        assert in_json()
        print_failure("two\nlines", name="NO_WAY", code=0x710)
    assert not in_json()
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert json.loads(error) == {"code": 0x710, "name": "NO_WAY", "message": "two\nlines"}


def test_the_end_has_its_exit_code(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit) as end:
        fail("so it is", 3)
    assert (end.value.exit_code, capsys.readouterr().err) == (3, "so it is\n")


def test_the_first_refusal_has_the_code(capsys: pytest.CaptureFixture[str]) -> None:
    with errors_in_json(True), pytest.raises(typer.Exit):
        fail_by(DeviceError(0x710, "A"), DeviceError(0x706, "B"), hint="look there")
    report = json.loads(capsys.readouterr().err)
    assert (report["code"], report["name"]) == (0x710, "SYMBOL_NOT_FOUND")
    assert report["message"].startswith("A: 0x710")
    assert report["message"].endswith("; look there")


@pytest.mark.parametrize(
    ("refusal", "name"),
    [
        (DeviceError(0x710), "SYMBOL_NOT_FOUND"),
        (DeviceError(0x4221), "AXIS_VELOCITY_NOT_ALLOWED"),
        (DeviceError(0xFFFF_0000), "DEVICE_ERROR"),
        (ConnectionLost("gone"), "CONNECTION_LOST"),
        (DecodeError("what"), "DECODE_ERROR"),
        (AdsError("what"), "ADS_ERROR"),
    ],
)
def test_each_refusal_has_a_name(refusal: AdsError, name: str) -> None:
    assert name_of(refusal) == name or refusal.args[0] == 0x4221


def test_what_an_encoding_does_not_have_is_escaped() -> None:
    ascii = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    utf_8 = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
    assert dumped({"unit": "µm"}, ascii) == '{"unit": "\\u00b5m"}'
    assert dumped({"unit": "µm"}, utf_8) == '{"unit": "µm"}'
    assert dumped({"file": "µ\udcff"}, utf_8) == '{"file": "\\u00b5\\udcff"}'


def test_an_error_without_a_code_of_ads_is_no_success(capsys: pytest.CaptureFixture[str]) -> None:
    refusal = UnknownAxis(0, "'Z'", "no such axis")
    assert name_of(refusal) == "UNKNOWN_AXIS"
    with errors_in_json(True):
        print_failure(str(refusal), name=name_of(refusal), code=refusal.code)
    assert json.loads(capsys.readouterr().err)["code"] is None


@pytest.mark.parametrize(
    "words",
    [
        "docs --help",
        "axis --help",
        "drive objects",
        "fault list --kinds",
        "fault list --kinds --json",
    ],
)
def test_commands_work_where_the_encoding_is_ascii(warm_commands: WarmCommands, words: str) -> None:
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    real = words == "docs --help"
    run = warm_commands.run(*words.split(), env=environment, real=real)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.isascii()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
@pytest.mark.parametrize("words", ["drive objects", "fault list --kinds --json", "--help"])
def test_a_full_disk_behind_stdout_is_reported(warm_commands: WarmCommands, words: str) -> None:
    with open("/dev/full", "w") as full:
        run = warm_commands.run(*words.split(), stdout=full, real=words == "drive objects")
    assert run.returncode == 1
    assert "cannot write the output: No space left on device" in run.stderr
    assert len(run.stderr.splitlines()) == 1
