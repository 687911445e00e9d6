# SPDX-License-Identifier: Apache-2.0
"""A recording, a network stream or a camera tracked while it happens, and shown while it is tracked.

Source -> `waiting` (bounded, newest wins) -> tracker -> an `Inbox` for each who looks -> `frame` -> page or terminal.
"""

__all__ = ["PORT"]

PORT = 8765  # of the page
