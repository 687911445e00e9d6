# SPDX-License-Identifier: Apache-2.0
"""MCAP for Foxglove: the topics that its panels show, the numbers that are read again, and damage."""

from __future__ import annotations

import base64
import io
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from evcot.errors import TrackLogError
from evcot.tracks.formats.base import BOX, Boxes
from evcot.tracks.formats.registry import read_boxes, write_boxes

pytest.importorskip("mcap", reason="mcap is not installed")
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from support.refusals import refused


def two_tracks() -> Boxes:
    """Ids 3 and 12: both at 1.5 s, one at 2.25 s, none at 3 s."""
    rows = np.zeros(3, BOX)
    rows["instant"], rows["id"] = (0, 0, 1), (3, 12, 3)
    rows["left"], rows["top"] = (-0.5, 9.5, 0.25), (4.5, 20.125, 5.5)
    rows["width"], rows["height"] = (10, 20, 10.1), (5, 6, 5.3)
    rows["confidence"], rows["class_id"], rows["visibility"], rows["counted"] = (1, 0.5, 0.25), 1, 1, True
    return Boxes(np.array([1_500_000, 2_250_000, 3_000_000]), rows, (64, 48))


def messages(path: Path) -> dict[str, list[tuple[int, str, Any]]]:
    """By topic: time in ns, name of the schema, and content."""
    found: dict[str, list[tuple[int, str, Any]]] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
            assert json.loads(schema.data)["type"] == "object"
            found.setdefault(channel.topic, []).append((message.log_time, schema.name, json.loads(message.data)))
    return found


def read_is_refused(path: Path, message: str) -> None:
    with refused(TrackLogError, start=f"{path}: {message}"):
        read_boxes(path)


def test_what_was_written_is_read_again(tmp_path: Path) -> None:
    made = two_tracks()
    write_boxes(tmp_path / "a.mcap", made)
    again = read_boxes(tmp_path / "a.mcap")
    assert again.instants_us.tolist() == made.instants_us.tolist()
    assert again.rows.tolist() == made.rows.tolist()
    assert again.sensor == (64, 48)
    write_boxes(tmp_path / "b.mcap", again)
    assert (tmp_path / "b.mcap").read_bytes() == (tmp_path / "a.mcap").read_bytes()


def test_foxglove_finds_annotations_and_a_picture_at_every_instant(tmp_path: Path) -> None:
    write_boxes(tmp_path / "a.mcap", two_tracks())
    found = messages(tmp_path / "a.mcap")
    assert {topic: rows[0][1] for topic, rows in found.items()} == {
        "/tracks/boxes": "evcot.Boxes",
        "/tracks/annotations": "foxglove.ImageAnnotations",
        "/sensor": "foxglove.CompressedImage",
    }
    for rows in found.values():
        assert [time for time, *_ in rows] == [1_500_000_000, 2_250_000_000, 3_000_000_000]
    first, second, third = (content for *_, content in found["/tracks/annotations"])
    assert [len(each["points"]) for each in (first, second, third)] == [2, 1, 0]
    outline, label = first["points"][1], first["texts"][1]
    assert outline["type"] == 2, "a closed line"
    corners = [(point["x"], point["y"]) for point in outline["points"]]
    assert corners == [(10, 20.625), (30, 20.625), (30, 26.625), (10, 26.625)], "the first pixel begins at 0"
    assert outline["timestamp"] == {"sec": 1, "nsec": 500_000_000}
    assert (label["text"], label["position"]) == ("12", {"x": 10, "y": 20.625})
    assert first["points"][0]["outline_color"] == second["points"][0]["outline_color"] != outline["outline_color"]
    picture = found["/sensor"][0][2]
    assert picture["format"] == "png"
    with Image.open(io.BytesIO(base64.b64decode(picture["data"]))) as image:
        assert image.size == (64, 48)


def test_a_layout_next_to_the_file_shows_topics_that_are_in_it(tmp_path: Path) -> None:
    write_boxes(tmp_path / "a.mcap", two_tracks())
    layout = json.loads((tmp_path / "a.layout.json").read_text())
    topics = messages(tmp_path / "a.mcap")
    panels = layout["configById"]
    image = panels["Image!evcot"]["imageMode"]
    assert {image["imageTopic"], *image["annotations"]} == {"/sensor", "/tracks/annotations"} <= topics.keys()
    box = topics["/tracks/boxes"][0][2]["boxes"][0]
    assert panels["Table!evcot"]["topicPath"] == "/tracks/boxes.boxes"
    assert all(path["value"].removeprefix("/tracks/boxes.boxes[:].") in box for path in panels["Plot!evcot"]["paths"])
    columns = layout["layout"]
    assert {columns["first"], columns["second"]["first"], columns["second"]["second"]} == panels.keys()


def test_a_layout_replaces_no_other_file(tmp_path: Path) -> None:
    layout = tmp_path / "a.layout.json"
    layout.write_text("mine")
    for force in (False, True):
        write_boxes(tmp_path / "a.mcap", two_tracks(), force=force)
        assert layout.read_text() == "mine"
    layout.unlink()
    layout.symlink_to("nowhere")
    write_boxes(tmp_path / "a.mcap", two_tracks(), force=True)
    assert layout.is_symlink()
    assert not (tmp_path / "nowhere").exists()
    layout.unlink()
    write_boxes(tmp_path / "a.mcap", two_tracks(), force=True)
    assert "Image!evcot" in json.loads(layout.read_text())["configById"]
    write_boxes(tmp_path / "b", two_tracks(), name="mcap")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.layout.json", "a.mcap", "b"]


