# SPDX-License-Identifier: Apache-2.0
# kv260_evcot for the Kria K26, out of context, from a release folder: vivado -mode batch -source scripts/vivado_kv260.tcl
# Written for Vivado 2023.2. Untested: it was never run in Vivado.

set release [file dirname [file dirname [file normalize [info script]]]]

read_verilog [list $release/evcot.v $release/examples/kv260_evcot.v]
read_xdc $release/scripts/kv260.sdc
synth_design -top kv260_evcot -part xck26-sfvc784-2LV-c -include_dirs $release/examples -mode out_of_context
opt_design
place_design
route_design
report_utilization -file kv260_utilization.rpt
report_timing_summary -file kv260_timing.rpt
write_checkpoint -force kv260_evcot.dcp
