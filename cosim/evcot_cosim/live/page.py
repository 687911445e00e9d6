# SPDX-License-Identifier: Apache-2.0
"""The live page: one self-contained document that opens only its own WebSocket."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files

from evcot.templating import templates

from ..report.page import inline_modules

__all__ = ["Page", "page"]

# Drawing that the report shares, then what is the live page's own, in the order in which they need each other.
_SHARED = ("surface", "stage", "pointer")
_OWN = ("protocol", "trails", "figures", "choice", "main")


@dataclass(frozen=True)
class Page:
    """The HTTP response for a browser."""

    body: bytes
    headers: Mapping[str, str]


def page() -> Page:
    """The page; its headers allow only its own script, and connections only to its own origin."""
    script = "\n".join([inline_modules(_SHARED), *(_source(f"{name}.js") for name in _OWN)])
    environment = templates("evcot_cosim.live", autoescape=True, trim_blocks=True, lstrip_blocks=True)
    body = environment.get_template("live.html.j2").render(style=_source("style.css"), script=script).encode()
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'"
    policy += "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    return Page(
        body,
        {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Security-Policy": policy,
            "X-Frame-Options": "DENY",
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
        },
    )


def _source(name: str) -> str:
    return (files("evcot_cosim.live") / "templates" / name).read_text(encoding="utf-8")
