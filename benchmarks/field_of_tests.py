# SPDX-License-Identifier: Apache-2.0
"""Try every tracker on the field of tests: a table, a picture, and all scores in build/field.

python benchmarks/field_of_tests.py                       # every preset of every tracker on every member
python benchmarks/field_of_tests.py --quick               # one member a family
python benchmarks/field_of_tests.py --leave-out 12        # with 12 more settings each: leave one family out
python benchmarks/field_of_tests.py --leave-out 12 --final 7012   # choose on the seed set, score on one that was never used
python benchmarks/field_of_tests.py --references          # paths of pendulum and hand, with pictures to look at
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from evcot.errors import ConfigError
from evcot.outputs import written_aside
from field import Absent, Entry, Member, entries
from field.choose import Choice, left_out
from field.contenders import Contender, contenders, more_settings
from field.kept import FOLDER
from field.peers import remot_log
from field.recorded import RECORDED, reference_of
from field.reference import REFERENCE
from field.scoring import prepared, score, score_log
from field.table import Scored, by_family, draw, print_families, print_table
from field.traffic import traffic

_FINALS = FOLDER / "finals.json"  # which seed sets have been used for a last table


def main() -> int:
    """Measure, print, draw; 2 for arguments that cannot be."""
    options = _options()
    if options.references:
        _references()
        return 0
    try:
        chosen = contenders(options.trackers)
        if not chosen:
            names = ", ".join(one.name for one in contenders())
            raise ConfigError(f"--trackers {' '.join(options.trackers)}: must be some of {names}")
        sources = {entry.source for entry in _field(options, options.seed_set)}
        if not sources:
            raise ConfigError(f"--families {' '.join(options.families)}: no family begins so")
        if options.leave_out is not None and len(sources) < 2:
            raise ConfigError(f"--leave-out {options.leave_out}: must have families of two sources at least")
        if options.final is not None:
            _use_once(options.final, options.seed_set)
        results = _presets(chosen, options) if options.leave_out is None else _left_out(chosen, options)
    except ConfigError as error:
        print(error, file=sys.stderr)
        return 2
    results |= {"arguments": sys.argv[1:], "seed_set": options.seed_set, "final": options.final, "when": time.strftime("%F %T")}
    path = FOLDER / ("left_out.json" if options.leave_out is not None else "field.json")
    _write(path, results)
    print(f"\n{path}")
    return 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one member a family")
    parser.add_argument("--seed-set", type=int, default=1, help="of everything drawn in the field (default 1)")
    parser.add_argument("--trackers", nargs="+", metavar="NAME", help="which trackers (default: all that are installed)")
    parser.add_argument("--families", nargs="+", metavar="WORD", help="only families whose name begins so")
    parser.add_argument("--leave-out", type=int, metavar="N", help="leave one family out; with N more settings at random each")
    parser.add_argument("--search-members", type=int, default=2, metavar="N", help="of a family, to choose settings on (2)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes (default 1)")
    parser.add_argument("--final", type=int, metavar="SEED", help="a seed set that was never used: for the last table")
    parser.add_argument("--references", action="store_true", help="write reference paths and pictures of them")
    return parser.parse_args()


def _use_once(seed_set: int, chosen_on: int) -> None:
    """Note that a seed set has been used for a last table; it must not have been used before."""
    used: list[int] = json.loads(_FINALS.read_text(encoding="utf-8")) if _FINALS.is_file() else []
    if seed_set in used or seed_set == chosen_on:
        raise ConfigError(f"--final {seed_set}: must be a seed set that was not used before")
    _write(_FINALS, sorted([*used, seed_set]))


def _field(options: argparse.Namespace, seed_set: int, per_family: int | None = None) -> list[Entry]:
    """The chosen families; of each the first members alone, if so many are given."""
    begins = tuple(options.families or [""])
    field = [entry for entry in entries(seed_set, options.quick) if entry.family.startswith(begins)]
    seen: Counter[str] = Counter()
    chosen = []
    for entry in field:
        seen[entry.family] += 1
        if per_family is None or seen[entry.family] <= per_family:
            chosen.append(entry)
    return chosen


def _built(field: Iterable[Entry]) -> Iterator[Member]:
    """The members, one after the other; says what is left out."""
    for entry in field:
        try:
            member = entry.build()
        except Absent as reason:
            print(f"{entry.family}, {entry.name}: left out: {reason}", file=sys.stderr)
            continue
        yield member


@dataclass(frozen=True)
class _Task:
    """Contenders with settings on one member, as another process can be told it."""

    seed_set: int
    quick: bool
    family: str
    member: str
    settings: Mapping[str, Mapping[str, Any]]  # contender -> title in the table -> settings
    whole: bool


def _done(task: _Task) -> list[Scored]:
    scored = []
    same = (task.family, task.member)
    for member in _built(entry for entry in entries(task.seed_set, task.quick) if (entry.family, entry.name) == same):
        begun_s = time.perf_counter()
        for contender in contenders(list(task.settings)):
            seen = prepared(contender, member)
            for title, settings in task.settings[contender.name].items():
                result = score(contender, settings, seen, task.whole)
                scored.append(Scored(contender.name, title, member.family, member.name, result))
        took_s = time.perf_counter() - begun_s
        events = len(member.recording.events)
        print(f"{member.family}, {member.name}: {events:,} events, {took_s:.1f} s", file=sys.stderr, flush=True)
    return scored


def _scored(tasks: Sequence[_Task], jobs: int) -> list[Scored]:
    """All scores, member by member, in `jobs` processes."""
    if jobs == 1:
        return [one for task in tasks for one in _done(task)]
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        return [one for own in pool.map(_done, tasks) for one in own]


def _presets(chosen: Sequence[Contender], options: argparse.Namespace) -> dict[str, Any]:
    """Every preset of every contender."""
    field = _field(options, options.seed_set if options.final is None else options.final)
    every = {one.name: one.settings for one in chosen}
    tasks = [_Task(*_place(entry, options, options.final), every, False) for entry in field]
    scored = _scored(tasks, options.jobs) + _remot(options)
    rows: dict[str, list[Scored]] = {}
    for one in scored:
        rows.setdefault(f"{one.contender} {one.settings}", []).append(one)
    print_table(rows)
    print()
    hota = {title: by_family(own, "hota") for title, own in rows.items() if not title.startswith("REMOT")}
    print_families(hota)
    draw(hota, "HOTA (centres), mean over the members of a family", FOLDER / "field.png")
    return {"scores": [one.to_dict() for one in scored]}


def _left_out(chosen: Sequence[Contender], options: argparse.Namespace) -> dict[str, Any]:
    """Each contender's settings chosen on the other families; with `final`, scored on members never seen before."""
    field = _field(options, options.seed_set, options.search_members)
    sources = {entry.family: entry.source for entry in field}
    choices: dict[str, list[Choice]] = {}
    many = {one.name: more_settings(one, options.leave_out, np.random.default_rng((options.seed_set, 9))) for one in chosen}
    every = _scored([_Task(*_place(entry, options, None), many, True) for entry in field], options.jobs)
    for one in chosen:
        own = [each for each in every if each.contender == one.name]
        choices[one.name] = left_out(own, sources, list(one.settings))
    if options.final is not None:
        print(f"chosen on seed set {options.seed_set}, scored on {options.final}\n")
    last = _last(chosen, many, choices, options) + _remot(options)
    rows: dict[str, list[Scored]] = {}
    for scored in last:
        rows.setdefault(f"{scored.contender}, {scored.settings}", []).append(scored)
    print_table(rows)
    print()
    families = {name: by_family(own, "hota") for name, own in rows.items() if not name.startswith("REMOT")}
    print_families(families)
    draw(families, "HOTA (centres) of families left out, beside each family's best preset", FOLDER / "left_out.png")
    return {
        "choices": {name: [asdict(choice) for choice in own] for name, own in choices.items()},
        "settings": {one.name: {name: repr(settings) for name, settings in many[one.name].items()} for one in chosen},
        "scores": [one.to_dict() for one in last],
        "search": [one.to_dict() for one in every],
    }


