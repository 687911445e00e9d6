# SPDX-License-Identifier: Apache-2.0
"""Commands of the command line, one module each; `add` adds one to the parser."""
