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
from .collect import looks_of
from .facts import agreement_rows, flat, latency_bars, run_rows

__all__ = ["write_overview"]

_MODULE = "overview.js"
_ALIVE = "alive_"  # what the fields of a part that are there once for each side begin with


def write_overview(summary: Mapping[str, Any], path: Path, *, force: bool = False) -> None:
    """Write the page; the pages of the parts that `summary` lists are beside it, or in a folder that they name.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
    """
    folder = files("evcot_cosim.report") / "templates"
    script, style = ((folder / name).read_text(encoding="utf-8") for name in (_MODULE, "style.css"))
    environment = templates("evcot_cosim.report", autoescape=True, trim_blocks=True, lstrip_blocks=True)
    verdict = verdict_from(summary["verdict"])
    names = [name.removeprefix(_ALIVE) for name in summary["parts"][0] if name.startswith(_ALIVE)]
    looks = looks_of(names)
    sides = [{"name": name, "look": looks[name]} for name in names]
    text = environment.get_template("overview.html.j2").render(
        title=summary["name"],
        summary=summary,
        verdict=verdict,
        sides=sides,
        folder=summary["parts"][0]["page"].rpartition("/")[0],
        decisive="hardware" if "hardware" in names else names[0],
        marks={"good": "✓", "fair": "!", "poor": "✗"},
        agreement=agreement_rows(summary),
        run_rows=run_rows(summary),
        config_rows=flat(summary.get("config", {})),
        versions=summary["versions"],
        latency=latency_bars(summary),
        style=style,
        script=script,
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        facts=json.dumps({"parts": summary["parts"], "sides": sides}, separators=(",", ":"), allow_nan=False).replace(
            "<", "\\u003c"
        ),
    )
    with written_aside(path, force=force) as file:
        file.write(text.encode())