def _last(
    chosen: Sequence[Contender],
    many: Mapping[str, Mapping[str, Any]],
    choices: Mapping[str, Sequence[Choice]],
    options: argparse.Namespace,
) -> list[Scored]:
    """All figures of what was chosen for each family without it, and of the family's best preset beside it."""
    picked = {name: {choice.family: choice for choice in own} for name, own in choices.items()}
    tasks = []
    for entry in _field(options, options.seed_set if options.final is None else options.final):
        settings: dict[str, dict[str, Any]] = {}
        for one in chosen:
            choice = picked[one.name].get(entry.family)
            if choice is None:
                continue  # absent when it was chosen
            names = {"left out": choice.settings, "best preset": choice.preset}
            if len(many[one.name]) == 1:  # nothing to choose
                names = {"as it is": choice.settings}
            settings[one.name] = {title: many[one.name][name] for title, name in names.items()}
        tasks.append(_Task(*_place(entry, options, options.final), settings, False))
    return _scored(tasks, options.jobs)


def _place(entry: Entry, options: argparse.Namespace, final: int | None) -> tuple[int, bool, str, str]:
    return options.seed_set if final is None else final, options.quick, entry.family, entry.name


def _remot(options: argparse.Namespace) -> list[Scored]:
    """REMOT's published output, on the one recording that it is of."""
    if options.trackers is not None and "remot" not in options.trackers:
        return []
    try:
        member = traffic()
        member = replace(member, rule=replace(member.rule, max_age_us=0))  # it says in each frame what is there
        logs = {f"frames moved by {later}": remot_log(member.truth.instants_us, later) for later in (0, -1, -2)}
    except Absent as reason:
        print(f"REMOT: left out: {reason}", file=sys.stderr)
        return []
    return [Scored("REMOT", name, member.family, member.name, score_log(log, member)) for name, log in logs.items()]


