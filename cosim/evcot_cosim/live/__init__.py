# SPDX-License-Identifier: Apache-2.0
"""Live view: tracks a recording, a network stream or a camera in real time and displays the result.

Source -> `waiting` (bounded; the oldest are dropped) -> tracker -> a queue per subscriber -> `frame` -> page or terminal.
"""

__all__ = ["PORT"]

PORT = 8765  # of the page
