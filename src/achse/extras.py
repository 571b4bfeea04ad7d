"""Advice for an extra that is not installed: the command that installs it beside this copy."""

from pathlib import Path
from typing import Any


def needs_extra(subject: str, extra: str) -> str:
    """Return the sentence that says which extra the subject needs, and how to install it."""
    return f"{subject} needs the extra {extra}: {install_command(extra)}"


def install_command(extra: str) -> str:
    """Return the command of pip that adds the extra to this copy of achse.

    A copy from a folder, a repository or an address is installed from there again (PEP 610), one
    that runs in its source tree from that tree.
    """
    from urllib.parse import urlsplit  # rarely needed: not at each start
    from urllib.request import url2pathname

    origin = _origin()
    if "dir_info" in origin:
        folder = url2pathname(urlsplit(origin["url"]).path)
        editable = "-e " if origin["dir_info"].get("editable") else ""
        return f'pip install {editable}"{folder}[{extra}]"'
    return f'pip install "{_requirement(origin, extra)}"'


def requirement_elsewhere(extra: str) -> tuple[str, bool]:
    """Return the requirement that installs this copy with the extra on another computer.

    False with it if no other computer reaches what this copy was installed from: a folder.
    """
    origin = _origin()
    is_folder = "dir_info" in origin
    return _requirement({} if is_folder else origin, extra), not is_folder


def _requirement(origin: dict[str, Any], extra: str) -> str:
    url = str(origin.get("url", ""))
    if "vcs_info" in origin:
        revision = origin["vcs_info"].get("requested_revision")
        url = f"{origin['vcs_info']['vcs']}+{url}" + (f"@{revision}" if revision else "")
    return f"achse[{extra}] @ {url}" if url else f"achse[{extra}]"


def _origin() -> dict[str, Any]:
    """Return what pip noted about where this copy came from; nothing for one from an index."""
    import json
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        noted = distribution("achse").read_text("direct_url.json")
    except PackageNotFoundError:
        root = Path(__file__).parents[2]
        is_tree = (root / "pyproject.toml").is_file()
        return {"url": root.as_uri(), "dir_info": {"editable": True}} if is_tree else {}
    origin: dict[str, Any] = json.loads(noted) if noted else {}
    return origin
