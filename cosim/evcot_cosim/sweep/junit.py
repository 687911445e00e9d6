# SPDX-License-Identifier: Apache-2.0
"""Runs as JUnit XML, as continuous integration reads it: a suite for each module and shape, a case for each seed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

from .execute import DONE, INVALID, MISMATCH

__all__ = ["junit_xml"]


def junit_xml(name: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """The text of the file: a mismatch is a failure, what was not done an error, and what cannot be is skipped."""
    suites: dict[str, list[Mapping[str, Any]]] = {}
    for row in sorted(rows, key=lambda row: (row["hardware"], row["task"])):
        shape = json.loads(row["task"])["tables"].get("shape", {})
        sizes = ", ".join(f"{field} = {value}" for field, value in shape.items()) or "default shape"
        suites.setdefault(f"{row['hardware']}: {sizes}", []).append(row)
    root = ElementTree.Element("testsuites", _counts(rows) | {"name": name})
    for title, own in suites.items():
        suite = ElementTree.SubElement(root, "testsuite", _counts(own) | {"name": title})
        for row in sorted(own, key=lambda row: row["seed"] if row["seed"] is not None else -1):
            case_name = title if row["seed"] is None else f"{title}, seed {row['seed']}"
            about = {"classname": f"{name}.{row['hardware']}", "name": case_name, "time": _seconds([row])}
            case = ElementTree.SubElement(suite, "testcase", about)
            kind = {DONE: None, MISMATCH: "failure", INVALID: "skipped"}.get(row["status"], "error")
            if kind is not None:
                fault = ElementTree.SubElement(case, kind, {"message": row["error"]})
                if kind != "skipped":
                    fault.text = f"{row['error']}\n{row['command']}\n"
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _counts(rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    status = [row["status"] for row in rows]
    failures, skipped = status.count(MISMATCH), status.count(INVALID)
    errors = len(status) - failures - skipped - status.count(DONE)
    numbers = {"tests": len(rows), "failures": failures, "errors": errors, "skipped": skipped}
    return {name: str(number) for name, number in numbers.items()} | {"time": _seconds(rows)}


def _seconds(rows: Sequence[Mapping[str, Any]]) -> str:
    return f"{sum(row['wall_s'] or 0.0 for row in rows):.3f}"
