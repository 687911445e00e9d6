# SPDX-License-Identifier: Apache-2.0
"""`evcot cosim` as a function, which `import evcot_cosim` offers by name."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.page import EVENTS_MAX, HEIGHT_PX, Page
from evcot.recognition.weights import Weights
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import run_config

from .lockstep.cosim import CosimRun, run_cosim
from .lockstep.run_file import Source
from .notebook import run_page
from .report.artifacts import save_run

__all__ = ["Run", "cosim"]


@dataclass(frozen=True, repr=False, kw_only=True)
class Run(CosimRun):
    """A run that can be saved and shown; `evcot_cosim.CosimRun`."""

    def show(self, *, events_max: int = EVENTS_MAX, height_px: int = HEIGHT_PX) -> Page:
        """The page of `evcot report` for a notebook, without the waveform.

        Args:
            events_max: most events in the page, which are spread evenly over the recording.
            height_px: height of the frame in the notebook.

        Raises:
            ConfigError: a value outside its range.
        """
        return run_page(self, events_max, height_px)

    def _repr_html_(self) -> str:
        """The run in a notebook: the page that `show` makes."""
        return self.show()._repr_html_()

    def save(self, folder: Path | str, *, waves: bool = True) -> dict[str, Any]:
        """Write what `evcot cosim -o FOLDER` writes, and return the summary; a recording made in memory is written, too.

        Files of an older run in the folder are replaced; other files are kept.

        Args:
            waves: whether to write a waveform, around the first merge, else around the first birth.

        Raises:
            OutputError: the folder is another command's, or a file cannot be written.
        """
        return save_run(self, Path(folder), waves=waves)


def cosim(
    source: Recording | Path | str,
    /,
    config: RunConfig | None = None,
    *,
    preset: str | None = None,
    hardware: str | None = None,
    slots: int | None = None,
    stall_seed: int | None = None,
    classify: Path | str | None = None,
) -> Run:
    """Run hardware, golden model and software tracker over a recording, as `evcot cosim` does.

    Example:
        run = evcot_cosim.cosim("drive.aedat4")
        run.agreement.tracks_paired
        run.save("build/drive")  # report.html, logs, waveform, run.toml

    Args:
        source: a recording in memory, a file, which is read into memory, or the name of a scene.
        config: both trackers' configurations, as `evcot.run_config` returns them; None: as the command, by the next three.
        preset: one of `evcot presets`; None: the default, `motion`.
        hardware: module, one of `evcot.MODULES`; None: the preset's. Without preset, other modules than cot_motion take the one
            for the sensor.
        slots: number of tracker slots; None: the preset's.
        stall_seed: seed of random stalls on every stream of the hardware; None never stalls.
        classify: weights that `evcot train` wrote; the logs of hardware and model then have verdicts.

    Raises:
        MismatchError: hardware and model differ.
        ConfigError, RecordingError, ToolchainError.
    """
    if isinstance(source, Recording):
        recording, origin = source, None
    else:
        origin = Source.named(str(source))
        recording = origin.read()
    if config is None:
        config = run_config(recording.width, recording.height, preset, slots, hardware=hardware)
    elif preset is not None or hardware is not None or slots is not None:
        raise ConfigError("config: must not be given with preset, hardware or slots")
    weights = None if classify is None else Weights.load(classify)
    run = run_cosim(recording, config, stall_seed=stall_seed, source=origin, weights=weights)
    return Run(**{field.name: getattr(run, field.name) for field in fields(run)})
