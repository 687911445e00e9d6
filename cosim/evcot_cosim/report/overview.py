# SPDX-License-Identifier: Apache-2.0
"""The overview of a long run: its figures, curves over all parts, and the page of the part that is chosen, loaded on demand."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from evcot.outputs import written_aside
from evcot.templating import templates

from ..lockstep.verdict import verdict_from
from .facts import agreement_rows, flat, latency_bars, run_rows

__all__ = ["write_overview"]

_MODULE = "overview.js"


def write_overview(summary: Mapping[str, Any], path: Path, *, force: bool = False) -> None:
    """Write the page; the pages of the parts that `summary` lists are beside it.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    folder = files("evcot_cosim.report") / "templates"
    script, style = ((folder / name).read_text(encoding="utf-8") for name in (_MODULE, "style.css"))
    environment = templates("evcot_cosim.report", autoescape=True, trim_blocks=True, lstrip_blocks=True)
    verdict = verdict_from(summary["verdict"])
    text = environment.get_template("overview.html.j2").render(
        title=summary["name"],
        summary=summary,
        verdict=verdict,
        decisive="hardware",
        marks={"good": "✓", "fair": "!", "poor": "✗"},
        agreement=agreement_rows(summary),
        run_rows=run_rows(summary),
        config_rows=flat(summary["config"]),
        versions=summary["versions"],
        latency=latency_bars(summary),
        style=style,
        script=script,
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        facts=json.dumps(summary["parts"], separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
    )
    with written_aside(path, force=force) as file:
        file.write(text.encode())
