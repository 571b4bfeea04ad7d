"""`achse run` and `achse check`: ready line, end, repeatability, and complaints."""

import contextlib
import json
import os
import shlex
import shutil
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from achse.ams import AmsAddress, Command, Frame
from achse.cli.app import app
from achse.station.routes.addresses import net_id_at
from tests.interop.waiting import until
from tests.warm_commands import PIPES, WarmCommands

ACHSE = [sys.executable, "-m", "achse"]


def _achse(*arguments: str, exit_code: int = 0) -> Result:
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def test_two_runs_end_in_the_same_state(warm_commands: WarmCommands) -> None:
    """One of them is a new interpreter, the other is forked."""
    command = ["run", "--speed", "max", "--for", "2", "--tcp-port", "0"]
    runs = [warm_commands.popen(*command, real=real, **PIPES) for real in (True, False)]
    (ready, one), (_, other) = (run.communicate()[0].splitlines() for run in runs)
    assert [run.returncode for run in runs] == [0, 0]
    assert ready.startswith("achse ready net_id=127.0.0.1.1.1 tcp=127.0.0.1:")
    assert one.startswith("achse done t=2 state=")
    assert one == other


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_it_with_0(warm_commands: WarmCommands, number: signal.Signals) -> None:
    run = warm_commands.popen("run", "--tcp-port", "0", **PIPES)
    assert run.stdout is not None
    pairs = dict(pair.split("=") for pair in run.stdout.readline().split()[2:])
    assert int(pairs["tcp"].rpartition(":")[2]) > 0
    assert {"500", "501", "851", "10000"} <= set(pairs["ports"].split(","))
    assert (pairs["speed"], pairs["axes"]) == ("1", "3")
    run.send_signal(number)
    rest, errors = run.communicate()
    assert (run.returncode, rest, errors) == (0, "", "")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="tells who waits for whom")
def test_it_ends_within_two_seconds_whatever_its_clients_do(
    tmp_path: Path, warm_commands: WarmCommands
) -> None:
    """Time in which the machine was busy with others does not count."""
    file = tmp_path / "station.toml"
    file.write_text(
        '[[plc]]\nglobals = ["achse.station.demo:GVL"]\n'
        '[[route]]\nname = "nowhere"\nnet_id = "5.9.9.9.1.1"\nhost = "192.0.2.1"\n'
    )
    run = warm_commands.popen("run", str(file), "--tcp-port", "0", real=True, **PIPES)
    assert run.stdout is not None
    port = int(run.stdout.readline().partition(" tcp=127.0.0.1:")[2].split()[0])

    def request(target: str, size: int) -> bytes:
        place = struct.pack("<III", 0x4020, 0, size)
        source = AmsAddress("192.0.2.7.1.1:30000")
        return Frame(AmsAddress(target), source, Command.READ, data=place).encode_tcp()

    with contextlib.ExitStack() as sockets:
        clients = [
            sockets.enter_context(socket.create_connection(("127.0.0.1", port))) for _ in range(50)
        ]
        clients[0].sendall(request("127.0.0.1.1.1:851", 0x1_0000) * 500)  # and reads nothing
        clients[1].sendall(request("5.9.9.9.1.1:851", 4))  # which is being dialled
        clients[2].sendall(request("127.0.0.1.1.1:851", 4)[:20])
        assert clients[0].recv(1)
        begin, before = time.monotonic(), _waited(run.pid)
        run.send_signal(signal.SIGTERM)
        os.waitid(os.P_PID, run.pid, os.WEXITED | os.WNOWAIT)
        took = time.monotonic() - begin - (_waited(run.pid) - before)
    run.communicate()
    assert run.returncode == 0
    assert took < 2.0


