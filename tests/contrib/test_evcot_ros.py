# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 node: packets in, detections out.

With ROS where it is installed, else with a thin fake; the tests' names say which.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import evcot
from evcot.errors import ConfigError, RecordingError
from evcot.events import Events
from evcot.scenes.registry import simulate_scene
from evcot.trackers.engines import DEFAULT, ENGINES
from evcot.trackers.settings import engine_settings
from evcot_cosim.live.visible_clusters import Alive

PACKAGE = Path(__file__).parents[2] / "contrib" / "evcot_ros"
NEEDED = ("rclpy", "event_camera_msgs", "vision_msgs", "geometry_msgs", "visualization_msgs")
HAS_ROS = all(importlib.util.find_spec(name) is not None for name in NEEDED)


class FakeNode:
    """What the node uses of rclpy.node.Node: it keeps what is made, and nothing runs by itself."""

    parameters: dict[str, Any] = {}  # noqa: RUF012
    subscribers = 0  # of each topic that is published

    def __init__(self, name: str) -> None:
        self.name = name
        self.published: dict[str, list[Any]] = {}
        self.subscribed: dict[str, Any] = {}
        self.timers: list[tuple[float, Any]] = []
        self.said: list[str] = []

    def declare_parameter(self, name: str, default: Any) -> SimpleNamespace:
        return SimpleNamespace(value=self.parameters.get(name, default))

    def create_publisher(self, _kind: type, topic: str, _depth: int) -> SimpleNamespace:
        return SimpleNamespace(
            publish=self.published.setdefault(topic, []).append, get_subscription_count=lambda: self.subscribers
        )

    def create_subscription(self, _kind: type, topic: str, callback: Any, _profile: Any) -> None:
        self.subscribed[topic] = callback

    def create_timer(self, period_s: float, callback: Any) -> None:
        self.timers.append((period_s, callback))

    def get_logger(self) -> SimpleNamespace:
        return SimpleNamespace(info=self.said.append)

    def destroy_node(self) -> None:
        self.name = "destroyed"


class Detection2D:
    """Fields of vision_msgs 4."""

    def __init__(self, header: Any, id: str) -> None:
        self.header, self.id, self.results = header, id, []
        position = SimpleNamespace(x=0.0, y=0.0)
        self.bbox = SimpleNamespace(center=SimpleNamespace(position=position, theta=0.0), size_x=0.0, size_y=0.0)


class Detection2DArray:
    def __init__(self, header: Any) -> None:
        self.header, self.detections = header, []


class ObjectHypothesisWithPose:
    def __init__(self) -> None:
        self.hypothesis = SimpleNamespace(class_id="", score=0.0)


class Point(SimpleNamespace):
    """Fields of geometry_msgs."""


class Marker(SimpleNamespace):
    """Fields of visualization_msgs that are used, with the values of its constants."""

    ADD, DELETEALL, LINE_STRIP, TEXT_VIEW_FACING = 0, 3, 4, 9

    def __init__(self, **given: Any) -> None:
        pose = SimpleNamespace(position=Point(x=0.0, y=0.0, z=0.0), orientation=SimpleNamespace(w=0.0))
        rest = {"scale": SimpleNamespace(x=0.0, z=0.0), "color": SimpleNamespace(), "points": [], "text": "", "pose": pose}
        super().__init__(**rest, **given)


class MarkerArray:
    def __init__(self) -> None:
        self.markers: list[Marker] = []


class EventPacket(SimpleNamespace):
    """Fields of event_camera_msgs."""


def fake_modules() -> dict[str, ModuleType]:
    """rclpy and the messages, as far as the node uses them."""
    names = (*NEEDED, "rclpy.node", "rclpy.qos", *(f"{name}.msg" for name in NEEDED if name != "rclpy"))
    made = {name: ModuleType(name) for name in names}
    made["geometry_msgs.msg"].Point = Point  # type: ignore[attr-defined]
    for kind in (Marker, MarkerArray):
        setattr(made["visualization_msgs.msg"], kind.__name__, kind)
    made["rclpy.node"].Node = FakeNode  # type: ignore[attr-defined]
    made["rclpy.qos"].qos_profile_sensor_data = object()  # type: ignore[attr-defined]
    made["event_camera_msgs.msg"].EventPacket = EventPacket  # type: ignore[attr-defined]
    for kind in (Detection2D, Detection2DArray, ObjectHypothesisWithPose):
        setattr(made["vision_msgs.msg"], kind.__name__, kind)
    return made


