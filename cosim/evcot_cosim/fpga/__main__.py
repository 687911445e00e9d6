# SPDX-License-Identifier: Apache-2.0
"""`python -m evcot_cosim.fpga`: what the RTL costs on an FPGA."""

import sys

from .cli import main

sys.exit(main())
