# SPDX-License-Identifier: Apache-2.0
"""Pages and pictures for those who build hardware with the RTL, made from the RTL: `python -m evcot_cosim.pages`."""
