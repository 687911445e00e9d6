# SPDX-License-Identifier: Apache-2.0
"""Lines by a Hough transform of spiking cells: golden model of the hardware, and a follower; docs/lines.md specifies both."""
