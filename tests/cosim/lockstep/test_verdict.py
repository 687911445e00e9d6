# SPDX-License-Identifier: Apache-2.0
"""The verdict: every grade and every advice by the figures that lead to it, and real runs that are good and useless."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.metrics.quality import Quality
from evcot.tracks.log import TrackLog
from evcot_cosim.lockstep import verdict as module
from evcot_cosim.lockstep.summary import verdict_lines
from evcot_cosim.lockstep.verdict import Grade, Verdict, verdict_from, verdict_of

GOOD = Quality(
    tracks=10, alive_mean=2.0, tracks_per_alive=5.0, short_us=200_000, short=1, short_merged=1, short_lost=0,
    owned_fraction=0.9, isolated_fraction=0.1, isolated_dropped_fraction=0.9, isolated_owned_fraction=0.05,
    noise_tracks=0, noise_time_fraction=0.0,
)  # fmt: skip
_SLOT = {"init_radix": 8, "max_ticks": 9, "clust_nev": 5, "detect_ticks": 7}
SUMMARY = {
    "exact": True,
    "records": 1_234,
    "config": {"name": "slow", "hardware": {"module": "cot_array", "slots": [_SLOT]}},
}
AGREEMENT = {
    "paired_fraction_hardware": 0.9, "paired_fraction_software": 0.8, "radius_px": 12.0, "merges_paired": 1,
    "merges_hardware": 3, "merges_software": 2, "merges_comparable_hardware": 3, "merges_comparable_software": 2,
}  # fmt: skip


def judged(
    monkeypatch: pytest.MonkeyPatch, hardware: Quality | None = GOOD, software: Quality | None = None, **summary: Any
) -> Verdict:
    figures = {name: one for name, one in (("hardware", hardware), ("software", software)) if one is not None}
    found = iter(figures.values())
    monkeypatch.setattr(module, "quality_of", lambda *_: next(found))
    nothing = np.empty(0, np.int64)
    events = Events(nothing, nothing.astype(np.uint16), nothing.astype(np.uint16), nothing.astype(np.uint8))
    logs = {name: TrackLog.empty("cot_array") for name in figures}
    return verdict_of(Recording(events, 8, 8, "nothing"), logs, SUMMARY | summary)


def line(verdict: Verdict, about: str, side: str = "hardware") -> module.Line:
    return next(one for one in verdict.lines if (one.about, one.side) == (about, side))


def test_a_good_run_is_good_in_every_line(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, software=GOOD, agreement=AGREEMENT)
    assert {one.grade for one in verdict.lines} == {Grade.GOOD}
    assert [one.about for one in verdict.lines] == ["exactness", *["tracks", "events", "noise"] * 2, "agreement"]
    assert verdict.grade is Grade.GOOD
    assert not any(one.advice for one in verdict.lines)


@pytest.mark.parametrize(
    ("change", "about", "grade", "advice"),
    [
        ({"tracks": 0}, "tracks", Grade.POOR, "clust_nev in run.toml below 5"),
        ({"short": 6, "short_merged": 6}, "tracks", Grade.POOR, "detect_ticks in run.toml below 7"),
        ({"short": 6, "short_merged": 6, "owned_fraction": 1.0}, "tracks", Grade.POOR, "`--hardware cot_motion`"),
        ({"tracks": 3, "short": 2, "short_lost": 2}, "tracks", Grade.FAIR, "max_ticks in run.toml above 9"),
        ({"short": 3, "short_lost": 2}, "tracks", Grade.FAIR, "max_ticks in run.toml above 9"),
        ({"short": 6, "noise_tracks": 6}, "tracks", Grade.POOR, "clusters on noise: filter more noise"),
        ({"owned_fraction": 0.6}, "events", Grade.FAIR, "clust_nev in run.toml below 5"),
        ({"owned_fraction": 0.4}, "events", Grade.POOR, "clust_nev in run.toml below 5"),
        ({"noise_time_fraction": 0.2, "noise_tracks": 1}, "noise", Grade.FAIR, "--activity-support 2"),
        ({"noise_time_fraction": 0.4, "isolated_dropped_fraction": 0.0}, "noise", Grade.POOR, "with --activity 5"),
        ({"noise_tracks": 4}, "noise", Grade.FAIR, "--activity-support 2"),
    ],
)  # fmt: skip
def test_a_figure_beyond_its_limit_has_its_grade_and_its_advice(
    monkeypatch: pytest.MonkeyPatch, change: dict[str, Any], about: str, grade: Grade, advice: str
) -> None:
    verdict = judged(monkeypatch, replace(GOOD, **change))
    found = line(verdict, about)
    assert found.grade is grade
    assert advice in found.advice
    assert bool(found.advice) == bool(advice)
    assert verdict.grade is grade


def test_the_hardware_decides_and_the_software_where_it_is_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    poor = replace(GOOD, owned_fraction=0.1)
    assert judged(monkeypatch, GOOD, poor).grade is Grade.GOOD
    assert judged(monkeypatch, poor, GOOD).grade is Grade.POOR
    assert judged(monkeypatch, None, poor).grade is Grade.POOR


def test_disagreement_alone_makes_no_run_poor(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, software=GOOD, agreement=AGREEMENT | {"paired_fraction_software": 0.1})
    assert line(verdict, "agreement", "").grade is Grade.POOR
    assert "report.html" in line(verdict, "agreement", "").advice
    assert verdict.grade is Grade.FAIR


@pytest.mark.parametrize(
    ("hardware", "software", "same", "grade", "advice"),
    [
        (41, 0, 0, Grade.POOR, "hardware merges more often"),
        (2, 9, 1, Grade.POOR, "software merges more often"),
        (10, 9, 5, Grade.FAIR, "every difference"),
        (10, 9, 7, Grade.GOOD, ""),
        (4, 0, 0, Grade.GOOD, ""),  # too few for a share
    ],
)
def test_agreement_is_as_good_as_the_worse_of_time_and_comparable_merges(
    monkeypatch: pytest.MonkeyPatch, hardware: int, software: int, same: int, grade: Grade, advice: str
) -> None:
    merges = {"merges_hardware": 50, "merges_software": 50, "merges_paired": same}
    merges |= {"merges_comparable_hardware": hardware, "merges_comparable_software": software}
    found = line(judged(monkeypatch, software=GOOD, agreement=AGREEMENT | merges), "agreement", "")
    assert found.grade is grade
    assert found.advice.startswith(advice)
    assert bool(found.advice) == bool(advice)


def test_the_headline_names_what_the_grade_comes_from(monkeypatch: pytest.MonkeyPatch) -> None:
    def headline(agreement: dict[str, Any] | None = None, **change: Any) -> str:
        return judged(monkeypatch, replace(GOOD, **change), GOOD, agreement=agreement).headline

    assert headline() == "The tracks look sound."
    assert headline(short=9, short_merged=9) == "The tracks are poor: 90 % are short."
    assert headline(tracks=0) == "The tracks are poor: none became visible."
    fair = "The tracks are usable, but 30 % are short, and lasting ones have 60 % of the events."
    assert headline(short=3, owned_fraction=0.6) == fair
    assert headline(noise_tracks=4) == "The tracks are usable, but many are on noise."
    poor = AGREEMENT | {"paired_fraction_software": 0.1}
    assert headline(poor) == "The tracks are usable, but hardware and software disagree."
    assert headline(poor, owned_fraction=0.1) == "The tracks are poor: lasting ones have 10 % of the events."


def test_absorbed_tracks_are_named_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    found = line(judged(monkeypatch, replace(GOOD, absorbed=7)), "tracks", "hardware").text
    assert "(5.0 per object alive), and 7 that merged into another in the moment of their birth; 10 % are short" in found


def test_short_tracks_come_with_their_share_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    found = line(judged(monkeypatch, replace(GOOD, short=3, short_time_fraction=0.02)), "tracks", "hardware")
    assert found.text.endswith("30 % are short: gone within 0.2 s, close to where they began, and 2 % of the time of all")


def test_a_mismatch_stands_above_everything(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, exact=False, mismatch={"event_index": 1_000, "field": "owner"})
    assert verdict.headline == "Hardware and model differ: the run ended there."
    assert verdict.lines[0].text == "hardware and model differ at event 1,000: owner"
    assert verdict.grade is Grade.POOR


def test_hardware_with_motion_has_no_slots_registers_to_change(monkeypatch: pytest.MonkeyPatch) -> None:
    config = {"name": "motion", "hardware": {"module": "cot_motion", "registers": {"detect_ticks": 7}}}
    advice = line(judged(monkeypatch, replace(GOOD, short=6, short_merged=6), config=config), "tracks").advice
    assert "[motion] in run.toml" in advice
    assert "--preset" not in advice


def test_a_recording_too_short_to_judge_says_what_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, replace(GOOD, tracks=0), recording_s=0.0088, exact=True, records=0)
    assert (verdict.grade, verdict.headline) == (Grade.FAIR, "Too short to judge the tracks.")
    assert [(found.about, found.grade, found.text) for found in verdict.lines] == [
        ("exactness", Grade.FAIR, "hardware = model in the owner of every event; no record was there to compare"),
        ("length", Grade.FAIR, "8.8 ms: must be 50 ms with moving objects at least, for tracks to be judged"),
    ]
    assert judged(monkeypatch, GOOD, recording_s=0.06).headline == "The tracks look sound."


def test_it_is_the_same_after_a_conversion_through_json(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, replace(GOOD, owned_fraction=None), agreement=AGREEMENT)
    assert verdict_from(json.loads(json.dumps(verdict.to_dict()))) == verdict


def test_the_terminal_has_every_line_and_every_advice(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, replace(GOOD, short=6, short_merged=6))
    text = "\n".join(verdict_lines(verdict))
    for one in verdict.lines:
        assert one.text in text
        assert one.advice in text
    assert text.startswith(f"verdict: {verdict.headline}")
    narrow = verdict_lines(verdict, 80)
    assert max(map(len, narrow)) <= 80
    assert " ".join(" ".join(narrow).split()) == " ".join(text.split())


@pytest.mark.parametrize(("tracks", "per"), [(3_000, "1,500"), (26, "13"), (3, "1.5")])
def test_tracks_for_each_object_are_told_in_plain_numbers(monkeypatch: pytest.MonkeyPatch, tracks: int, per: str) -> None:
    found = line(judged(monkeypatch, replace(GOOD, tracks=tracks, tracks_per_alive=tracks / 2)), "tracks").text
    assert found.startswith(f"{tracks:,} tracks, about 2 alive at a time ({per} per object alive)")


DATA = Path(__file__).parents[4] / "shared" / "data"


@pytest.mark.parametrize("preset", ["motion", "slow"])
@pytest.mark.parametrize("name", ["hand_dvs128.aedat4", "traffic_outbound.aedat4"])
def test_a_real_recording_is_told_good_from_useless(name: str, preset: str) -> None:
    """`slow` finds no track that lasts."""
    useful = preset == "motion"
    if not (DATA / name).is_file():
        pytest.skip(f"{name} is not here")
    from evcot.hardware.golden import track as track_model
    from evcot.recordings.files import open_recording
    from evcot.trackers.presets import PRESETS, fit

    with open_recording(DATA / name) as file:
        recording = file.read()
    sensor = recording.width, recording.height
    config = fit(PRESETS[preset], *sensor)
    log = track_model(recording, config.device_config(*sensor))
    verdict = verdict_of(recording, {"hardware": log}, {"exact": True, "config": config.to_dict()})
    assert (verdict.grade is not Grade.POOR) == useful, verdict_lines(verdict)
