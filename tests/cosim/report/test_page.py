# SPDX-License-Identifier: Apache-2.0
"""The HTML file: complete, bounded in size, and safe against markup in names; the facts that it shows; pages of a long run."""

from __future__ import annotations

import gc
import itertools
import json
import os
import re
import subprocess
import sys
import weakref
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.tracks.log import DROPPED, TrackLog
from evcot_cosim.lockstep.verdict import Grade, Line, Verdict
from evcot_cosim.report import Material, Side, page, write_report
from evcot_cosim.report.facts import METRICS, checks_of, headline, latency_bars, score_rows
from evcot_cosim.report.heat_maps import heat_maps
from evcot_cosim.report.material import Material as Made

from .conftest import mismatch_at, summary_of

HOSTILE = '</script><script>alert(1)</script><img src=x onerror="alert(2)">'


def facts_of(text: str) -> dict[str, Any]:
    """What the page knows about its columns."""
    found = re.search(r'<script type="application/json" id="facts">(.*?)</script>', text)
    assert found
    facts: dict[str, Any] = json.loads(found[1])
    return facts


def empty(name: str = "nothing") -> Recording:
    nothing = np.empty(0, np.int64)
    return Recording(Events(nothing, *(nothing.astype(np.uint16),) * 2, nothing.astype(np.uint8)), 32, 24, name)


def test_it_asks_the_network_for_nothing(report: Path) -> None:
    text = report.read_text()
    assert not re.findall(r"https?://", re.sub(r'id="columns">.*?</script>', "", text))
    assert "default-src &#39;none&#39;" in text or "default-src 'none'" in text
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', text) == []


def test_a_report_has_no_character_of_a_template_left(report: Path) -> None:
    text = re.sub(r"<script.*?</script>", "", report.read_text(), flags=re.DOTALL)
    assert not re.findall(
        r"\{[{%#]|[%#}]\}|\bNone\b|\bTrue\b|Undefined", re.sub(r"<style>.*?</style>", "", text, flags=re.DOTALL)
    )


def test_modules_are_joined_without_imports_and_exports_and_share_no_name() -> None:
    text = page.inline_modules(page.MODULES)
    assert not re.findall(r"^\s*(import|export)\b", text, re.MULTILINE)
    names = re.findall(r"^(?:const|let|class|function|async function) (\w+)", text, re.MULTILINE)
    assert len(names) == len(set(names))


def test_every_module_is_in_the_page_or_in_that_of_a_long_run() -> None:
    folder = Path(page.__file__).with_name("templates")
    assert {path.stem for path in folder.glob("*.js")} == {*page.MODULES, "overview"}


def test_hostile_names_are_shown_and_not_run(material: Made) -> None:
    recording = replace(material.recording, name=HOSTILE)
    summary = summary_of(HOSTILE, command=f"evcot cosim {HOSTILE}", versions={HOSTILE: HOSTILE})
    ids = ("car", *(HOSTILE,) * (len(material.truth.objects.ids) - 1)) if material.truth else ()
    assert material.truth
    truth = replace(material.truth, objects=replace(material.truth.objects, ids=ids))
    text = page.render(Material(recording, summary, material.sides, truth))
    assert "<img src=x" not in text
    assert "alert(1)</script>" not in text
    assert text.count("&lt;/script&gt;") >= 4
    assert text.count("<script") == text.count("</script>") == 3
    assert HOSTILE in facts_of(text)["sides"][2]["ids"]


def test_the_same_run_gives_the_same_bytes(material: Made) -> None:
    assert page.render(material) == page.render(material)


def test_a_long_run_is_thinned_and_says_so(material: Made) -> None:
    text = page.render(material, events_max=10_000)
    facts = facts_of(text)
    assert (facts["shown"], facts["events"]) == (10_000, len(material.recording.events))
    assert f"10,000 of {len(material.recording.events):,} events are drawn" in text


def test_the_text_is_bounded_whatever_the_events(material: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "_TEXT_MAX", 200_000)
    text = page.render(material)
    packed = re.search(r'id="columns">(.*?)</script>', text)
    assert packed
    assert len(packed[1]) <= 200_000
    assert 0 < facts_of(text)["shown"] < len(material.recording.events)


def test_two_million_events_at_random_stay_below_four_megabytes() -> None:
    random = np.random.default_rng(7)
    n = 2_000_000
    events = Events(
        np.cumsum(random.integers(0, 3, n)), random.integers(0, 1280, n, np.uint16), random.integers(0, 720, n, np.uint16),
        random.integers(0, 2, n, np.uint8),
    )  # fmt: skip
    owner = random.integers(-1, 8, n).astype(np.int16)
    sides = (Side("hardware", replace(TrackLog.empty("cot_array"), owner=owner)),)
    text = page.render(Material(Recording(events, 1280, 720, "noise"), {}, sides))
    assert len(text.encode()) <= 4_000_000
    assert facts_of(text)["shown"] > 500_000


