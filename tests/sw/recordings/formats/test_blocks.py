# SPDX-License-Identifier: Apache-2.0
"""Parts become blocks; what is read ahead comes in the order of its pieces, exceptions too."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest

from evcot.errors import RecordingError
from evcot.recordings.formats.blocks import batches, in_order


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [([3, 2, 9, 1], [[3, 2], [9], [1]]), ([4, 1, 5], [[4, 1], [5], []]), ([6, 2, 2], [[6], [2, 2]]), ([], [[]])],
)
def test_parts_are_gathered_up_to_a_size_of_five(sizes: list[int], expected: list[list[int]]) -> None:
    assert list(batches(sizes, 5, lambda size: size)) == expected


def test_parts_before_an_error_come_before_it() -> None:
    def parts() -> Iterator[int]:
        yield from (5, 1, 2)
        raise RecordingError("damaged")

    given: list[list[int]] = []
    with pytest.raises(RecordingError, match="damaged"):
        given.extend(batches(parts(), 5, lambda size: size))
    assert given == [[5], [1, 2]]


def test_results_stand_in_the_order_of_their_pieces() -> None:
    def slow_at_first(piece: int) -> int:
        time.sleep(0.01 if piece % 3 == 0 else 0.0)
        return 10 * piece

    assert list(in_order(slow_at_first, range(40), workers=2)) == [10 * piece for piece in range(40)]
    assert list(in_order(slow_at_first, [], workers=2)) == []


@pytest.mark.parametrize("error", [ValueError("piece 7"), OSError(5, "Input/output error")])
@pytest.mark.parametrize("failing", ["pieces", "decode"])
def test_what_goes_wrong_comes_after_all_before_it_and_nothing_comes_after(error: Exception, failing: str) -> None:
    def pieces() -> Iterator[int]:
        for piece in range(20):
            if failing == "pieces" and piece == 7:
                raise error
            yield piece

    def decode(piece: int) -> int:
        if failing == "decode" and piece == 7:
            raise error
        return piece

    given: list[int] = []
    with pytest.raises(type(error)) as caught:
        given.extend(in_order(decode, pieces()))
    assert caught.value is error
    assert given == list(range(7))


def test_pieces_are_made_a_few_ahead_and_no_more_and_the_first_without_a_thread() -> None:
    made: list[int] = []

    def pieces() -> Iterator[int]:
        for piece in range(1_000):
            made.append(piece)
            yield piece

    threads = threading.active_count()
    results = in_order(lambda piece: piece, pieces())
    assert next(results) == 0
    assert threading.active_count() == threads
    assert made == [0]
    assert [next(results) for _ in range(2)] == [1, 2]
    assert made == list(range(7)), "four ahead"
    results.close()  # type: ignore[attr-defined]
    assert len(made) == 7


def test_pieces_are_made_on_the_callers_thread_and_all_but_the_first_are_decoded_on_others() -> None:
    makers: set[int] = set()
    decoders: list[int] = []

    def pieces() -> Iterator[int]:
        for piece in range(20):
            makers.add(threading.get_ident())
            yield piece

    for _ in in_order(lambda _: decoders.append(threading.get_ident()), pieces(), workers=1):
        pass
    assert makers == {threading.get_ident()}
    assert decoders[0] == threading.get_ident()
    assert len(decoders) == 20
    assert len(set(decoders[1:])) == 1
    assert not set(decoders[1:]) & makers
