# SPDX-License-Identifier: Apache-2.0
"""Event files: reading, writing and describing them."""
