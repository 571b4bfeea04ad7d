"""Sources in a real browser: mistakes are found as one types, changes go into the running PLC."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

Show = Callable[..., AbstractContextManager[Any]]

MAIN = "PROGRAM MAIN\nVAR\n    nCount : INT;\nEND_VAR\nnCount := 7;\nEND_PROGRAM\n"


def test_code_is_typed_checked_and_applied(
    serve_pages: Callable[..., AbstractContextManager[Any]], show: Show, tmp_path: Path
) -> None:
    (tmp_path / "MAIN.st").write_text(MAIN)
    file = tmp_path / "station.toml"
    file.write_text('[[plc]]\nsources = "MAIN.st"\n')
    with serve_pages(str(file), "--web-edit") as running, show(running.url) as tab:
        page = tab.open("code")
        code = page.locator("textarea")
        code.wait_for()
        page.get_by_role("cell", name="7", exact=True).wait_for()
        code.fill(MAIN.replace("nCount := 7", "\n  nCuont := 8"))
        finding = page.get_by_role("button", name="error MAIN.st:6")
        finding.click()
        assert code.evaluate("field => field.selectionStart") == MAIN.index("nCount := 7") + 3
        code.fill(MAIN.replace("7", "8"))
        finding.wait_for(state="detached")
        page.get_by_role("button", name="Apply").click()
        page.get_by_role("cell", name="8", exact=True).wait_for()
        code.fill("not saved")
        page.once("dialog", lambda dialog: dialog.dismiss())
        page.evaluate("location.hash = '#axes'")
        assert code.input_value() == "not saved"
        assert page.evaluate("location.hash").startswith("#code")
        code.fill(MAIN.replace("7", "8"))
        assert (tmp_path / "MAIN.st").read_text() == MAIN.replace("7", "8")
        long = MAIN.replace("7", "8") + "// one of 2,000 lines, \u20ac\n" * 2_000
        code.fill(long)
        code.press("Control+s")
        page.get_by_text("MAIN.st: saved.").first.wait_for()
        (tmp_path / "MAIN.st").write_text(MAIN)
        code.press("x")
        page.get_by_text("written by others meanwhile").wait_for()
        code.press("Control+s")
        page.get_by_text("read it again").wait_for()
        assert (tmp_path / "MAIN.st").read_text() == MAIN
        page.get_by_role("button", name="Discard").click()
        page.locator("button:disabled", has_text="Discard").wait_for()
        assert code.input_value() == MAIN
        assert not tab.complaints
