"""One word, one thing: a public class name is there once; texts are in plain English."""

import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from tests.house.sources import Module, Texts

WORDS = Path("docs/explanation/words.md")
"""The glossary: one word for each thing, and phrases that are not to be used."""

TWICE = {
    "AxisTrace": "the samples of an axis, awaited and blocking (achse.client.nc)",
    "AxisValue": "the same parameter, awaited and blocking",
    "AxisValues": "the same parameters, awaited and blocking",
    "Client": "the same client, awaited and blocking (achse.client, achse.client.blocking)",
    "FunctionBlock": "as a source declares it (st.units) and as it is at run time (iec)",
    "Method": "as a source declares it (st.units) and as clients call it (iec)",
    "Move": "the same command, awaited and blocking",
    "Program": "as a source declares it (st.units) and as it is at run time (iec)",
    "Property": "as a source declares it (st.units) and as clients reach it (iec)",
    "RemoteAxis": "the same axis, awaited and blocking",
    "RemoteNc": "the same NC, awaited and blocking",
    "RemoteTable": "the same table, awaited and blocking",
    "Subscription": "the same subscription, awaited and blocking",
    "Target": "the same device, awaited and blocking",
}
"""Class names that two modules share, because they are the same thing at two levels."""


def test_a_class_name_means_one_thing(parsed: dict[Path, Module]) -> None:
    places = defaultdict(list)
    for path, module in parsed.items():
        for name in module.classes:
            places[name].append(str(path))
    shared = {name: paths for name, paths in places.items() if len(paths) > 1}
    new = {name: paths for name, paths in shared.items() if name not in TWICE}
    assert not new, f"rename the less central one to the field's word: {new}"
    gone = TWICE.keys() - shared.keys()
    assert not gone, f"no longer shared, take them out of the exceptions: {gone}"


PHRASES = {
    "is not a … (are not …)": re.compile(
        r"(?<!there )(?<!there will )\b(?:is|are|was|were|be) no\b(?! (?:longer|more|better)\b)",
        re.IGNORECASE,
    ),
    "again": re.compile(r"\banew\b", re.IGNORECASE),
    "any client that, anyone who": re.compile(r"\bwhoever\b", re.IGNORECASE),
    "later": re.compile(r"\bby and by\b", re.IGNORECASE),
    "none": re.compile(r"\bnone such\b", re.IGNORECASE),
    "say who does what": re.compile(r"\b(?:of whom|what nothing)\b", re.IGNORECASE),
    "postpone": re.compile(r"\b(?:owes?|owed|owing)\b", re.IGNORECASE),
    "is at, is in": re.compile(
        r"\b(?:stands?|stood|lies?|lay) "
        r"(?:at|in(?! for\b)|on|before|behind|beside|there|here|under|after|above|between|with)\b",
        re.IGNORECASE,
    ),
}
"""What to write, and what not to write instead."""

VERBS = {
    "succeed": "inherit", "give": "load", "owe": "postpone", "part": "leave",
    "begin_anew": "begin_again",
}  # fmt: skip
"""Names of public functions that are not the field's verbs, and what to write."""

ROOMS_TO_MEND: dict[str, int] = {}
"""Phrases that are still there, by room. The numbers only shrink."""


QUESTION = re.compile(
    r"(?:(?:What|How|When|Where|Which|Who|Whom|Whose)(?:ever)?|Whether|Why|That|Those|Raises)\b"
)
"""Beginnings of docstrings that answer a question or point back, instead of a name or a command.
Errors come last (`Return … Raises X.`); what is there to raise begins with `Raise X unless …`."""

PARTICIPLES = {
    "asked", "begun", "chosen", "done", "found", "given", "gone", "held", "kept", "known", "left",
    "lent", "lost", "made", "over", "said", "seen", "sent", "shown", "taken", "told", "wanted",
    "written",
}  # fmt: skip
"""Participles that name no thing: `_reported_lag`, `_pending_requests`, `_send_buffer` do."""

