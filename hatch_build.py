"""Metadata that hatchling asks for when it builds achse: addresses, and the page of the index.

One variable, `repository` of the metadata hook in pyproject.toml, says where the sources are
published; `ACHSE_REPOSITORY` in the environment of a build replaces it. While it is empty the
package has no addresses, and README's links stay as they are.
"""

import os
import re
from pathlib import Path
from typing import Any
from urllib.parse import urljoin, urlsplit

from hatchling.metadata.plugin.interface import MetadataHookInterface

_LINK = re.compile(r"(?<=\]\()(?![a-z]+:|#)[^)\s]+")
"""Target of a Markdown link that is relative to the page."""


class AchseMetadata(MetadataHookInterface):
    """Fill in `readme` and `urls`, which pyproject.toml leaves to the build."""

    PLUGIN_NAME = "custom"

    def update(self, metadata: dict[str, Any]) -> None:
        """Complete the metadata of one build. Raises ValueError for an address that is none."""
        root = Path(self.root)
        repository = repository_address(os.environ.get("ACHSE_REPOSITORY") or self._configured())
        text = (root / "README.md").read_text(encoding="utf-8")
        if repository:
            text = absolute_links(text, f"{repository}/blob/v{_version(root)}/")
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        metadata["urls"] = project_addresses(repository)

    def _configured(self) -> str:
        return str(self.config.get("repository", ""))


def repository_address(text: str) -> str:
    """Return the address without a slash at its end. Raises ValueError unless it is https."""
    parts = urlsplit(text)
    if text and (parts.scheme != "https" or not parts.netloc or parts.query or parts.fragment):
        raise ValueError(
            f"repository: expected an address like https://host/owner/achse, got {text!r}"
        )
    return text.rstrip("/")


def absolute_links(text: str, base: str) -> str:
    """Return Markdown whose relative links lead to `base`, which ends with a slash."""
    return _LINK.sub(lambda link: urljoin(base, link[0]), text)


def project_addresses(repository: str) -> dict[str, str]:
    """Return the addresses of the project by the labels that package indexes know."""
    if not repository:
        return {}
    return {
        "Source": repository,
        "Changelog": f"{repository}/blob/main/CHANGELOG.md",
        "Documentation": f"{repository}/tree/main/docs",
        "Issues": f"{repository}/issues",
        "Security": f"{repository}/security/policy",
    }


def _version(root: Path) -> str:
    source = (root / "src/achse/__init__.py").read_text(encoding="utf-8")
    found = re.search(r'^__version__ = "([^"]+)"', source, re.MULTILINE)
    if found is None:
        raise ValueError("src/achse/__init__.py: expected __version__")
    return found[1]
