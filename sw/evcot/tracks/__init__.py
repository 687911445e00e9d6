# SPDX-License-Identifier: Apache-2.0
"""What trackers give: the TrackLog, the interface of a tracker, timelines, and two logs compared."""
