# SPDX-License-Identifier: Apache-2.0
"""Event filters in front of a tracker: golden models of the hardware's filters; docs/filters.md specifies both."""
