"""A real browser on the pages of a station: Debian's Chromium, driven by playwright."""

import contextlib
import os
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

from tests.conftest import browser_binary
from tests.interop.browser.guard import BrowserGuard

FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
"""A container's Chromium as root, which asks nobody but the station."""

NO_LIMIT_MS = 0
"""For every wait: what else the machine has to do decides nothing. `GUARD` ends those in vain."""

GUARD = BrowserGuard()

DESK = {"width": 1280, "height": 720}
"""Size of a window where a test does not care."""

FEW_PICTURES = """
const soon = (draw) => setTimeout(() => draw(performance.now()), 50);
globalThis.requestAnimationFrame = soon;
globalThis.cancelAnimationFrame = clearTimeout;
"""
"""Pages draw 20 pictures a second for 60; a Chromium without a GPU has all of them to paint."""

ADDRESS = re.compile(r"^achse web .*?\burl=(\S+)", re.MULTILINE)


EXAMPLES = Path(__file__).parents[3] / "examples"
AXE = Path(__file__).parents[1] / "npm" / "node_modules" / "axe-core" / "axe.min.js"

SERIOUS = """async (rules) => {
  const { violations } = await axe.run(document, { resultTypes: ["violations"], ...rules });
  return violations.filter(({ impact }) => ["serious", "critical"].includes(impact))
    .map(({ id, nodes }) => [id, nodes.map(({ html }) => html)]);
}"""
"""Rules that a page breaks, each with the elements."""


class Shown:
    """A page of a station as a user has it: opened by its name, judged by what it says."""

    def __init__(self, page: "Page", url: str, artefacts: Path | None) -> None:
        self.page = page
        self.url = url
        self.complaints: list[str] = []
        self.artefacts = artefacts
        self._listeners: dict[Any, Any] = {
            "pageerror": lambda error: self.complaints.append(str(error)),
            "console": self._heard,
        }
        for event, listener in self._listeners.items():
            page.on(event, listener)

    def _heard(self, message: Any) -> None:
        if message.type in ("error", "warning"):
            self.complaints.append(f"{message.type}: {message.text}")

    def open(self, name: str) -> "Page":
        """Go to `overview`, or `axes?axis=1`; the page is there when this returns."""
        self.page.goto(f"{self.url}#{name}")
        self.page.wait_for_function(
            "name => document.body.dataset.connection === 'open'"
            " && document.querySelector('#nav [aria-current]')?.dataset.page === name"
            " && document.querySelector('#page')?.dataset.shows === name"
            " && document.querySelector('#page').childElementCount > 0"
            " && document.title.startsWith(document.querySelector('#title').textContent)",
            arg=name.partition("?")[0],
        )
        return self.page

    def leave(self) -> None:
        """Forget all that pages keep, and show one that asks nobody."""
        self.page.goto(f"{self.url}icon.svg")
        self.page.evaluate("localStorage.clear(), sessionStorage.clear()")

    def deaf(self) -> None:
        """Hear no more of the page."""
        for event, listener in self._listeners.items():
            self.page.remove_listener(event, listener)

    def serious_findings(self, **rules: Any) -> list[list[Any]]:
        """Return what axe-core finds serious on the page: rules with their elements.

        `rules` are options of axe-core; the test needs its witness.
        """
        if not self.page.evaluate("'axe' in globalThis"):
            self.page.evaluate(AXE.read_text(encoding="utf-8"))
        findings: list[list[Any]] = self.page.evaluate(SERIOUS, rules)
        return findings

    def picture(self, name: str) -> None:
        """Keep a screenshot as an artefact of the run, if the run keeps them."""
        if self.artefacts is not None:
            self.page.screenshot(path=self.artefacts / f"{name}.png")


OPEN = contextlib.ExitStack()
"""Holds the Chromium while tests of this folder run: its driver keeps the event loop."""

CHROMIUM: "list[Browser]" = []
"""The one that runs, if one does."""

TABS: "list[Page]" = []
"""The one that tests use one after the other: a new one costs three times as much."""


@pytest.fixture(scope="session")
def browser(witness: Callable[[str], None]) -> "Callable[[], Browser]":
    """Return the Chromium for the tests of this folder: another one if it was killed."""
    witness("playwright")
    witness("chromium")
    from playwright.sync_api import Error, sync_playwright

    def running() -> "Browser":
        try:
            for one in CHROMIUM:
                one.new_browser_cdp_session().detach()
        except Error:  # it was killed
            close_browser()
        if not CHROMIUM:
            driver = OPEN.enter_context(sync_playwright())
            started = driver.chromium.launch(executable_path=browser_binary(), args=FLAGS)
            OPEN.callback(started.close)
            CHROMIUM.append(started)
        return CHROMIUM[0]

    return running


