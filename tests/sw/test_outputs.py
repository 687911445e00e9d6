# SPDX-License-Identifier: Apache-2.0
"""No file of the user is destroyed: files, links, devices and folders, by the one policy for all outputs of evcot."""

from __future__ import annotations

import errno
import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evcot import outputs
from evcot.errors import OutputError, reason_of
from evcot.events import Events, Recording
from evcot.outputs import (
    RUN_FILE,
    Claims,
    folder_written_aside,
    is_own_file,
    new_file,
    note_input,
    own_files,
    remade,
    spool_folder,
    suffix_of,
    written_aside,
)
from evcot.recordings.files import open_recording, write_events, write_recording
from support.refusals import refused


@pytest.fixture(autouse=True)
def in_own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write(path: Path | str, text: bytes = b"new", *, force: bool = False) -> None:
    with written_aside(Path(path), force=force) as file:
        file.write(text)


def run_into(folder: Path | str, **files: str) -> None:
    """Write a folder as a run does: run.toml, and other files by their names without suffix."""
    with folder_written_aside(Path(folder), "cosim") as aside:
        (aside / RUN_FILE).write_text('[run]\nrecording = "boxes"\n')
        for name, text in files.items():
            (aside / f"{name}.txt").write_text(text)


def names(folder: Path | str = ".") -> list[str]:
    return sorted(os.listdir(folder))


