"""Each kind of fault, met by pyads or by ads-client.

Time limits are long where an answer comes and short where none does: what else the machine has to
do decides nothing.
"""

import json
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from achse.testing import LiveStation
from tests.interop.conftest import NO_LATE_REQUESTS, PATIENT_MS
from tests.warm_commands import WarmCommands

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

NPM = Path(__file__).parent / "npm"
INT, UDINT = "GVL.nInt", "MAIN.nCounter"
TIMEOUT = 0x745
IMPATIENT_MS = 150
"""Where no answer comes."""

virtual = pytest.mark.achse_station(time="virtual")


@pytest.fixture
def plc(achse_station: LiveStation) -> Iterator[Any]:
    """pyads on the PLC of a station that only this test has."""
    connection = pyads.Connection(achse_station.net_id, 851, achse_station.host)
    reopen(connection)
    yield connection
    connection.close()


def reopen(plc: Any) -> None:
    """Connect again, as a program does after a loss."""
    plc.close()
    plc.open()


def code_of(ask: Callable[[], Any]) -> int:
    """The ADS error that pyads raises; 0 if it does not."""
    try:
        ask()
    except pyads.ADSError as failure:
        return int(failure.err_code)
    return 0


def asking(station: LiveStation, *requests: tuple[int, int], limit_ms: int = PATIENT_MS) -> Any:
    """What ads-client gets for reads under way at the same time, and the order of the answers."""
    settings = {
        "routerAddress": station.host,
        "routerTcpPort": station.tcp_port,
        "targetAmsNetId": station.net_id,
        "targetAdsPort": 851,
        "requests": requests,
        "timeLimit": limit_ms,
        **NO_LATE_REQUESTS,
    }
    finished = subprocess.run(
        ["node", "faults.mjs", json.dumps(settings)],
        cwd=NPM,
        capture_output=True,
        text=True,
    )
    assert finished.returncode == 0, finished.stderr
    return json.loads(finished.stdout)


def state(plc: Any) -> int:
    return code_of(plc.read_state)


def lost(plc: Any) -> int:
    """The error of a request that gets no answer."""
    plc.set_timeout(IMPATIENT_MS)
    code = state(plc)
    plc.set_timeout(PATIENT_MS)
    return code


@pytest.mark.parametrize("kind", ["drop", "wrong_invoke_id"])
def test_a_lost_answer_is_a_timeout(achse_station: LiveStation, plc: Any, kind: str) -> None:
    achse_station.fault(kind, command="read_state", count=1)
    assert lost(plc) == TIMEOUT
    assert state(plc) == 0


@virtual
def test_delay(achse_station: LiveStation, plc: Any, until: Callable[..., None]) -> None:
    late = achse_station.fault("delay", by=0.3, count=1)
    codes: list[int] = []
    asking = threading.Thread(target=lambda: codes.append(state(plc)))
    asking.start()
    until(lambda: late.hits)
    achse_station.advance(0.2)
    assert codes == []
    achse_station.advance(0.2)
    asking.join()
    assert codes == [0]


@virtual
def test_a_late_answer_is_no_answer_to_the_next_question(
    achse_station: LiveStation, plc: Any
) -> None:
    achse_station.fault("delay", by=0.3, count=1)
    assert lost(plc) == TIMEOUT
    achse_station.advance(0.4)
    assert plc.read_by_name("GVL.nUint", pyads.PLCTYPE_UINT) == 16


@virtual
def test_notifications_are_dropped(
    achse_station: LiveStation, plc: Any, until: Callable[..., None]
) -> None:
    counts: list[int] = []

    @plc.notification(pyads.PLCTYPE_UDINT)
    def note(handle: int, name: str, stamp: Any, value: int) -> None:
        counts.append(value)

    cyclic = pyads.NotificationAttrib(4, pyads.ADSTRANS_SERVERCYCLE, cycle_time=10)
    handles = plc.add_device_notification(UDINT, cyclic, note)
    try:
        achse_station.advance(0.03)
        until(lambda: counts[-1:] == [3])
        achse_station.fault("drop", command="notification", count=3)
        achse_station.advance(0.06)
        until(lambda: counts[-1:] == [9])
        # pyads drops a sample that arrives before it has noted the handle: the first may be missing
        assert counts[counts[0] == 0 :] == [1, 2, 3, 7, 8, 9]
    finally:  # pyads crashes if it closes before its notifications are over
        plc.del_device_notification(*handles)


def test_duplicate(achse_station: LiveStation, plc: Any) -> None:
    doubled = achse_station.fault("duplicate")
    values = [plc.read_by_name("GVL.nInt", pyads.PLCTYPE_INT) for _ in range(20)]
    assert values == [-16] * 20
    assert doubled.hits >= 20


