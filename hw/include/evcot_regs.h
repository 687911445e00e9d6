/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The registers of evcot_top.v: byte addresses, fields, and the words of its streams.
 * Generated from sw/evcot/hardware/registers.toml and contract.py by `python -m evcot.hardware.generate`: edit there.
 *
 * A field F of a word has EVCOT_F_SHIFT and EVCOT_F_MASK (in place): EVCOT_GET(word, EVCOT_STATUS_HELD).
 */
#ifndef EVCOT_REGS_H
#define EVCOT_REGS_H

#include <stdint.h>

#define EVCOT_GET(word, field) (((word) & field##_MASK) >> field##_SHIFT)
#define EVCOT_PUT(value, field) (((uint32_t)(value) << field##_SHIFT) & field##_MASK)

#define EVCOT_ID_VALUE 0x45564354u
#define EVCOT_VERSION_MAJOR_VALUE 3u

/* the letters EVCT */
#define EVCOT_ID 0x000u

/* version of this map */
#define EVCOT_VERSION 0x004u
#define EVCOT_VERSION_MINOR_SHIFT 0u
#define EVCOT_VERSION_MINOR_MASK 0x0000FFFFu /* ro: incremented with compatible additions; 0 without the classifier */
#define EVCOT_VERSION_MAJOR_SHIFT 16u
#define EVCOT_VERSION_MAJOR_MASK 0xFFFF0000u /* ro: incremented with incompatible changes */

/* shape of the trackers */
#define EVCOT_SHAPE0 0x008u
#define EVCOT_SHAPE0_N_SLOTS_SHIFT 0u
#define EVCOT_SHAPE0_N_SLOTS_MASK 0x0000007Fu /* ro: tracker slots */
#define EVCOT_SHAPE0_FRAC_SHIFT 8u
#define EVCOT_SHAPE0_FRAC_MASK 0x00000F00u /* ro: fractional bits of a centre; not used by cot_motion */
#define EVCOT_SHAPE0_X_W_SHIFT 16u
#define EVCOT_SHAPE0_X_W_MASK 0x001F0000u /* ro: bits of an x address */
#define EVCOT_SHAPE0_Y_W_SHIFT 24u
#define EVCOT_SHAPE0_Y_W_MASK 0x1F000000u /* ro: bits of a y address */

/* shape of the trackers */
#define EVCOT_SHAPE1 0x00Cu
#define EVCOT_SHAPE1_TICK_W_SHIFT 0u
#define EVCOT_SHAPE1_TICK_W_MASK 0x0000003Fu /* ro: bits of the ticks in a token */
#define EVCOT_SHAPE1_RADIX_W_SHIFT 8u
#define EVCOT_SHAPE1_RADIX_W_MASK 0x00000F00u /* ro: bits of a radius register */
#define EVCOT_SHAPE1_NEV_W_SHIFT 16u
#define EVCOT_SHAPE1_NEV_W_MASK 0x001F0000u /* ro: bits of N_ev */
#define EVCOT_SHAPE1_TC_W_SHIFT 24u
#define EVCOT_SHAPE1_TC_W_MASK 0x3F000000u /* ro: bits of a timer */

/* shape of the trackers */
#define EVCOT_SHAPE2 0x010u
#define EVCOT_SHAPE2_SUP_W_SHIFT 0u
#define EVCOT_SHAPE2_SUP_W_MASK 0x0000003Fu /* ro: bits of a support count */
#define EVCOT_SHAPE2_ID_W_SHIFT 8u
#define EVCOT_SHAPE2_ID_W_MASK 0x00003F00u /* ro: bits of a track id */
#define EVCOT_SHAPE2_SEQ_W_SHIFT 16u
#define EVCOT_SHAPE2_SEQ_W_MASK 0x003F0000u /* ro: bits of an event's number */
#define EVCOT_SHAPE2_TIME_W_SHIFT 24u
#define EVCOT_SHAPE2_TIME_W_MASK 0x3F000000u /* ro: bits of the tick count */

