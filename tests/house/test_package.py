"""What is published: its addresses, its page, and licences of what it needs."""

import importlib.util
import json
import re
import runpy
import tomllib
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from achse.ams.secure import SECURE_PORT

FREE = re.compile(
    r"\b(?:MIT|BSD|Apache|ISC|PSF|Python Software Foundation|MPL|Mozilla Public|Unlicense|Zlib|EPL"
    r"|0BSD|HPND|Redistribution and use in source and binary forms)",
    re.IGNORECASE,
)
"""Licences under which a dependency may be installed beside achse by anyone."""


@pytest.fixture(scope="module")
def hook() -> ModuleType:
    path = Path(__file__).parents[2] / "hatch_build.py"
    spec = importlib.util.spec_from_file_location("hatch_build", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("written", "published"),
    [
        ("[a](docs/a.md)", "[a](https://h/o/p/blob/v1/docs/a.md)"),
        (
            "[a](docs/a.md#b) and ![c](d.svg)",
            "[a](https://h/o/p/blob/v1/docs/a.md#b) and ![c](https://h/o/p/blob/v1/d.svg)",
        ),
        ("[a](https://x/y) [b](#c) [d](mailto:e)", "[a](https://x/y) [b](#c) [d](mailto:e)"),
    ],
)
def test_links_of_the_published_page_are_absolute(
    hook: ModuleType, written: str, published: str
) -> None:
    assert hook.absolute_links(written, "https://h/o/p/blob/v1/") == published


@pytest.mark.parametrize("address", ["http://h/o", "h/o", "https://", "https://h/o?q=1"])
def test_an_address_that_is_none_is_refused(hook: ModuleType, address: str) -> None:
    with pytest.raises(ValueError, match="expected an address like https://"):
        hook.repository_address(address)


@pytest.mark.parametrize("environment", ["", "https://host.example/o/achse/"])
def test_one_variable_gives_all_addresses(
    hook: ModuleType, root: Path, environment: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ACHSE_REPOSITORY", environment)
    metadata: dict[str, Any] = {}
    hook.AchseMetadata(str(root), {}).update(metadata)
    addresses = metadata["urls"].values()
    assert all(each.startswith("https://host.example/o/achse") for each in addresses)
    assert bool(addresses) == bool(environment)
    relative = re.findall(r"\]\((?!https?:|#)[^)]*\)", metadata["readme"]["text"])
    assert bool(relative) != bool(environment)


def test_tools_of_developers_are_not_published(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"]["optional-dependencies"]
    assert "dev" not in extras
    named = Requirement(extras["all"][0]).extras
    assert named == extras.keys() - {"all"}


def test_licences_of_all_that_is_installed_are_free() -> None:
    missing = {
        name: licence
        for name, each in sorted(_needed().items())
        if not FREE.search(licence := _licence(each))
    }
    assert not missing


def _needed() -> dict[str, Distribution]:
    """What `achse[all]` brings, as far as it is here."""
    distributions: dict[str, Distribution] = {}
    open_ones = [Requirement("achse[all]")]
    seen: set[tuple[str, frozenset[str]]] = set()
    while open_ones:
        requirement = open_ones.pop()
        name = canonicalize_name(requirement.name)
        key = (name, frozenset(requirement.extras))
        if key in seen:
            continue
        seen.add(key)
        try:
            distributions[name] = distribution(name)
        except PackageNotFoundError:
            continue
        for text in distributions[name].requires or ():
            needed = Requirement(text)
            wanted = ({"extra": extra} for extra in (*requirement.extras, ""))
            if needed.marker is None or any(needed.marker.evaluate(each) for each in wanted):
                open_ones.append(needed)
    return distributions


def _licence(installed: Distribution) -> str:
    metadata = installed.metadata
    names = ("License-Expression", "License", "Classifier")
    texts = [text for name in names for text in metadata.get_all(name) or ()]
    texts = [text[:300] for text in texts if "License" in text or "::" not in text]
    if not texts:  # the metadata say nothing: the file itself does
        files = (file for file in installed.files or () if file.name.upper().startswith("LICENSE"))
        texts = [file.read_text(encoding="utf-8") for file in files]
    return " ".join(texts)


def test_the_lock_file_has_a_version_for_each_requirement(root: Path) -> None:
    wanted = runpy.run_path(str(root / "packaging/lock"))["requirements"]()
    lines = (root / "packaging/dev.lock").read_text().splitlines()
    versions: dict[str, list[str]] = {}
    for line in lines:
        if not line.startswith("#"):
            name, version = line.split(";")[0].strip().split("==")
            versions.setdefault(canonicalize_name(name), []).append(version)
    for text in wanted:
        needed = Requirement(text)
        entries = versions.get(canonicalize_name(needed.name), [])
        assert any(needed.specifier.contains(one) for one in entries), (text, entries)


TOP = """
    .gitignore .pre-commit-config.yaml .pre-commit-hooks.yaml CHANGELOG.md CITATION.cff
    CODE_OF_CONDUCT.md CONTRIBUTING.md Containerfile GOVERNANCE.md LICENSE NOTICE README.md
    SECURITY.md SUPPORT.md action.yml hatch_build.py mkdocs.yml pyproject.toml
"""
"""Files beside the folders: what forges, installers and newcomers look for by name."""


def test_no_stray_file_lies_at_the_top(tracked: list[Path]) -> None:
    assert sorted(str(path) for path in tracked if len(path.parts) == 1) == sorted(TOP.split())


@pytest.mark.parametrize("file", ["Containerfile", "docs/how-to/keep-a-station-running.md"])
def test_the_container_has_its_extras(file: str) -> None:
    """Each extra that the image has exists; the page lists the same ones."""
    root = Path(__file__).parents[2]
    text = (root / file).read_text(encoding="utf-8")
    match = re.search(r"\.\[([a-z,]+)\]|with the extras ([a-z, ]+?) and ([a-z]+)\.", text)
    assert match is not None
    extras = set(re.findall(r"[a-z]+", ",".join(filter(None, match.groups()))))
    assert extras == {"fast", "metrics", "mqtt", "secure", "web"}
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert extras <= set(project["optional-dependencies"])


def test_the_container_serves_other_computers() -> None:
    """Its command listens at all addresses; the ports of ADS and of the pages are published."""
    text = (Path(__file__).parents[2] / "Containerfile").read_text(encoding="utf-8")
    (command,) = re.findall(r"^CMD (\[.*\])$", text, re.MULTILINE)
    words = json.loads(command)
    assert words[:3] == ["run", "--host", "0.0.0.0"]
    assert "--let-everybody-in" in words
    (ports,) = re.findall(r"^EXPOSE (.*)$", text, re.MULTILINE)
    assert {"48898", "48899/udp", str(SECURE_PORT), "8080"} <= set(ports.split())


def test_the_page_of_a_lasting_station_names_what_lasts() -> None:
    """One station in a container, a unit, an upgrade; where logs, records, caches, certificates."""
    page = Path(__file__).parents[2] / "docs" / "how-to" / "keep-a-station-running.md"
    text = page.read_text(encoding="utf-8").lower()
    words = ("podman run", "[service]", "upgrade", "logs", "record", "cache", "certificate")
    assert [word for word in words if word not in text] == []
