"""What nests too deep: every parser that a stranger's text reaches gives a value or a typed error.

Each text is drawn: which brackets, in which order, how deep, closed or cut off. Before, 700 aliases
of aliases and 100,000 brackets in a station.toml ended in tracebacks.
"""

import json
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.devices.station import FAULTS
from achse.iec import DINT, DeclarationError, IecError
from achse.iec.literals import parse_value
from achse.iec.names import parse_type
from achse.iec.paths import parse_path
from achse.router.routes import RouteError
from achse.router.static_routes import parse_static_routes
from achse.st.lexis.xml import parse_xml
from achse.st.symbolfiles import read_symbol_file
from achse.st.syntax.parser import parse as parse_st
from achse.st.syntax.parser import parse_expression, parse_statements
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import load, parse
from achse.station.persistence.persistent_data import PersistentData
from achse.station.persistence.state_file import StateFile
from achse.station.slaves.parameter_file import ParameterFile, ParameterFileError

DEPTHS = st.one_of(st.integers(1, 40), st.sampled_from([63, 64, 65, 99, 101, 700, 2000]))
VERY_DEEP = st.one_of(DEPTHS, st.just(100_000))
Pairs = list[tuple[str, str]]


@pytest.fixture(scope="module", autouse=True)
def limit_of_recursion() -> Iterator[None]:
    """The limit of a new process, whatever PLCs of other tests need; these tests leave it alone."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(1000)
    yield
    after = sys.getrecursionlimit()
    sys.setrecursionlimit(before)
    assert after == 1000


@st.composite
def nested(
    draw: st.DrawFn, pairs: Pairs, cores: list[str], depths: st.SearchStrategy[int] = DEPTHS
) -> str:
    """A core within brackets of the kinds given, some thousands deep, perhaps cut off."""
    depth = draw(depths)
    pattern = draw(st.lists(st.sampled_from(pairs), min_size=1, max_size=4))
    opened = "".join(pattern[level % len(pattern)][0] for level in range(depth))
    closed = "".join(pattern[level % len(pattern)][1] for level in reversed(range(depth)))
    text = opened + draw(st.sampled_from(cores)) + closed
    return text[: draw(st.integers(0, len(text)))] if draw(st.booleans()) else text


def outcome(parser: Callable[[Any], object], text: object, *errors: type[Exception]) -> str:
    """What came of a text; any other error than `errors` fails the test."""
    try:
        parser(text)
    except errors as refusal:
        return "refused" if str(refusal) else "refused without a word"
    return "taken"


ST_BRACKETS = [
    *(("(", ")"), ("-(", ")"), ("NOT ", ""), ("f(", ")"), ("a[", "]"), ("a(b := ", ")")),
    *(("1 + ", ""), ("", ".a"), ("", "^"), ("ADR(", ")")),
]
ST_STATEMENTS = [
    *(
        ("IF a THEN ", " END_IF;"),
        ("WHILE a DO ", " END_WHILE;"),
        ("REPEAT ", " UNTIL a END_REPEAT;"),
    ),
    *(("FOR i := 1 TO 2 DO ", " END_FOR;"), ("CASE a OF 1: ", " END_CASE;"), ("(* ", " *)")),
]
ST_TYPES = [
    *(("ARRAY[0..1] OF ", ""), ("POINTER TO ", ""), ("REFERENCE TO ", "")),
    *(
        ("STRUCT a : ", "; END_STRUCT"),
        ("STRING(", ")"),
        ("INT(", "..5)"),
        ("UNION a : ", "; END_UNION"),
    ),
]
JSON_BRACKETS = [("[", "]"), ('{"a":', "}"), ("[1,", "]")]
XML_BRACKETS = [
    ("<a>", "</a>"),
    ("<Route>", "</Route>"),
    ("<RemoteConnections>", "</RemoteConnections>"),
]
COMMENTS = [("(*", "*)"), ("//", "\n"), ("/*", "*/"), ("{attribute '", "'}"), ("{IF ", "{END_IF}")]


@settings(max_examples=13)
@given(nested(ST_BRACKETS, ["1", "a", "", "1.5E3", "'x'"]))
def test_expressions(text: str) -> None:
    outcome(parse_expression, text, DeclarationError)


@settings(max_examples=13)
@given(nested(ST_STATEMENTS, ["a := 1;", ";", "", "a();"]))
def test_statements(text: str) -> None:
    outcome(parse_statements, text, DeclarationError)


@settings(max_examples=13)
@given(nested(ST_TYPES, ["INT", "", "T"]), nested(COMMENTS, ["a", ""]))
def test_declarations_and_comments(of_type: str, comment: str) -> None:
    for text in (
        f"TYPE T : {of_type}; END_TYPE",
        comment,
        f"VAR_GLOBAL a : INT; {comment} END_VAR",
    ):
        outcome(parse_st, text, DeclarationError)


CHAINS = {
    "alias": "TYPE T{i} : T{before}; END_TYPE",
    "array": "TYPE T{i} : ARRAY[0..0] OF T{before}; END_TYPE",
    "structure": "TYPE T{i} : STRUCT a : T{before}; END_STRUCT END_TYPE",
    "union": "TYPE T{i} : UNION a : T{before}; END_UNION END_TYPE",
    "pointer": "TYPE T{i} : POINTER TO T{before}; END_TYPE",
    "range": "TYPE T{i} : T{before} (0..10); END_TYPE",
}


@settings(max_examples=10)
@given(
    kinds=st.lists(st.sampled_from(sorted(CHAINS)), min_size=1, max_size=3),
    count=st.sampled_from([1, 20, 63, 64, 65, 66, 130, 700]),
    random=st.randoms(use_true_random=False),
    order=st.sampled_from(["as written", "backwards", "shuffled"]),
)
def test_types_that_rest_on_each_other(
    kinds: list[str], count: int, random: Any, order: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """A PLC has them, with all that clients ask about them, or the configuration is refused."""
    lines = ["TYPE T0 : INT; END_TYPE"]
    lines += [CHAINS[kinds[i % len(kinds)]].format(i=i, before=i - 1) for i in range(1, count + 1)]
    if order != "as written":
        lines.reverse() if order == "backwards" else random.shuffle(lines)
    folder = tmp_path_factory.mktemp("chain")
    (folder / "a.st").write_text("\n".join([*lines, f"VAR_GLOBAL g : T{count}; END_VAR"]))

    def station(_: object) -> None:
        built = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=folder)
        plc = next(each for each in built.devices if each.address.port == 851)
        built.advance(0.01)
        plc.read(0xF00E, 0, 1 << 22)
        plc.read_write(0xF009, 0, 1 << 16, b"a.g\0")

    came = outcome(station, None, ConfigError)
    assert came == "taken" or count > 20 or "range" in kinds  # there are no ranges of arrays
    assert came in ("taken", "refused")


@settings(max_examples=13)
@given(nested(ST_TYPES, ["INT", "", "T"]))
def test_names_of_types(text: str) -> None:
    outcome(parse_type, text, IecError)


@settings(max_examples=13)
@given(nested([("a.", ""), ("a[", "]"), ("", "[1]"), ("", "^"), ("(", ")")], ["b", "1", ""]))
def test_paths(text: str) -> None:
    outcome(parse_path, text, IecError)


@settings(max_examples=6)
@given(nested([("[", "]"), ("(", ")"), ("(a := ", ")"), ("3(", ")")], ["1", ""]))
def test_values(text: str) -> None:
    array = parse_type("ARRAY[0..1] OF ARRAY[0..1] OF DINT")
    for wanted in (DINT, array):
        outcome(lambda text: parse_value(wanted, text), text, IecError)  # noqa: B023


toml = st.one_of(
    nested([("[", "]"), ("{a=", "}")], ["1", ""], VERY_DEEP).map(lambda text: f"a = {text}"),
    nested([("a.", ""), ("[[", "]]"), ("[", "]")], ["b"]).map(lambda text: f"{text} = 1"),
    DEPTHS.map(lambda depth: f"[axis{'.a' * depth}]\nb = 1"),
    DEPTHS.map(lambda depth: f'[[axis]]\nid = 1\nname = "X"\ncolour{".a" * depth} = 1'),
    VERY_DEEP.map(lambda depth: f"[nc]\ncycle = {'9' * depth}"),
)


@settings(max_examples=13)
@given(text=toml)
def test_station_toml(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.getbasetemp() / "nested.toml"
    file.write_text(text)
    outcome(lambda path: Station(load(path), base=file.parent), file, ConfigError)


state = st.one_of(
    nested(JSON_BRACKETS, ["1", "", "null", "1e999"], VERY_DEEP),
    nested(JSON_BRACKETS, ["1"], VERY_DEEP).map(lambda text: f'{{"nc": {text}}}'),
    nested(JSON_BRACKETS, ["1"], VERY_DEEP).map(lambda text: f'{{"1": {text}}}'),
    nested(JSON_BRACKETS, ["1"], VERY_DEEP).map(
        lambda text: f'{{"nc": {{"1": {{"zeros": {text}, "position": 0, "homed": 1}}}}}}'
    ),
)


@settings(max_examples=13)
@given(text=state)
def test_state_files(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.getbasetemp() / "nested.json"
    file.write_text(text)
    outcome(lambda path: StateFile(path).read_json(), file, ValueError)
    outcome(ParameterFile, file, ParameterFileError)
    config = parse({"system": {"persistent_data": file.name}}, "a.toml")
    PersistentData(config, file.parent)  # one that is damaged is told, and that is all


@settings(max_examples=13)
@given(nested(XML_BRACKETS, ["", "x", "<Name>a</Name>"], VERY_DEEP))
def test_xml(text: str) -> None:
    outcome(parse_static_routes, text, RouteError)
    outcome(lambda data: parse_xml(data, "a.xml"), text.encode(), DeclarationError)
    for tag in ("TcModuleClass", "PlcProjectInfo"):
        data = f"<{tag}>{text}</{tag}>".encode()
        outcome(lambda text: read_symbol_file(text, "a.tmc"), data, DeclarationError)


@settings(max_examples=13)
@given(
    nested(JSON_BRACKETS, ["1", "", "null"], VERY_DEEP),
    st.sampled_from(["kind", "at", "axis", "x", "self"]),
)
def test_faults_that_a_client_wants(text: str, field: str) -> None:
    built = Station(parse({"axis": [{"id": 1, "name": "X"}]}, "a.toml"))
    for data in (text, f'{{"{field}": {text}}}', f'{{"kind": "no_answer", "{field}": {text}}}'):
        answer = built.service.read_write(FAULTS, 0, 1 << 16, data.encode())
        assert json.loads(answer).keys() <= {"error", "number"}
