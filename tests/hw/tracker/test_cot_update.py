# SPDX-License-Identifier: Apache-2.0
"""cot_update.v against the golden model's EV_NO_PROC and EV_PROC, on random clusters and registers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.hardware import _cot_kernel as kernel
from evcot.hardware.contract import REGISTERS, Shape
from support.testing import evaluate, lint

COUNT = 20_000
GROUP_1 = ["new_av_x", "new_av_y", "new_ring", "new_support"]
GROUP_2 = ["new_cm_x", "new_cm_y", "new_g", "new_n_ev"]
SHAPES = {
    "default": Shape(n_slots=1),
    "published": Shape(n_slots=1, x_w=7, y_w=7, frac=0, radix_w=5, nev_w=4, tc_w=6, sup_w=3),
    "one bit": Shape(1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 8, 8),
    "widest": Shape(1, 16, 16, 8, 32, 12, 16, 32, 32, 32, 48, 48),
}


def parameters(shape: Shape) -> dict[str, int]:
    names = {
        "X_W": "x_w",
        "Y_W": "y_w",
        "FRAC": "frac",
        "RADIX_W": "radix_w",
        "NEV_W": "nev_w",
        "TC_W": "tc_w",
        "SUP_W": "sup_w",
    }
    return {verilog: getattr(shape, name) for verilog, name in names.items()}


def random_inputs(shape: Shape, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Clusters and registers as a run can have them."""

    def upto(high: int | np.ndarray) -> np.ndarray:
        return rng.integers(0, np.broadcast_to(high, COUNT), endpoint=True)

    def bits(width: int) -> np.ndarray:
        """As likely of any length in bits."""
        return upto(1 << width) >> rng.integers(0, width + 1, COUNT) & (1 << width) - 1

    radius = np.sort([bits(shape.radix_w) for _ in range(3)], axis=0)
    n_ev = np.sort([np.maximum(bits(shape.nev_w), 1) for _ in range(3)], axis=0)
    inputs = {
        "active": upto(1), "ring": upto(1), "support": upto((1 << shape.sup_w) - 1),
        "count": n_ev[1] - 1 - np.minimum(upto(2), n_ev[1] - 1),
        "g": radius[1], "n_ev": n_ev[1], "tc2": bits(shape.tc_w), "last_tc2": bits(shape.tc_w),
        "radix_step": bits(shape.radix_w), "radix_min": radius[0], "radix_max": radius[2], "hist_avg": upto(8),
        "nev_min": n_ev[0], "nev_max": n_ev[2], "nev_th": bits(shape.tc_w) >> 1,
    }  # fmt: skip
    for axis, width in (("x", shape.x_w), ("y", shape.y_w)):
        top = (1 << width) - 1
        inputs[f"cm_{axis}"], inputs[f"av_{axis}"] = upto(top << shape.frac), upto(top << shape.frac)
        inputs[f"pixel_{axis}"] = inputs[f"cm_{axis}"] + ((1 << shape.frac) >> 1) >> shape.frac
        inputs[axis] = np.clip(inputs[f"pixel_{axis}"] + rng.integers(-3, 4, COUNT) * radius[1] // 2, 0, top)
    return inputs


def model(shape: Shape, given: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same through the golden model's own functions, one cluster at a time."""
    result = {name: np.empty(COUNT, np.int64) for name in ["last", *GROUP_1, *GROUP_2]}
    limits = np.zeros(kernel.LIMIT_COUNT, np.int64)
    limits[[kernel.FRAC, kernel.X_MAX, kernel.Y_MAX, kernel.TC_MAX, kernel.SUPPORT_MAX, kernel.ID_MASK]] = (
        shape.frac, *((1 << w) - 1 for w in (shape.x_w, shape.y_w, shape.tc_w, shape.sup_w, shape.id_w)),
    )  # fmt: skip
    state, registers = np.zeros((kernel.FIELD_COUNT, 1), np.int64), np.zeros((len(REGISTERS), 1), np.int64)
    global_state = np.zeros(kernel.GLOBAL_COUNT, np.int64)
    names = {"cm_x": kernel.CM_X, "cm_y": kernel.CM_Y, "av_x": kernel.AV_X, "av_y": kernel.AV_Y, "g": kernel.G}
    names |= {"n_ev": kernel.N_EV, "ring": kernel.RING, "support": kernel.SUPPORT}
    outputs = {f"new_{name}": row for name, row in names.items()}
    names |= {"count": kernel.COUNT, "active": kernel.ACTIVE, "last_tc2": kernel.LAST_TC2}
    addresses = {name: i for i, name in enumerate(REGISTERS) if name in given}
    for i in range(COUNT):
        for name, row in names.items():
            state[row, 0] = given[name][i]
        for name, row in addresses.items():
            registers[row, 0] = given[name][i]
        now = 1 << 40
        state[kernel.START, 0] = now - given["tc2"][i]
        last = kernel._take(state, registers, limits, 0, given["x"][i], given["y"][i], now)
        result["last"][i] = last
        for name in GROUP_1:
            result[name][i] = state[outputs[name], 0]
        if last:
            state[kernel.START, 0] = now - given["tc2"][i]
            kernel._proc(state, registers, limits, global_state, 0, now)
        for name in GROUP_2:
            result[name][i] = state[outputs[name], 0]
    return result


@pytest.mark.parametrize("name", SHAPES)
def test_is_what_the_model_computes(name: str) -> None:
    shape = SHAPES[name]
    given = random_inputs(shape, np.random.default_rng(11))
    result = evaluate("cot_update", parameters(shape), given, ["last", *GROUP_1, *GROUP_2])
    expected = model(shape, given)
    last = expected["last"].astype(bool)
    assert np.count_nonzero(last) > 1000
    for port in ["last", *GROUP_1]:
        np.testing.assert_array_equal(result[port], expected[port], err_msg=port)
    for port in GROUP_2:  # hold with the N_ev-th event alone
        np.testing.assert_array_equal(result[port][last], expected[port][last], err_msg=port)
    if name == "default":  # every branch was taken
        n_ev, radius = expected["new_n_ev"][last] - given["n_ev"][last], expected["new_g"][last] - given["g"][last]
        for change in (n_ev, radius):
            assert all(np.count_nonzero(chosen) > 200 for chosen in (change < 0, change == 0, change > 0))


def answer(**changed: int) -> dict[str, int]:
    """A cluster at (64, 64) with g = 4 whose second of two events is at its centre, `changed` aside."""
    given = {
        "x": 64, "y": 64, "active": 1, "cm_x": 1024, "cm_y": 1024, "pixel_x": 64, "pixel_y": 64, "av_x": 1024, "av_y": 1024,
        "g": 4, "ring": 0, "n_ev": 2, "count": 1, "support": 9, "tc2": 10, "last_tc2": 10,
        "radix_step": 1, "radix_min": 2, "radix_max": 6, "hist_avg": 1, "nev_min": 1, "nev_max": 8, "nev_th": 3,
    }  # fmt: skip
    result = evaluate("cot_update", parameters(SHAPES["default"]), given | changed, ["last", *GROUP_1, *GROUP_2])
    return {port: int(values[0]) for port, values in result.items()}


def test_the_average_takes_half_of_the_way_and_the_centre_half_of_that() -> None:
    result = answer(x=70, y=60)
    assert (result["new_av_x"], result["new_av_y"]) == (67 * 16, 62 * 16)
    assert (result["new_cm_x"], result["new_cm_y"]) == (65.5 * 16, 63 * 16)


@pytest.mark.parametrize(
    ("changed", "ring", "g"),
    [
        ({}, 0, 3),
        ({"x": 68}, 0, 3),
        ({"x": 69}, 1, 5),
        ({"y": 59}, 1, 5),
        ({"ring": 1}, 1, 5),
        ({"ring": 1, "g": 6}, 1, 6),
        ({"g": 2}, 0, 2),
    ],
)
def test_g_grows_with_an_event_beyond_it_and_shrinks_without(changed: dict[str, int], ring: int, g: int) -> None:
    result = answer(**changed)
    assert (result["new_ring"], result["new_g"]) == (ring, g)


@pytest.mark.parametrize(("tc2", "n_ev"), [(13, 2), (14, 4), (7, 2), (6, 1)])
def test_n_ev_doubles_when_slower_and_halves_when_faster_by_more_than_the_threshold(tc2: int, n_ev: int) -> None:
    assert answer(tc2=tc2)["new_n_ev"] == n_ev
    assert answer(tc2=tc2, active=0)["new_n_ev"] == 2  # the first window has nothing to compare with


def test_the_last_event_is_the_n_evth() -> None:
    assert [answer(count=count)["last"] for count in (0, 1)] == [0, 1]


def test_support_saturates() -> None:
    assert [answer(support=support)["new_support"] for support in (65534, 65535)] == [65535, 65535]


@pytest.mark.parametrize("name", SHAPES)
def test_lints_clean(name: str) -> None:
    assert lint("cot_update", **parameters(SHAPES[name])) == (0, "")


@pytest.mark.parametrize(("parameter", "high"), [("RADIX_W", 12), ("NEV_W", 16), ("TC_W", 32), ("SUP_W", 32)])
def test_refuses_parameters_out_of_range(parameter: str, high: int) -> None:
    for value in (0, high + 1):
        code, log = lint("cot_update", **parameters(replace(SHAPES["default"])) | {parameter: value})
        assert code != 0
        assert f"{parameter}_must_be_1_to_{high}" in log
