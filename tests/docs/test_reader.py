"""The reader of pages notices when a page is wrong."""

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

Read = Callable[[str, str], None]


def page(text: str) -> str:
    return textwrap.dedent(text).replace("'''", "```")


def test_a_true_page_passes(read_page: Read, tmp_path: Path) -> None:
    read_page(
        "page",
        page("""\
        '''toml title="name.toml"
        a = 1
        '''
        '''console
        $ cat name.toml
        a = 1
        $ printf 'one\\n2 of 3\\nx\\ny\\nend\\n'
        one
        2 of …
        …
        end
        '''
        '''python
        two = 2
        '''
        '''python
        print(two)
        '''
        '''text
        2
        '''
        """),
    )
    assert (tmp_path / "name.toml").read_text() == "a = 1\n"


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("'''console\n$ echo two\none\n'''\n", id="other output"),
        pytest.param("'''console\n$ echo one\n'''\n", id="output not shown"),
        pytest.param("'''console\n$ printf 'a\\nb\\n'\na\n'''\n", id="more output"),
        pytest.param("'''console\n$ false\n'''\n", id="fails"),
        pytest.param("'''console fails\n$ true\n'''\n", id="does not fail"),
        pytest.param("'''python\nprint(1)\n'''\n'''text\n2\n'''\n", id="prints otherwise"),
        pytest.param("'''python\nassert False\n'''\n", id="raises"),
    ],
)
def test_a_false_page_fails(read_page: Read, text: str) -> None:
    with pytest.raises(AssertionError):
        read_page("page", page(text))


def test_a_background_command_runs_until_the_page_ends(read_page: Read) -> None:
    serving = "python3 -m http.server --bind 127.0.0.1 0"
    with pytest.raises(AssertionError, match="exit code"):  # SIGTERM kills it: not a clean end
        read_page("page", page(f"'''console\n$ {serving} &\nServing HTTP on 127.0.0.1 …\n'''\n"))


@pytest.mark.parametrize(("end", "seconds"), [("fg", 0), ("kill %%", 60)])
def test_a_background_command_is_waited_for_or_ended(
    read_page: Read, end: str, seconds: float
) -> None:
    lines = (
        "import atexit, signal, sys, time",
        "atexit.register(print, 2)",
        "signal.signal(15, lambda *_: sys.exit())",
        "print(1, flush=True)",
        f"time.sleep({seconds})",
    )
    command = f"python3 -c '{'; '.join(lines)}'"
    read_page("page", page(f"'''console\n$ {command} &\n1\n$ {end}\n2\n'''\n"))


def test_a_page_has_a_loopback_address_of_its_own(read_page: Read) -> None:
    read_page("page", page("'''python\nassert '127.0.0.1' != '127.0.0' + '.1'\n'''\n"))
    read_page("page", page("'''python\nassert '127.0.0.1.1.1' == '127.0.0' + '.1.1.1'\n'''\n"))