/* build options of the hardware */
#define EVCOT_BUILD 0x014u
#define EVCOT_BUILD_FILTERS_SHIFT 0u
#define EVCOT_BUILD_FILTERS_MASK 0x000000FFu /* ro: a bit for each filter, in their order */
#define EVCOT_BUILD_SOURCES_SHIFT 8u
#define EVCOT_BUILD_SOURCES_MASK 0x00003F00u /* ro: a bit for each source, in the order of `source_select` */
#define EVCOT_BUILD_TICKS_SHIFT 14u
#define EVCOT_BUILD_TICKS_MASK 0x0000C000u /* ro: what a tick may be, besides 1 us of the events' time: 1 `tick_us`, 2 `prescale`, 3 both */
#define EVCOT_BUILD_TRACKER_SHIFT 16u
#define EVCOT_BUILD_TRACKER_MASK 0x00030000u /* ro: 0 cot_array, 1 cot_chain, 2 cot_motion: the parameter TRACKER */
#define EVCOT_BUILD_CLASSIFIER_SHIFT 20u
#define EVCOT_BUILD_CLASSIFIER_MASK 0x00F00000u /* ro: version of the classifier (docs/recognition.md); 0: none, the parameter CLASSIFY */
#define EVCOT_BUILD_CELL_PX_SHIFT 24u
#define EVCOT_BUILD_CELL_PX_MASK 0x07000000u /* ro: side of a cell of the filters' memory in pixels; 0: a time stamp per pixel and filter */

/* size of the sensor */
#define EVCOT_SENSOR 0x018u
#define EVCOT_SENSOR_LAST_X_SHIFT 0u
#define EVCOT_SENSOR_LAST_X_MASK 0x0000FFFFu /* ro: last column: width - 1 */
#define EVCOT_SENSOR_LAST_Y_SHIFT 16u
#define EVCOT_SENSOR_LAST_Y_MASK 0xFFFF0000u /* ro: last row: height - 1 */

/* memories */
#define EVCOT_MEMORY 0x01Cu
#define EVCOT_MEMORY_STAMP_W_SHIFT 0u
#define EVCOT_MEMORY_STAMP_W_MASK 0x0000003Fu /* ro: bits of a time stamp in a filter's memory */
#define EVCOT_MEMORY_RECENT_LAST_SHIFT 8u
#define EVCOT_MEMORY_RECENT_LAST_MASK 0x0000FF00u /* ro: events that the filter `recent` holds, less 1 */
#define EVCOT_MEMORY_FIFO_DEPTH_SHIFT 16u
#define EVCOT_MEMORY_FIFO_DEPTH_MASK 0xFFFF0000u /* ro: tokens that the input FIFO holds */

/* control */
#define EVCOT_CONTROL 0x020u
#define EVCOT_CONTROL_ENABLE_SHIFT 0u
#define EVCOT_CONTROL_ENABLE_MASK 0x00000001u /* rw: 1: pass tokens to filters and trackers; 0: they wait in the input FIFO */
#define EVCOT_CONTROL_DROP_SHIFT 1u
#define EVCOT_CONTROL_DROP_MASK 0x00000002u /* rw: 1: a full input FIFO drops events and keeps their time; 0: it stalls the source */
#define EVCOT_CONTROL_SLVERR_SHIFT 2u
#define EVCOT_CONTROL_SLVERR_MASK 0x00000004u /* rw: 1: an access that `fault` records is answered with SLVERR; 0: with OKAY */
#define EVCOT_CONTROL_LATCH_SHIFT 8u
#define EVCOT_CONTROL_LATCH_MASK 0x00000100u /* pulse: copy all counters in one clock to the registers in which they are read */
#define EVCOT_CONTROL_SOFT_RESET_SHIFT 9u
#define EVCOT_CONTROL_SOFT_RESET_MASK 0x00000200u /* pulse: at once reset everything except the registers and the data that has reached an output; `source`, `tick_us`, `prescale` and `lfsr_*` take effect */

