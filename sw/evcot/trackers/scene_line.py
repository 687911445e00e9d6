# SPDX-License-Identifier: Apache-2.0
"""What a tracker has seen of a scene, as a line for people."""

from __future__ import annotations

from ..tracks.tracking import FilteredTracker, Tracker
from .adaptive.estimates import ObservedTracker
from .following import FollowingTracker

__all__ = ["seen_by"]


def seen_by(tracker: Tracker) -> str | None:
    """A line on what a tracker of `ENGINES` has seen so far, filters in front or not; None if it does not tell."""
    if isinstance(tracker, FilteredTracker):
        tracker = tracker.tracker
    if isinstance(tracker, ObservedTracker):
        return str(tracker.estimates())
    return str(tracker) if isinstance(tracker, FollowingTracker) else None
