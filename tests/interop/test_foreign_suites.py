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
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import achse
from tests import warm_commands as warm

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


ROUTED_FAILURES = {
    ("adstool", "raw"): "a symbol handle ends with the program that fetched it; the suite's next"
    " program uses it",
}
"""Tests that pass directly and fail through `achse router`, with their reasons."""

LOAD_TESTS = ("testManyNotifications", "testEndurance", "testParallelReadAndWrite")
"""Tests that are run directly alone: the router has a benchmark of its own."""

NET_ID_OF_THE_STATION = """#!/bin/sh
[ "$1 $2" = "$ADS_SERVER netid" ] && exec "{tool}" {station} netid
exec "{tool}" "$@"
"""
"""The tool, which is told the NetId of the station: the router answers its own."""


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


@pytest.fixture(scope="module")
def start_router(
    free_host: Callable[[], str], warm_commands: warm.WarmCommands
) -> Callable[[str, str], AbstractContextManager[str]]:
    """`start_router(host, net_id)` runs an `achse router` to a target, and yields its address."""

    @contextmanager
    def start(target: str, net_id: str) -> Iterator[str]:
        host = free_host()
        words = ("router", "--to", f"{target}={net_id}", "--host", host, "--net-id", f"{host}.1.1")
        process = warm_commands.popen(*words, **warm.PIPES)
        try:
            assert process.stdout is not None
            assert process.stdout.readline().startswith("achse ready")
            yield host
        finally:
            process.terminate()
            process.communicate()

    return start


@pytest.fixture(scope="module")
def vendor_router(
    vendor_station: Any, start_router: Callable[[str, str], AbstractContextManager[str]]
) -> Iterator[str]:
    """Address of a router with the station of the suites as its target."""
    with start_router(vendor_station[0].host, NET_ID) as host:
        yield host


Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def run_vendor_test(built: Path, vendor_station: Any, second_host: str, tmp_path: Path) -> Run:
    """`run_vendor_test("AdsLibTest", "testAdsTimeout")` runs one test of a suite."""
    station, programs = vendor_station
    commands: dict[str, Callable[[str, str], list[str | Path]]] = {
        "AdsLibTest": lambda test, _: [built / "AdsLibTest", test],
        "AdsLibOOITest": lambda test, _: [built / "AdsLibOOITest", test],
        "AdsTest": lambda test, host: [built / "AdsTest", NET_ID, f"--gw={host}", "registry", test],
        "adstool": lambda test, host: [
            *("sh", TOOL_SUITE.with_name("one_check.sh"), host, tool, test),
        ],
    }

    tool = tmp_path / "tool"
    tool.write_text(NET_ID_OF_THE_STATION.format(tool=built / "AdsTool", station=station.host))
    tool.chmod(0o700)

    def run(
        suite: str, test: str, address: str = station.host
    ) -> "subprocess.CompletedProcess[str]":
        with achse.blocking.connect(station.host, net_id=NET_ID) as plc:
            plc.write_raw(0x4020, 0, bytes(8))  # flags that another test has left
        places = {"ADS_SERVER": address, "ADS_SECOND": second_host, "ADS_FOLDER": str(programs)}
        return subprocess.run(
            commands[suite](test, address),
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
def test_foreign_suite_meets_the_table(row: Expectation, run_vendor_test: Run) -> None:
    done = run_vendor_test(row.suite, row.test)
    last = "\n".join(done.stdout.splitlines()[-30:])
    if row.expected == "pass":
        assert done.returncode == 0, f"{row.suite} {row.test} was green, and is red:\n{last}"
    else:
        assert done.returncode != 0, (
            f"{row.suite} {row.test} was red ({row.reason}), and is green: change {TABLE.name}"
        )


@pytest.mark.parametrize(
    "row",
    [
        row
        for row in ROWS
        if row.suite in ("AdsLibTest", "AdsTest", "adstool") and row.test not in LOAD_TESTS
    ],
    ids=lambda row: f"{row.suite}-{row.test}",
)
def test_foreign_suite_meets_the_table_through_a_router(
    row: Expectation, run_vendor_test: Run, vendor_router: str
) -> None:
    done = run_vendor_test(row.suite, row.test, vendor_router)
    fails = row.expected == "fail" or (row.suite, row.test) in ROUTED_FAILURES
    last = "\n".join(done.stdout.splitlines()[-30:])
    assert (done.returncode != 0) is fails, f"{row.suite} {row.test} through a router:\n{last}"


@pytest.fixture(scope="module")
def ads_client_suite() -> Path:
    """The folder ACHSE_ADS_CLIENT_SUITE; no registry has the suite, so CI may lack it."""
    if "ACHSE_ADS_CLIENT_SUITE" not in os.environ:
        pytest.skip(
            "ACHSE_ADS_CLIENT_SUITE is not set: expected a folder with ads-client (a clone,"
            " after `npm install` and `npx tsc`) and ads-client-test-plc-project"
        )
    return Path(os.environ["ACHSE_ADS_CLIENT_SUITE"])


NEEDS_A_ROUTER = "connection connecting to the target"
"""Test that fails for want of a router between the client and its target."""


@pytest.mark.parametrize("way", ["direct", "router"])
def test_ads_client_suite_meets_the_table(
    way: str,
    ads_client_suite: Path,
    start_station: Callable[..., AbstractContextManager[Any]],
    start_router: Callable[[str, str], AbstractContextManager[str]],
    tmp_path: Path,
) -> None:
    station_file, results = tmp_path / "station.toml", tmp_path / "results.json"
    project = ads_client_suite / "ads-client-test-plc-project" / "TwinCAT 3/AdsClientTests/PLC"
    station_file.write_text(ADS_CLIENT_STATION.format(project=project))
    suite, preload = ads_client_suite / "ads-client", Path(__file__).with_name("npm")
    with (
        start_station(str(station_file), "--net-id", "192.168.4.1.1.1") as station,
        nullcontext(station.host)
        if way == "direct"
        else start_router(station.host, station.net_id) as host,
    ):
        subprocess.run(
            [
                *("npx", "jest", "--runInBand", "--rootDir", "test", "TC3/ads-client.test.js"),
                *("--json", "--outputFile", results, "--testTimeout", "600000"),
            ],
            cwd=suite,
            env=os.environ
            | {
                "ADS_SERVER": host,
                "AMS_NET_ID": station.net_id,
                "NODE_OPTIONS": f"--require {preload / 'to-station.cjs'}",
            },
            stdin=subprocess.DEVNULL,
        )
    tests = json.loads(results.read_text(encoding="utf-8"))["testResults"][0]["assertionResults"]
    actual = {test["fullName"]: "pass" if test["status"] == "passed" else "fail" for test in tests}
    expected = {row.test: row.expected for row in ROWS if row.suite == "ads-client"}
    if way == "router":
        expected[NEEDS_A_ROUTER] = "pass"
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