/* source of events; takes effect with `soft_reset` */
#define EVCOT_SOURCE 0x024u
#define EVCOT_SOURCE_SELECT_SHIFT 0u
#define EVCOT_SOURCE_SELECT_MASK 0x00000007u /* rw: 0 events, 1 LFSR, 2 AER, 3 EVT 2.0, 4 EVT 2.1, 5 EVT 3.0; it must have been built */
#define EVCOT_SOURCE_CLOCK_TIME_SHIFT 8u
#define EVCOT_SOURCE_CLOCK_TIME_MASK 0x00000100u /* rw: 1: ticks come from the clock; 0: from the events' own time */
#define EVCOT_SOURCE_SWAP_BYTES_SHIFT 16u
#define EVCOT_SOURCE_SWAP_BYTES_MASK 0x00010000u /* rw: EVT: the high byte comes first */
#define EVCOT_SOURCE_SWAP_HALVES_SHIFT 17u
#define EVCOT_SOURCE_SWAP_HALVES_MASK 0x00020000u /* rw: EVT 2.1: the upper half of a word comes first */
#define EVCOT_SOURCE_ACTIVE_LOW_SHIFT 24u
#define EVCOT_SOURCE_ACTIVE_LOW_MASK 0x01000000u /* rw: AER: request and acknowledge are active low */
#define EVCOT_SOURCE_WORD_SERIAL_SHIFT 25u
#define EVCOT_SOURCE_WORD_SERIAL_MASK 0x02000000u /* rw: AER: rows and columns are sent as separate words */

/* length of a tick of the events' own time; takes effect with `soft_reset` */
#define EVCOT_TICK_US 0x028u

/* length of a tick and of a microsecond in clocks; takes effect with `soft_reset` */
#define EVCOT_PRESCALE 0x02Cu
#define EVCOT_PRESCALE_TICK_SHIFT 0u
#define EVCOT_PRESCALE_TICK_MASK 0x0000FFFFu /* rw: clocks per tick, with `source_clock_time` */
#define EVCOT_PRESCALE_US_SHIFT 16u
#define EVCOT_PRESCALE_US_MASK 0xFFFF0000u /* rw: clocks per microsecond, for the time of AER events */

/* self-test source: seed; takes effect with `soft_reset` */
#define EVCOT_LFSR_SEED 0x030u

/* self-test source: distance of events */
#define EVCOT_LFSR_GAP 0x034u

/* self-test source: columns */
#define EVCOT_LFSR_X 0x038u
#define EVCOT_LFSR_X_MIN_SHIFT 0u
#define EVCOT_LFSR_X_MIN_MASK 0x0000FFFFu /* rw: first column */
#define EVCOT_LFSR_X_SPAN_SHIFT 16u
#define EVCOT_LFSR_X_SPAN_MASK 0xFFFF0000u /* rw: last column less the first */

/* self-test source: rows */
#define EVCOT_LFSR_Y 0x03Cu
#define EVCOT_LFSR_Y_MIN_SHIFT 0u
#define EVCOT_LFSR_Y_MIN_MASK 0x0000FFFFu /* rw: first row */
#define EVCOT_LFSR_Y_SPAN_SHIFT 16u
#define EVCOT_LFSR_Y_SPAN_MASK 0xFFFF0000u /* rw: last row less the first */

/* state of the hardware */
#define EVCOT_STATUS 0x040u
#define EVCOT_STATUS_IDLE_SHIFT 0u
#define EVCOT_STATUS_IDLE_MASK 0x00000001u /* ro: no data between the source and the outputs, and no commit pending; with `clock_time`, ticks count as data */
#define EVCOT_STATUS_PENDING_SHIFT 1u
#define EVCOT_STATUS_PENDING_MASK 0x00000002u /* ro: a commit is waiting or being applied */
#define EVCOT_STATUS_OPEN_SHIFT 2u
#define EVCOT_STATUS_OPEN_MASK 0x00000004u /* ro: the gate to filters and trackers is open */
#define EVCOT_STATUS_CLEARED_SHIFT 3u
#define EVCOT_STATUS_CLEARED_MASK 0x00000008u /* ro: the filters' memories have been cleared since the last reset; before that a write of `mask` is refused */
#define EVCOT_STATUS_HELD_SHIFT 16u
#define EVCOT_STATUS_HELD_MASK 0xFFFF0000u /* ro: tokens in the input FIFO */

