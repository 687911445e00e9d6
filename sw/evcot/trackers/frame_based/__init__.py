# SPDX-License-Identifier: Apache-2.0
"""The classical pipeline on accumulated frames: median filter, connected components, optimal assignment."""
