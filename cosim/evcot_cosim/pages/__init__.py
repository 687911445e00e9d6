# SPDX-License-Identifier: Apache-2.0
"""Generator of the hardware documentation's pages and pictures from the RTL: `make generate` and `make docs`."""
