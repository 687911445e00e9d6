# SPDX-License-Identifier: Apache-2.0
"""Try every tracker on the field of tests, on draws of it: tables, a picture, and all scores in build/field.

python benchmarks/field_of_tests.py                       # every preset of every tracker on every member
python benchmarks/field_of_tests.py --quick               # one member a family
python benchmarks/field_of_tests.py --trackers cot_motion --keep before.json     # before a change of the tracker
python benchmarks/field_of_tests.py --trackers cot_motion --against before.json  # after it: paired differences and errors
python benchmarks/field_of_tests.py --vary activity_us=20000 n_slots=32           # the default with other settings, paired
python benchmarks/field_of_tests.py --trackers oracle     # true identity, extents of events
python benchmarks/field_of_tests.py --leave-out 12        # with 12 more settings each: leave one family out
python benchmarks/field_of_tests.py --leave-out 12 --final 7012   # choose on the seed set, score on one that was never used
python benchmarks/field_of_tests.py --references          # paths of pendulum and hand, with pictures to look at

A figure is a mean over families, their members, and draws of each member, in which a tenth of the events is lost; its error is
that of the draws.
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
from field.contenders import Contender, contenders, more_settings, oracle_log, varied_default
from field.draws import FIXED, LOST, drawn
from field.member import FOLDER
from field.peers import remot_log
from field.recorded import RECORDED, reference_of
from field.reference import REFERENCE
from field.scoring import prepared, score, score_log
from field.table import (
    Choice,
    Scored,
    by_family,
    left_out,
    picture,
    print_differences,
    print_families,
    print_members,
    print_table,
)
from field.traffic import traffic

_FINALS = FOLDER / "finals.json"  # which seed sets have been used for a last table
_ORACLE, _REMOT = "oracle", "remot"  # not trackers that could be started on any recording


def main() -> int:
    """Measure, print, draw; 2 for arguments that cannot be."""
    options = _options()
    if options.references:
        _references()
        return 0
    try:
        chosen = _contenders(options)
        sources = {entry.source for _, entry in _field(options, options.seed_set)}
        if not sources:
            if options.members:
                raise ConfigError(f"--members {' '.join(options.members)}: no member has this name")
            raise ConfigError(f"--families {' '.join(options.families)}: no family begins so")
        if options.leave_out is not None and len(sources) < 2:
            raise ConfigError(f"--leave-out {options.leave_out}: must have families of two sources at least")
        before = None if options.against is None else _kept(options.against)
        if options.draws < 0:
            raise ConfigError(f"--draws {options.draws}: must be at least 0")
        if options.keep is not None and options.keep.exists():
            raise ConfigError(f"--keep {options.keep}: must be a file that does not exist yet")
        if options.final is not None:
            _use_once(options.final, options.seed_set)
    except ConfigError as error:
        print(error, file=sys.stderr)
        return 2
    sets = options.seed_set if options.final is None else [options.final]
    if options.draws:
        print(f"{100 * LOST:g} % of the events are lost; seeds (S, 11, D): S = {sets}, D = {list(_draws(options))}\n")
    results = _presets(chosen, options) if options.leave_out is None else _left_out(chosen, options)
    _compare([Scored.from_dict(one) for one in results["scores"]], before, options)
    results |= {"arguments": sys.argv[1:], "seed_set": options.seed_set, "final": options.final, "when": time.strftime("%F %T")}
    path = options.keep or FOLDER / ("left_out.json" if options.leave_out is not None else "field.json")
    _write(path, results)
    print(f"\n{path}")
    return 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--quick", action="store_true", help="one member a family")
    add("--seed-set", type=int, nargs="+", default=[1], metavar="N", help="of everything drawn in the field (default 1)")
    add("--trackers", nargs="+", metavar="NAME", help="which trackers (default: all that are installed)")
    add("--vary", nargs="+", default=[], metavar="NAME=VALUE,…", help="the default tracker with registers or filters changed")
    add("--families", nargs="+", metavar="WORD", help="only families whose name begins so")
    add("--members", nargs="*", metavar="NAME", help="only members of these names; a line each, with its minimum over draws")
    add("--draws", type=int, default=5, metavar="N", help="of each member (default 5); 0: the members with all their events")
    add("--first-draw", type=int, default=0, metavar="N", help="others than those on which a change was selected")
    add("--timed", action="store_true", help="HOTA when answered, too: events come in packets")
    add("--keep", type=Path, metavar="JSON", help="where the scores are kept (default: in build/field)")
    add("--against", type=Path, metavar="JSON", help="scores kept before: paired differences")
    add("--leave-out", type=int, metavar="N", help="leave one family out; with N more settings at random each")
    add("--search-members", type=int, default=2, metavar="N", help="of a family, to choose settings on (2)")
    add("--jobs", type=int, default=1, metavar="N", help="processes (default 1)")
    add("--final", type=int, metavar="SEED", help="a seed set that was never used: for the last table")
    add("--references", action="store_true", help="write reference paths and pictures of them")
    return parser.parse_args()


def _contenders(options: argparse.Namespace) -> list[Contender]:
    """Those that are asked for; the default tracker alone if its settings are varied."""
    if options.vary:
        return [varied_default(options.vary)]
    chosen = contenders(options.trackers)
    if not chosen and not {_ORACLE, _REMOT} & set(options.trackers):
        names = ", ".join((*(one.name for one in contenders()), _ORACLE, _REMOT))
        raise ConfigError(f"--trackers {' '.join(options.trackers)}: must be some of {names}")
    return chosen


def _kept(path: Path) -> list[Scored]:
    """The scores of an earlier run."""
    try:
        return [Scored.from_dict(one) for one in json.loads(path.read_text(encoding="utf-8"))["scores"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ConfigError(f"--against {path}: must be a file that --keep wrote: {error}") from error


def _use_once(seed_set: int, chosen_on: Sequence[int]) -> None:
    """Note that a seed set has been used for a last table; it must not have been used before."""
    used: list[int] = json.loads(_FINALS.read_text(encoding="utf-8")) if _FINALS.is_file() else []
    if seed_set in (*used, *chosen_on):
        raise ConfigError(f"--final {seed_set}: must be a seed set that was not used before")
    _write(_FINALS, sorted([*used, seed_set]))


def _draws(options: argparse.Namespace) -> Sequence[int | None]:
    return range(options.first_draw, options.first_draw + options.draws) if options.draws else [None]


def _field(options: argparse.Namespace, seed_sets: Sequence[int], per_family: int | None = None) -> list[tuple[int, Entry]]:
    """The chosen families, with their seed sets; of each the first members alone, if so many are given."""
    begins = tuple(options.families or [""])
    seen: Counter[str] = Counter()
    chosen = []
    for seed_set in dict.fromkeys(seed_sets):
        for entry in entries(seed_set, options.quick):
            repeated = seed_set != seed_sets[0] and entry.family in FIXED
            if repeated or not entry.family.startswith(begins) or (options.members and entry.name not in options.members):
                continue
            seen[entry.family] += 1
            if per_family is None or seen[entry.family] <= per_family:
                chosen.append((seed_set, entry))
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
    """Contenders with settings on draws of one member, as another process can be told it."""

    seed_set: int
    quick: bool
    family: str
    member: str
    settings: Mapping[str, Mapping[str, Any]]  # contender -> title in the table -> settings
    draws: Sequence[int | None]
    timed: bool = False


def _task(place: tuple[int, Entry], settings: Mapping[str, Mapping[str, Any]], options: argparse.Namespace) -> _Task:
    seed_set, entry = place
    return _Task(seed_set, options.quick, entry.family, entry.name, settings, _draws(options), options.timed)


def _done(task: _Task) -> list[Scored]:
    scored = []
    same = (task.family, task.member)
    for member in _built(entry for entry in entries(task.seed_set, task.quick) if (entry.family, entry.name) == same):
        begun_s = time.perf_counter()
        for draw in task.draws:
            less = drawn(member, task.seed_set, draw)
            where = task.seed_set, member.family, member.name, draw
            for contender in contenders(list(task.settings)):
                seen = prepared(contender, less)
                for title, settings in task.settings[contender.name].items():
                    scored.append(Scored(contender.name, title, *where, score(contender, settings, seen, task.timed)))
            if _ORACLE in task.settings and not member.empty:
                scored.append(Scored(_ORACLE, "extents of events", *where, score_log(oracle_log(less), less)))
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


def _asked(name: str, options: argparse.Namespace) -> bool:
    """Whether a row beside those of trackers is asked for."""
    return name in options.trackers if options.trackers else not options.vary


def _presets(chosen: Sequence[Contender], options: argparse.Namespace) -> dict[str, Any]:
    """Every preset of every contender."""
    every: dict[str, Mapping[str, Any]] = {one.name: one.settings for one in chosen}
    if _asked(_ORACLE, options):
        every[_ORACLE] = {}
    sets = options.seed_set if options.final is None else [options.final]
    tasks = [_task(place, every, options) for place in _field(options, sets)]
    scored = _scored(tasks, options.jobs) + _remot(options)
    _print(scored, options, "HOTA (centres), mean over the members of a family", "field.png")
    return {"scores": [one.to_dict() for one in scored]}


def _print(scored: Sequence[Scored], options: argparse.Namespace, title: str, name: str) -> None:
    rows = _rows(scored)
    print_table(rows)
    print()
    families = {row: by_family(own, "hota") for row, own in rows.items() if not row.startswith(_REMOT)}
    print_families(families, options.seed_set if options.final is None else [options.final])
    if options.members is not None:
        print()
        print_members(rows)
    if any(families.values()):
        picture(families, title, FOLDER / name)


def _rows(scored: Iterable[Scored]) -> dict[str, list[Scored]]:
    rows: dict[str, list[Scored]] = {}
    for one in scored:
        rows.setdefault(one.title, []).append(one)
    return rows


def _compare(scored: Sequence[Scored], before: Sequence[Scored] | None, options: argparse.Namespace) -> None:
    """Each row with that of the same title in an earlier run, or with its only one; varied settings with the default's."""
    now = _rows(scored)
    if before is not None:
        then = _rows(before)
        only = next(iter(then.values())) if len(then) == 1 else []
        pairs = {title: (own, then.get(title, only)) for title, own in now.items()}
    elif options.vary:
        first, *others = now
        pairs = {title: (now[title], now[first]) for title in others}
    else:
        return
    print()
    print_differences(pairs)


