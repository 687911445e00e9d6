# SPDX-License-Identifier: Apache-2.0
# kv260_evcot for a Cyclone V, all ports virtual, from a release folder: quartus_sh -t scripts/quartus_kv260.tcl
# Written for Quartus Prime Standard 22.1. Untested: it was never run in Quartus.

package require ::quartus::project
package require ::quartus::flow

set release [file dirname [file dirname [file normalize [info script]]]]

project_new -overwrite kv260_evcot
set_global_assignment -name FAMILY "Cyclone V"
set_global_assignment -name DEVICE 5CSEBA6U23I7
set_global_assignment -name TOP_LEVEL_ENTITY kv260_evcot
set_global_assignment -name SEARCH_PATH $release/examples
set_global_assignment -name VERILOG_FILE $release/evcot.v
set_global_assignment -name VERILOG_FILE $release/examples/kv260_evcot.v
set_global_assignment -name SDC_FILE $release/scripts/kv260.sdc
set_instance_assignment -name VIRTUAL_PIN ON -to *
set_instance_assignment -name VIRTUAL_PIN OFF -to aclk
execute_flow -compile
project_close