def _waited(process_id: int) -> float:
    """Seconds for which a process waited for a processor."""
    return int(Path(f"/proc/{process_id}/schedstat").read_text().split()[1]) / 1e9


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_it_with_0_before_it_is_ready(
    number: signal.Signals, tmp_path: Path, warm_commands: WarmCommands
) -> None:
    (tmp_path / "slow.py").write_text(
        "print('now', flush=True); import threading; threading.Event().wait()"
    )
    file = tmp_path / "station.toml"
    file.write_text('[[plc]]\nglobals = ["slow.py:GVL"]')
    run = warm_commands.popen("run", str(file), real=number == signal.SIGINT, **PIPES)
    assert run.stdout is not None
    assert run.stdout.readline() == "now\n"
    run.send_signal(number)
    rest, _ = run.communicate()
    assert (run.returncode, rest) == (0, "")


SAVING = """
[system]
persistent_data = "state.json"
[[axis]]
id = 1
name = "X"
persistent_data_enable = 1
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_saves_persistent_data(
    number: signal.Signals, tmp_path: Path, warm_commands: WarmCommands
) -> None:
    """SIGHUP ended it without, when its terminal was closed."""
    (tmp_path / "station.toml").write_text(SAVING)
    run = warm_commands.popen("run", str(tmp_path / "station.toml"), "--tcp-port", "0", **PIPES)
    assert run.stdout is not None
    assert run.stdout.readline().startswith("achse ready ")
    run.send_signal(number)
    run.communicate()
    assert run.returncode == 0
    assert list(json.loads((tmp_path / "state.json").read_text())["nc"]) == ["1"]


def test_end_without_saved_data_is_exit_code_1(tmp_path: Path, warm_commands: WarmCommands) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "station.toml").write_text(SAVING.replace("state.json", "data/state.json"))
    run = warm_commands.popen("run", str(tmp_path / "station.toml"), "--tcp-port", "0", **PIPES)
    assert run.stdout is not None
    assert run.stdout.readline().startswith("achse ready ")
    shutil.rmtree(tmp_path / "data")
    run.send_signal(signal.SIGTERM)
    _, errors = run.communicate()
    assert run.returncode == 1
    assert "state.json cannot be written: No such file or directory" in errors


def assert_is_station(client: socket.socket) -> None:
    """Ask for the NetId."""
    client.sendall(bytes.fromhex("0210 00000000"))
    assert client.recv(12) == bytes.fromhex("0210 06000000 7f0000010101")


def test_under_nohup_it_stays_and_the_usual_limit_of_open_files_is_none_of_connections() -> None:
    command = f"ulimit -Sn 64; exec nohup {shlex.join(ACHSE)} run --tcp-port 0"
    run = subprocess.Popen(["bash", "-c", command], stdout=subprocess.PIPE, text=True)
    assert run.stdout is not None
    port = int(run.stdout.readline().partition(" tcp=127.0.0.1:")[2].split()[0])
    run.send_signal(signal.SIGHUP)
    with contextlib.ExitStack() as stack:
        for _ in range(100):
            client = stack.enter_context(socket.create_connection(("127.0.0.1", port)))
            assert_is_station(client)
    if sys.platform == "linux":
        status = Path(f"/proc/{run.pid}/status").read_text(encoding="utf-8")
        [ignored] = [line.split()[1] for line in status.splitlines() if line.startswith("SigIgn:")]
        assert int(ignored, 16) & 1 << (signal.SIGHUP - 1)
    run.terminate()
    run.communicate()
    assert run.returncode == 0


def test_beyond_this_computer_it_listens_only_with_an_explicit_option(
    warm_commands: WarmCommands,
) -> None:
    refused = _achse("run", "--host", "0.0.0.0", "--tcp-port", "0", exit_code=1)
    assert refused.stdout == ""
    assert "this station lets everybody in. To allow that: --let-everybody-in" in refused.stderr
    words = "run", "--host", "0.0.0.0", "--tcp-port", "0", "--let-everybody-in"
    run = warm_commands.popen(*words, **PIPES)
    assert run.stdout is not None
    assert f" net_id={net_id_at('0.0.0.0')} tcp=0.0.0.0:" in run.stdout.readline()
    run.terminate()
    _, errors = run.communicate()
    assert "Any client that reaches it may, without a password:" in errors
    assert "- stop, restart and shut down the station" in errors


def test_its_samples_show_the_wall_clock(warm_commands: WarmCommands) -> None:
    before = datetime.now(UTC)
    run = warm_commands.popen("run", "--tcp-port", "0", **PIPES)
    assert run.stdout is not None
    port = run.stdout.readline().partition(" tcp=127.0.0.1:")[2].split()[0]
    watch = ["ads", "read", "--watch", "MAIN.nCounter", "-n", "1", "--json", "--tcp-port", port]
    sample = json.loads(_achse(*watch).stdout)
    run.terminate()
    run.communicate()
    assert before < datetime.fromisoformat(sample["time"]) < datetime.now(UTC)


def test_slaves_of_a_bus_may_be_on_an_interface(warm_commands: WarmCommands) -> None:
    """Without that interface the station starts, and says what is missing."""
    example = str(Path(__file__).parents[3] / "examples" / "drives" / "station.toml")
    command = ["run", example, "--tcp-port", "0", "--for", "0.1"]
    run = warm_commands.run(*command, "--interface", "no-such-if")
    assert run.returncode == 0, run.stderr
    assert "achse ready" in run.stdout
    assert "EtherCAT: " in run.stderr
    assert "no-such-if" in run.stderr
    for words in (["="], ["a=b", "a=c"]):
        options = [f"--interface={word}" for word in words]
        assert "--interface" in _achse("run", example, *options, exit_code=2).output
    output = _achse("run", example, "--interface", "Q=eth0", exit_code=1).output
    assert "no bus 'Q'; buses: EtherCAT" in output


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--interface=e1", "--redundant=Q=e2"), "no bus 'Q'; buses: EtherCAT"),
        (("--redundant=e2",), "redundant: expected an interface beside the second one, e2"),
        (("--interface=e1", "--redundant=e1"), "redundant: expected another interface than e1"),
    ],
)
def test_a_second_interface_that_cannot_be_is_reported(
    options: tuple[str, ...], message: str
) -> None:
    example = str(Path(__file__).parents[3] / "examples" / "drives" / "station.toml")
    assert message in _achse("run", example, *options, exit_code=1).output
    assert "--redundant" in _achse("run", example, "--redundant", "=", exit_code=2).output


def test_without_end_means_for_ever(warm_commands: WarmCommands) -> None:
    run = warm_commands.popen("run", "--tcp-port", "0", "--for", "inf", **PIPES)
    assert run.stdout is not None
    assert run.stdout.readline().startswith("achse ready ")
    run.terminate()
    rest, _ = run.communicate()
    assert (run.returncode, rest) == (0, "")


def test_what_can_be_no_host_name_is_reported() -> None:
    [line] = _achse("run", "--host", "a..b", exit_code=1).stderr.splitlines()
    assert line.startswith("cannot listen on a..b:48898: ")


def test_a_port_that_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        result = _achse("run", "--tcp-port", str(port), exit_code=1)
    assert result.stdout == ""
    [line] = result.stderr.splitlines()
    assert f"127.0.0.1:{port}" in line
    assert "--tcp-port" in line


@pytest.mark.parametrize("speed", ["0", "-1", "fast", "nan", "inf"])
def test_a_speed_that_is_none(speed: str) -> None:
    result = _achse("run", "--speed", speed, exit_code=2)
    assert "--speed" in result.stderr
    assert "a number above 0 or `max`" in result.stderr


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[router\n", "line 1"),
        ("[router]\nnet_id = 5\n", "router.net_id"),
        ("[[axis]]\nid = 1\nname = 'X'\nmax_velocity = -1.0\n", "max_velocity"),
        ("[[plc]]\nport = 851\nglobals = ['nowhere:GVL']\n", "globals"),
    ],
)
@pytest.mark.parametrize("command", ["check", "run"])
def test_a_broken_station_toml(tmp_path: Path, command: str, text: str, complaint: str) -> None:
    file = tmp_path / "station.toml"
    file.write_text(text)
    result = _achse(command, str(file), exit_code=1)
    assert complaint in result.stderr
    assert "station.toml" in result.stderr
    assert "Traceback" not in result.stderr


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    assert "nothing.toml" in _achse("check", str(tmp_path / "nothing.toml"), exit_code=1).stderr


def test_a_station_toml_that_is_right(tmp_path: Path) -> None:
    file = tmp_path / "station.toml"
    file.write_text("[[axis]]\nid = 4\nname = 'Z'\n")
    assert _achse("check", str(file)).stdout.rstrip().endswith("1 axes: ok")


def test_what_only_a_running_program_could_do_is_a_warning_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "plc").mkdir()
    (tmp_path / "plc" / "main.st").write_text(
        "PROGRAM MAIN\nVAR\n    n : INT := 3;\n    m : INT := n + 1;\n"
        "    fMass : LREAL := F_Weigh(n);\nEND_VAR\nEND_PROGRAM\n"
    )
    file = tmp_path / "station.toml"
    file.write_text('[[plc]]\nsources = "plc"\nexecute = false\n')
    result = _achse("check", str(file))
    assert result.stdout.rstrip().endswith(": ok")
    assert result.stderr.splitlines() == [
        "warning: plc 851: main.st:5:22: shows only when the program runs: starts as its type says",
        "        fMass : LREAL := F_Weigh(n);",
        "                         ^",
    ]


@pytest.mark.skipif(sys.platform == "win32", reason="closes files by number")
@pytest.mark.parametrize("closed", ["2>&-", ">&-", "<&- >&- 2>&-"])
def test_closed_standard_streams_do_not_matter(closed: str, free_host: Callable[[], str]) -> None:
    host = free_host()
    command = f"exec {shlex.join([*ACHSE, 'run', '--host', host, '--tcp-port', '48898'])} {closed}"
    run = subprocess.Popen(
        ["sh", "-c", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )

    def answers() -> bool:
        assert run.poll() is None
        with contextlib.suppress(OSError), socket.create_connection((host, 48898)) as client:
            client.sendall(bytes.fromhex("0210 00000000"))  # its NetId
            return len(client.recv(12)) == 12
        return False

    try:
        until(answers)
    finally:
        run.terminate()
        _, errors = run.communicate()
    assert (run.returncode, errors) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_a_full_disk_behind_stdout_is_reported_and_ends_nothing(
    warm_commands: WarmCommands,
) -> None:
    with open("/dev/full", "w") as full:
        words = "run", "--tcp-port", "0", "--speed", "max", "--for", "0.1"
        run = warm_commands.run(*words, stdout=full)
    assert run.returncode == 0
    assert "stdout cannot be written: No space left on device" in run.stderr
    assert "Traceback" not in run.stderr


def test_a_folder_stands_for_the_station_in_it(tmp_path: Path, warm_commands: WarmCommands) -> None:
    run = warm_commands.run("run", str(tmp_path))
    assert run.returncode == 1
    assert "expected a station.toml, or a folder with" in run.stderr
    (tmp_path / "station.toml").write_text('[[axis]]\nid = 1\nname = "X"\n')
    run = warm_commands.run("run", str(tmp_path), "--tcp-port", "0", "--for", "0", "--speed", "max")
    assert run.returncode == 0
    assert "axes=1" in run.stdout


def test_demo_beside_a_station_file_names_the_command_for_that_station(
    tmp_path: Path, warm_commands: WarmCommands
) -> None:
    (tmp_path / "station.toml").write_text('[[axis]]\nid = 1\nname = "X"\n')
    run = warm_commands.run("run", "--tcp-port", "0", "--for", "0", "--speed", "max", cwd=tmp_path)
    assert run.returncode == 0
    assert "axes=1" not in run.stdout
    assert "starting the demo; `achse run station.toml` starts the station here" in run.stderr
