# SPDX-License-Identifier: Apache-2.0
"""Recordings at URLs: the same runs as of the files, read through a copy that follows what lies there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot_cosim.sweep.execute import execute
from evcot_cosim.sweep.inputs import inputs_of
from evcot_cosim.sweep.machine import content_of
from evcot_cosim.sweep.places import files_in, is_url, local, placed
from evcot_cosim.sweep.plan import Planner, points_of
from evcot_cosim.sweep.spec import Spec, spec_from
from evcot_cosim.sweep.task import Task
from support.sweeping import recorded

pytest.importorskip("fsspec")


@pytest.fixture(autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("EVCOT_CACHE", str(folder))
    return folder


def spec_of(*names: str) -> Spec:
    values: dict[str, Any] = {"recordings": list(names), "engines": ["rct"], "preset": "discs"}
    return spec_from(values, Path("/nowhere"), "url")


def tasks_of(spec: Spec) -> list[Task]:
    return Planner(spec).plan(points_of(spec)).tasks


def test_what_is_a_url() -> None:
    assert all(map(is_url, ("s3://bucket/a.raw", "file:///a.raw", "simplecache::s3://bucket/a.raw")))
    assert not any(map(is_url, ("/data/a.raw", "a.raw", "C:/a.raw", "a:b/c.raw")))
    assert placed(Path("/x"), "s3://bucket/a.raw") == "s3://bucket/a.raw"
    assert placed(Path("/x"), "a.raw") == "/x/a.raw"


def test_a_url_is_run_as_the_file_is(tmp_path: Path) -> None:
    path = recorded(tmp_path, 1)
    (by_path,), (by_url,), (of_folder,) = (
        tasks_of(spec_of(name)) for name in (str(path), f"file://{path}", f"file://{tmp_path}")
    )
    assert by_path.key == by_url.key == of_folder.key
    assert by_url.input is not None
    assert (by_url.input.name, by_url.input.truth) == (f"file://{path}", f"file://{tmp_path}/discs1.truth.csv")
    row, same = execute(by_url), execute(by_path)
    assert (row["status"], row["error"]) == ("done", "")
    assert row["hota"] == same["hota"] > 0


def test_a_url_is_copied_once_and_again_when_it_changes(tmp_path: Path, cache: Path) -> None:
    path = tmp_path / "a.raw"
    path.write_bytes(b"first")
    url = f"file://{path}"
    copy = local(url)
    assert copy == local(url)
    assert (copy.read_bytes(), cache in copy.parents, copy.name) == (b"first", True, "a.raw")
    before = content_of(url)
    path.write_bytes(b"another")
    assert local(url).read_bytes() == b"another"
    assert content_of(url) != before
    assert files_in(f"file://{tmp_path}") == [f"file://{path}"]


@pytest.mark.parametrize(
    ("url", "why"),
    [
        ("file:///nowhere/gone.raw", r"^recordings: file:///nowhere/gone.raw: is missing: must be a recording"),
        ("nosuch://a/b.raw", r"^nosuch://a/b.raw: cannot be opened: Protocol not known: nosuch"),
    ],
)
def test_a_url_that_cannot_be_read_is_one_line(url: str, why: str) -> None:
    with pytest.raises(ConfigError, match=why) as refused:
        inputs_of(spec_of(url))
    assert "\n" not in str(refused.value)
