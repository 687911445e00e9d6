# SPDX-License-Identifier: Apache-2.0
"""Clusters as `vision_msgs/Detection2DArray`."""

from __future__ import annotations

from typing import Any

from vision_msgs.msg import Detection2D, Detection2DArray, ObjectHypothesisWithPose

from evcot_cosim.live.visible_clusters import Clusters

__all__ = ["CLASS_ID", "detections"]

CLASS_ID = "object"  # trackers of events know no classes
_EDGE = 0.5  # vision_msgs counts from the corner of the first pixel, evcot from its middle


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
