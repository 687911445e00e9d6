# SPDX-License-Identifier: Apache-2.0
"""rtl.joined: one C++ file of those of a model, in make's order, with what runs once not optimised."""

from __future__ import annotations

import pytest

from evcot_cosim.rtl.joined import main


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
