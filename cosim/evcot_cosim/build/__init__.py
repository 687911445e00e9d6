# SPDX-License-Identifier: Apache-2.0
"""From Verilog to a loadable model: tools, sources, and a cache of what was built."""
