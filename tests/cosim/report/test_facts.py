# SPDX-License-Identifier: Apache-2.0
"""Facts of a report that are worked out in Python: the bars of the latency."""

from __future__ import annotations

from typing import Any

from evcot_cosim.report.facts import latency_bars


def bars_of(histogram: list[tuple[int, int]], p99: int) -> list[tuple[str, int]]:
    told: dict[str, Any] = {"median": 39, "p99": p99, "max": histogram[-1][0], "histogram": histogram}
    made = latency_bars({"latency_clocks": told}, 5)
    assert made is not None
    return list(made.bars)


def test_few_latencies_have_a_bar_each() -> None:
    assert bars_of([(3, 10), (4, 1), (9, 2)], 9) == [("3", 10), ("4", 1), ("9", 2)]


def test_a_few_slow_records_do_not_make_all_others_one_bar() -> None:
    fast = [(clocks, 10) for clocks in range(30, 42)]
    assert bars_of([*fast, (2_000, 1), (4_095, 2)], 41) == [
        ("30–32", 30), ("33–35", 30), ("36–38", 30), ("39–41", 30), ("42–4095", 3),
    ]  # fmt: skip


def test_without_slow_ones_there_is_no_last_bar() -> None:
    bars = bars_of([(clocks, 1) for clocks in range(10)], 9)
    assert bars == [("0–2", 3), ("3–5", 3), ("6–8", 3), ("9", 1)]


def test_what_was_not_measured_has_none() -> None:
    assert latency_bars({}) is None
    assert latency_bars({"latency_clocks": {"histogram": []}}) is None
