"""Test suites of others pass and fail as `expected.tsv` says: green stays green, red is explained.

`.ci/foreign-suites` builds them. A test that passes though a fault is expected is an error too, so
that the table stays true.
"""

import json
import os
import re
import socket
import subprocess
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import achse

TABLE = Path(__file__).with_name("expected.tsv")
BUILT = Path(__file__).parents[2] / ".foreign" / "pyads-3.6.0"
TOOL_SUITE = BUILT / "adslib" / "tools" / "91_test_AdsTool.sh"

NET_ID = "192.168.0.231.1.1"
"""NetId of the station that the vendor's suites are written for."""

STATION = """
[system]
root = "files"
restart_time = "10ms"
programs = ['/usr/bin/env', '{programs}/result*.sh']

[[plc]]
sources = '{project}'
"""


ADS_CLIENT_STATION = """
[[plc]]
sources = '{project}'

[[plc]]
port = 852
"""


@dataclass(frozen=True)
class Expectation:
    """A row of the table."""

    suite: str
    test: str
    expected: str
    fault: str
    reason: str


def _rows() -> list[Expectation]:
    head, *lines = TABLE.read_text(encoding="utf-8").splitlines()
    assert head.split("\t") == ["suite", "test", "expected", "fault", "reason"]
    return [Expectation(*line.split("\t")) for line in lines]


ROWS = _rows()


@pytest.fixture(scope="module")
def built() -> Path:
    """Folder of the built suites; without them the test is skipped, or fails in CI."""
    if not (BUILT / "recipe").is_file():
        absent = pytest.fail if os.environ.get("ACHSE_WITNESSES") == "required" else pytest.skip
        absent("the vendor's suites are not built on this machine; .ci/foreign-suites builds them")
    return BUILT


