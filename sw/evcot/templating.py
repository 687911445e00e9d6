# SPDX-License-Identifier: Apache-2.0
"""Templates that text is made from: RTL headers, C++ drives, pages."""

from __future__ import annotations

from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

__all__ = ["templates"]


def templates(*packages: str, **options: Any) -> Environment:
    """The templates of packages, each in its folder `templates`; a name that they use and nobody gives is an error.

    Args:
        packages: their dotted names; a template is taken from the first that has it.
        options: more of Jinja's own options.
    """
    loader = ChoiceLoader([PackageLoader(package) for package in packages])
    return Environment(loader=loader, undefined=StrictUndefined, keep_trailing_newline=True, **options)
