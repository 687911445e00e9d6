# SPDX-License-Identifier: Apache-2.0
# kv260_evcot for a CertusPro-NX, synthesis and map, from a release folder: radiantc scripts/radiant_kv260.tcl
# Written for Radiant 2023.2. Untested: it was never run in Radiant.

set release [file dirname [file dirname [file normalize [info script]]]]

prj_create -name kv260_evcot -impl impl_1 -dev LFCPNX-100-9LFG672C -performance 9_High-Performance_1.0V -synthesis synplify
prj_add_source $release/evcot.v
prj_add_source $release/examples/kv260_evcot.v
prj_add_source $release/scripts/kv260.sdc
prj_set_impl_opt -impl impl_1 top kv260_evcot
prj_set_impl_opt -impl impl_1 {include path} $release/examples
prj_run Synthesis -impl impl_1
prj_run Map -impl impl_1
prj_save
prj_close