/* accesses that were clamped or refused */
#define EVCOT_FAULT 0x044u
#define EVCOT_FAULT_CLAMPED_SHIFT 0u
#define EVCOT_FAULT_CLAMPED_MASK 0x00000001u /* w1c: a value was clamped */
#define EVCOT_FAULT_REFUSED_SHIFT 1u
#define EVCOT_FAULT_REFUSED_MASK 0x00000002u /* w1c: a value was refused */
#define EVCOT_FAULT_PENDING_SHIFT 2u
#define EVCOT_FAULT_PENDING_MASK 0x00000004u /* w1c: a write to a bank whose commit was pending, or of `mask` before `status.cleared`, was refused */
#define EVCOT_FAULT_UNMAPPED_SHIFT 3u
#define EVCOT_FAULT_UNMAPPED_MASK 0x00000008u /* w1c: a write to a read-only address, or any access to one that does not exist */
#define EVCOT_FAULT_ADDRESS_SHIFT 16u
#define EVCOT_FAULT_ADDRESS_MASK 0x3FFF0000u /* ro: address of the last of these accesses */

/* interrupt events since they were last cleared */
#define EVCOT_IRQ_STATUS 0x048u
#define EVCOT_IRQ_STATUS_BIRTH_SHIFT 0u
#define EVCOT_IRQ_STATUS_BIRTH_MASK 0x00000001u /* ro: a track was born */
#define EVCOT_IRQ_STATUS_LOSS_SHIFT 1u
#define EVCOT_IRQ_STATUS_LOSS_MASK 0x00000002u /* ro: a track was lost */
#define EVCOT_IRQ_STATUS_MERGE_SHIFT 2u
#define EVCOT_IRQ_STATUS_MERGE_MASK 0x00000004u /* ro: two tracks merged */
#define EVCOT_IRQ_STATUS_OVERFLOW_SHIFT 3u
#define EVCOT_IRQ_STATUS_OVERFLOW_MASK 0x00000008u /* ro: an event was dropped */
#define EVCOT_IRQ_STATUS_COMMIT_SHIFT 4u
#define EVCOT_IRQ_STATUS_COMMIT_MASK 0x00000010u /* ro: a commit took effect */

/* interrupt events that assert `irq` */
#define EVCOT_IRQ_ENABLE 0x04Cu

/* writing 1 clears a bit of `irq_status` */
#define EVCOT_IRQ_CLEAR 0x050u

/* number of the first event after the last commit */
#define EVCOT_COMMIT_SEQ_LOW 0x054u

/* number of the first event after the last commit */
#define EVCOT_COMMIT_SEQ_HIGH 0x058u

/* commits applied since reset */
#define EVCOT_COMMITS 0x05Cu

/* packets of `m_axis_records`: where tlast is 1 */
#define EVCOT_PACKET 0x060u
#define EVCOT_PACKET_RECORDS_SHIFT 0u
#define EVCOT_PACKET_RECORDS_MASK 0x0000FFFFu /* rw: records per packet */
#define EVCOT_PACKET_WAIT_SHIFT 16u
#define EVCOT_PACKET_WAIT_MASK 0xFFFF0000u /* rw: if not 0, a packet also ends 256 clocks times this value after its first record; the last beat of a record then waits for the next record or that time */

/* the word of the classifier's weights that `weight_data` reads and writes */
#define EVCOT_WEIGHT_ADDRESS 0x064u

/* a word of the classifier's weights */
#define EVCOT_WEIGHT_DATA 0x068u

/* words of the classifier's weights */
#define EVCOT_WEIGHTS 0x06Cu
#define EVCOT_WEIGHTS_LOADED_SHIFT 0u
#define EVCOT_WEIGHTS_LOADED_MASK 0x00000FFFu /* ro: words written since reset, counted in order from word 0 */
#define EVCOT_WEIGHTS_NEEDED_SHIFT 16u
#define EVCOT_WEIGHTS_NEEDED_MASK 0x0FFF0000u /* ro: words that there are; with fewer of them loaded, a commit of `enable` = 1 is refused */

/* verdicts of the classifier */
#define EVCOT_VERDICTS 0x070u
#define EVCOT_VERDICTS_LOST_SHIFT 0u
#define EVCOT_VERDICTS_LOST_MASK 0x00000001u /* w1c: a verdict was lost, since as many as there are slots waited for `m_axis_records` */

/* events received from the source: = events_dropped + events + those in the input FIFO */
#define EVCOT_EVENTS_IN 0x080u

/* events dropped because the input FIFO was full */
#define EVCOT_EVENTS_DROPPED 0x084u

