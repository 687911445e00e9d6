# SPDX-License-Identifier: Apache-2.0
"""`evcot tune`: settings chosen on some recordings and validated on others."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from evcot.errors import ConfigError
from evcot.outputs import written_aside

from ...sweep.folder import folder_names
from ...sweep.spec import Spec, spec_from
from ...sweep.tune import Tuned, axes_from, default_axes, objective_from, preset_toml, tune
from ...tables import print_table
from .sweep import swept

__all__ = ["run"]


def run(options: argparse.Namespace, arguments: Sequence[str]) -> int:
    """Choose, validate, write the settings; 0."""
    spec = _spec(options)
    folder = Path("build") / "tune" / options.output.stem
    for part in ("choose", "validate"):
        options.claims.write_folder("stores", folder / part, "sweep", folder_names())
    found = tune(spec, options.validate, folder, lambda own, where: swept(options, own, where))
    text = preset_toml(spec, found, shlex.join(["evcot", *arguments]))
    with written_aside(options.output, force=options.force) as file:
        file.write(text.encode())
    if options.json:
        print(json.dumps(found.to_dict() | {"preset": str(options.output), "stores": str(folder)}, indent=2, allow_nan=False))
    elif not options.quiet:
        _print(found)
        print(f"\n{options.output}: for --config; {folder}/ holds the runs, choose and validate")
    if found.warning and not options.json:
        print(f"evcot: warning: {found.warning}", file=sys.stderr)
    return 0


def _spec(options: argparse.Namespace) -> Spec:
    if options.truth and len(options.truth) != len(options.recordings):
        counts = f"{len(options.truth)} for {len(options.recordings)} recordings"
        raise ConfigError(f"--truth: {counts}: must be given once for each, in their order, or not at all")
    recordings = [str(path.absolute()) for path in options.recordings]
    for path in options.recordings:
        if not path.is_file():
            raise ConfigError(f"{path}: is no file: must be a recording")
    truths = [str(path.absolute()) for path in options.truth]
    optional = {"preset": options.preset, "config": str(options.config.absolute()) if options.config else None}
    values = {
        "recordings": recordings, "truth": dict(zip(recordings, truths, strict=True)) if truths else {},
        "rule": _rule(options.rule), "engines": [options.engine],
        "objectives": objective_from(options.objective), **{key: value for key, value in optional.items() if value is not None},
    }  # fmt: skip
    spec = spec_from(values, Path(), options.output.stem)
    axes = axes_from(options.field, options.engine) or default_axes(spec)
    if options.samples < 1 or options.seed < 0:
        raise ConfigError(f"--samples {options.samples}, --seed {options.seed}: must be at least 1 and 0")
    return replace(spec, axes=axes, method=options.method, samples=options.samples, sampling_seed=options.seed)


def _rule(rule: str | None) -> str:
    return "" if rule is None else str(Path(rule).absolute()) if Path(rule).is_file() else rule


def _print(found: Tuned) -> None:
    sign = "best" if found.way == "max" else "least"
    print_table(
        [
            (found.metric, "preset", "chosen", "difference", "recordings"),
            _row("chosen on", found.chosen_before, found.chosen, found.chosen_on),
            _row("validated on", found.validated_before, found.validated, found.validated_on),
        ]
    )
    gap = found.validated - found.chosen
    print(f"\n{sign} of {found.tried} settings; from what it was chosen on to what it has not seen: {gap:+.4f}")
    print("Expect what the validation says: the other figure is flattered by the choice.")
    if found.settings:
        print_table([(name, str(value)) for name, value in found.settings.items()])
    else:
        print("The preset is kept.")


def _row(title: str, before: float, after: float, names: Sequence[str]) -> tuple[str, ...]:
    return title, f"{before:.4f}", f"{after:.4f}", f"{after - before:+.4f}", "; ".join(names)
