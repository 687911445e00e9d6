# SPDX-License-Identifier: Apache-2.0
"""Clusters as `vision_msgs/Detection2DArray`, and as `visualization_msgs/MarkerArray` for RViz."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import Point
from vision_msgs.msg import Detection2D, Detection2DArray, ObjectHypothesisWithPose
from visualization_msgs.msg import Marker, MarkerArray

from evcot.tracks.formats.foxglove import COLOURS
from evcot_cosim.live.visible_clusters import Clusters

__all__ = ["CLASS_ID", "METRES_PER_PX", "detections", "markers"]

CLASS_ID = "object"  # trackers of events know no classes
_EDGE = 0.5  # messages and pictures count from the corner of the first pixel, evcot from its middle


def detections(clusters: Clusters, header: Any) -> Any:
    """A message with one detection a visible cluster: its box in pixels, turned by `theta`, its track id and its confidence.

    Args:
        header: of the message and of every detection in it: the camera's frame, and the time of its newest packet.
    """
    array = Detection2DArray(header=header)
    for state in clusters.states:
        detection = Detection2D(header=header, id=str(int(state["track_id"])))
        box = detection.bbox
        box.center.position.x, box.center.position.y = float(state["x"]) + _EDGE, float(state["y"]) + _EDGE
        box.center.theta = float(state["angle"])
        box.size_x, box.size_y = float(state["width"]), float(state["height"])
        hypothesis = ObjectHypothesisWithPose()
        hypothesis.hypothesis.class_id, hypothesis.hypothesis.score = CLASS_ID, float(state["confidence"])
        detection.results.append(hypothesis)
        array.detections.append(detection)
    return array


METRES_PER_PX = 0.01
"""Size of a pixel in RViz: a sensor of 346 x 260 pixels is 3.46 m wide."""

_LINE_PX, _TEXT_PX = 0.8, 8.0


def markers(clusters: Clusters, header: Any) -> Any:
    """A message that first removes all markers, then draws for each visible cluster an outline, turned by `angle`, and its id.

    The picture lies in the plane z = 0 of the header's frame, x to the right and y down as in an optical frame, with
    `METRES_PER_PX`.

    Args:
        header: of every marker: the camera's frame, and the time of its newest packet.
    """
    array = MarkerArray()
    array.markers.append(Marker(header=header, action=Marker.DELETEALL))
    for state in clusters.states:
        track_id = int(state["track_id"])
        outline = _marker(header, "outline", track_id, Marker.LINE_STRIP)
        outline.scale.x = _LINE_PX * METRES_PER_PX
        outline.points = [_point(*corner) for corner in _corners(state)]
        text = _marker(header, "id", track_id, Marker.TEXT_VIEW_FACING)
        text.scale.z = _TEXT_PX * METRES_PER_PX
        text.text = str(track_id)
        text.pose.position = _point(float(state["x"]), float(state["y"]) - float(state["height"]) / 2 - _TEXT_PX / 2)
        array.markers += [outline, text]
    return array


def _marker(header: Any, name: str, track_id: int, kind: int) -> Any:
    marker = Marker(header=header, ns=name, id=track_id, type=kind, action=Marker.ADD)
    marker.pose.orientation.w = 1.0
    marker.color.r, marker.color.g, marker.color.b = COLOURS[track_id % len(COLOURS)]
    marker.color.a = 1.0
    return marker


def _corners(state: Any) -> list[tuple[float, float]]:
    """The corners of a box in pixels, the first one again at the end."""
    x, y, angle = float(state["x"]), float(state["y"]), float(state["angle"])
    across, down = float(state["width"]) / 2, float(state["height"]) / 2
    cos, sin = math.cos(angle), math.sin(angle)
    offsets = ((-across, -down), (across, -down), (across, down), (-across, down), (-across, -down))
    return [(x + dx * cos - dy * sin, y + dx * sin + dy * cos) for dx, dy in offsets]


def _point(x: float, y: float) -> Any:
    return Point(x=(x + _EDGE) * METRES_PER_PX, y=(y + _EDGE) * METRES_PER_PX, z=0.0)
