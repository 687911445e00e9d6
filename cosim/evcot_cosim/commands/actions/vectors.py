# SPDX-License-Identifier: Apache-2.0
"""`evcot vectors`: stimulus and expected beats of `evcot_top` as hex files, with a bench that checks them."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from evcot.outputs import RUN_FILE, folder_written_aside

from ...lockstep.run_file import write_run_file
from ...vectors import FILES, Vectors
from ..options import window_from
from .job import job_from
from .spinner import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write the folder of vectors; 0."""

    def folder_of(name: str) -> Path:
        return options.output or Path("build") / "vectors" / name

    def claim(name: str) -> None:
        options.claims.write_folder("-o", folder_of(name), "vectors", (RUN_FILE, *FILES))

    with Counting("running the golden model", enabled=not (options.quiet or options.json)):
        job = job_from(options, window_from(options), claim=claim)
        vectors = Vectors.of(job.recording, job.config)
    folder = folder_of(job.name)
    with folder_written_aside(folder, "vectors") as aside:
        for name, text in vectors.files().items():
            (aside / name).write_text(text, encoding="utf-8")
        write_run_file(aside / RUN_FILE, job.run_file)
    job.filters.save_learned()
    counts = {name: len(getattr(vectors, name)) for name in ("events", "accesses", "owned", "passed", "records")}
    if options.json:
        print(json.dumps({"folder": str(folder), "module": vectors.config.module, "parameters": vectors.parameters, **counts}))
    elif not options.quiet:
        print(", ".join(f"{count:,} {name}" for name, count in counts.items()) + f" in {folder}/")
        print(f"check the RTL: cd {folder} && iverilog -g2005 -f rtl.f -s vectors_tb -o tb && vvp tb")
    return 0
