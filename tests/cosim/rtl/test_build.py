# SPDX-License-Identifier: Apache-2.0
"""Building a module into a loadable model: what is cached, what is refused, and what an interrupted build leaves behind."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from evcot.errors import ToolchainError
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, RANDOM_INITIAL_FLAGS, build, load
from evcot_cosim.rtl.files import manifest, rtl_files, verilog_dir
from evcot_cosim.rtl.joined import main
from evcot_cosim.rtl.toolchain import find_toolchain

COUNTER = """
`include "step.vh"
module counter #(parameter W = 8) (input wire clk, input wire rst, output reg [W-1:0] count);
    wire [W-1:0] next;
    adder #(.W(W)) adder_i (.a(count), .sum(next));
    always @(posedge clk) count <= rst ? {W{1'b0}} : next;
endmodule
"""
ADDER = """
module adder #(parameter W = 8) (input wire [W-1:0] a, output wire [W-1:0] sum);
    assign sum = a + `STEP;
endmodule
"""
DOUBLE = """
#include "Vcounter.h"
extern "C" int twice(Vcounter* top) { return 2 * top->count; }
"""


@pytest.fixture(scope="session")
def session_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One cache for all tests here, so that what they share is compiled once."""
    return tmp_path_factory.mktemp("evcot cache")  # the space is on purpose: home folders may have one


