# SPDX-License-Identifier: Apache-2.0
"""Renders WaveDrom descriptions to SVG for light and dark pages."""

from __future__ import annotations

import importlib
import json
import re
from xml.etree import ElementTree

from evcot.errors import ToolchainError

from .trace import Diagram

__all__ = ["svg"]

_STYLE = """
.paper{fill:#fff}
text{font:9.5pt Helvetica,Arial,sans-serif;fill:#1f2328}
.info{font-size:11pt;fill:#0550ae}
.s1,.s2,.s3{fill:none;stroke:#1f2328;stroke-linecap:round}
.s2{stroke-width:.5}
.s3{stroke-dasharray:1,3}
.s7{fill:#e7effa}
.mark{stroke:#888;stroke-width:.5;stroke-dasharray:1,3}
.group{stroke:#0550ae;fill:none}
@media (prefers-color-scheme:dark){
.paper{fill:#0d1117}
text{fill:#e6edf3}
.info{fill:#79c0ff}
.s1,.s2,.s3{stroke:#e6edf3}
.s7{fill:#1b3048}
.group{stroke:#79c0ff}
}
"""
_SVG = "http://www.w3.org/2000/svg"
_HREF = "{http://www.w3.org/1999/xlink}href"


def svg(diagram: Diagram, title: str) -> str:
    """The SVG text of a diagram, with its own background, and without unused symbols.

    Raises:
        ToolchainError: the package wavedrom is not installed.
    """
    try:
        wavedrom = importlib.import_module("wavedrom")
    except ImportError as error:
        raise ToolchainError("wavedrom: not installed: pip install evcot[docs]") from error
    ElementTree.register_namespace("", _SVG)
    ElementTree.register_namespace("xlink", "http://www.w3.org/1999/xlink")
    root = ElementTree.fromstring(wavedrom.render(json.dumps(diagram)).tostring())
    used = {node.get(_HREF, "")[1:] for node in root.iter(f"{{{_SVG}}}use")}
    for definitions in root.iter(f"{{{_SVG}}}defs"):
        for brick in list(definitions):
            if brick.get("id") not in used:
                definitions.remove(brick)
    for node in root.iter():
        inline = node.attrib.pop("style", "")
        if inline:
            node.set("class", "mark" if "dasharray" in inline else "group")
    sheet = root.find(f"{{{_SVG}}}style")
    assert sheet is not None
    sheet.text = _STYLE
    root.set("viewBox", root.get("viewBox", "").replace(",", " "))
    root.set("role", "img")
    label = ElementTree.Element(f"{{{_SVG}}}title")
    label.text = title
    paper = ElementTree.Element(f"{{{_SVG}}}rect", {"class": "paper", "width": "100%", "height": "100%", "rx": "6"})
    root.insert(0, label)
    root.insert(list(root).index(sheet) + 1, paper)
    text = ElementTree.tostring(root, encoding="unicode")
    return re.sub(r"(<(?:g id=\"(?:wavelane|lanes|labels|gmarks|groups|waves)_\d)|</svg>)", r"\n\1", text) + "\n"
