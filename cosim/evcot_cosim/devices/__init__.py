# SPDX-License-Identifier: Apache-2.0
"""Compiled RTL as Python objects: events or words stream in and answers come out; or pins and clocks, by hand."""