/* input words that were skipped, and events outside the sensor */
#define EVCOT_MALFORMED 0x088u

/* events that entered filters and trackers: = filtered + owned + passed, when idle */
#define EVCOT_EVENTS 0x08Cu

/* events dropped by a filter */
#define EVCOT_FILTERED 0x090u

/* events owned by a slot */
#define EVCOT_OWNED 0x094u

/* events without an owner */
#define EVCOT_PASSED 0x098u

/* records */
#define EVCOT_RECORDS 0x09Cu

/* clocks in which a token waited for filters, trackers, outputs or a commit, while enabled */
#define EVCOT_STALLS 0x0A0u

/* events with an earlier time than a previous one, which get the latest time instead; many indicate a damaged time mark */
#define EVCOT_BACKWARD 0x0A4u

/* Registers of slot i: shadow registers that take effect after any write to the slot's EVCOT_SLOT_COMMIT. */
#define EVCOT_SLOT(i, reg) (0x2000u + 128u * (uint32_t)(i) + (reg))
#define EVCOT_SLOT_MODE 0x00u /* 0 off, 1 fixed start, 2 seeded start; a write restarts the slot */
#define EVCOT_SLOT_INIT_CM_X 0x04u /* x of the initial centre */
#define EVCOT_SLOT_INIT_CM_Y 0x08u /* y of the initial centre */
#define EVCOT_SLOT_INIT_RADIX 0x0Cu /* initial inner radius g */
#define EVCOT_SLOT_RADIX_TH 0x10u /* width of the ring: R = g + radix_th */
#define EVCOT_SLOT_RADIX_STEP 0x14u /* step by which g grows or shrinks at a centre update */
#define EVCOT_SLOT_RADIX_MIN 0x18u /* smallest g */
#define EVCOT_SLOT_RADIX_MAX 0x1Cu /* largest g */
#define EVCOT_SLOT_HIST_AVG 0x20u /* k in alpha = 2^-k, for the average and for the centre */
#define EVCOT_SLOT_MAX_TICKS 0x24u /* ticks without an event after which an active cluster ends */
#define EVCOT_SLOT_CLUST_NEV 0x28u /* N_ev at the start of a life */
#define EVCOT_SLOT_NEV_MIN 0x2Cu /* smallest N_ev */
#define EVCOT_SLOT_NEV_MAX 0x30u /* largest N_ev */
#define EVCOT_SLOT_NEV_TH 0x34u /* ticks by which a window must differ from the previous one to change N_ev */
#define EVCOT_SLOT_DETECT_TICKS 0x38u /* ticks within which a candidate must collect clust_nev events */
#define EVCOT_SLOT_COMMIT 0x7Cu /* reads: low bits of the number of the first event after it */