def test_reorder(achse_station: LiveStation, plc: Any, witness: Callable[[str], None]) -> None:
    witness("ads-client")
    for offset in (0, 4, 8, 12):
        plc.write(0x4020, offset, offset, pyads.PLCTYPE_UDINT)
    achse_station.fault("reorder", command="read", group=0x4020, by=PATIENT_MS / 1e3)
    report = asking(achse_station, *((0x4020, offset) for offset in (0, 4, 8, 12)))
    assert report["arrived"] == [4, 0, 12, 8]
    assert report["outcomes"] == [0, 4, 8, 12]


def test_ads_client_meets_an_error_and_a_timeout(
    achse_station: LiveStation, witness: Callable[[str], None]
) -> None:
    witness("ads-client")
    achse_station.fault("error", port=851, group=0x4020, offset=0, code=0x70A)
    achse_station.fault("router_error", group=0x4020, offset=8, code=0x7)
    report = asking(achse_station, (0x4020, 0), (0x4020, 8), (0x4020, 12))
    assert report["outcomes"] == [0x70A, 7, 0]
    achse_station.fault("drop", group=0x4020, offset=4)
    [error] = asking(achse_station, (0x4020, 4), limit_ms=IMPATIENT_MS)["outcomes"]
    assert isinstance(error, str)  # ads-client's own time limit, not a code of the station


def test_cut_ends_the_connection_in_the_middle_of_a_frame(
    achse_station: LiveStation, plc: Any
) -> None:
    achse_station.fault("cut", count=1)
    assert lost(plc) != 0
    reopen(plc)
    assert state(plc) == 0


def test_truncate_gives_no_wrong_value(achse_station: LiveStation, plc: Any) -> None:
    cut = achse_station.fault("truncate", size=2, count=1, command="read")
    with pytest.raises(RuntimeError, match="expected 4 bytes, 2 were read"):
        plc.read(0x4040, 0, pyads.PLCTYPE_UDINT)
    assert cut.hits == 1
    assert plc.read(0x4020, 0, pyads.PLCTYPE_UDINT) == 0


@pytest.mark.parametrize("code", [0x706, 0x70A, 0x712, 0x4221])
def test_an_error_on_a_symbol(achse_station: LiveStation, plc: Any, code: int) -> None:
    achse_station.fault("error", symbol=INT, code=code)
    assert code_of(lambda: plc.read_by_name(INT, pyads.PLCTYPE_INT)) == code
    assert code_of(lambda: plc.write_by_name(INT, 1, pyads.PLCTYPE_INT)) == code
    assert plc.read_by_name("GVL.nUint", pyads.PLCTYPE_UINT) == 16
    achse_station.clear_faults()
    assert plc.read_by_name(INT, pyads.PLCTYPE_INT) == -16


def test_an_error_on_a_symbol_in_a_sum(achse_station: LiveStation, plc: Any) -> None:
    names = [INT, "GVL.nUint"]
    assert plc.read_list_by_name(names) == {INT: -16, "GVL.nUint": 16}
    achse_station.fault("error", symbol=INT, code=0x70A)
    values = plc.read_list_by_name(names)
    assert values["GVL.nUint"] == 16
    assert values[INT] != -16


def test_an_error_on_a_service(achse_station: LiveStation, plc: Any) -> None:
    achse_station.fault("error", port=851, group=0x4020, code=0x707)
    assert code_of(lambda: plc.read(0x4020, 0, pyads.PLCTYPE_INT)) == 0x707
    assert code_of(lambda: plc.read(0x4030, 0, pyads.PLCTYPE_INT)) == 0


def test_router_error(achse_station: LiveStation, plc: Any) -> None:
    achse_station.fault("router_error", code=0x6, count=1)
    assert state(plc) == 6
    assert state(plc) == 0


def test_drop_link_and_refuse_links(achse_station: LiveStation, plc: Any) -> None:
    assert state(plc) == 0
    refusing = achse_station.fault("refuse_links")
    achse_station.fault("drop_link")
    assert lost(plc) != 0
    reopen(plc)
    assert lost(plc) != 0
    achse_station.run(achse_station.station.faults.clear, refusing.number)
    reopen(plc)
    assert state(plc) == 0


def test_one_connection_per_host(achse_station: LiveStation, plc: Any) -> None:
    assert state(plc) == 0
    achse_station.fault("one_connection")
    with achse_station.connect(mode="direct") as other:
        other.state()
        assert lost(plc) != 0
    reopen(plc)
    assert state(plc) == 0


