"""The programs of examples/ do what their pages say, against a station."""

import json
import os
import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from achse.testing import LiveStation

EXAMPLES = Path(__file__).parents[2] / "examples"
NPM = Path(__file__).parent / "npm" / "node_modules"


@pytest.fixture
def live() -> Iterator[LiveStation]:
    with LiveStation() as station:
        yield station


def _run(
    *command: object, cwd: Path | None = None, environment: dict[str, str] | None = None
) -> str:
    """What a program prints; it must end with exit code 0."""
    finished = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=os.environ | (environment or {}),
        capture_output=True,
        text=True,
    )
    assert finished.returncode == 0, finished.stdout + finished.stderr
    return finished.stdout


def _run_until_printed(expected: list[str], *command: object) -> None:
    """Run a program that prints on and on until each of the expected lines came."""
    missing = set(expected)
    with subprocess.Popen(
        [str(word) for word in command], stdout=subprocess.PIPE, text=True
    ) as program:
        assert program.stdout is not None
        for line in program.stdout:
            missing.discard(line.rstrip("\n"))
            if not missing:
                program.kill()
        assert missing == set()


def test_each_folder_has_a_page_and_a_line_in_the_list() -> None:
    listed = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for folder in (each for each in EXAMPLES.iterdir() if each.is_dir()):
        if any(folder.glob("*.*")):
            assert (folder / "README.md").is_file()
            assert f"]({folder.name}/README.md)" in listed


def test_home_assistant(live: LiveStation, witness: Callable[[str], None]) -> None:
    witness("pyads")
    witness("pyyaml")
    program = EXAMPLES / "home-assistant" / "try_configuration.py"
    page = (EXAMPLES / "home-assistant" / "README.md").read_text(encoding="utf-8")
    lines = page.rpartition("```text\n")[2].partition("```")[0].splitlines()
    command = (sys.executable, program, "--host", live.host, "--seconds", "600")
    _run_until_printed(lines, *command)
    _run_until_printed(["switch Conveyor = off"], *command, "--turn", "Conveyor", "off")
    with live.connect() as plc:
        assert plc.read("GVL.bBool") is False


def test_node_red(live: LiveStation, witness: Callable[[str], None]) -> None:
    witness("ads-client")
    program = EXAMPLES / "node-red" / "run-flow.mjs"
    with (
        subprocess.Popen(
            ["node", program, live.host, live.net_id, "2"],
            env=os.environ | {"NODE_PATH": str(NPM)},
            stdout=subprocess.PIPE,
            text=True,
        ) as flow,
        live.connect() as plc,
    ):
        assert flow.stdout is not None
        first = json.loads(flow.stdout.readline())
        assert first == {
            "node": "show",
            "payload": {"fX": 1, "fY": 2, "sName": "home", "bValid": True},
        }
        plc.write("GVL.nInt", 40)
        rest, _ = flow.communicate()
        assert json.loads(rest)["payload"] == 16
        assert flow.returncode == 0
        assert plc.read("GVL.fLreal") == 16.0


def test_the_flow_names_only_nodes_that_it_has() -> None:
    flow = json.loads((EXAMPLES / "node-red" / "flow.json").read_text(encoding="utf-8"))
    ids = {node["id"] for node in flow}
    for node in flow:
        assert {id for wire in node.get("wires", []) for id in wire} <= ids
        assert node.get("connection", "station") in ids
        assert node.get("z", "tab") in ids


def test_pytest(tmp_path: Path) -> None:
    folder = shutil.copytree(EXAMPLES / "pytest", tmp_path / "machine")
    words = ("-q", "-W", "error", "-p", "no:cacheprovider", ".")
    if not hasattr(os, "fork"):
        printed = _run(sys.executable, "-m", "pytest", *words, cwd=folder)
    else:
        loaded = ("-W", "ignore::pytest.PytestAssertRewriteWarning")  # plugins, by this process
        code, printed = _forked_pytest(folder, (*words, *loaded))
        assert code == 0, printed
    assert re.search(r"^\d passed", printed, re.MULTILINE), printed