def close_browser() -> None:
    """Close the Chromium, if one runs."""
    TABS.clear()
    CHROMIUM.clear()
    OPEN.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Iterator[None]:
    """Fail a test that waits in vain, with what it waited for."""
    with GUARD.limit():
        return (yield)


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(nextitem: pytest.Item | None) -> None:
    """Close the Chromium after the last test of this folder."""
    if nextitem is None or nextitem.path.parent != Path(__file__).parent:
        close_browser()


@pytest.fixture(scope="session")
def artefacts() -> Path | None:
    """Folder of screenshots, ACHSE_ARTEFACTS; None if they are not kept."""
    chosen = os.environ.get("ACHSE_ARTEFACTS")
    if not chosen:
        return None
    folder = Path(chosen)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def new_tab(browser: "Browser") -> "Page":
    """A tab that has kept nothing and waits without limit."""
    context = browser.new_context()
    context.set_default_timeout(NO_LIMIT_MS)
    context.add_init_script(FEW_PICTURES)
    return context.new_page()


@contextmanager
def init_script(page: "Page", script: str) -> Iterator[None]:
    """Each page that is opened here runs the script first."""
    if not script:
        yield
        return
    line = page.context.new_cdp_session(page)
    line.send("Page.enable")
    number = line.send("Page.addScriptToEvaluateOnNewDocument", {"source": script})
    yield
    line.send("Page.removeScriptToEvaluateOnNewDocument", number)
    line.detach()


@pytest.fixture(scope="module")
def show(
    browser: "Callable[[], Browser]", artefacts: Path | None
) -> Callable[..., AbstractContextManager[Shown]]:
    """`with show(url, viewport=PHONE) as shown:` is a tab that knows nothing of other tests.

    `script` runs before those of each page. With `fresh` not even files are in the tab's cache,
    and what a test routes ends with it. At the end nothing may stand on the console.
    """

    @contextmanager
    def tab(
        url: str,
        *,
        viewport: Any = DESK,
        color_scheme: Any = "light",
        script: str = "",
        fresh: bool = False,
    ) -> Iterator[Shown]:
        chromium = browser()
        page = TABS.pop() if TABS and not fresh else new_tab(chromium)
        try:
            page.emulate_media(color_scheme=color_scheme, reduced_motion="reduce")
            page.set_viewport_size(viewport)
            page.mouse.move(0, 0)
            shown = Shown(page, url, artefacts)
            with init_script(page, script):
                yield shown
            assert shown.complaints == []
            if fresh:
                page.context.close()
            else:
                shown.leave()
                shown.deaf()
                TABS.append(page)
        except BaseException:
            page.context.close()
            raise

    return tab


@pytest.fixture(scope="session")
def serve_pages(
    start_station: Callable[..., AbstractContextManager[Any]],
) -> Callable[..., AbstractContextManager["Served"]]:
    """`with serve_pages("station.toml") as station:` runs a station with pages at `.url`."""

    @contextmanager
    def start(*arguments: str) -> Iterator[Served]:
        with start_station(*arguments, "--web-port", "0") as running:
            line = running.process.stdout.readline()
            address = ADDRESS.search(line)
            assert address, line
            with GUARD.counting(running.process.pid):
                yield Served(running, address[1])

    return start


@pytest.fixture(scope="module")
def web_station(
    serve_pages: Callable[..., AbstractContextManager["Served"]],
) -> Iterator["Served"]:
    """The demo station with its pages."""
    with serve_pages() as running:
        yield running


@pytest.fixture(scope="module")
def portal(
    serve_pages: Callable[..., AbstractContextManager["Served"]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator["Served"]:
    """The station of examples/scene with its clamp open: what a test does alone changes the
    picture."""
    folder = tmp_path_factory.mktemp("portal") / "scene"
    shutil.copytree(EXAMPLES / "scene", folder)
    program = folder / "MAIN.st"
    text = program.read_text(encoding="utf-8")
    assert "NOT bClamped" in text
    program.write_text(text.replace("NOT bClamped", "bClamped"), encoding="utf-8")
    with serve_pages(str(folder / "station.toml")) as running:
        yield running


class Served:
    """A running station and the address of its pages."""

    def __init__(self, station: Any, url: str) -> None:
        self.host, self.port, self.net_id = station.host, station.port, station.net_id
        self.process = station.process
        self.url = url