@pytest.fixture(params=["ROS" if HAS_ROS else "ROS is absent: a thin fake"])
def node_module(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """evcot_ros.node, on ROS or on the fake."""
    monkeypatch.syspath_prepend(str(PACKAGE))
    if not HAS_ROS:
        for name, module in fake_modules().items():
            monkeypatch.setitem(sys.modules, name, module)
    for name in [name for name in sys.modules if name.partition(".")[0] == "evcot_ros"]:
        monkeypatch.delitem(sys.modules, name)
    module = importlib.import_module("evcot_ros.node")
    if HAS_ROS:
        module.rclpy.init()
    yield module
    if HAS_ROS:
        module.rclpy.try_shutdown()
    for name in [name for name in sys.modules if name.partition(".")[0] == "evcot_ros"]:
        del sys.modules[name]


def packet(of: Events, **more: Any) -> Any:
    """The events as a packet in the encoding `mono`, whose time base is 1 s."""
    words = (of.t_us * 1_000).astype(np.uint64) | of.x.astype(np.uint64) << np.uint64(32)
    words |= of.y.astype(np.uint64) << np.uint64(48) | of.p.astype(np.uint64) << np.uint64(63)
    fields = {
        "header": header(int(of.t_us[-1])), "width": 346, "height": 260, "seq": 0, "time_base": 1_000_000_000,
        "encoding": "mono", "is_bigendian": False, "events": words.astype("<u8").tobytes(),
    }  # fmt: skip
    if not HAS_ROS:
        return EventPacket(**{**fields, **more})
    message = importlib.import_module("event_camera_msgs.msg").EventPacket()
    for name, value in {**fields, **more}.items():
        setattr(message, name, value)
    return message


def header(t_us: int) -> Any:
    if not HAS_ROS:
        return SimpleNamespace(stamp=t_us, frame_id="camera")
    made = importlib.import_module("std_msgs.msg").Header()
    made.frame_id = "camera"
    made.stamp.nanosec = 1_000 * t_us % 10**9
    return made


def wait_until(holds: Any, seconds: float = 30.0) -> None:
    deadline_s = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline_s, "waited for too long"
        time.sleep(0.02)


@pytest.fixture
def node(node_module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    made = node_module.TrackNode()
    published: list[Any] = []
    monkeypatch.setattr(made._tracks, "publish", published.append)
    made.seen = published
    yield made
    made.destroy_node()


@pytest.fixture(scope="module")
def discs() -> Events:
    return simulate_scene("discs", 5, {"duration_us": 400_000}).recording.events


def test_tracks_of_a_scene_come_as_detections(node: Any, discs: Events) -> None:
    node.on_time()
    assert node.seen == [], "nothing is known before the first packet"
    settings, filters = engine_settings(DEFAULT, (346, 260))
    tracker, alone = ENGINES[DEFAULT].start(settings, filters, (346, 260)), Alive()
    for begin in range(0, len(discs), 2_000):
        part = discs[begin : begin + 2_000]
        node.on_packet(packet(part))
        tracked_s = (part.t_us[-1] - discs.t_us[0]) / 1e6
        wait_until(lambda tracked_s=tracked_s: node._session.figures()["recording_s"] == tracked_s)
        alone.apply(tracker.feed(Events(part.t_us + 1_000_000, part.x, part.y, part.p))[0])
    node.on_time()
    (array,) = node.seen
    assert array.header.frame_id == "camera"
    assert array.header == node._header
    states = alone.clusters.states
    assert [int(each.id) for each in array.detections] == states["track_id"].tolist() != []
    for each, row in zip(array.detections, states, strict=True):
        box = each.bbox
        assert (box.center.position.x, box.center.position.y) == (row["x"] + 0.5, row["y"] + 0.5)
        assert (box.size_x, box.size_y, box.center.theta) == (row["width"], row["height"], row["angle"])
        (result,) = each.results
        assert result.hypothesis.class_id == "object"
        assert result.hypothesis.score == row["confidence"]
    node.on_figures()


def test_rviz_shows_an_outline_and_an_id_of_each_object(node: Any, discs: Events, monkeypatch: pytest.MonkeyPatch) -> None:
    marker_kind = importlib.import_module("visualization_msgs.msg").Marker
    shown: list[Any] = []
    monkeypatch.setattr(node._markers, "publish", shown.append)
    node.on_packet(packet(discs))
    wait_until(lambda: len(node._session.clusters.states) > 0)
    monkeypatch.setattr(node._markers, "get_subscription_count", lambda: 0)
    node.on_time()
    assert shown == [], "nobody subscribes"
    monkeypatch.setattr(node._markers, "get_subscription_count", lambda: 1)
    tracked_s = (discs.t_us[-1] - discs.t_us[0]) / 1e6
    wait_until(lambda: node._session.figures()["recording_s"] == tracked_s)
    node.on_time()
    (first, *rest), states = shown[0].markers, node._session.clusters.states
    assert first.action == marker_kind.DELETEALL
    assert [(each.ns, each.id) for each in rest] == [(ns, i) for i in states["track_id"].tolist() for ns in ("outline", "id")]
    for outline, text, row in zip(rest[::2], rest[1::2], states, strict=True):
        assert (outline.type, text.type) == (marker_kind.LINE_STRIP, marker_kind.TEXT_VIEW_FACING)
        assert text.text == str(row["track_id"])
        assert outline.pose.orientation.w == 1.0
        left, top = row["x"] - row["width"] / 2 + 0.5, row["y"] - row["height"] / 2 + 0.5
        corners = [(point.x, point.y) for point in outline.points]
        assert corners[0] == corners[4]
        assert corners[0] == pytest.approx((left * 0.01, top * 0.01))
        assert corners[2] == pytest.approx(((left + row["width"]) * 0.01, (top + row["height"]) * 0.01))
        assert text.pose.position.y < top * 0.01


def test_a_turned_box_has_turned_corners(node_module: ModuleType) -> None:
    from evcot.tracks.log import TRACK
    from evcot_cosim.live.visible_clusters import Clusters

    row = np.zeros(1, TRACK)
    row["x"], row["y"], row["width"], row["height"], row["angle"] = 9.5, 19.5, 8, 4, np.pi / 2
    made = importlib.import_module("evcot_ros.messages").markers(Clusters(row, np.zeros(1, np.int64)), header(0))
    corners = [(round(100 * point.x, 9), round(100 * point.y, 9)) for point in made.markers[1].points]
    assert corners == [(12, 16), (12, 24), (8, 24), (8, 16), (12, 16)]


def test_another_sensor_or_encoding_is_refused_in_one_line(node: Any, discs: Events) -> None:
    with pytest.raises(RecordingError, match=r"^events: encoding 'jpeg': must be one of evt3, libcaer_cmp, mono, libcaer$"):
        node.on_packet(packet(discs[:10], encoding="jpeg"))
    with pytest.raises(RecordingError, match=r"^events: width, height = 0, 260: must be more than 0$"):
        node.on_packet(packet(discs[:10], width=0))
    node.on_packet(packet(discs[:10]))
    with pytest.raises(RecordingError, match=r"^events: sensor and encoding are .* as before$"):
        node.on_packet(packet(discs[:10], width=640))


def test_damaged_events_end_the_node_with_their_message(node: Any, discs: Events) -> None:
    node.on_packet(packet(discs[:10]))
    node.on_packet(packet(discs[:10], events=b"12345"))
    wait_until(lambda: node._session.failed)
    with pytest.raises(RecordingError, match=r"^events: has 5 bytes of events: must be a multiple of 8$"):
        node.on_time()


@pytest.mark.skipif(HAS_ROS, reason="parameters are set on the fake")
def test_an_engine_or_preset_that_is_none(node_module: ModuleType, discs: Events, monkeypatch: pytest.MonkeyPatch) -> None:
    for wrong, message in (
        ({"engine": "none"}, "^engine none: must be one of"),
        ({"preset": "none"}, "^preset none: must be one"),
    ):
        monkeypatch.setattr(FakeNode, "parameters", wrong)
        made = node_module.TrackNode()
        with pytest.raises(ConfigError, match=message):
            made.on_packet(packet(discs[:10]))
        made.destroy_node()


def test_a_queue_that_nobody_takes_from_gives_up_the_oldest(node_module: ModuleType, discs: Events) -> None:
    topic = importlib.import_module("evcot_ros.topic")
    source = topic.TopicSource("events", packet(discs[:10]))
    for i in range(1_005):
        source.put(packet(discs[i : i + 1]))
    assert source.missed == 5
    got = next(iter(source.arrivals(lambda: True))).events
    assert got.t_us.tolist() == (discs.t_us[5:6] + 1_000_000).tolist()


def test_the_package_says_of_itself_what_evcot_does() -> None:
    said = ET.parse(PACKAGE / "package.xml").getroot()
    texts = {field.tag: field.text for field in said}
    assert texts["name"] == PACKAGE.name
    assert texts["version"] == evcot.__version__
    assert texts["license"] == "Apache-2.0"
    assert {field.text for field in said.findall("exec_depend")} == {*NEEDED, "launch_ros"}
    setup = (PACKAGE / "setup.py").read_text()
    assert f'version="{evcot.__version__}"' in setup
    assert "track = evcot_ros.node:main" in setup
    assert (PACKAGE / "resource" / PACKAGE.name).exists()