def _references() -> None:
    """CSV files and pictures of the reference paths."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from field.recorded import recorded

    for name in RECORDED:
        try:
            found, recording = reference_of(name), recorded(name)
        except Absent as reason:
            print(f"{name}: left out: {reason}", file=sys.stderr)
            continue
        path, events = found.path, recording.events
        table = FOLDER / f"{name}_reference.csv"
        table.parent.mkdir(parents=True, exist_ok=True)
        with written_aside(table, force=True) as file:
            rows = np.array([tuple(row) for row in path.tolist()])
            np.savetxt(file, rows, ["%d", *["%.2f"] * 4, "%d", "%d"], ",", header=",".join(REFERENCE.names or ()), comments="")
        figure, axes = plt.subplots(2, 1, figsize=(16, 8), sharex=True, layout="constrained")
        some = slice(None, None, max(1, len(events) // 200_000))
        seconds, at_s = (events.t_us[some] - events.t_us[0]) * 1e-6, (path["t_us"] - events.t_us[0]) * 1e-6
        there = path["state"] > 0
        for axis, coordinate, size, column in zip(axes, "xy", ("width", "height"), (events.x, events.y), strict=True):
            axis.plot(seconds, column[some], ",", color="0.6")
            middle, half = np.where(there, path[coordinate], np.nan), path[size] / 2
            axis.plot(at_s, middle, color="tab:red", lw=1)
            axis.fill_between(at_s, middle - half, middle + half, color="tab:red", alpha=0.2, lw=0)
            axis.set_ylabel(f"{coordinate}, px")
        axes[0].set_title(f"{name}: {found.error}")
        axes[1].set_xlabel("s")
        picture = FOLDER / f"{name}_reference.png"
        figure.savefig(picture, dpi=80)
        plt.close(figure)
        print(f"{name}: {found.error}\n{table}\n{picture}")


def _write(path: Path, values: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with written_aside(path, force=True) as file:
        file.write((json.dumps(values, indent=1) + "\n").encode())


if __name__ == "__main__":
    sys.exit(main())
