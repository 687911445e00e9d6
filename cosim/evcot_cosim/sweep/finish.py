# SPDX-License-Identifier: Apache-2.0
"""After the runs: the results of a sweep as plain values, its report and JUnit file, and the playback of its best runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any
from xml.etree import ElementTree

from .execute import DONE, INVALID, MISMATCH
from .folder import JUNIT, REPORT, write_own
from .page import render
from .playback import write_mismatches, write_playback
from .results import Group, best_first, families_of, front, grouped, module_and_shape, suites_of
from .run import Swept
from .spec import Spec
from .store import COLUMNS, read_rows

__all__ = ["finish", "leaders"]


def junit_xml(name: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """The text of the file: a mismatch is a failure, what was not done an error, and what cannot be is skipped."""
    suites: dict[str, list[Mapping[str, Any]]] = {}
    for row in sorted(rows, key=lambda row: (row["hardware"], row["task"])):
        suites.setdefault(module_and_shape(row), []).append(row)
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


_BEST = 20  # that are listed
_FRONT = 200
_NOT_NEEDED = ("versions", "code", "design", "content")


def finish(spec: Spec, found: Swept) -> dict[str, Any]:
    """Write what stands beside the store; returns the summary that `evcot sweep --json` prints.

    Raises:
        OutputError: a file of the sweep that somebody has changed, or a full disk.
    """
    rows = [row for row in read_rows(found.folder, [n for n in COLUMNS if n not in _NOT_NEEDED]) if row["key"] in found.keys]
    rows.sort(key=lambda row: row["key"])  # the same whatever ended first
    groups = grouped(rows, list(spec.objectives))
    best = best_first(groups, spec.objectives)[:_BEST] if spec.objectives else []
    playback = write_playback(found.folder, _chosen(best[: spec.best], spec)) if best else {}
    tests: list[str] = []
    if spec.fuzz is not None:
        tests = write_mismatches(found.folder, [row for row in rows if row["status"] == MISMATCH])
        write_own(found.folder / JUNIT, junit_xml(spec.name, rows))
    metric, way = next(iter(spec.objectives.items()), ("", "max"))
    summary = {
        "name": spec.name,
        "folder": str(found.folder),
        "runs": found.runs,
        "new": found.new,
        "status": dict(found.counts),
        "best": [_plain(group, playback) for group in best],
        "front": [_plain(group, playback) for group in front(groups, spec.objectives)[:_FRONT]]
        if len(spec.objectives) > 1
        else [],
        "left_out": {name: [asdict(each) for each in own] for name, own in families_of(groups, metric, way).items()}
        if spec.families and metric
        else {},
        "modules": {name: suite.to_dict() for name, suite in suites_of(rows, lambda row: str(row["hardware"])).items()}
        if spec.fuzz is not None
        else {},
        "tests": tests,
        "faults": [{key: row[key] for key in ("key", "status", "error", "command")} for row in rows if row["status"] != DONE],
    }
    write_own(found.folder / REPORT, render(spec, rows, groups, summary))
    return summary


def leaders(spec: Spec, best: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """The best configurations as a table."""
    rows = [(*spec.objectives, "runs", "configuration")]
    for each in best:
        rows.append((*(f"{each['means'][metric]:.4g}" for metric in spec.objectives), str(each["runs"]), each["name"]))
    return rows


def _plain(group: Group, playback: Mapping[str, str]) -> dict[str, Any]:
    keys = [row["key"] for row in group.rows]
    return {
        "name": group.name, "engine": group.engine, "hardware": group.hardware, "preset": group.preset,
        "settings": dict(group.settings), "means": dict(group.means), "runs": len(group.rows), "keys": keys[:100],
        "playback": [playback[key] for key in keys if key in playback],
    }  # fmt: skip


def _chosen(best: Sequence[Group], spec: Spec) -> list[Mapping[str, Any]]:
    """Of each of the best configurations, the run that shows most: the one with the median of the first objective."""
    metric = next(iter(spec.objectives))
    return [sorted(group.rows, key=lambda row: (row[metric], row["key"]))[len(group.rows) // 2] for group in best]