@pytest.fixture(autouse=True)
def cache(session_cache: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("EVCOT_CACHE", str(session_cache))
    monkeypatch.setenv("EVCOT_OPTIMISATION", "-O0")  # Verilator's runtime takes most of the time here
    return session_cache


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """A small design of two modules and a header, and a third module that it does not use."""
    folder = tmp_path / "rtl"
    folder.mkdir()
    (folder / "counter.v").write_text(COUNTER)
    (folder / "adder.v").write_text(ADDER)
    (folder / "step.vh").write_text("`define STEP 1\n")
    (folder / "stranger.v").write_text("module stranger; endmodule\n")
    return folder


@pytest.fixture
def would_build(sources: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., bool]:
    """Whether a request misses the cache, without the build that would follow."""

    def ask(**request: object) -> bool:
        class MissError(Exception):
            pass

        def miss() -> None:
            raise MissError

        try:
            build("counter", **{"verilog": sources, "on_miss": miss, **request})  # type: ignore[arg-type]
        except MissError:
            return True
        return False

    return ask


def test_a_built_model_counts(sources: Path) -> None:
    sim = load("counter", {"W": 4}, verilog=sources)
    for _ in range(17):
        sim.clock.tick()
    assert sim.io.count == 1
    assert dict(sim.outputs) == {"count": 4}


def test_what_no_design_has_a_part_in_is_compiled_once(sources: Path, cache: Path) -> None:
    build("counter", {"W": 5}, verilog=sources)
    model = build("counter", {"W": 6}, verilog=sources)
    log = (model.shared_object.parent / "build.log").read_text()
    assert re.findall(r"-c -o (\S+)", log) == ["Vcounter__ALL.o"]
    if not find_toolchain().compiler_is_clang:
        (header,) = cache.glob("runtime/*/evcot_runtime.h.gch")
        assert header.stat().st_size > 1_000_000
        assert "-include evcot_runtime.h" in log


def test_registers_begin_with_random_values_by_the_seed_and_the_runtime_serves_such_a_model_too(sources: Path) -> None:
    build("counter", {"W": 32}, verilog=sources)
    model = build("counter", {"W": 32}, extra_flags=(*RANDOM_INITIAL_FLAGS, *PORTS_ONLY_FLAGS), verilog=sources)
    compiled = re.findall(r"-c -o (\S+)", (model.shared_object.parent / "build.log").read_text())
    assert compiled == ["Vcounter__ALL.o"]
    one, same, other, zero = (model.load(seed).io.count for seed in (1, 1, 2, 0))
    assert one == same
    assert len({int(one), int(other), 0}) == 3
    assert zero == 0


def test_the_runtime_serves_a_model_whose_state_is_saved_but_for_one_file(sources: Path) -> None:
    build("counter", {"W": 5}, verilog=sources)
    model = build("counter", {"W": 5}, extra_flags=("--savable", *PORTS_ONLY_FLAGS), verilog=sources)
    compiled = re.findall(r"-c -o (\S+)", (model.shared_object.parent / "build.log").read_text())
    assert sorted(compiled) == ["Vcounter__ALL.o", "verilated_save.o"]


def test_extra_cpp_lives_in_the_same_shared_object(sources: Path) -> None:
    model = build("counter", extra_cpp={"twice.cpp": DOUBLE}, verilog=sources)
    sim = model.load()
    sim.lib.twice.argtypes = [ctypes.c_void_p]
    sim.clock.tick()
    assert sim.lib.twice(sim.model) == 2


def test_two_simulations_of_one_model_are_independent(sources: Path, tmp_path: Path) -> None:
    model = build("counter", verilog=sources)
    first = model.load()
    first.start_vcd_trace(str(tmp_path / "first.vcd"))
    for _ in range(5):
        first.clock.tick()
    second = model.load()  # after the first has already run
    second.start_vcd_trace(str(tmp_path / "second.vcd"))
    second.clock.tick()
    first.clock.tick()
    assert (first.io.count, second.io.count) == (6, 1)
    first.stop_vcd_trace()
    second.stop_vcd_trace()
    assert "b00000110" in (tmp_path / "first.vcd").read_text()
    assert "b00000110" not in (tmp_path / "second.vcd").read_text()


def test_the_second_build_is_a_lookup(sources: Path, would_build: Callable[..., bool]) -> None:
    first = build("counter", verilog=sources)
    again = build("counter", verilog=sources)
    assert again.cached
    assert again.shared_object == first.shared_object
    assert not would_build()
    assert min(build("counter", verilog=sources).build_s for _ in range(5)) < 0.050


def test_whatever_decides_the_result_misses_the_cache(sources: Path, would_build: Callable[..., bool]) -> None:
    width = {"W": 20}  # that no other test here builds
    build("counter", width, verilog=sources)
    assert not would_build(parameters=width)
    assert would_build(parameters={"W": 21})
    assert would_build(parameters=width, extra_cpp={"twice.cpp": DOUBLE})
    assert would_build(parameters=width, extra_flags=["-DOTHER"])
    assert would_build(parameters=width, toolchain=replace(find_toolchain(), version="5.006"))
    assert would_build(parameters=width, toolchain=replace(find_toolchain(), compiler_version="g++ 99"))
    assert would_build(parameters=width, toolchain=replace(find_toolchain(), optimisation="-O2"))
    assert would_build(parameters=width, toolchain=replace(find_toolchain(), target="another machine"))


def test_the_runtime_has_options_of_its_own(sources: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build("counter", {"W": 4}, verilog=sources)
    lines = [line for log in cache.glob("models/*/build.log") for line in log.read_text().splitlines() if " -c " in line]
    levels = {line.split()[-1]: re.findall(r" (-O\w+)", line)[-1] for line in lines}
    own = {"Vcounter__ALL.cpp", "evcot_context.cpp"}
    assert levels == {name: "-O0" if name in own else "-Og" for name in levels}
    assert own < levels.keys()
    monkeypatch.delenv("EVCOT_OPTIMISATION")
    assert "OPT_FAST=-O1" in find_toolchain().environment["MAKEFLAGS"]


def test_only_files_that_the_module_needs_decide(sources: Path, would_build: Callable[..., bool]) -> None:
    build("counter", verilog=sources)
    (sources / "stranger.v").write_text("module stranger; wire changed; endmodule\n")
    assert not would_build()
    (sources / "step.vh").write_text("`define STEP 2\n")
    assert would_build()
    (sources / "step.vh").write_text("`define STEP 1\n")
    assert not would_build()
    (sources / "adder.v").write_text(ADDER.replace("+", "-"))
    assert would_build()


def test_nothing_is_printed_and_the_environment_stays(
    sources: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MAKEFLAGS", "-n -- OPT_FAST=-O0")  # as under `make -n`: must not reach the inner make
    before = dict(os.environ)
    load("counter", {"W": 5}, verilog=sources)
    assert capfd.readouterr() == ("", "")
    assert dict(os.environ) == before


def test_a_module_that_does_not_exist(sources: Path) -> None:
    with pytest.raises(ToolchainError, match=r"rtl/nothing\.v: no such file, so module nothing cannot be built$"):
        build("nothing", verilog=sources)


def test_verilog_that_verilator_refuses(sources: Path, cache: Path) -> None:
    (sources / "adder.v").write_text(ADDER.replace("endmodule", "endmodul"))
    with pytest.raises(
        ToolchainError, match=r"^cannot build counter W=3: %Error: verilog/adder\.v:\d+:\d+: .*\(log: "
    ) as error:
        build("counter", {"W": 3}, verilog=sources)
    log = Path(str(error.value).rpartition("(log: ")[2].rstrip(")"))
    assert log.parent == cache / "logs"
    assert "| endmodul\n" in log.read_text()
    assert not list((cache / "models").glob(f"{log.stem}*"))


def test_a_parameter_outside_its_range_is_told_by_its_rule() -> None:
    with pytest.raises(ToolchainError, match=r"^cannot build fifo W=0: W must be at least 1 \(log: "):
        build("fifo", {"W": 0})


def test_cpp_that_the_compiler_refuses(sources: Path) -> None:
    with pytest.raises(ToolchainError, match=r"^cannot build counter: twice\.cpp:\d+:\d+: error: .*no_such_port"):
        build("counter", extra_cpp={"twice.cpp": DOUBLE.replace("count;", "no_such_port;")}, verilog=sources)


def test_a_compiler_that_dies(sources: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    broken = tmp_path / "broken-g++"
    broken.write_text(
        '#!/bin/sh\n[ "$1" = --version ] && echo broken 1.0 && exit\necho "as: error: No space left" >&2\nexit 1\n'
    )
    broken.chmod(0o755)
    monkeypatch.setenv("CXX", str(broken))
    with pytest.raises(ToolchainError, match=r"^cannot build counter: as: error: No space left \(log: "):
        build("counter", verilog=sources)


def test_a_cache_that_cannot_be_written(sources: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("EVCOT_CACHE", str(tmp_path / "file"))
    with pytest.raises(ToolchainError, match=r"/file/models: cannot keep the built model: Not a directory$"):
        build("counter", verilog=sources)


def start_build(sources: Path, cache: Path, width: int) -> subprocess.Popen[bytes]:
    """Another process that builds the counter."""
    script = (
        "import sys; from pathlib import Path; from evcot_cosim.rtl.build import build\n"
        "print(build('counter', {'W': int(sys.argv[2])}, verilog=Path(sys.argv[1])).cached)"
    )
    return subprocess.Popen(
        [sys.executable, "-c", script, str(sources), str(width)],
        env={"NUMBA_CACHE_DIR": str(cache.with_name("kernels")), **os.environ, "EVCOT_CACHE": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def test_an_interrupted_build_leaves_nothing_behind(sources: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    process = start_build(sources, cache, 6)
    deadline = time.monotonic() + 60
    while not list(cache.glob("building-*/Vcounter.mk")):  # Verilator is done, the compiler at work
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=30)
    assert process.returncode != 0
    assert [path for path in cache.rglob("*") if path.is_file()] == []


def test_two_processes_that_need_the_same_model_build_it_once(sources: Path, cache: Path) -> None:
    both = [start_build(sources, cache, 7) for _ in range(2)]
    printed = [process.communicate(timeout=120)[0] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert sorted(printed) == [b"False\n", b"True\n"], "the second waits, and finds it"
    assert not list((cache / "models").glob(".*"))
    assert build("counter", {"W": 7}, verilog=sources).cached
    assert not list(cache.glob("building-*"))


def test_what_nobody_uses_is_swept_away(sources: Path, cache: Path) -> None:
    kept = build("counter", verilog=sources).shared_object.parent
    unused = cache / "models" / "counter-of-long-ago"
    shutil.copytree(kept, unused)
    os.utime(unused, (0, 0))
    users = [cache / "models" / "mine", cache / "building-plans"]
    for folder in users:
        folder.mkdir()
        (folder / "notes.txt").write_text("no build made this")
        os.utime(folder, (0, 0))
    os.utime(kept, (0, 0))
    build("counter", verilog=sources)  # a hit marks it as used
    build("counter", {"W": 10}, verilog=sources)
    assert kept.is_dir()
    assert not unused.exists()
    assert all((folder / "notes.txt").is_file() for folder in users)


def test_the_rtl_folder_holds_what_the_manifest_lists() -> None:
    listed = manifest()
    assert sorted(listed) == sorted(path.relative_to(verilog_dir()).as_posix() for path in rtl_files().values())
    assert len({Path(name).name for name in listed}) == len(listed), "two files share a name"
    for position, name in enumerate(listed):
        text = (verilog_dir() / name).read_text()
        later = [other for other in listed[position + 1 :] if f'`include "{Path(other).name}"' in text]
        assert later == [], f"{name} comes before a header that it includes"


def test_another_copy_of_the_rtl_can_be_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("EVCOT_VERILOG", str(tmp_path))
    assert verilog_dir() == tmp_path
    monkeypatch.delenv("EVCOT_VERILOG")
    assert (verilog_dir() / "tracker" / "array" / "cot_array.v").is_file()


def test_macros_and_files_keep_their_order(capsys: pytest.CaptureFixture[str]) -> None:
    main(["pyverilator_wrapper.cpp", "stream.cpp", "-DVL_INCLUDE_OPT=include", "Vcot.cpp"])
    assert capsys.readouterr().out.splitlines() == [
        '#include "pyverilator_wrapper.cpp"',
        '#include "stream.cpp"',
        "#define VL_INCLUDE_OPT include",
        '#include "Vcot.cpp"',
    ]


def test_only_what_runs_once_is_not_optimised(capsys: pytest.CaptureFixture[str]) -> None:
    main(["Vcot___024root__0.cpp", "Vcot___024root__0__Slow.cpp", "Vcot__Trace__0.cpp"])
    lines = capsys.readouterr().out.splitlines()
    begin, end = lines.index("#pragma GCC push_options"), lines.index("#pragma GCC pop_options")
    assert '#pragma GCC optimize ("O0")' in lines[begin:end]
    assert [line for line in lines[begin:end] if "include" in line] == ['#include "Vcot___024root__0__Slow.cpp"']
    assert lines[0] == '#include "Vcot___024root__0.cpp"'
    assert lines[-1] == '#include "Vcot__Trace__0.cpp"'
