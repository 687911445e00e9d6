# SPDX-License-Identifier: Apache-2.0
"""Motion step and activity filter of cot_motion, the same on every recording: docs/defaults.md names the sets.

python benchmarks/noise_filter.py                      # seed sets 1, 2 and 21, on which they were chosen; ten minutes
python benchmarks/noise_filter.py --seed-sets 100 101  # others; recordings that do not depend on the set are left out

The golden model, whole recordings; HOTA, mean over families, and tracks born where nothing is. The noise is that of the whole
recording, as `evcot cosim` estimates it, but in the last row measured while it goes on: the default of `evcot track`.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from evcot.filters.noise import support_against
from evcot.hardware.config import MotionConfig
from evcot.metrics import evaluate
from evcot.trackers.adaptive.estimates import estimate
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES
from evcot.trackers.presets import FOLLOWING
from evcot.tracks.log import Kind, TrackLog
from field import members
from field.member import Member
from registers import CHOSEN_ON, FIXED

_STEPS = (9, 10, 11, 12, 13)  # log2 of us
_JOIN_US, _REPORT_US = 10_240, 4_096  # times that are counted in steps
_WITHIN_MS = (10, 20, 30, 40, 60, 80)
_PASSING_HZ = (0.015, 0.03, 0.06, 0.12)
_FOLLOWS = "measured while the recording goes on"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed-sets", type=int, nargs="+", default=[CHOSEN_ON, 2, 21], help="of the field (default 1 2 21)")
    scores: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    born: dict[str, int] = defaultdict(int)
    for seed_set in parser.parse_args().seed_sets:
        for member in members(seed_set):
            if seed_set != CHOSEN_ON and member.family in FIXED:
                continue
            for name, config in _variants(member):
                log = _tracked(config, member)
                if member.empty:
                    born[name] += int(np.count_nonzero(log.records["kind"] == Kind.BORN))
                else:
                    scores[name][member.family].append(evaluate(log, member.truth, member.rule).hota or 0.0)
    print("| | HOTA | born of noise |\n|---|---|---|")
    for name, families in scores.items():
        print(f"| {name} | {np.mean([np.mean(of) for of in families.values()]):.3f} | {born[name]} |")
    return 0


def _variants(member: Member) -> Iterator[tuple[str, RunConfig]]:
    """The configurations to be compared, with their names."""
    recording = member.recording
    seen = estimate([recording.events], (recording.width, recording.height))
    assert isinstance(FOLLOWING.hardware, MotionConfig)
    hardware, follow = FOLLOWING.hardware, FOLLOWING.filters
    motion = hardware.registers

    def held(within_us: int, passing_hz: float, step_log2: int = motion.step_log2) -> RunConfig:
        support = support_against(seen.noise_hz or 0.0, within_us, passing_hz)
        filters = replace(follow, hot_pixels=seen.hot_pixels, activity_noise_hz=0.0, activity_us=within_us if support else 0)
        changed = replace(
            motion,
            step_log2=step_log2,
            friction=motion.friction + motion.step_log2 - step_log2,
            join_steps=max(1, round(_JOIN_US / 2**step_log2)),
            report_steps=max(1, round(_REPORT_US / 2**step_log2)),
        )
        filters = replace(filters, activity_support=max(support, 1))
        return replace(FOLLOWING, hardware=replace(hardware, registers=changed), filters=filters)

    for step_log2 in _STEPS:
        yield f"motion step of {2**step_log2 / 1e3:.2g} ms", held(follow.activity_us, follow.activity_noise_hz, step_log2)
    for within_ms in _WITHIN_MS:
        yield f"filter of {within_ms} ms", held(1_000 * within_ms, follow.activity_noise_hz)
    for passing_hz in _PASSING_HZ:
        yield f"{passing_hz:g} Hz of noise pass", held(follow.activity_us, passing_hz)
    yield _FOLLOWS, FOLLOWING


def _tracked(config: RunConfig, member: Member) -> TrackLog:
    recording = member.recording
    tracker = ENGINES["cot_motion"].start(config, config.filters, (recording.width, recording.height))
    records = np.concatenate([tracker.feed(recording.events)[0], tracker.finish()])
    return TrackLog(config.name, records, np.empty(0, np.int16))


if __name__ == "__main__":
    sys.exit(main())