@pytest.fixture(scope="module")
def vendor_station(
    built: Path,
    start_station: Callable[..., AbstractContextManager[Any]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Any]:
    """A station with the suites' sample PLC project, and the folder of programs that it starts."""
    folder = tmp_path_factory.mktemp("vendor")
    (folder / "files" / "dev" / "shm").mkdir(parents=True)
    project = built / "adslib" / "PLC-TestProject" / "Untitled1"
    programs = folder / "programs"
    programs.mkdir()
    text = STATION.format(project=project, programs=programs)
    (folder / "station.toml").write_text(text, encoding="utf-8")
    with start_station(str(folder / "station.toml"), "--net-id", NET_ID) as running:
        yield running, programs


@pytest.fixture(scope="module")
def second_host(free_host: Callable[[], str]) -> Iterator[str]:
    """An address where a connection is accepted, and no more."""
    host = free_host()
    with socket.create_server((host, 48898)):
        yield host


@pytest.fixture
def run_vendor_test(
    built: Path, vendor_station: Any, second_host: str, tmp_path: Path
) -> Callable[[str, str], "subprocess.CompletedProcess[str]"]:
    """`run_vendor_test("AdsLibTest", "testAdsTimeout")` runs one test of a suite."""
    station, programs = vendor_station
    address = station.host
    commands: dict[str, Callable[[str], list[str | Path]]] = {
        "AdsLibTest": lambda test: [built / "AdsLibTest", test],
        "AdsLibOOITest": lambda test: [built / "AdsLibOOITest", test],
        "AdsTest": lambda test: [built / "AdsTest", NET_ID, f"--gw={address}", "registry", test],
        "adstool": lambda test: [
            *("sh", TOOL_SUITE.with_name("one_check.sh"), address, built / "AdsTool", test),
        ],
    }

    def run(suite: str, test: str) -> "subprocess.CompletedProcess[str]":
        with achse.blocking.connect(address, net_id=NET_ID) as plc:
            plc.write_raw(0x4020, 0, bytes(8))  # flags that another test has left
        places = {"ADS_SERVER": address, "ADS_SECOND": second_host, "ADS_FOLDER": str(programs)}
        return subprocess.run(
            commands[suite](test),
            cwd=tmp_path,  # the tool's suite writes a log where it runs
            env=os.environ | places | {"BHF_CI_ADS_RETRY_LIMIT": "600"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )

    return run


@pytest.mark.parametrize(
    "row",
    [row for row in ROWS if row.suite != "ads-client"],
    ids=lambda row: f"{row.suite}-{row.test}",
)
def test_foreign_suite_meets_the_table(
    row: Expectation, run_vendor_test: Callable[[str, str], "subprocess.CompletedProcess[str]"]
) -> None:
    done = run_vendor_test(row.suite, row.test)
    last = "\n".join(done.stdout.splitlines()[-30:])
    if row.expected == "pass":
        assert done.returncode == 0, f"{row.suite} {row.test} was green, and is red:\n{last}"
    else:
        assert done.returncode != 0, (
            f"{row.suite} {row.test} was red ({row.reason}), and is green: change {TABLE.name}"
        )


@pytest.fixture(scope="module")
def ads_client_suite() -> Path:
    """The folder ACHSE_ADS_CLIENT_SUITE; no registry has the suite, so CI may lack it."""
    if "ACHSE_ADS_CLIENT_SUITE" not in os.environ:
        pytest.skip(
            "ACHSE_ADS_CLIENT_SUITE is not set: expected a folder with ads-client (a clone,"
            " after `npm install` and `npx tsc`) and ads-client-test-plc-project"
        )
    return Path(os.environ["ACHSE_ADS_CLIENT_SUITE"])


def test_ads_client_suite_meets_the_table(
    ads_client_suite: Path,
    start_station: Callable[..., AbstractContextManager[Any]],
    tmp_path: Path,
) -> None:
    station_file, results = tmp_path / "station.toml", tmp_path / "results.json"
    project = ads_client_suite / "ads-client-test-plc-project" / "TwinCAT 3/AdsClientTests/PLC"
    station_file.write_text(ADS_CLIENT_STATION.format(project=project))
    suite, preload = ads_client_suite / "ads-client", Path(__file__).with_name("npm")
    with start_station(str(station_file), "--net-id", "192.168.4.1.1.1") as station:
        subprocess.run(
            [
                *("npx", "jest", "--runInBand", "--rootDir", "test", "TC3/ads-client.test.js"),
                *("--json", "--outputFile", results, "--testTimeout", "600000"),
            ],
            cwd=suite,
            env=os.environ
            | {
                "ADS_SERVER": station.host,
                "AMS_NET_ID": station.net_id,
                "NODE_OPTIONS": f"--require {preload / 'to-station.cjs'}",
            },
            stdin=subprocess.DEVNULL,
        )
    tests = json.loads(results.read_text(encoding="utf-8"))["testResults"][0]["assertionResults"]
    actual = {test["fullName"]: "pass" if test["status"] == "passed" else "fail" for test in tests}
    expected = {row.test: row.expected for row in ROWS if row.suite == "ads-client"}
    assert actual == expected


def test_each_red_has_a_reason_and_whose_fault_it_is() -> None:
    for row in ROWS:
        if row.expected == "pass":
            assert (row.fault, row.reason) == ("", ""), row
        else:
            assert row.expected == "fail", row
            assert row.fault in ("ours", "theirs"), row
            assert row.reason, row


def test_table_lists_each_test_of_the_suites(built: Path) -> None:
    """The tests of the sources, but those that the vendor has commented out."""
    expected = {("AdsTest", "testdeletekey")}
    for suite in ("AdsLibTest", "AdsLibOOITest"):
        source = (built / "adslib" / suite / "main.cpp").read_text(encoding="utf-8")
        main = source[source.index("int main(") :]
        names = re.findall(r"^\s*\w+\.add_test\(\s*\"(\w+)\"", main, re.MULTILINE)
        expected |= {(suite, name) for name in names}
    calls = TOOL_SUITE.read_text(encoding="utf-8").partition("# --log-level requires no PLC")[2]
    expected |= {("adstool", name) for name in re.findall(r"^check_(\w+)$", calls, re.MULTILINE)}
    listed = [(row.suite, row.test) for row in ROWS if row.suite != "ads-client"]
    assert sorted(listed) == sorted(expected)
