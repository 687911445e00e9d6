# SPDX-License-Identifier: Apache-2.0
"""Errors that a user can cause: one printable line with the place, the value and the rule."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

__all__ = ["refused"]


@contextmanager
def refused(error: type[Exception], message: str = "", *, start: str = "") -> Iterator[None]:
    """A block that must fail with this message, or with one that starts like this."""
    with pytest.raises(error) as caught:
        yield
    said = str(caught.value)
    assert said.isprintable(), said
    if start:
        assert said.startswith(start), said
    else:
        assert said == message
