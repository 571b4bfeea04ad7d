"""Recorders: states, triggers at their cycle, pre-trigger, groups of several sample times."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.native.backend import compiler_installed
from achse.native.memory import MemoryCell
from achse.scope.channel import ScopeChannel
from achse.scope.channel_group import ScopeSource
from achse.scope.definition import definition_of
from achse.scope.recorder import Recorder, ScopeState
from achse.scope.trigger import TRIGGER_KINDS
from achse.scope.types import SCOPE_TYPES, ScopeError

MS = 1_000_000

Bind = Callable[[ScopeChannel], ScopeSource]


def recorder_of(bind: Bind, compiled: bool, **document: Any) -> Recorder:
    return Recorder(definition_of(document), bind, compiled=compiled)


def run(recorder: Recorder, memory: bytearray, begin: int, end: int) -> None:
    """Cycles of a ms; the first 4 bytes of the memory are their number."""
    for cycle in range(begin, end):
        memory[:4] = cycle.to_bytes(4, "little")
        if recorder.due_ns <= cycle * MS:
            recorder.sample(cycle * MS)


def test_a_trigger_at_a_known_cycle_is_found_there(
    compiled: bool, memory: bytearray, bind: Bind
) -> None:
    recorder = recorder_of(
        *(bind, compiled),
        channels=["UINT32.0"],
        triggers=["UINT32.0 rising 777"],
        record_length=0.1,
        pretrigger=0.4,
    )
    assert recorder.state is ScopeState.OFFLINE
    recorder.start(0)
    run(recorder, memory, 1, 777)
    assert recorder.state is ScopeState.RECORDING
    run(recorder, memory, 777, 778)
    assert (recorder.state, recorder.trigger_ns) == (ScopeState.TRIGGERED, 777 * MS)
    run(recorder, memory, 778, 2000)
    assert recorder.state is ScopeState.DONE
    assert recorder.online
    assert recorder.due_ns == math.inf
    data = recorder.data()
    assert data["UINT32.0"].values == list(range(737, 837))
    assert data.trigger_time == 0.04


def test_length_and_sample_time_say_how_many_samples(
    compiled: bool, memory: bytearray, bind: Bind
) -> None:
    """0.5 s at 2 ms are 250 samples; the last is 0.498 s after the first (scope facts B.4)."""
    recorder = recorder_of(bind, compiled, channels=["UINT32.0@2ms"], record_length=0.5)
    recorder.start(0)
    run(recorder, memory, 1, 1000)
    data = recorder.data(epoch_ns=10**18)
    assert len(data["UINT32.0"]) == 250
    assert data.end_ns - data.begin_ns == 498 * MS
    assert data.end_ns == 10**18 + 998 * MS
    assert recorder.ring_bytes == 2000


def test_a_manual_trigger_needs_a_scope_that_waits(
    compiled: bool, memory: bytearray, bind: Bind
) -> None:
    recorder = recorder_of(bind, compiled, channels=["UINT32.0"], record_length=0.01)
    with pytest.raises(ScopeError, match="it is OFFLINE"):
        recorder.trigger(0)
    recorder.start(0)
    run(recorder, memory, 1, 50)
    recorder.trigger(49 * MS)
    with pytest.raises(ScopeError, match="it is TRIGGERED"):
        recorder.trigger(49 * MS)
    run(recorder, memory, 50, 100)
    with pytest.raises(ScopeError, match="it is DONE"):
        recorder.trigger(99 * MS)
    assert recorder.data()["UINT32.0"].values == list(range(49, 59))
    recorder.start(99 * MS)
    run(recorder, memory, 100, 103)
    assert recorder.data()["UINT32.0"].values == [100, 101, 102]
    recorder.stop()
    assert recorder.due_ns == math.inf
    assert recorder.data()["UINT32.0"].values == [100, 101, 102]


def test_groups_of_several_sample_times_end_with_the_same_moment(
    compiled: bool, memory: bytearray, bind: Bind
) -> None:
    recorder = recorder_of(
        *(bind, compiled),
        channels=["UINT32.0", {"name": "slow", "symbol": "UINT16.0", "sample_time": 0.007}],
        triggers=["slow above 100"],
        record_length=0.07,
        pretrigger=0.5,
    )
    recorder.start(0)
    run(recorder, memory, 1, 500)
    assert recorder.trigger_ns == 105 * MS
    assert recorder.data()["UINT32.0"].values == list(range(70, 140))
    assert recorder.data()["slow"].values == list(range(70, 140, 7))


def test_all_triggers_at_once_or_any(compiled: bool, memory: bytearray, bind: Bind) -> None:
    document = {
        "channels": ["UINT32.0", "UINT8.0"],
        "triggers": ["UINT32.0 above 300", "UINT8.0 inside 10 20"],
        "record_length": 0.01,
    }
    for combine, cycle in (("any", 10), ("all", 256 * 2 + 10)):
        recorder = recorder_of(bind, compiled, combine=combine, **document)
        recorder.start(0)
        run(recorder, memory, 1, 600)
        assert recorder.trigger_ns == cycle * MS
    document["channels"] = ["UINT32.0", "UINT8.0@2ms"]
    with pytest.raises(ScopeError, match="combine: all triggers need channels of the same"):
        recorder_of(bind, compiled, combine="all", **document)


def test_what_cannot_be_bound_is_refused(compiled: bool, bind: Bind) -> None:
    with pytest.raises(ScopeError, match="no symbol STRING"):
        recorder_of(bind, compiled, channels=["STRING.0"])
    with pytest.raises(ScopeError, match=r"in whole ticks of 1 ms, got 1\.5"):
        Recorder(
            definition_of({"channels": ["UINT8.0@1500us"]}), bind, compiled=compiled, tick_ns=MS
        )


def test_the_length_changes_only_offline(compiled: bool, bind: Bind) -> None:
    recorder = recorder_of(bind, compiled, channels=["UINT8.0"])
    recorder.start(0)
    with pytest.raises(ScopeError, match="only while the scope is offline"):
        recorder.resize(recorder.definition.with_length(1))
    recorder.stop()
    recorder.resize(recorder.definition.with_length(1))
    assert recorder.facts()["record_length"] == 1


def test_a_symbol_that_goes_ends_its_channel(compiled: bool, memory: bytearray) -> None:
    there = {"a": (0, "UINT16"), "b": (2, "UINT16"), "c": (4, "UINT16")}

    def bind(channel: ScopeChannel) -> ScopeSource:
        if channel.symbol not in there:
            raise ScopeError(f"{channel.symbol} is not there")
        offset, type = there[channel.symbol]
        size = SCOPE_TYPES[type].size
        return ScopeSource(MemoryCell(memory, offset, size), SCOPE_TYPES[type], MS)

    recorder = recorder_of(bind, compiled, channels=["a", "b", "c"], record_length=0.1)
    recorder.find_again()
    recorder.start(0)
    memory[:6] = bytes((1, 0, 2, 0, 3, 0))
    recorder.sample(MS)
    del there["a"]
    there["b"] = (10, "UINT16")
    there["c"] = (4, "INT32")
    memory[10] = 9
    recorder.find_again()
    recorder.find_again()
    recorder.sample(2 * MS)
    data = recorder.data()
    assert {name: data[name].values for name in data} == {"a": [1], "b": [2, 9], "c": [3]}
    lost = {
        each["name"]: each["lost"] for each in recorder.facts()["channel_groups"][0]["channels"]
    }
    assert lost == {"a": "a is not there", "b": "", "c": "is a INT32 now, was UINT16"}


def test_the_load_is_what_the_values_cost(compiled: bool, memory: bytearray, bind: Bind) -> None:
    recorder = recorder_of(bind, compiled, channels=["UINT8.0", "UINT8.1@2ms"])
    assert recorder.load(0.0, 2.0, 1000.0) == pytest.approx(3e-6)
    assert recorder.load(10.0, 0.0, 0.0) == pytest.approx(1.5e-5)
    recorder = Recorder(
        definition_of({"channels": ["a@1ms"]}),
        lambda channel: ScopeSource(lambda: b"\0", SCOPE_TYPES["UINT8"], MS),
        compiled=compiled,
    )
    assert recorder.load(0.0, 2.0, 1000.0) == pytest.approx(1e-3)


def test_minutes_of_64_channels_lose_no_sample_and_take_no_more_memory(
    memory: bytearray, many: Callable[[int], int]
) -> None:
    """1 ms, read each minute as a client does; the ring holds 61 s and is used again."""
    if not compiler_installed():
        pytest.skip("no compiler")
    place = memoryview(memory).cast("q")
    type = SCOPE_TYPES["INT64"]
    recorder = recorder_of(
        lambda channel: ScopeSource(MemoryCell(memory, 8 * (int(channel.symbol) % 2), 8), type, MS),
        True,
        channels=[{"name": f"c{n}", "symbol": str(n)} for n in range(64)],
        record_length=61,
    )
    minutes = many(3)
    recorder.start(0)
    [group] = recorder.groups
    bytes_of_ring = recorder.ring_bytes
    sample, seen = recorder.sample, 0
    for minute in range(minutes):
        for cycle in range(60_000 * minute + 1, 60_000 * (minute + 1) + 1):
            place[0] = cycle
            sample(cycle * MS)
        first, rows = group.rows(seen, 60_000)
        words = memoryview(rows).cast("q")
        counts = words[0::64].tolist()
        assert counts == list(range(seen + 1, seen + 60_001))
        assert words[62::64].tolist() == counts
        assert first == seen
        seen += 60_000
    assert (group.count, recorder.ring_bytes) == (60_000 * minutes, bytes_of_ring)
    assert bytes_of_ring == 64 * 8 * 61_000
    place.release()


PARAMETERS = st.fixed_dictionaries(
    {
        "types": st.lists(st.sampled_from(sorted(SCOPE_TYPES)), min_size=1, max_size=4),
        "steps": st.lists(st.integers(1, 5), min_size=4, max_size=4),
        "length": st.integers(1, 60),
        "pretrigger": st.floats(0, 0.99),
        "kind": st.none() | st.sampled_from(sorted(TRIGGER_KINDS)),
        "bounds": st.tuples(st.integers(-200, 200), st.integers(-200, 200)).map(sorted),
        "watched": st.integers(0, 3),
        "begin": st.integers(0, 20),
        "manual": st.none() | st.integers(1, 60),
        "stop": st.none() | st.integers(1, 150),
        "compiled": st.booleans(),
    }
)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(PARAMETERS, st.lists(st.integers(-128, 127), min_size=150, max_size=150))
def test_any_recording_is_what_a_list_of_all_values_says(
    drawn: dict[str, Any], signal: list[int]
) -> None:
    """The oracle keeps every value and looks back; the recorder has a ring."""
    if drawn["compiled"] and not compiler_installed():
        return
    memory = bytearray(64)
    types = [SCOPE_TYPES[name] for name in drawn["types"]]
    names = [f"c{n}" for n in range(len(types))]

    def bind(channel: ScopeChannel) -> ScopeSource:
        n = names.index(channel.name)
        return ScopeSource(MemoryCell(memory, 9 * n, types[n].size), types[n], MS)

    def value(n: int, cycle: int) -> float:
        type, raw = types[n], signal[cycle] + n
        if type.real:
            return raw / 2
        low, high = type.range
        return min(max(raw, low), high)

    watched = drawn["watched"] % len(types)
    kind = drawn["kind"]
    bounds = drawn["bounds"][: TRIGGER_KINDS[kind].bounds] if kind else []
    step = dict(zip(names, drawn["steps"], strict=False))
    recorder = recorder_of(
        bind,
        drawn["compiled"],
        channels=[{"name": n, "symbol": n, "sample_time": step[n] / 1000} for n in names],
        triggers=[" ".join(map(str, (names[watched], kind, *bounds)))] if kind else [],
        record_length=drawn["length"] / 1000,
        pretrigger=drawn["pretrigger"],
    )
    recorder.start(drawn["begin"] * MS)
    seen: dict[str, list[tuple[int, float]]] = {name: [] for name in names}
    fired = None
    ends: dict[str, int] = {}
    length_ns, before = drawn["length"] * MS, None
    for cycle in range(drawn["begin"] + 1, 150):
        if cycle == drawn["stop"]:
            recorder.stop()
            break
        for n in range(len(types)):
            word = types[n].word(bool(value(n, cycle)) if types[n].code == "?" else value(n, cycle))
            memory[9 * n : 9 * n + types[n].size] = (word & (1 << 64) - 1).to_bytes(8, "little")[
                : types[n].size
            ]
        if recorder.due_ns <= cycle * MS:
            recorder.sample(cycle * MS)
        wide = 0
        for n, name in enumerate(names):
            if cycle % step[name] == 0 and cycle * MS < ends.get(name, math.inf):
                seen[name].append((cycle, value(n, cycle)))
                if kind and n == watched and fired is None:
                    now = _holds(kind, bounds, value(n, cycle))
                    if _fires(kind, before, now):
                        wide = step[name]
                    before = now
        if wide and fired is None:
            fired = cycle
        elif cycle == drawn["manual"] and fired is None:
            recorder.trigger(cycle * MS)
            fired, wide = cycle, 0
        if fired == cycle:
            rest = max(length_ns - round(length_ns * drawn["pretrigger"]), wide * MS, 1)
            for name in names:
                first = -(-max(cycle, drawn["begin"] + 1) // step[name]) * step[name]
                ends[name] = first * MS + -(-rest // (step[name] * MS)) * step[name] * MS
    assert recorder.trigger_ns == (None if fired is None else fired * MS)
    data = recorder.data()
    for name in names:
        ring = -(-length_ns // (step[name] * MS))
        last = seen[name][-ring:]
        assert [each for _, each in last] == data[name].values
        if last:
            assert data[name].block.begin_ns == last[0][0] * MS


def _holds(kind: str, bounds: list[int], value: float) -> bool:
    low, high = bounds[0], bounds[-1]
    return {
        "rising": value >= low,
        "edge": value >= low,
        "falling": value <= low,
        "above": value > low,
        "below": value < low,
        "enters": low <= value <= high,
        "inside": low <= value <= high,
        "leaves": not low <= value <= high,
        "outside": not low <= value <= high,
    }[kind]


def _fires(kind: str, before: bool | None, now: bool) -> bool:
    if kind in ("above", "below", "inside", "outside"):
        return now
    if before is None:
        return False
    return now != before if kind == "edge" else now and not before