RETIRED = {
    "ask": "request, query, poll or call",
    "tell": "report, log, notify or return",
}  # fmt: skip
"""Names that functions, parameters, variables and attributes of `MENDED` must not have, with or
without underscores at their ends, and what to write."""

MENDED = (
    "ams", "camshaft", "codes", "devices", "drive", "ethercat", "fmu", "gcode", "iec", "motion",
    "native",
)  # fmt: skip
"""Rooms in which no name of `RETIRED` is left."""

RETIRED_PROSE = re.compile(
    r"\b(?:nobody|somebody|everybody|any ?one who|told|asks|asked|asking)\b", re.IGNORECASE
)
"""Words that strings of mended rooms must not have: a client or a caller, reports, requests."""

NOT_YET = ("src/achse/devices/scope/",)
"""Folders of mended rooms that still have such names."""

RETIRED_IN = {
    "drive": {"attention": "service_request"},
    "ethercat": {"nobody": "no_slave", "pieces": "split_writes, ranges"},
    "motion": {
        "gate": "junction",
        "holder": "view",
        "led": "has_moving_master; positions of axes that follow: following",
        "piece": "element of a path; span of a curve, cam or way",
        "pieces": "elements of a path; spans of a curve, cam or way",
        "reals": "floats",
        "unusual": "slow_path",
        "wholes": "ints",
    },
}
"""Parts of names that are not the field's words in a room, and what to write."""

PRIVATE = {
    "DeclaredFacts": "SourceDefines", "GivenTypes": "PredefinedTypes",
    "KeptVariable": "RetainedVariable", "StaticLives": "StaticInstances",
    "_Shelf": "_LibraryFolders", "asks_for_declarations": "needs_declarations",
    "begun_again": "created_again", "forget_made": "reset_heap_pointers",
    "given_units": "predefined_units", "given_variable": "predefined_variable",
    "is_given": "is_predefined", "is_held": "is_halted", "kept_plain": "plain_routines",
    "kept_trees": "cached_trees", "kept_variables": "retained_variables",
    "of_given": "of_predefined", "refuel": "reset_budget", "shelf": "search folders",
    "stand_in": "stub", "stand_ins": "stubs", "standin": "stub", "standins": "stubs",
    "stands still": "is halted", "to life": "create", "shelves": "search folders",
    "stand-in": "stub", "stand-ins": "stubs", "leads nowhere": "has no target",
    "is told": "is reported", "are told": "are reported", "nobody": "no client, no task …",
    "somebody": "a client, a task …",
}  # fmt: skip
"""Words that only we used, and the field's words: in the code of the rooms below."""

ROOMS_WITH_FIELD_WORDS = ("libraries", "plc", "site", "st", "tcunit", "testing")
"""Rooms of `src/achse` without private words."""

RESULTS = ("asked", "found", "given", "held", "kept", "made", "told")
"""Participles that are not the name of a result: `match`, `entry`, `faults`, `operand` are."""

_RESULT = f"({'|'.join(RESULTS)})"
BOUND = re.compile(
    rf"^ +(?:\w+, )*{_RESULT}(?:, \w+)* *(?::[^=\n]+)?[-+|&]?=(?!=)"
    rf"|\({_RESULT} :=|\bfor (?:\w+, )*{_RESULT}(?:, \w+)* in\b|\bas {_RESULT}:$"
    rf"|^ *(?:async )?def .*[(,] *{_RESULT}\s*:|^ +{_RESULT} *: *[^=\n]+,$",
    re.MULTILINE,
)
"""Where such a participle is bound, in files whose trees are not walked."""

PROGRAMS = ("tests", "benchmarks", "examples", "packaging")
"""Folders of Python beside the package."""

NAME_OF_A_TEST = re.compile(
    r"def (test_\w*?_(?:told|tells?|asks?|asked|nobody|somebody|everybody|anybody|whoever|anew)"
    r"(?:_\w+)?)\("
)
"""Tests whose names have words that are not the field's: report, request, query, no client, a
client, any client and again are."""

OF_THE_FIELD = {"test_seek_and_tell"}
"""Tests whose names have such a word, because the field has it."""