/* Registers of the filters, likewise; EVCOT_FILTER_MASK acts at once, and is refused before status.cleared. */
#define EVCOT_FILTER_ENABLE 0x0200u /* one bit per filter, in their order */
#define EVCOT_FILTER_REGION_X0 0x0204u /* first column that stays */
#define EVCOT_FILTER_REGION_X1 0x0208u /* last column that stays */
#define EVCOT_FILTER_REGION_Y0 0x020Cu /* first row that stays */
#define EVCOT_FILTER_REGION_Y1 0x0210u /* last row that stays */
#define EVCOT_FILTER_POLARITY 0x0214u /* polarity that stays */
#define EVCOT_FILTER_REFRACTORY_TICKS 0x0218u /* ticks for which a pixel is silent after an event that stayed */
#define EVCOT_FILTER_ACTIVITY_TICKS 0x021Cu /* oldest neighbour that supports an event */
#define EVCOT_FILTER_ACTIVITY_SUPPORT 0x0220u /* neighbours that an event needs; 0: they follow the noise */
#define EVCOT_FILTER_RECENT_TICKS 0x0224u /* age past which an event leaves the FIFO */
#define EVCOT_FILTER_RECENT_RADIUS 0x0228u /* how near an event in the FIFO must be to support another */
#define EVCOT_FILTER_RECENT_SUPPORT 0x022Cu /* events in the FIFO that an event needs */
#define EVCOT_FILTER_DECAY_RATE 0x0230u /* units of 1/32 half-life per tick, in 2^-24 */
#define EVCOT_FILTER_DECAY_EPSILON 0x0234u /* weight in 1/256 up to which an event is discarded */
#define EVCOT_FILTER_DECAY_SUPPORT 0x0238u /* sum of weights in 1/256 that an event needs */
#define EVCOT_FILTER_MASK 0x023Cu /* marks one pixel as hot, or not: see `mask_word` */
#define EVCOT_FILTER_ROWCOL_TICKS 0x0240u /* oldest event of a row or column that supports another */
#define EVCOT_FILTER_ROWCOL_RADIUS 0x0244u /* how near along its row or column it must be */
#define EVCOT_FILTER_ROWCOL_SUPPORT 0x0248u /* rows and columns whose last events an event needs */
#define EVCOT_FILTER_STAMP_SHIFT 0x024Cu /* log2 of the ticks in a unit of the time stamps of cells */
#define EVCOT_FILTER_NOISE_LOG2 0x0250u /* log2 of the ticks in the longest window in which noise is counted */
#define EVCOT_FILTER_NOISE_2 0x0254u /* least noise at which an event needs 2 neighbours, per cell and window, in 1/256 */
#define EVCOT_FILTER_NOISE_3 0x0258u /* least noise at which an event needs 3 neighbours, per cell and window, in 1/256 */
#define EVCOT_FILTER_NOISE_4 0x025Cu /* least noise at which an event needs 4 neighbours, per cell and window, in 1/256 */
#define EVCOT_FILTER_NOISE_5 0x0260u /* least noise at which an event needs 5 neighbours, per cell and window, in 1/256 */
#define EVCOT_FILTER_NOISE_6 0x0264u /* least noise at which an event needs 6 neighbours, per cell and window, in 1/256 */
#define EVCOT_FILTER_COMMIT 0x027Cu

/* Registers of boxes and velocities, likewise; they exist only with TRACKER = 2 (EVCOT_BUILD_TRACKER), and a commit of values
   that contradict each other is refused. */
#define EVCOT_MOTION_STEP_LOG2 0x0284u /* a motion step of each slot every 2^step_log2 ticks */
#define EVCOT_MOTION_SIDE_STEP 0x0288u /* way of a side for an event beyond and one within it, in 2^-12 px */
#define EVCOT_MOTION_SIDE_SHARE 0x028Cu /* 2^-side_share of a slot's events lie beyond each side */
#define EVCOT_MOTION_SIDE_SHRINK 0x0290u /* a side without an event beyond it moves inwards by 2^-side_shrink of the box; 0: never */
#define EVCOT_MOTION_SIDE_MAX 0x0294u /* longest side, px */
#define EVCOT_MOTION_GAIN_LOG2 0x0298u /* gain of a velocity's correction is 2^-gain_log2 in the end */
#define EVCOT_MOTION_GAIN_SLOW 0x029Cu /* 2^gain_slow corrections until a gain is halved */
#define EVCOT_MOTION_GAIN_FAST 0x02A0u /* it is doubled while corrections agree in direction, up to 2^-gain_fast; 0: it is not */
#define EVCOT_MOTION_SETTLE 0x02A4u /* corrections during which a velocity follows the slower of two sides */
#define EVCOT_MOTION_SPEED_MAX 0x02A8u /* limit of a velocity on each axis, in 2^-12 px per step; 0: nothing moves between events */
#define EVCOT_MOTION_FRICTION 0x02ACu /* a silent slot loses 2^-friction of its velocity a step; 0: nothing */
#define EVCOT_MOTION_COAST_SLOW 0x02B0u /* a silent slot moves by 2^-coast_slow of its velocity */
#define EVCOT_MOTION_NEV_LOW 0x02B4u /* fewest events of a correction */
#define EVCOT_MOTION_NEV_HIGH 0x02B8u /* most events of a correction */
#define EVCOT_MOTION_SEED_PX 0x02BCu /* half the side of a new candidate's box */
#define EVCOT_MOTION_RING_PX 0x02C0u /* least distance of a window from its box */
#define EVCOT_MOTION_RING_MAX 0x02C4u /* largest distance of a window from its box */
#define EVCOT_MOTION_RING_ACROSS 0x02C8u /* distance across the motion is 2^-ring_across of the box's side there */
#define EVCOT_MOTION_RING_ALONG 0x02CCu /* distance along the motion is 2^-ring_along of the side across it */
#define EVCOT_MOTION_RING_ANY 0x02D0u /* distance, where there is no one direction, is 2^-ring_any of the side */
#define EVCOT_MOTION_ELONGATION 0x02D4u /* a box this many times as long as it is wide reaches along its motion as across it */
#define EVCOT_MOTION_COMMIT 0x02FCu