def test_without_a_sensor_the_picture_holds_all_boxes(tmp_path: Path) -> None:
    made = two_tracks()
    write_boxes(tmp_path / "a.mcap", Boxes(made.instants_us, made.rows))
    assert read_boxes(tmp_path / "a.mcap").sensor is None
    picture = messages(tmp_path / "a.mcap")["/sensor"][0][2]["data"]
    with Image.open(io.BytesIO(base64.b64decode(picture))) as image:
        assert image.size == (30, 27)


def test_every_field_that_is_written_is_in_its_schema(tmp_path: Path) -> None:
    def unknown(value: Any, schema: Any) -> bool:
        if isinstance(value, dict):
            known = schema["properties"]
            return any(key not in known or unknown(each, known[key]) for key, each in value.items())
        return isinstance(value, list) and any(unknown(each, schema["items"]) for each in value)

    write_boxes(tmp_path / "a.mcap", two_tracks())
    with (tmp_path / "a.mcap").open("rb") as file:
        for schema, _, message in make_reader(file).iter_messages():
            assert not unknown(json.loads(message.data), json.loads(schema.data)), schema.name


def test_a_file_cut_or_damaged_anywhere_is_refused_or_read_the_same(tmp_path: Path) -> None:
    write_boxes(tmp_path / "a.mcap", two_tracks())
    whole, path = (tmp_path / "a.mcap").read_bytes(), tmp_path / "b.mcap"
    random = np.random.default_rng(1)
    cuts = [whole[:length] for length in {0, 1, 8, 9, *random.integers(len(whole), size=40).tolist()}]
    flips = []
    for at in random.integers(len(whole), size=200).tolist():
        flipped = bytearray(whole)
        flipped[at] ^= 1 << int(random.integers(8))
        flips.append(bytes(flipped))
    said = []
    for number, damaged in enumerate(cuts + flips):
        path.write_bytes(damaged)
        try:
            again = read_boxes(path)
            assert number >= len(cuts) or again.rows.tolist() == two_tracks().rows.tolist(), "cut behind all boxes"
        except TrackLogError as error:
            said.append(str(error))
    assert len(said) > 100
    assert all(line.startswith(f"{path}: ") and "\n" not in line for line in said)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t_us": -1}, "t_us = -1: must be an integer from 0 to "),
        ({"t_us": "1"}, "t_us = '1': must be an integer"),
        ({"sensor": [0, 48]}, "sensor = [0, 48]: must be width and height"),
        ({"boxes": 3}, "must hold t_us, sensor, and boxes, each with id, class_id, left"),
        ({"boxes": [{"id": 1}]}, "must hold t_us, sensor, and boxes"),
        ({"boxes": [{"id": 1.5}]}, "must hold"),
    ],
)
def test_what_a_message_cannot_say(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    write(tmp_path / "a.mcap", {"t_us": 5, "sensor": [64, 48], "boxes": [], **change})
    read_is_refused(tmp_path / "a.mcap", f"message 0: {message}")


def write(path: Path, *told: Any, topic: str = "/tracks/boxes", compression: CompressionType = CompressionType.ZSTD) -> None:
    with path.open("wb") as file:
        writer = Writer(file, compression=compression)
        writer.start()
        channel = writer.register_channel(topic, "json", writer.register_schema("evcot.Boxes", "jsonschema", b"{}"))
        for i, each in enumerate(told):
            writer.add_message(channel, i, json.dumps(each).encode(), i)
        writer.finish()


def test_a_file_that_is_not_evcot_s(tmp_path: Path) -> None:
    path, empty = tmp_path / "a.mcap", {"t_us": 5, "sensor": [], "boxes": []}
    read_is_refused(path, "cannot be read: No such file or directory")
    path.write_bytes(b"nothing at all")
    read_is_refused(path, "is damaged, or no MCAP file: ")
    write(path, {}, topic="/other")
    read_is_refused(path, "has no topic /tracks/boxes in JSON: must be a file that evcot wrote")
    write(path, {}, compression=CompressionType.LZ4)
    read_is_refused(path, "compression 'lz4': must be zstd, or none")
    write(path, empty, empty)
    read_is_refused(path, "message 1: t_us = 5 follows 5: must ascend")


def test_times_that_mcap_cannot_hold(tmp_path: Path) -> None:
    made = two_tracks()
    with pytest.raises(TrackLogError, match=r"a\.mcap: t = -1 us: must be from 0 to \d+, a time of MCAP$"):
        write_boxes(tmp_path / "a.mcap", Boxes(made.instants_us - 1_500_001, made.rows, made.sensor))
    assert not (tmp_path / "a.mcap").exists()


def test_without_the_package_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("mcap", "mcap.stream_reader"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(TrackLogError, match=r"a\.mcap: mcap is not installed: .*pip install 'evcot\[mcap\]'$"):
        write_boxes(tmp_path / "a.mcap", two_tracks())
