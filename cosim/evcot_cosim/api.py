# SPDX-License-Identifier: Apache-2.0
"""`evcot cosim` as a function, which `import evcot_cosim` offers by name."""

from __future__ import annotations

from pathlib import Path

from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.recognition.weights import Weights
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import run_config

from .lockstep.cosim import CosimRun, run_cosim
from .lockstep.run_file import Source

__all__ = ["cosim"]


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
) -> CosimRun:
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
    return run_cosim(recording, config, stall_seed=stall_seed, source=origin, weights=weights)