/* Registers of lives, likewise; they exist only with TRACKER = 2 (EVCOT_BUILD_TRACKER), and a commit of values
   that contradict each other is refused. */
#define EVCOT_TRACKS_DETECT_TICKS 0x0304u /* ticks within which a candidate must have its first correction */
#define EVCOT_TRACKS_LIFE_LOG2 0x0308u /* a life ends after 2^life_log2 times the usual time between corrections without one */
#define EVCOT_TRACKS_LIFE_TICKS 0x030Cu /* but not before this time */
#define EVCOT_TRACKS_COAST_TICKS 0x0310u /* nor after this time */
#define EVCOT_TRACKS_RETURN_TICKS 0x0314u /* ticks after its end in which a track goes on in what becomes visible there; 0: never */
#define EVCOT_TRACKS_BIRTH_SUPPORT 0x0318u /* events that a candidate needs to become visible */
#define EVCOT_TRACKS_BIRTH_PX 0x031Cu /* sides that it needs */
#define EVCOT_TRACKS_BIRTH_TICKS 0x0320u /* time that it needs */
#define EVCOT_TRACKS_BIRTH_TRAVEL 0x0324u /* since the 4th correction its middle has moved 1 px and 2^-birth_travel of a half side */
#define EVCOT_TRACKS_GAP_CORRECTIONS 0x0328u /* corrections after which a box is looked through for a gap; 0: never */
#define EVCOT_TRACKS_GAP_SHARE 0x032Cu /* a bin with at most 2^-gap_share of the events is empty */
#define EVCOT_TRACKS_GAP_PX 0x0330u /* narrowest gap */
#define EVCOT_TRACKS_JOIN_STEPS 0x0334u /* steps for which two slots must move together before they merge */
#define EVCOT_TRACKS_JOIN_LIFE 0x0338u /* and 2^-join_life of the younger's life */
#define EVCOT_TRACKS_JOIN_SPEED 0x033Cu /* together: velocities differ by at most 2^-join_speed of the larger */
#define EVCOT_TRACKS_JOIN_REACH 0x0340u /* one object: a gap along the motion of at most 2^-join_reach of the width, and join_px */
#define EVCOT_TRACKS_JOIN_PX 0x0344u /* one object: a gap of at most so many px */
#define EVCOT_TRACKS_KEEP_OLDER 0x0348u /* of two that merge stays 0: the one with more support; 1: the one that was seeded first */
#define EVCOT_TRACKS_REPORT_STEPS 0x034Cu /* steps after which a slot without a correction is reported */
#define EVCOT_TRACKS_COMMIT 0x037Cu

/* Registers of the classifier, likewise; they exist only with CLASSIFY = 1 (EVCOT_BUILD_CLASSIFIER), and a commit of enable = 1 is
   refused before all weights are loaded. */
#define EVCOT_CLASSIFIER_VERSION 1u
#define EVCOT_CLASSIFIER_ENABLE 0x0384u /* 1: events count; 0: they do not, and weights can be written */
#define EVCOT_CLASSIFIER_WINDOW_LOG2 0x0388u /* a window has 2^window_log2 counted events */
#define EVCOT_CLASSIFIER_SCALE_START 0x038Cu /* scale of both axes in a track's first window, in 2^-12 cells per half pixel */
#define EVCOT_CLASSIFIER_SHIFT_1 0x0390u /* a hidden unit is 2^-shift_1 of its weighted sum */
#define EVCOT_CLASSIFIER_SHIFT_2 0x0394u /* the loss of a class is 2^-shift_2 of its distance from the best */
#define EVCOT_CLASSIFIER_CLASSES 0x0398u /* number of classes */
#define EVCOT_CLASSIFIER_MARGIN_MIN 0x039Cu /* a mean margin per window below this gives class 15, none of these */
#define EVCOT_CLASSIFIER_COMMIT 0x03FCu

