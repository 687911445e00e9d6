# SPDX-License-Identifier: Apache-2.0
"""The first difference between hardware and model, and the error that reports it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from evcot.errors import EvcotError

if TYPE_CHECKING:
    from evcot.hardware.config import CotConfig, MotionConfig

__all__ = ["Mismatch", "MismatchError"]


@dataclass(frozen=True)
class Mismatch:
    """The first difference between hardware and model.

    Attributes:
        event_index: the event at which they differ.
        tick: ticks since reset at that event.
        field: what differs: "owner", "rel_x", "rel_y", "visible", "record.<field>", "records" (one side has more) or "stream"
            (the hardware lost, repeated, reordered or changed an event).
        hardware, model: both values.
        seed: seed of the stall patterns, or None.
        config: the run's hardware configuration.
    """

    event_index: int
    tick: int
    field: str
    hardware: int | str | None
    model: int | str | None
    seed: int | None
    config: CotConfig | MotionConfig

    def __str__(self) -> str:
        return (
            f"{self.config.module}: event {self.event_index}, tick {self.tick}: {self.field}: "
            f"hardware has {self.hardware}, model has {self.model}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything that repeats the mismatch, as plain values."""
        return asdict(self)


class MismatchError(EvcotError, AssertionError):
    """Hardware and model differ; `mismatch` is the first difference."""

    def __init__(self, mismatch: Mismatch) -> None:
        super().__init__(str(mismatch))
        self.mismatch = mismatch