@virtual
def test_a_stale_handle_after_an_online_change(achse_station: LiveStation, plc: Any) -> None:
    handle = plc.get_handle(INT)
    plc.write_by_name(INT, 7, pyads.PLCTYPE_INT)
    achse_station.fault("online_change")
    assert code_of(lambda: plc.read_by_name("", pyads.PLCTYPE_INT, handle=handle)) == 0x711
    plc.release_handle(handle)
    assert plc.read_by_name(INT, pyads.PLCTYPE_INT) == 7


@virtual
def test_a_download_brings_initial_values_and_another_symbol_version(
    achse_station: LiveStation, plc: Any
) -> None:
    handle = plc.get_handle(INT)
    plc.write_by_name(INT, 7, pyads.PLCTYPE_INT)
    version = plc.read(0xF008, 0, pyads.PLCTYPE_BYTE)
    achse_station.fault("download")
    assert plc.read(0xF008, 0, pyads.PLCTYPE_BYTE) == version + 1
    assert code_of(lambda: plc.read_by_name("", pyads.PLCTYPE_INT, handle=handle)) == 0x711
    assert plc.read_by_name(INT, pyads.PLCTYPE_INT) == -16


@virtual
def test_a_slow_cycle(achse_station: LiveStation, plc: Any) -> None:
    achse_station.fault("slow_cycle", factor=5)
    achse_station.advance(1.0)
    assert plc.read_by_name(UDINT, pyads.PLCTYPE_UDINT) == 20


@virtual
def test_a_restart_of_the_process(achse_station: LiveStation, plc: Any) -> None:
    achse_station.advance(1.0)
    assert plc.read_by_name(UDINT, pyads.PLCTYPE_UDINT) == 100
    achse_station.restart()
    assert lost(plc) != 0
    reopen(plc)
    assert plc.read_by_name(UDINT, pyads.PLCTYPE_UDINT) == 0


@virtual
def test_config_and_run_again(achse_station: LiveStation, plc: Any) -> None:
    with pyads.Connection(achse_station.net_id, 10_000, achse_station.host) as system:
        assert (state(plc), system.read_state()[0]) == (0, pyads.ADSSTATE_RUN)
        achse_station.fault("config")
        achse_station.advance(1.0)
        assert (state(plc), system.read_state()[0]) == (6, pyads.ADSSTATE_CONFIG)
        achse_station.clear_faults()
        achse_station.advance(1.0)
        assert (state(plc), system.read_state()[0]) == (0, pyads.ADSSTATE_RUN)


@virtual
def test_a_restart_of_the_station_keeps_the_connection(
    achse_station: LiveStation, plc: Any
) -> None:
    achse_station.advance(1.0)
    handle = plc.get_handle(INT)
    achse_station.fault("restart")
    achse_station.advance(0.2)
    assert state(plc) == 6
    achse_station.advance(1.0)
    assert code_of(lambda: plc.read_by_name("", pyads.PLCTYPE_INT, handle=handle)) in (0x710, 0x711)
    assert plc.read_by_name(UDINT, pyads.PLCTYPE_UDINT) < 100


# where faults come from


def test_from_the_command_line(
    achse_station: LiveStation, plc: Any, warm_commands: WarmCommands
) -> None:
    def fault(*arguments: str) -> str:
        where = ("--host", achse_station.host, "--net-id", achse_station.net_id)
        done = warm_commands.run("fault", *arguments, *where)
        assert done.returncode == 0, done.stderr
        return done.stdout

    fault("add", "error", f"symbol={INT}", "code=0x706")
    assert code_of(lambda: plc.read_by_name(INT, pyads.PLCTYPE_INT)) == 0x706
    assert "1 hits" in fault("list")
    fault("clear")
    assert plc.read_by_name(INT, pyads.PLCTYPE_INT) == -16


def test_at_the_times_of_the_configuration(tmp_path: Path) -> None:
    script = tmp_path / "station.toml"
    script.write_text(
        '[[plc]]\nglobals = ["achse.station.demo:GVL"]\n'
        '[[fault]]\nkind = "error"\nsymbol = "GVL.nInt"\ncode = 0x70A\n'
        'at = "1s"\nlasting = "500ms"\n'
        '[[fault]]\nkind = "online_change"\nat = "2s"\n'
    )

    def meet() -> list[int]:
        codes = []
        with (
            LiveStation(script, time="virtual") as station,
            pyads.Connection(station.net_id, 851, station.host) as plc,
        ):
            handle = plc.get_handle(INT)
            for _ in range(24):
                codes.append(code_of(lambda: plc.read(0xF005, handle, pyads.PLCTYPE_INT)))
                station.advance(0.1)
        return codes

    assert meet() == [0] * 10 + [0x70A] * 5 + [0] * 5 + [0x711] * 4
    assert meet() == meet()
