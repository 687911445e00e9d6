# SPDX-License-Identifier: Apache-2.0
"""Jinja templates for generated text: RTL headers, C++ drivers, pages."""

from __future__ import annotations

from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

__all__ = ["html_templates", "templates"]


def templates(*packages: str, **options: Any) -> Environment:
    """Environment with the templates of packages, each in its folder `templates`; an undefined variable is an error.

    Args:
        packages: dotted names; a template is taken from the first package that has it.
        options: further options of Jinja's Environment.
    """
    loader = ChoiceLoader([PackageLoader(package) for package in packages])
    return Environment(loader=loader, undefined=StrictUndefined, keep_trailing_newline=True, **options)


def html_templates(*packages: str) -> Environment:
    """As `templates`, of pages: values are escaped, and lines of statements leave nothing behind."""
    return templates(*packages, autoescape=True, trim_blocks=True, lstrip_blocks=True)