def _left_out(chosen: Sequence[Contender], options: argparse.Namespace) -> dict[str, Any]:
    """Each contender's settings chosen on the other families; with `final`, scored on members never seen before."""
    field = _field(options, options.seed_set, options.search_members)
    sources = {entry.family: entry.source for _, entry in field}
    choices: dict[str, list[Choice]] = {}
    random = np.random.default_rng((options.seed_set[0], 9))
    many = {one.name: more_settings(one, options.leave_out, random) for one in chosen}
    every = _scored([replace(_task(place, many, options), draws=[None], timed=False) for place in field], options.jobs)
    for one in chosen:
        own = [each for each in every if each.contender == one.name]
        choices[one.name] = left_out(own, sources, list(one.settings))
    if options.final is not None:
        print(f"chosen on seed set {options.seed_set}, scored on {options.final}\n")
    last = _last(chosen, many, choices, options) + _remot(options)
    _print(last, options, "HOTA (centres) of families left out, beside each family's best preset", "left_out.png")
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
    for place in _field(options, options.seed_set if options.final is None else [options.final]):
        settings: dict[str, dict[str, Any]] = {_ORACLE: {}} if _asked(_ORACLE, options) else {}
        for one in chosen:
            choice = picked[one.name].get(place[1].family)
            if choice is None:
                continue  # absent when it was chosen
            names = {"left out": choice.settings, "best preset": choice.preset}
            if len(many[one.name]) == 1:  # nothing to choose
                names = {"as it is": choice.settings}
            settings[one.name] = {title: many[one.name][name] for title, name in names.items()}
        tasks.append(_task(place, settings, options))
    return _scored(tasks, options.jobs)


def _remot(options: argparse.Namespace) -> list[Scored]:
    """REMOT's published output, on the one recording that it is of."""
    if not _asked(_REMOT, options):
        return []
    try:
        member = traffic()
        member = replace(member, rule=replace(member.rule, max_age_us=0))  # it says in each frame what is there
        logs = {f"frames moved by {later}": remot_log(member.truth.instants_us, later) for later in (0, -1, -2)}
    except Absent as reason:
        print(f"REMOT: left out: {reason}", file=sys.stderr)
        return []
    where = 1, member.family, member.name, None
    return [Scored(_REMOT, name, *where, score_log(log, member)) for name, log in logs.items()]


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