RETIRED_CLASSES = {
    "Agenda": "TimerQueue", "Beat": "SampleGroup", "Deck": "ChannelGroup", "Gate": "FrameFilter",
    "Judge": "Completion, Outcome, AccessPolicy", "Outbox": "WriteBuffer",
    "Pulse": "SampleTimer", "Road": "NetworkLink", "Turns": "Scheduler",
    "Unanswered": "PendingRequests",
}  # fmt: skip
"""Words of class names that no manual has, and what to write; `CommandJudge` has one too."""

RETIRED_NAMES = {
    "Line": "ByteTransport", "agenda": "timer_queue",
    "beat": "group", "deck": "group", "gate": "frame_filter",
    "judge": "completion, check", "outbox": "write_buffer", "pulse": "timer", "road": "link",
}  # fmt: skip
"""Names of variables, parameters and functions, and what to write; plurals and `_private` too."""

RENAMED_ROOMS = {
    "cli", "client", "dap", "faults", "fleet", "gateway", "monitor", "router", "scope", "server",
    "station", "swarm", "sweeps", "transport", "web",
}  # fmt: skip
"""Rooms of `src/achse` without retired words; the others follow."""


def _room(path: Path) -> str:
    """`docs/how-to`, `src/achse/st`; the root's pages by name."""
    return "/".join(path.parts[:-1][:3]) or str(path)


def _paragraphs(page: str) -> list[str]:
    return re.split(r"\n\s*\n", page)


def test_texts_are_in_plain_english(
    tracked: list[Path], texts: Texts, parsed: dict[Path, Module]
) -> None:
    """The paragraphs of each page; the string literals of each module, docstrings among them."""
    strings = {path: module.strings for path, module in parsed.items()} | {
        path: _paragraphs(texts[path]) for path in tracked if path.suffix == ".md"
    }
    places = defaultdict(list)
    for path in strings.keys() - {WORDS}:
        lines = "\n".join(" ".join(text.split()) for text in strings[path])
        for instead, phrase in PHRASES.items():
            for hit in phrase.finditer(lines):
                around = lines[max(0, hit.start() - 30) : hit.end() + 30].replace("\n", " ")
                places[_room(path)].append(f"{path}: …{around}… (write: {instead})")
    more = [
        line
        for room, lines in places.items()
        if len(lines) > ROOMS_TO_MEND.get(room, 0)
        for line in lines
    ]
    assert not more, "\n".join(more)
    mended = ROOMS_TO_MEND.keys() - places.keys()
    assert not mended, f"nothing left there, take them out of ROOMS_TO_MEND: {mended}"


def test_docstrings_name_or_command(parsed: dict[Path, Module]) -> None:
    """The docstrings of modules, classes, functions and attributes."""
    questions = [
        f"{path}:{line}: {text}"
        for path, module in parsed.items()
        if path.is_relative_to("src/achse")
        for line, text in module.docstrings
        if QUESTION.match(text)
    ]
    assert not questions, "begin with a noun, or with an imperative such as Return:\n" + "\n".join(
        questions
    )


def test_attributes_are_no_participles(tracked: list[Path], texts: Texts) -> None:
    """`self._told = …` says that something was told, and not the thing."""
    assigned = re.compile(
        r"^        self\.(_?(?:" + "|".join(sorted(PARTICIPLES)) + r"))\b *[:=]", re.M
    )
    places = sorted(
        {
            f"{path}: {name}"
            for path in tracked
            if path.is_relative_to("src/achse") and path.suffix == ".py"
            for name in assigned.findall(texts[path])
        }
    )
    assert not places, "name the thing:\n" + "\n".join(places)


def _code_of(rooms: tuple[str, ...], tracked: list[Path]) -> Iterator[Path]:
    for path in tracked:
        if path.suffix == ".py" and any(path.is_relative_to(f"src/achse/{name}") for name in rooms):
            yield path