class TestFiles:
    def test_a_new_file_appears_when_it_is_whole_and_one_that_exists_is_replaced_by_force(self) -> None:
        with written_aside(Path("a")) as file:
            file.write(b"mine")
            file.flush()
            assert not Path("a").exists()
        with pytest.raises(OutputError, match=r"^a: exists: must be another file, or --force"), written_aside(Path("a")):
            pytest.fail("the block must not run")
        assert (names(), Path("a").read_bytes()) == (["a"], b"mine")
        write("a", force=True)
        assert (names(), Path("a").read_bytes()) == (["a"], b"new")

    @pytest.mark.parametrize("force", [False, True])
    def test_an_error_leaves_what_was_there_and_nothing_else(self, force: bool) -> None:
        if force:
            Path("a").write_bytes(b"mine")
        with pytest.raises(ZeroDivisionError), written_aside(Path("a"), force=force) as file:
            file.write(str(1 // 0).encode())
        assert names() == (["a"] if force else [])
        assert not force or Path("a").read_bytes() == b"mine"

    @pytest.mark.parametrize("links", [True, False], ids=["hard links", "none"])
    def test_a_file_that_appears_meanwhile_stays(self, links: bool, monkeypatch: pytest.MonkeyPatch) -> None:
        if not links:
            monkeypatch.setattr(os, "link", lambda *_: (_ for _ in ()).throw(PermissionError(1, "Operation not permitted")))
            write("other")
            assert Path("other").read_bytes() == b"new"
            Path("other").unlink()
        with pytest.raises(OutputError, match=r"^a: exists"), written_aside(Path("a")):
            Path("a").write_bytes(b"mine")
        assert (names(), Path("a").read_bytes()) == (["a"], b"mine")

    def test_a_hard_link_keeps_what_it_has_and_no_folder_is_written(self) -> None:
        Path("mine").write_bytes(b"mine")
        os.link("mine", "a")
        write("a", force=True)
        assert (Path("a").read_bytes(), Path("mine").read_bytes()) == (b"new", b"mine")
        Path("folder").mkdir()
        for path in (".", "..", "folder", "/"):
            with pytest.raises(OutputError, match="is a folder: must be a file"):
                write(path, force=True)

    @pytest.mark.parametrize(
        ("path", "reason"),
        [("absent/a", "No such file or directory"), ("file/a", "Not a directory"), ("loop", "Too many levels")],
    )
    def test_a_place_that_cannot_be_written(self, path: str, reason: str) -> None:
        Path("file").touch()
        Path("loop").symlink_to("loop")
        with pytest.raises(OutputError, match=f"^{path}: cannot be written: {reason}"):
            write(path)

    def test_a_new_file_at_once(self) -> None:
        with new_file(Path("a")) as file:
            file.write(b"one")
            file.flush()
            assert Path("a").read_bytes() == b"one"
        with pytest.raises(OutputError, match="exists"):
            new_file(Path("a"))
        os.link("a", "kept")
        with new_file(Path("a"), force=True) as file:
            file.write(b"two")
        assert (names(), Path("a").read_bytes(), Path("kept").read_bytes()) == (["a", "kept"], b"two", b"one")


class TestLinks:
    def test_the_target_is_written_and_the_link_stays(self) -> None:
        Path("target").write_bytes(b"mine")
        Path("link").symlink_to("target")
        with pytest.raises(OutputError, match="link: exists"):
            write("link")
        Path("folder").mkdir()
        Path("to folder").symlink_to("folder/target")
        for name, force, target in (("link", True, "target"), ("to folder", False, "folder/target")):
            write(name, force=force)
            assert Path(name).is_symlink()
            assert Path(target).read_bytes() == b"new"
        assert names("folder") == ["target"]

    def test_a_link_to_a_folder_of_a_run(self) -> None:
        Path("link").symlink_to("run")
        run_into("link", a="1")
        run_into("link", a="2")
        assert Path("link").is_symlink()
        assert (Path("run/a.txt").read_text(), names()) == ("2", ["link", "run"])


class TestSpecialFiles:
    @pytest.mark.parametrize("through", [True, False], ids=["by itself", "by a link"])
    def test_a_device_is_written_through(self, through: bool) -> None:
        path = Path("/dev/null")
        before = path.stat()
        if not through:
            path = Path("link")
            path.symlink_to("/dev/null")
        write(path)
        write_recording(Recording(Events(*np.array([[5], [1], [1], [1]])), 4, 4, "one"), path, "npz")
        with new_file(path) as file:
            file.write(b"x")
        assert (path.stat().st_ino, path.stat().st_rdev) == (before.st_ino, before.st_rdev)
        assert path.is_char_device()
        assert spool_folder(path) != Path("/dev")

    def test_a_pipe_gets_all_of_it_and_a_full_device_is_named(self) -> None:
        os.mkfifo("pipe")
        got = []
        reader = threading.Thread(target=lambda: got.append(Path("pipe").read_bytes()))
        reader.start()
        write("pipe", b"n" * 100_000)
        reader.join(10)
        assert got == [b"n" * 100_000]
        assert Path("pipe").is_fifo()
        with pytest.raises(OutputError, match="/dev/full: cannot be written: No space left on device"):
            write("/dev/full")

    @pytest.mark.parametrize("name", ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"])
    @pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
    def test_standard_output_is_written_through_also_where_it_is_a_file(self, name: str) -> None:
        code = f"""
from pathlib import Path
from evcot.outputs import written_aside
print("first")
with written_aside(Path({name!r})) as file:
    file.write(b"second\\n")
print("third")
"""
        with Path("out").open("wb") as file:
            subprocess.run([sys.executable, "-c", code], stdout=file, check=True)
        assert Path("out").read_text() == "first\nsecond\nthird\n"


class TestFolders:
    def test_a_new_folder_appears_whole_or_not_at_all(self) -> None:
        with folder_written_aside(Path("deep/er/run"), "cosim") as aside:
            (aside / "a").touch()
            assert not Path("deep/er/run").exists()
        assert names("deep/er/run") == ["a"]
        with pytest.raises(ZeroDivisionError), folder_written_aside(Path("not/here/run"), "cosim") as aside:
            (aside / "a").write_text(str(1 // 0))
        assert names() == ["deep"]

    def test_a_run_replaces_what_a_run_wrote_and_leaves_what_the_user_added(self) -> None:
        run_into("run", a="1", b="1")
        Path("run/notes").write_text("mine")
        Path("run/more").mkdir()
        Path("run/more/drive.raw").write_text("mine")
        run_into("run", a="2", c="2")
        assert names("run") == ["a.txt", "c.txt", "more", "notes", RUN_FILE]
        assert (Path("run/a.txt").read_text(), Path("run/notes").read_text()) == ("2", "mine")
        assert own_files(Path("run")) == {"a.txt", "c.txt", RUN_FILE}
        assert names() == ["run"]

    def test_an_error_leaves_the_older_run(self) -> None:
        run_into("run", a="1")
        with pytest.raises(ZeroDivisionError), folder_written_aside(Path("run"), "cosim") as aside:
            (aside / "a.txt").write_text(str(1 // 0))
        assert (names("run"), names()) == (["a.txt", RUN_FILE], ["run"])
        assert is_own_file(Path("run/a.txt"))

    @pytest.mark.parametrize("name", ["..", ".", "full", "full/."])
    def test_a_folder_that_evcot_did_not_make_is_refused(self, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
        Path("full").mkdir()
        Path("full/drive.raw").write_text("mine")
        Path("cwd").mkdir()
        monkeypatch.chdir("cwd" if name == ".." else ".")
        with pytest.raises(OutputError, match="holds files, and evcot did not make it: must be a new or an empty folder"):
            run_into(name)
        assert (Path("../full") if name == ".." else Path("full")).joinpath("drive.raw").read_text() == "mine"

    def test_a_run_toml_alone_does_not_make_it_evcots(self) -> None:
        """`--print-config` is saved by hand, and the one of a run is copied."""
        Path("saved").mkdir()
        Path("saved/run.toml").write_text('[run]\nrecording = "boxes"\n')
        run_into("run", a="1")
        Path("copied").mkdir()
        Path("copied/run.toml").write_bytes(Path("run/run.toml").read_bytes())
        Path("copied/a.txt").write_text("mine")
        for name in ("saved", "copied"):
            with pytest.raises(OutputError, match="evcot did not make it"):
                run_into(name, a="2")
        assert Path("copied/a.txt").read_text() == "mine"

    @pytest.mark.parametrize(
        "name", ["../mine", "/{here}/mine", "more/mine", "..", ".", "", "a.txt\\u0000", "..\\\\mine", "key"]
    )
    def test_a_list_that_names_a_path_or_has_a_key_of_very_many_parts_is_no_list(self, name: str) -> None:
        """A run folder may come from somebody else; such a key would take more memory than the square of its parts."""
        Path("mine").write_text("mine")
        run_into("run", a="1")
        Path("run/more").mkdir()
        Path("run/more/mine").write_text("mine")
        digest = re.findall('"a.txt" = "(.*)"', Path("run/run.toml").read_text())[0]
        line = f'"{name.format(here=str(Path.cwd())[1:])}" = "{digest}"\n'
        with Path("run/run.toml").open("a") as file:
            file.write(f"[{'.'.join('a' * 17)}]\n" if name == "key" else line)
        before = names("run")
        with pytest.raises(OutputError, match="holds files, and evcot did not make it"):
            run_into("run", a="2")
        assert (own_files(Path("run")), names("run")) == (None, before)
        assert (Path("mine").read_text(), Path("run/more/mine").read_text()) == ("mine", "mine")

    def test_a_folder_belongs_to_the_command_that_made_it(self) -> None:
        run_into("run", a="1")
        told = "run: was made by evcot cosim: must be another folder for evcot sweep"
        with refused(OutputError, told), folder_written_aside(Path("run"), "sweep"):
            pass
        assert names("run") == ["a.txt", RUN_FILE]

    @pytest.mark.parametrize("name", ["a.txt", RUN_FILE])
    def test_a_file_that_the_user_has_changed_is_the_users(self, name: str) -> None:
        run_into("run", a="1", b="1")
        with Path("run", name).open("r+") as file:
            file.write("# mine\n")
        kept = Path("run", name).read_text()
        with pytest.raises(OutputError, match=f"holds {name}, which evcot did not write or which has changed since"):
            run_into("run", a="2", b="2")
        assert Path("run", name).read_text() == kept
        Path("run", name).rename("moved")
        if name != RUN_FILE:
            run_into("run", a="2", b="2")
            assert Path("run/a.txt").read_text() == "2"

    @pytest.mark.parametrize(
        "make", [lambda path: path.symlink_to("../mine"), lambda path: path.write_text("mine"), Path.mkdir]
    )
    def test_what_is_in_the_way_of_a_new_file_or_folder_is_the_users(self, make: Callable[[Path], object]) -> None:
        Path("mine").write_text("mine")
        run_into("run", a="1")
        make(Path("run/b.txt"))
        with pytest.raises(OutputError, match=r"holds b\.txt, which evcot did not write"):
            run_into("run", a="2", b="2")
        assert Path("run/a.txt").read_text() == "1"
        for folder, told in (("mine", "mine: is not a folder"), ("mine/in", "mine/in: cannot be written: Not a directory")):
            with pytest.raises(OutputError, match=told):
                run_into(folder)
        assert Path("mine").read_text() == "mine"

    @pytest.mark.parametrize("name", ["empty", "."])
    @pytest.mark.parametrize("mounted", [False, True])
    def test_an_empty_folder_may_be_used(self, name: str, mounted: bool, monkeypatch: pytest.MonkeyPatch) -> None:
        """Of a mounted one, what is beside it lies on another disk."""
        Path("empty").mkdir()
        monkeypatch.setattr(os.path, "ismount", lambda _: mounted)
        if name == ".":
            monkeypatch.chdir("empty")
        for text in "12":
            run_into(name, a=text)
            assert (names(name), Path(name, "a.txt").read_text()) == (["a.txt", RUN_FILE], text)

    def test_run_toml_and_the_summary_come_last_so_that_what_is_interrupted_does_not_look_whole(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        run_into("run", a="1", summary="1")
        moved, link = [], os.link

        def interrupted(source: Path, target: Path) -> None:
            moved.append(target.name)
            if target.name == "summary.txt":
                raise KeyboardInterrupt
            link(source, target)

        monkeypatch.setattr(os, "link", interrupted)
        with pytest.raises(KeyboardInterrupt):
            run_into("run", a="2", summary="2")
        assert names("run") == ["a.txt"]
        run_into("other", a="1")
        moved.clear()
        with folder_written_aside(Path("other"), "cosim") as aside:
            for name in ("z", "summary.json", RUN_FILE, "a.txt"):
                (aside / name).touch()
        assert moved == ["a.txt", "z", "summary.json", RUN_FILE]

    def test_one_of_its_files_made_anew_stays_evcots(self) -> None:
        run_into("run", a="1", b="1")
        write("run/a.txt", b"again", force=True)
        assert not is_own_file(Path("run/a.txt"))
        remade(Path("run/a.txt"))
        assert is_own_file(Path("run/a.txt"))
        assert is_own_file(Path("run/run.toml"))
        run_into("run", a="2")
        assert names("run") == ["a.txt", RUN_FILE]


class TestCalls:
    @pytest.fixture(autouse=True)
    def files(self) -> None:
        Path("in").write_text("input")
        Path("folder").mkdir()
        Path("folder/1.png").write_text("input")
        os.link("in", "hard")
        Path("soft").symlink_to("in")

    @pytest.mark.parametrize("first", ["input", "output"])
    @pytest.mark.parametrize(
        ("source", "target"), [("in", "in"), ("in", "hard"), ("in", "soft"), ("soft", "hard"), ("folder", "folder/1.png")]
    )
    def test_an_output_is_never_an_input(self, source: str, target: str, first: str) -> None:
        claims = Claims()
        steps = [lambda: claims.read(Path(source)), lambda: claims.write("-o", Path(target), force=True)]
        if first == "output":
            steps.reverse()
        steps[0]()
        with pytest.raises(OutputError, match=rf"-o {target}: is .*, an input of the same call: must be another file"):
            steps[1]()

    @pytest.mark.parametrize("source", ["run/in", "run", "run/sub/in", "link"])
    def test_an_output_folder_holds_no_input(self, source: str) -> None:
        run_into("run", a="1")
        Path("run/sub").mkdir()
        Path("link").symlink_to("run/in")
        for name in ("run/in", "run/sub/in"):
            Path(name).touch()
        for first in (0, 1):
            claims = Claims()
            steps = [lambda: claims.read(Path(source)), lambda: claims.write_folder("-o", Path("run/../run"), "cosim")]  # noqa: B023
            steps[first]()
            with pytest.raises(OutputError, match=r"-o run/../run: holds .*, an input of the same call"):
                steps[1 - first]()

    def test_a_file_of_the_run_that_is_an_input_by_another_name(self) -> None:
        run_into("run", a="1")
        os.link("run/a.txt", "b")
        with Claims() as claims:
            claims.read(Path("b"))
            with pytest.raises(OutputError, match=r"holds a\.txt, an input"):
                claims.write_folder("-o", Path("run"), "cosim")

    @pytest.mark.parametrize(("one", "other"), [("a", "a"), ("a", "folder/../a"), ("a", "link")])
    def test_two_outputs_are_two_files(self, one: str, other: str) -> None:
        Path("link").symlink_to("a")
        claims = Claims()
        claims.write("-o", Path(one))
        with pytest.raises(OutputError, match=r"--csv .*: is also -o: must be another file"):
            claims.write("--csv", Path(other))
        for option in ("-o", "--csv"):
            Claims().write(option, Path("/dev/null"))
        claims.write_folder("-o", Path("run"), "cosim")
        with pytest.raises(OutputError, match="is in run, which is written too"):
            claims.write("--csv", Path("run/a.csv"))

    def test_what_readers_tell_is_not_written_over(self) -> None:
        with Claims() as claims:
            claims.write("-o", Path("soft"), force=True)
            with pytest.raises(OutputError, match="-o soft: is in, an input of the same call"):
                note_input("in")
        with Claims():
            note_input("in")
            with pytest.raises(OutputError, match="is an input of the same call"):
                write("hard", force=True)
        note_input("in")
        write("hard", force=True)

    def test_a_recording_that_is_open_is_not_written_over(self) -> None:
        recording = Recording(Events(*np.array([[5, 6], [1, 2], [1, 2], [1, 0]])), 4, 4, "two")
        write_recording(recording, "a.npz")
        os.link("a.npz", "b.npz")
        before = Path("a.npz").read_bytes()
        for name in ("a.npz", "b.npz"):
            refusal = pytest.raises(OutputError, match=f"{name}: is an input of the same call")
            with open_recording("a.npz") as file, refusal:
                write_events(name, file.sensor, file.blocks(), force=True)
        with pytest.raises(OutputError, match="input"):
            write_events("a.npz", (4, 4), open_recording("a.npz").blocks(), force=True)
        assert Path("a.npz").read_bytes() == before
        write_recording(recording, "a.npz", force=True)
        assert not any(count > 0 for count in outputs._being_read.values())


_FULL = os.strerror(errno.ENOSPC)


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (OSError(errno.ENOSPC, _FULL), _FULL),
        (OSError(errno.ENOSPC, _FULL, "log.npz"), _FULL),
        (OSError(errno.ENOSPC, _FULL, b"log.npz"), _FULL),
        (OSError(errno.ENOSPC, _FULL, ".log.npz.0123abcd.partial"), _FULL),
        (OSError(errno.ENOSPC, _FULL, "./log.npz"), _FULL),
        (OSError(errno.ENOENT, "No such file or directory", "main.js"), "main.js: No such file or directory"),
        (OSError(errno.ENOENT, "No such file", ".run.0123abcd.partial/a.html"), "run/a.html: No such file"),
        (OSError(errno.ENOENT, "No such file", 7), "No such file"),
        (OSError("1 requested\nand 0 written"), "1 requested and 0 written"),
        (TimeoutError(), "TimeoutError"),
        (OSError(), "OSError"),
    ],
)
def test_reason_is_never_empty_and_names_another_file(error: OSError, reason: str) -> None:
    assert reason_of(error, Path("log.npz")) == reason


def test_option_before_the_file_or_its_whole_path_changes_nothing() -> None:
    assert reason_of(OSError(errno.ENOSPC, _FULL, "log.npz"), "-o log.npz") == _FULL
    assert reason_of(OSError(errno.ENOSPC, _FULL, os.path.abspath("log.npz")), Path("log.npz")) == _FULL


@pytest.mark.parametrize("writes", [written_aside, lambda path: folder_written_aside(path, "cosim")])
def test_output_is_not_blamed_for_a_file_that_was_read(writes: object, tmp_path: Path) -> None:
    assert callable(writes)
    absent = tmp_path / "absent.css"
    with (
        pytest.raises(OSError, match=rf"^{tmp_path}/out: cannot be written: {absent}: No such file or directory$"),
        writes(tmp_path / "out"),
    ):
        absent.read_text()
    assert list(tmp_path.iterdir()) == []


def test_error_without_a_text_has_a_reason(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"out: cannot be written: OSError$"), written_aside(tmp_path / "out"):
        raise OSError


def test_a_suffix_is_one_of_those_that_can_be_written() -> None:
    assert suffix_of(Path("log.CSV"), (".npz", ".csv")) == ".csv"
    with refused(OutputError, "--out a.txt: suffix '.txt': must be .npz"):
        suffix_of(Path("a.txt"), (".npz",), "--out")
    with refused(OutputError, "a: suffix '': must be one of .npz, .csv"):
        suffix_of(Path("a"), (".npz", ".csv"))
