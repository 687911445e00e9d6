// SPDX-License-Identifier: Apache-2.0
// The register map of evcot_top.v: byte addresses of the banks, places of fields on AXI4-Stream and in a record.
// Generated from sw/evcot/hardware/registers.toml and contract.py by `python -m evcot.hardware.generate`: edit there.
`ifndef EVCOT_REGS_VH
`define EVCOT_REGS_VH

`define EVCOT_CSR_ID      32'h45564354
`define EVCOT_CSR_MAJOR   16'd2
`define EVCOT_CSR_MINOR   16'd1
`define EVCOT_CSR_ADDR_W  14

// Banks: base address of the first of each kind; in each bank, the word that commits and the last register.
`define EVCOT_BANK_FILTER 14'h200
`define EVCOT_BANK_SLOT 14'h2000
`define EVCOT_BANK_COMMIT 5'd31
`define EVCOT_BANK_LAST 5'd19

// Bit numbers of the sources.
`define EVCOT_SOURCE_EVENTS 0
`define EVCOT_SOURCE_LFSR 1
`define EVCOT_SOURCE_AER 2
`define EVCOT_SOURCE_EVT2 3
`define EVCOT_SOURCE_EVT21 4
`define EVCOT_SOURCE_EVT3 5

// Kinds of trackers.
`define EVCOT_TRACKER_ARRAY 0
`define EVCOT_TRACKER_CHAIN 1

// Bit numbers of the interrupts.
`define EVCOT_IRQ_BIRTH 0
`define EVCOT_IRQ_LOSS 1
`define EVCOT_IRQ_MERGE 2
`define EVCOT_IRQ_OVERFLOW 3
`define EVCOT_IRQ_COMMIT 4
`define EVCOT_IRQ_W 5

// Words on AXI4-Stream.
`define EVCOT_EVENT_T_LSB 0
`define EVCOT_EVENT_T_W 32
`define EVCOT_EVENT_X_LSB 32
`define EVCOT_EVENT_X_W 15
`define EVCOT_EVENT_Y_LSB 47
`define EVCOT_EVENT_Y_W 15
`define EVCOT_EVENT_P_LSB 62
`define EVCOT_EVENT_P_W 1
`define EVCOT_OWNED_X_LSB 0
`define EVCOT_OWNED_X_W 14
`define EVCOT_OWNED_Y_LSB 14
`define EVCOT_OWNED_Y_W 14
`define EVCOT_OWNED_SLOT_LSB 28
`define EVCOT_OWNED_SLOT_W 6
`define EVCOT_OWNED_P_LSB 34
`define EVCOT_OWNED_P_W 1
`define EVCOT_OWNED_SEQ_LSB 35
`define EVCOT_OWNED_SEQ_W 29
`define EVCOT_PASSED_X_LSB 0
`define EVCOT_PASSED_X_W 16
`define EVCOT_PASSED_Y_LSB 16
`define EVCOT_PASSED_Y_W 16
`define EVCOT_PASSED_P_LSB 34
`define EVCOT_PASSED_P_W 1
`define EVCOT_PASSED_SEQ_LSB 35
`define EVCOT_PASSED_SEQ_W 29

// A record: contract.RECORD.
`define EVCOT_RECORD_W 384
`define EVCOT_RECORD_SEQ_LSB 0
`define EVCOT_RECORD_SEQ_W 64
`define EVCOT_RECORD_TIME_LSB 64
`define EVCOT_RECORD_TIME_W 64
`define EVCOT_RECORD_TRACK_ID_LSB 128
`define EVCOT_RECORD_TRACK_ID_W 32
`define EVCOT_RECORD_OTHER_ID_LSB 160
`define EVCOT_RECORD_OTHER_ID_W 32
`define EVCOT_RECORD_CM_X_LSB 192
`define EVCOT_RECORD_CM_X_W 32
`define EVCOT_RECORD_CM_Y_LSB 224
`define EVCOT_RECORD_CM_Y_W 32
`define EVCOT_RECORD_SUPPORT_LSB 256
`define EVCOT_RECORD_SUPPORT_W 32
`define EVCOT_RECORD_RADIUS_LSB 288
`define EVCOT_RECORD_RADIUS_W 16
`define EVCOT_RECORD_N_EV_LSB 304
`define EVCOT_RECORD_N_EV_W 16
`define EVCOT_RECORD_SLOT_LSB 320
`define EVCOT_RECORD_SLOT_W 8
`define EVCOT_RECORD_KIND_LSB 328
`define EVCOT_RECORD_KIND_W 8

`endif
