# SPDX-License-Identifier: Apache-2.0
"""Test vectors of `evcot_top`: register accesses, events, and the beats that the golden model expects, as hex files."""
