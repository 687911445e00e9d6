# SPDX-License-Identifier: Apache-2.0
"""Metadata that a package index shows: the README with links and pictures that work there, and the addresses of the project.

Relative links lead nowhere on an index. With `EVCOT_REPOSITORY=https://HOST/OWNER/evcot` in the environment of the build they
point into that repository, at the tag of the version, and the index lists its addresses. Without it links become plain text,
and pictures are left out.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_LINK = re.compile(r"(?<!!)\[([^\[\]]+)\]\(([^()\s]+)\)")
_PICTURE = re.compile(r"!\[([^\[\]]*)\]\(([^()\s]+)\)")
_TAG = re.compile(r'<img src="([^"]+)"')
_LINE_OF_TAG = re.compile(r'^<img src="(?!\w+:)[^>]*>\n\n?', re.MULTILINE)


def readme_for_index(text: str, repository: str, version: str) -> str:
    """README.md as an index shows it; `repository` is its address without a slash at the end, or empty."""
    page, raw = f"{repository}/blob/v{version}/", f"{repository}/raw/v{version}/"
    if not repository:
        text = _LINE_OF_TAG.sub("", text)
    text = _TAG.sub(lambda found: f'<img src="{_absolute(found[1], raw)}"', text)
    text = _PICTURE.sub(
        lambda found: f"![{found[1]}]({_absolute(found[2], raw)})" if repository or _is_address(found[2]) else "", text
    )
    return _LINK.sub(
        lambda found: f"[{found[1]}]({_absolute(found[2], page)})" if _stays(found[2], repository) else found[1], text
    )


def urls(repository: str) -> dict[str, str]:
    """The addresses that an index lists."""
    if not repository:
        return {}
    blob = f"{repository}/blob/main"
    return {
        "Repository": repository,
        "Documentation": f"{blob}/docs/README.md",
        "Changelog": f"{blob}/CHANGELOG.md",
        "Issues": f"{repository}/issues",
    }


def _is_address(target: str) -> bool:
    return re.match(r"\w+:", target) is not None


def _stays(target: str, repository: str) -> bool:
    return bool(repository) or _is_address(target) or target.startswith("#")


def _absolute(target: str, base: str) -> str:
    return target if _is_address(target) or target.startswith("#") else base + target


class CustomMetadataHook(MetadataHookInterface):
    """Called by hatchling for wheel and sdist."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill in the dynamic fields `readme` and `urls`."""
        root = Path(self.root)
        version = re.search(r'__version__ = "([^"]+)"', (root / "sw" / "evcot" / "__init__.py").read_text(encoding="utf-8"))
        assert version is not None
        repository = os.environ.get("EVCOT_REPOSITORY", "").rstrip("/")
        if repository and not re.fullmatch(r"https://[\w.-]+/[\w./-]+", repository):
            raise ValueError(f"EVCOT_REPOSITORY = {repository!r}: must be an address such as https://HOST/OWNER/evcot")
        text = readme_for_index((root / "README.md").read_text(encoding="utf-8"), repository, version[1])
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        metadata["urls"] = urls(repository)
