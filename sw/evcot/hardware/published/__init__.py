# SPDX-License-Identifier: Apache-2.0
"""The published tracker: its golden model and its register map."""
