# SPDX-License-Identifier: Apache-2.0
"""The node `track`: events of a camera in, tracks out, at a steady rate."""

from __future__ import annotations

import sys
from typing import Any

import rclpy
from event_camera_msgs.msg import EventPacket
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from vision_msgs.msg import Detection2DArray
from visualization_msgs.msg import MarkerArray

from evcot.errors import EvcotError
from evcot.recordings.formats.source import Sensor
from evcot.trackers.engines import DEFAULT, ENGINES
from evcot.trackers.settings import engine_settings
from evcot.tracks.tracking import Tracker
from evcot_cosim.live.session import Session
from evcot_cosim.live.tracker_thread import warm_up

from .messages import detections, markers
from .topic import TopicSource

__all__ = ["TrackNode", "main"]

_QUEUE = 10  # messages of tracks that a slow subscriber may be behind
_SAY_S = 10.0  # between two lines of figures


class TrackNode(Node):  # type: ignore[misc, unused-ignore]
    """Subscribes to `events` (event_camera_msgs/EventPacket), publishes `tracks` (vision_msgs/Detection2DArray) and, while
    somebody subscribes to them, `markers` (visualization_msgs/MarkerArray) for RViz.

    Parameters: `engine` (that of `evcot track`), `preset` (the engine's default), `rate_hz` (50) of the messages.

    Raises:
        EvcotError: from callbacks, an engine or preset that is none, an unknown encoding, or damaged events.
    """

    def __init__(self) -> None:
        super().__init__("evcot")
        self._engine = str(self.declare_parameter("engine", DEFAULT).value)
        self._preset = str(self.declare_parameter("preset", "").value) or None
        rate_hz = float(self.declare_parameter("rate_hz", 50.0).value)
        self._session: Session | None = None
        self._source: TopicSource | None = None
        self._header: Any = None
        self._tracks = self.create_publisher(Detection2DArray, "tracks", _QUEUE)
        self._markers = self.create_publisher(MarkerArray, "markers", _QUEUE)
        self.create_subscription(EventPacket, "events", self.on_packet, qos_profile_sensor_data)
        self.create_timer(1.0 / rate_hz, self.on_time)
        self.create_timer(_SAY_S, self.on_figures)

    def on_packet(self, message: Any) -> None:
        """Hand a packet to the session; the first one starts it."""
        if self._session is None or self._source is None:
            self._source = TopicSource("events", message)
            self._session = Session(self._source, self._ready_tracker(self._source.sensor))
            self._session.start()
        self._header = message.header
        self._source.put(message)

    def on_time(self) -> None:
        """Publish the visible clusters."""
        if self._session is None:
            return
        if self._session.failed:
            self._session.stop()
        clusters = self._session.clusters
        self._tracks.publish(detections(clusters, self._header))
        if self._markers.get_subscription_count():
            self._markers.publish(markers(clusters, self._header))

    def on_figures(self) -> None:
        """Say how it goes."""
        if self._session is None or self._source is None:
            return
        figures = self._session.figures()
        lost = figures["dropped"] + figures["left_out"] + sum(self._source.dropped.values())
        said = f"{figures['events_per_s'] / 1e6:.3f} M events/s, {figures['clusters']} objects, {figures['tracks']} tracks"
        self.get_logger().info(f"{said}, {lost} events and {self._source.missed} packets given up")

    def destroy_node(self) -> None:
        """End the session, then the node."""
        session, self._session = self._session, None
        if session is not None and not session.failed:
            session.stop()
        super().destroy_node()

    def _ready_tracker(self, sensor: Sensor) -> Tracker:
        """A tracker for the sensor, with everything compiled, which takes seconds the first time."""
        settings, filters = engine_settings(self._engine, sensor, self._preset)
        start = ENGINES[self._engine].start
        warm_up(start(settings, filters, sensor), sensor)
        self.get_logger().info(f"tracking with {self._engine} on {sensor[0]}x{sensor[1]} pixels")
        return start(settings, filters, sensor)


def main() -> None:
    """`ros2 run evcot_ros track`; exit code 2 for what the user can mend."""
    rclpy.init()
    node = TrackNode()
    code = 0
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    except EvcotError as error:
        print(f"evcot_ros: {error}", file=sys.stderr)
        code = 2
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    sys.exit(code)
