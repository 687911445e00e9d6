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
        ({"short": 6, "noise_tracks": 6}, "tracks", Grade.POOR, "clusters on noise: drop events without a recent neighbour"),
        ({"owned_fraction": 0.6}, "events", Grade.FAIR, "clust_nev in run.toml below 5"),
        ({"owned_fraction": 0.4}, "events", Grade.POOR, "clust_nev in run.toml below 5"),
        ({"noise_time_fraction": 0.2, "noise_tracks": 1}, "noise", Grade.FAIR, "`--activity 20`"),
        ({"noise_time_fraction": 0.4, "isolated_dropped_fraction": 0.0}, "noise", Grade.POOR, "`--activity 20`"),
        ({"noise_tracks": 4}, "noise", Grade.FAIR, "`--activity 20`"),
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
    assert "about 2 at a time, and 7 that merged into another in the moment of their birth; 10 % are short" in found


def test_short_tracks_come_with_their_share_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    found = line(judged(monkeypatch, replace(GOOD, short=3, short_time_fraction=0.02)), "tracks", "hardware")
    assert found.text.endswith("30 % are short: gone within 0.2 s, close to where they began, and 2 % of the time of all")


def test_a_mismatch_stands_above_everything(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, exact=False, mismatch={"event_index": 1_000, "field": "owner"})
    assert verdict.headline == "Hardware and model differ: the run ended there."
    assert verdict.lines[0].text == "hardware and model differ at event 1,000: owner"
    assert verdict.grade is Grade.POOR


def test_hardware_with_motion_has_registers_of_its_own_to_change(monkeypatch: pytest.MonkeyPatch) -> None:
    registers = {"detect_ticks": 7_500, "life_ticks": 60_000, "coast_ticks": 90_000}
    config = {"name": "motion", "hardware": {"module": "cot_motion", "registers": registers}}
    merging = replace(GOOD, short=6, short_merged=6)
    advice = line(judged(monkeypatch, merging, config=config), "tracks").advice
    assert "set detect_ticks = 5000 (now 7500) in [motion] of run.toml, then `evcot cosim --config run.toml`" in advice
    losing = replace(GOOD, short=6, short_merged=0, short_lost=6)
    assert "set life_ticks = 90000 (now 60000)" in line(judged(monkeypatch, losing, config=config), "tracks").advice


def test_a_recording_too_short_to_judge_says_what_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = judged(monkeypatch, replace(GOOD, tracks=0), recording_s=0.0088, exact=True, records=0)
    assert (verdict.grade, verdict.headline) == (Grade.FAIR, "Too short to judge the tracks.")
    assert [(found.about, found.grade, found.text) for found in verdict.lines] == [
        ("exactness", Grade.FAIR, "hardware = model in the owner of every event; no record was there to compare"),
        ("length", Grade.FAIR, "8.8 ms: must be 50 ms with moving objects at least, for tracks to be judged"),
    ]
    assert verdict.lines[1].advice == "record longer: half a second is enough for most scenes"
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


TRUTH = {
    "objects": 8,
    "alive_mean": 3.1,
    "rule": "as it is",
    "scores": {"hardware": {"hota": 0.8, "mt": 6, "ml": 0, "idsw": 1}},
}


def with_truth(hota: float, lost: int = 0) -> dict[str, Any]:
    return TRUTH | {"scores": {"hardware": {"hota": hota, "mt": 6 - lost, "ml": lost, "idsw": 1}}}


@pytest.mark.parametrize(("hota", "grade"), [(0.65, Grade.GOOD), (0.598, Grade.FAIR), (0.4, Grade.FAIR), (0.39, Grade.POOR)])
def test_where_there_is_a_truth_it_decides(monkeypatch: pytest.MonkeyPatch, hota: float, grade: Grade) -> None:
    verdict = judged(monkeypatch, replace(GOOD, short=9, short_merged=9, owned_fraction=0.1), truth=with_truth(hota))
    found = line(verdict, "tracks")
    assert (found.grade, verdict.grade) == (grade, grade)
    assert found.text == (
        f"10 tracks, about 2 at a time for 3.1 objects; HOTA {hota:.3f}: 6 of 8 objects mostly tracked, 0 mostly lost, "
        "1 switch of identity"
    )
    assert line(verdict, "events").grade is Grade.POOR, "but that is no reason to call the tracks poor"
    fault = f"they score HOTA {hota:.3f}."
    assert (fault in verdict.headline) == (grade is not Grade.GOOD)


def test_a_truth_of_objects_that_are_lost_advises_an_easier_birth(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "clust_nev" in line(judged(monkeypatch, GOOD, truth=with_truth(0.5, lost=3)), "tracks").advice
    assert "max_ticks" in line(judged(monkeypatch, replace(GOOD, short_lost=5), truth=with_truth(0.5, lost=2)), "tracks").advice


def test_a_truth_says_nothing_about_a_side_without_scores(monkeypatch: pytest.MonkeyPatch) -> None:
    found = line(judged(monkeypatch, GOOD, GOOD, truth=TRUTH), "tracks", "software")
    assert "10 % are short" in found.text
    assert found.text.startswith("10 tracks, about 2 at a time for 3.1 objects")


@pytest.mark.parametrize(
    ("window_us", "advice"),
    [(0, "`--activity 20`"), (40_000, "`--activity 20`"), (2_500, "`--activity 2.5 --activity-support 2`")],
)
def test_noise_is_filtered_harder_than_it_is(monkeypatch: pytest.MonkeyPatch, window_us: int, advice: str) -> None:
    config = SUMMARY["config"] | {"filters": {"activity_us": window_us}}  # type: ignore[operator]
    assert advice in line(judged(monkeypatch, replace(GOOD, noise_tracks=4), config=config), "noise").advice


@pytest.mark.parametrize(
    ("owned", "isolated", "grade"), [(0.3, 0.1, Grade.GOOD), (0.31, 0.1, Grade.FAIR), (0.9, 0.05, Grade.GOOD)]
)
def test_noise_in_tracks_is_no_longer_good_unless_it_is_rare(
    monkeypatch: pytest.MonkeyPatch, owned: float, isolated: float, grade: Grade
) -> None:
    verdict = judged(monkeypatch, replace(GOOD, isolated_owned_fraction=owned, isolated_fraction=isolated))
    assert line(verdict, "noise").grade is verdict.grade is grade
    assert ("the isolated events enter them" in verdict.headline) == (grade is Grade.FAIR)


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