def _forked_pytest(folder: Path, words: tuple[str, ...]) -> tuple[int, str]:
    """Exit code and output of pytest in a fork, which has loaded what the tests need."""
    output = folder.with_suffix(".txt")
    process = os.fork()
    if process == 0:
        code = 1
        try:
            with output.open("wb") as file:
                os.dup2(file.fileno(), 1)
                os.dup2(file.fileno(), 2)
            sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
            os.chdir(folder)
            sys.path.insert(0, str(folder))
            code = int(pytest.main(list(words)))
            sys.stdout.flush()
        finally:
            os._exit(code)
    code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    return code, output.read_text(encoding="utf-8")


PROGRAM_WITH_OPHYD = """
import runpy
import sys
import pyads
runpy.run_path("scan.py", run_name="__main__")
from ads_axis import NC_PORT, AdsAxis, AxisFault
with pyads.Connection(sys.argv[1] + ".1.1", NC_PORT, sys.argv[1]) as nc:
    nc.set_timeout(600_000)
    x = AdsAxis(nc, 1, velocity=50.0, name="x")
    x.enable()
    status = x.move(1000, wait=False)
    nc.write(0x4301, 0x01, 0, pyads.PLCTYPE_UDINT)
    try:
        status.wait(600)
    except AxisFault as fault:
        print(fault)
    try:
        x.move(10).wait(600)
    except pyads.ADSError as refusal:
        print(refusal.err_code)
"""
"""The example, and what it does not show, in one process: ophyd takes long to import."""


def test_ophyd_scans_and_reports_faults_and_refusals(
    live: LiveStation, witness: Callable[[str], None]
) -> None:
    witness("pyads")
    witness("ophyd")
    printed = _run(sys.executable, "-c", PROGRAM_WITH_OPHYD, live.host, cwd=EXAMPLES / "ophyd")
    steps = re.findall(r"^x +([\d.]+) mm$", printed, re.MULTILINE)
    assert [float(step) for step in steps] == pytest.approx([0, 10, 20, 30], abs=0.2)
    assert printed.splitlines()[-2:] == ["x: 0x4260", str(0x4260)]


PROGRAM_WITH_CAPROTO = """
import time
from caproto import CaprotoTimeoutError
from caproto.sync.client import read, write
while True:  # one datagram searches for the server, which may not listen yet
    try:
        read("X:DMOV", timeout=1, repeater=False)
        break
    except CaprotoTimeoutError:
        pass
def put(name, value):
    write("X:" + name, value, timeout=3600, repeater=False)
def get(name):
    return read("X:" + name, timeout=3600, repeater=False).data[0]
put("CNEN", 1)
time.sleep(0.5)
put("VELO", 200.0)
put("VAL", 50.0)
while not get("DMOV"):
    time.sleep(0.05)
print(round(get("RBV")), get("MSTA"))
put("VAL", 5000.0)
put("STOP", 1)
while not get("DMOV"):
    time.sleep(0.05)
print(get("RBV") < 4000)
"""


def test_epics(live: LiveStation, witness: Callable[[str], None]) -> None:
    witness("pyads")
    witness("caproto")
    with socket.create_server((live.host, 0)) as free:
        port = str(free.getsockname()[1])
    environment = {
        "EPICS_CA_SERVER_PORT": port,
        "EPICS_CAS_SERVER_PORT": port,
        "EPICS_CA_ADDR_LIST": live.host,
        "EPICS_CA_AUTO_ADDR_LIST": "NO",
        "EPICS_CAS_BEACON_ADDR_LIST": live.host,
        "EPICS_CAS_AUTO_BEACON_ADDR_LIST": "NO",
    }
    program = EXAMPLES / "epics" / "ioc.py"
    with subprocess.Popen(
        [sys.executable, program, "--host", live.host, "--interface", live.host],
        env=os.environ | environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as ioc:
        try:
            printed = _run(sys.executable, "-c", PROGRAM_WITH_CAPROTO, environment=environment)
        finally:
            ioc.terminate()
    assert printed.splitlines() == ["50 0", "True"]