/* Sources. */
#define EVCOT_SOURCE_EVENTS 0u
#define EVCOT_SOURCE_LFSR 1u
#define EVCOT_SOURCE_AER 2u
#define EVCOT_SOURCE_EVT2 3u
#define EVCOT_SOURCE_EVT21 4u
#define EVCOT_SOURCE_EVT3 5u

/* Trackers. */
#define EVCOT_TRACKER_ARRAY 0u
#define EVCOT_TRACKER_CHAIN 1u
#define EVCOT_TRACKER_MOTION 2u

/* Kinds of a record. */
#define EVCOT_KIND_BORN 0u
#define EVCOT_KIND_MOVED 1u
#define EVCOT_KIND_MERGED 2u
#define EVCOT_KIND_LOST 3u
#define EVCOT_KIND_VERDICT 4u

/* A record on the stream of records, little-endian. */
struct evcot_record {
    uint64_t seq;
    uint64_t time;
    uint32_t track_id;
    uint32_t other_id;
    uint32_t cm_x;
    uint32_t cm_y;
    uint32_t support;
    uint16_t radius;
    uint16_t n_ev;
    uint8_t slot;
    uint8_t kind;
    uint16_t pad;
    uint32_t pad2;
};
#define EVCOT_RECORD_BYTES 48u

/* A record of cot_motion on the stream of records, little-endian. */
struct evcot_motion_record {
    uint64_t seq;
    uint64_t time;
    uint32_t track_id;
    uint32_t other_id;
    int32_t cm_x;
    int32_t cm_y;
    uint32_t width;
    uint32_t height;
    int16_t v_x;
    int16_t v_y;
    uint32_t support;
    uint16_t n_ev;
    uint8_t slot;
    uint8_t kind;
    uint32_t pad;
};
#define EVCOT_MOTION_RECORD_BYTES 56u

/* A verdict of the classifier on the stream of records, little-endian. */
struct evcot_verdict_record {
    uint64_t seq;
    uint64_t pad;
    uint32_t track_id;
    uint16_t margin;
    uint8_t windows;
    uint8_t class_index;
    uint64_t pad2;
    uint64_t pad3;
    uint64_t pad4;
    uint16_t pad5;
    uint8_t slot;
    uint8_t kind;
    uint32_t pad6;
};
#define EVCOT_VERDICT_RECORD_BYTES 56u

/* an input event: 64 bits */
#define EVCOT_EVENT_T(word) ((uint32_t)((uint64_t)(word) >> 0 & 0xFFFFFFFFu))
#define EVCOT_EVENT_X(word) ((uint32_t)((uint64_t)(word) >> 32 & 0x7FFFu))
#define EVCOT_EVENT_Y(word) ((uint32_t)((uint64_t)(word) >> 47 & 0x7FFFu))
#define EVCOT_EVENT_P(word) ((uint32_t)((uint64_t)(word) >> 62 & 0x1u))

/* an event owned by a slot; tuser is the slot, too: 64 bits */
#define EVCOT_OWNED_X(word) ((uint32_t)((uint64_t)(word) >> 0 & 0x3FFFu))
#define EVCOT_OWNED_Y(word) ((uint32_t)((uint64_t)(word) >> 14 & 0x3FFFu))
#define EVCOT_OWNED_SLOT(word) ((uint32_t)((uint64_t)(word) >> 28 & 0x3Fu))
#define EVCOT_OWNED_P(word) ((uint32_t)((uint64_t)(word) >> 34 & 0x1u))
#define EVCOT_OWNED_SEQ(word) ((uint32_t)((uint64_t)(word) >> 35 & 0x1FFFFFFFu))

/* an event without an owner: 64 bits */
#define EVCOT_PASSED_X(word) ((uint32_t)((uint64_t)(word) >> 0 & 0xFFFFu))
#define EVCOT_PASSED_Y(word) ((uint32_t)((uint64_t)(word) >> 16 & 0xFFFFu))
#define EVCOT_PASSED_P(word) ((uint32_t)((uint64_t)(word) >> 34 & 0x1u))
#define EVCOT_PASSED_SEQ(word) ((uint32_t)((uint64_t)(word) >> 35 & 0x1FFFFFFFu))

#endif
