# SPDX-License-Identifier: Apache-2.0
"""A baseline: median filter, connected components and optimal assignment on accumulated frames."""
