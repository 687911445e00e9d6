# SPDX-License-Identifier: Apache-2.0
"""`python -m evcot_cosim.fpga`: area and speed of the RTL on FPGAs."""

import sys

from .cli import main

sys.exit(main())
