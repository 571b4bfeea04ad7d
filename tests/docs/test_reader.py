"""The reader of pages notices when a page is wrong."""

import textwrap
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

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
    assert (tmp_path / "page" / "name.toml").read_text() == "a = 1\n"


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("'''console\n$ echo two\none\n'''\n", id="other output"),
        pytest.param("'''console\n$ echo one\n'''\n", id="output not shown"),
        pytest.param("'''console\n$ printf 'a\\nb\\n'\na\n'''\n", id="more output"),
        pytest.param("'''console\n$ false\n'''\n", id="fails"),
        pytest.param("'''console fails\n$ true\n'''\n", id="does not fail"),
        pytest.param("'''console\n$ cat > eaten\n$ echo one\none\n'''\n", id="eats its input"),
        pytest.param("'''console\n$ sleep 600 &\n'''\n", id="leaves a job"),
        pytest.param("'''console\n$ node --version\nv…\n'''\n", id="not said to be needed"),
        pytest.param("'''python\nimport numpy\n'''\n", id="module not said to be needed"),
        pytest.param("'''python\nprint(1)\n'''\n'''text\n2\n'''\n", id="prints otherwise"),
        pytest.param("'''python\nassert False\n'''\n", id="raises"),
    ],
)
def test_a_false_page_fails(read_page: Read, text: str) -> None:
    with pytest.raises(AssertionError):
        read_page("page", page(text))


def test_a_page_that_leaves_a_station_fails(read_page: Read) -> None:
    with pytest.raises(AssertionError, match="leaves running"):
        read_page("page", page("'''console\n$ achse run --detach\nachse ready …\n'''\n"))


def test_commands_are_pasted_into_one_shell(read_page: Read) -> None:
    """Folder and variables last, also beyond other blocks; jobs are not waited for."""
    read_page(
        "page",
        page("""\
        '''console
        $ mkdir cell; cd cell; part=7
        $ { until test -e go; do sleep 0.01; done; echo late > seen.txt; } &
        $ touch go
        '''
        '''text title="cell/name.txt"
        feeder
        '''
        '''console
        $ wait; cat seen.txt name.txt; echo $part
        late
        feeder
        7
        '''
        """),
    )


def test_a_page_has_what_it_names(read_page: Read) -> None:
    needs = "You need: achse with the extra `tables` ([install](install.md)),\nand Node.js.\n"
    read_page(
        "page",
        needs + page("'''python\nimport numpy\n'''\n'''console\n$ node --version\nv…\n'''\n"),
    )


def test_each_extra_is_one_that_a_page_may_name(optional_modules: set[str]) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = {f"[{extra}]" for extra in project["project"]["optional-dependencies"]}
    assert extras - {"[fast]", "[all]"} <= optional_modules


def test_a_page_has_a_loopback_address_of_its_own(read_page: Read) -> None:
    read_page("page", page("'''python\nassert '127.0.0.1' != '127.0.0' + '.1'\n'''\n"))
    read_page("page", page("'''python\nassert '127.0.0.1.1.1' == '127.0.0' + '.1.1.1'\n'''\n"))
