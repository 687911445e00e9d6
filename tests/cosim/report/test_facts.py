# SPDX-License-Identifier: Apache-2.0
"""Facts of a report that are worked out in Python: bars of the latency, best scores, checks, and the words at the top."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from evcot_cosim.lockstep.verdict import Grade, Line, Verdict
from evcot_cosim.report.facts import METRICS, checks_of, headline, latency_bars, score_rows


def bars_of(histogram: list[tuple[int, int]]) -> list[tuple[str, int, float]]:
    return [tuple(bar) for bar in latency_bars({"latency_clocks": {"histogram": histogram}})]


def test_few_latencies_have_a_bar_each() -> None:
    assert bars_of([(3, 10), (4, 5), (9, 5)]) == [("3", 10, 0.5), ("4", 5, 0.75), ("9", 5, 1.0)]


def test_many_latencies_have_bars_that_widen() -> None:
    bars = bars_of([(clocks, 1) for clocks in range(1, 1_001)])
    assert len(bars) <= 16
    assert sum(count for _, count, _ in bars) == 1_000
    assert bars[0][0] == "1"
    assert bars[-1][0].endswith("1000")
    assert [share for *_, share in bars] == sorted(share for *_, share in bars)
    ends = [tuple(map(int, text.split("–"))) for text, *_ in bars]
    assert all(b[0] == a[-1] + 1 for a, b in itertools.pairwise(ends)), "without gaps"


def test_what_was_not_measured_has_no_bars() -> None:
    assert latency_bars({}) == []
    assert latency_bars({"latency_clocks": {"histogram": []}}) == []


def scores(**values: float | None) -> dict[str, Any]:
    return {metric.name: None for metric in METRICS} | values


def test_the_best_score_is_the_one_that_looks_best() -> None:
    rows = {row.metric.name: row for row in score_rows([scores(hota=0.8004, idsw=3, ml=1), scores(hota=0.8001, idsw=2, ml=1)])}
    assert set(rows) == {"hota", "idsw", "ml"}, "what no side has is left out"
    assert rows["hota"].best == [False, False], "after rounding they are the same"
    assert rows["idsw"].best == [False, True], "fewer switches are better"
    assert rows["ml"].best == [False, False]
    (row,) = score_rows([scores(hota=0.7), scores(hota=None), scores(hota=0.75)])
    assert (row.texts, row.best) == (["0.700", "–", "0.750"], [False, False, True])


LINES = (
    Line("exactness", "", Grade.GOOD, "exact"), Line("tracks", "software", Grade.POOR, "poor"),
    Line("tracks", "hardware", Grade.FAIR, "fair"), Line("noise", "hardware", Grade.GOOD, "none"),
)  # fmt: skip


def test_a_check_is_graded_by_the_side_that_decides() -> None:
    found = checks_of(Verdict(Grade.FAIR, "", LINES), "hardware")
    assert [(check.name, check.grade, len(check.lines)) for check in found] == [
        ("exact", "good", 1), ("tracks", "fair", 2), ("noise", "good", 1),
    ]  # fmt: skip
    assert [line.side for line in found[1].lines] == ["hardware", "software"]


@pytest.mark.parametrize(
    ("summary", "lines", "tracked", "words"),
    [
        ({"mismatch": {}}, LINES, True, "Hardware ≠ model"),
        ({"exact": False}, LINES, True, "Hardware ≠ model"),
        ({}, (Line("length", "", Grade.FAIR, "short"),), True, "Too short to judge"),
        ({}, LINES, False, "Nothing was tracked"),
        ({}, LINES, True, "Tracks are usable"),
    ],
)
def test_the_headline_is_a_few_words(summary: dict[str, Any], lines: tuple[Line, ...], tracked: bool, words: str) -> None:
    assert headline(Verdict(Grade.FAIR, "", lines), summary, tracked) == words
