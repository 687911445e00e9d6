# SPDX-License-Identifier: Apache-2.0
"""Templates that text is made from: RTL headers, C++ drives, pages."""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

__all__ = ["templates"]


def templates(package: str, **options: Any) -> Environment:
    """The templates of a package, in its folder `templates`; a name that they use and nobody gives is an error.

    Args:
        package: its dotted name.
        options: more of Jinja's own options.
    """
    return Environment(loader=PackageLoader(package), undefined=StrictUndefined, keep_trailing_newline=True, **options)
