# SPDX-License-Identifier: Apache-2.0
"""What the commands do; imported when a command is called."""