def test_private_words_do_not_return(tracked: list[Path], texts: Texts) -> None:
    write = {word.casefold(): instead for word, instead in PRIVATE.items()}
    words = "|".join(map(re.escape, PRIVATE))
    private = re.compile(rf"(?<![\w-])(?:{words})(?![\w-])", re.IGNORECASE)
    places = [
        f"{path}: {word[0]} (write: {write[word[0].casefold()]})"
        for path in _code_of(ROOMS_WITH_FIELD_WORDS, tracked)
        for word in private.finditer(texts[path])
    ]
    assert not places, "\n".join(places)


def test_results_are_named_after_the_thing(
    tracked: list[Path], texts: Texts, parsed: dict[Path, Module]
) -> None:
    """`found`, `made`, `kept` and their like name nothing: no variable, function or attribute."""
    places = [
        f"{path}:{line}: {name}"
        for path, module in parsed.items()
        for name, line in module.bound.items()
        if name.strip("_") in RESULTS
    ]
    places += [
        f"{path}: {hit[0].strip()}"
        for path in tracked
        if path.suffix == ".py" and path.parts[0] in PROGRAMS
        for hit in BOUND.finditer(texts[path])
    ]
    assert not places, "name the thing:\n" + "\n".join(places)


def test_names_of_tests_are_in_the_words_of_the_field(tracked: list[Path], texts: Texts) -> None:
    places = [
        f"{path}: {hit[0]}"
        for path in tracked
        if path.suffix == ".py" and path.parts[0] == "tests"
        for hit in NAME_OF_A_TEST.finditer(texts[path])
        if hit[1] not in OF_THE_FIELD
    ]
    assert not places, "\n".join(places)


def test_retired_words_of_classes_do_not_come_back(parsed: dict[Path, Module]) -> None:
    """Classes by their last word, all other names as a whole."""
    places = []
    for path, module in parsed.items():
        if not path.is_relative_to("src/achse") or path.parts[2] not in RENAMED_ROOMS:
            continue
        for name in sorted(module.bound):
            last = re.findall(r"[A-Z][a-z]*|$", name)[-2:][0]
            whole = name.strip("_").removesuffix("s")
            write = RETIRED_CLASSES.get(last) if name.strip("_")[:1].isupper() else None
            if write := write or RETIRED_NAMES.get(whole):
                places.append(f"{path}: {name} (write: {write})")
    assert not places, "\n".join(places)


def test_public_functions_have_the_verbs_of_the_field(parsed: dict[Path, Module]) -> None:
    names = [
        f"{path}:{function.line}: {function.name} (write: {VERBS[function.name]})"
        for path, module in parsed.items()
        for function in module.functions
        if function.name in VERBS
        and (function.name != "part" or function.parameters < 2)  # a part of something is a noun
    ]
    assert not names, "\n".join(names)


def test_retired_words_do_not_come_back(parsed: dict[Path, Module]) -> None:
    places = []
    for path, module in parsed.items():
        room = path.parts[2] if path.parts[:2] == ("src", "achse") else ""
        if room not in MENDED or str(path).startswith(NOT_YET):
            continue
        places += [
            f"{path}: …{hit[0]}… in {text[:60]!r} (write who by its role; reports, requests)"
            for text in module.strings
            for hit in RETIRED_PROSE.finditer(text)
        ]
        parts = RETIRED_IN.get(room, {})
        for name, line in module.bound.items():
            write = RETIRED.get(name.strip("_"))
            for part in re.findall("[A-Z]?[a-z]+|[A-Z]+", name) if parts else ():
                write = write or parts.get(part.lower())
            if write:
                places.append(f"{path}:{line}: {name} (write: {write})")
    assert not places, "\n".join(places)


def test_words_are_listed_once(root: Path) -> None:
    """Each word of the glossary has one row, and its class, where it names one, is there."""
    page = (root / WORDS).read_text(encoding="utf-8")
    words = [row.split("|")[1].strip() for row in page.splitlines() if row.startswith("| ")]
    words = [word for word in words if word not in {"word", "we say", "---"}]
    assert len(words) == len(set(words))
    assert str(WORDS) in (root / "README.md").read_text(encoding="utf-8")