def test_a_run_without_anything_says_what_is_missing() -> None:
    recording = empty()
    sides = (Side("hardware", TrackLog.empty("cot_array")), Side("software", TrackLog.empty("rct")))
    text = page.render(Material(recording, {}, sides))
    for words in ("No truth: HOTA not known", "no track became visible", "Too short to judge", "0 events", "What is missing"):
        assert words in text, words
    assert "<p>Record longer: half a second is enough for most scenes.</p>" in text


def test_where_nothing_was_tracked_the_first_advice_says_what_to_do() -> None:
    n = 1_000
    random = np.random.default_rng(3)
    places = (random.integers(0, 64, n, np.uint16) for _ in range(2))
    events = Events(np.arange(n) * 1_000, *places, np.zeros(n, np.uint8))
    owner = np.full(n, -1, np.int16)
    sides = tuple(Side(name, replace(TrackLog.empty(name), owner=owner)) for name in ("hardware", "software"))
    text = page.render(Material(Recording(events, 64, 64, "noise"), {}, sides))
    part = text[text.index("<h2>What to do</h2>") :]
    advice = re.findall(r"<p>(.*?)</p>", part[: part.index("</section>")])
    assert advice == [
        "Take cot_motion, whose boxes follow the objects (<code>--hardware cot_motion</code>), "
        "or require fewer events for a birth."
    ]


def test_maps_of_filtered_events_say_whose_filters(material: Made) -> None:
    first, second = (
        Side(name, replace(material.sides[0].log, owner=material.sides[0].log.owner.copy())) for name in ("a", "b")
    )
    for side in (first, second):
        side.log.owner[:10] = DROPPED
    titles = [heat.title for heat in heat_maps(Material(material.recording, {}, (first, second)))]
    assert [title for title in titles if "filters" in title] == ["Removed by filters: a, b"]
    second.log.owner[10] = DROPPED
    titles = [heat.title for heat in heat_maps(Material(material.recording, {}, (first, second)))]
    assert [title for title in titles if "filters" in title] == ["Removed by filters: a", "Removed by filters: b"]


def test_a_mismatch_comes_first(material: Made) -> None:
    n = 1_000
    sides = tuple(
        Side(name, TrackLog(engine, material.sides[0].log.records[:5], material.sides[0].log.owner[:n]))
        for name, engine in (("hardware", "cot_array"), ("model", "cot_array"))
    )
    text = page.render(
        Material(material.recording, mismatch_at(50, tick=4_321, field="record.cm_x", hardware=7, model=8), sides)
    )
    assert '<strong class="poor">Hardware ≠ model</strong>' in text
    assert re.findall(r'role="tab" id="tab-(\w+)"', text)[0] == "mismatch"
    for words in ("4,321", "record.cm_x", "gtkwave mismatch.vcd", f"The run ended after {n:,} of"):
        assert words in text, words
    t_us = material.recording.events.t_us
    assert facts_of(text)["mismatch"] == facts_of(text)["start"] == t_us[50] - t_us[0]


def test_logs_of_another_recording_are_refused(material: Made) -> None:
    short = Side("software", replace(material.sides[1].log, owner=material.sides[1].log.owner[:-1]))
    with pytest.raises(ConfigError, match="must be of the same recording"):
        Material(material.recording, {}, (material.sides[0], short))
    with pytest.raises(ConfigError, match="must be of the same recording"):
        Material(empty(), {}, material.sides)


def test_a_page_that_is_written_leaves_nothing_in_memory(material: Made, tmp_path: Path) -> None:
    shown = replace(material)
    alive = weakref.ref(shown)
    gc.disable()  # a reference cycle would keep the page's data until a collection, which may be hundreds of pages away
    try:
        write_report(shown, tmp_path / "report.html")
        del shown
        assert alive() is None
    finally:
        gc.enable()


# Two pages, and the names of the functions of this process that Numba compiled for them.
_PAGES = """
import sys
from pathlib import Path
import numpy as np
from numba.core import event
from evcot.events import Events
from evcot.tracks.log import TRACK, TrackLog
from evcot_cosim.report import part_pages

class Compiled(event.Listener):
    def on_start(self, event): pass
    def on_end(self, event):  # of a compilation that was refused, too
        if event.data["dispatcher"].signatures: print(event.data["dispatcher"].py_func.__name__)
event.register("numba:compile", Compiled())

part_pages.PART_EVENTS = 100
count = 150
columns = (np.zeros(count, kind) for kind in (np.uint16, np.uint16, np.uint8))
blocks = iter([Events(np.arange(count, dtype=np.int64), *columns)])
recording = part_pages.LongRecording("made", (64, 64), blocks, count, 0, count - 1)
log = TrackLog("cot_array", np.empty(0, TRACK), np.full(count, -1, np.int16))
part_pages.write_parts(recording, {"hardware": log}, Path(sys.argv[1]), {})
"""


def test_kernels_of_the_pages_are_compiled_by_another_process(tmp_path: Path) -> None:
    kernels = tmp_path / "kernels"
    kernels.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", _PAGES, str(tmp_path)], env=os.environ | {"NUMBA_CACHE_DIR": str(kernels)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert sorted(path.name for path in tmp_path.glob("part-*.html")) == ["part-00000.html", "part-00001.html"]
    assert done.stdout.split() == []
    assert list(kernels.rglob("*.nbc")) != []


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
