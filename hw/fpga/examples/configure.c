/* SPDX-License-Identifier: Apache-2.0 */
/* Settings of kv260_evcot.v from C: `regs` is where its 16 KiB of registers are mapped, say /dev/uio0 with mmap. */
#include "evcot_regs.h"

#include <stddef.h>

#define REG(regs, address) ((regs)[(address) / 4u])

/* One seeded tracker in each of `slots` slots, the same for all; 0 when all is well, else the word `fault`. */
uint32_t evcot_configure(volatile uint32_t *regs, unsigned slots) {
    static const struct {
        uint32_t reg, value;
    } setting[] = {
        {EVCOT_SLOT_INIT_RADIX, 12}, {EVCOT_SLOT_RADIX_TH, 4},   {EVCOT_SLOT_RADIX_STEP, 1},
        {EVCOT_SLOT_RADIX_MIN, 6},   {EVCOT_SLOT_RADIX_MAX, 40}, {EVCOT_SLOT_HIST_AVG, 3},
        {EVCOT_SLOT_MAX_TICKS, 50000}, {EVCOT_SLOT_CLUST_NEV, 32}, {EVCOT_SLOT_NEV_MIN, 8},
        {EVCOT_SLOT_NEV_MAX, 64},    {EVCOT_SLOT_NEV_TH, 2000},  {EVCOT_SLOT_DETECT_TICKS, 5000},
        {EVCOT_SLOT_MODE, 2}, /* seeded */
    };
    if (REG(regs, EVCOT_ID) != EVCOT_ID_VALUE)
        return UINT32_MAX;
    for (unsigned i = 0; i < slots; i++) {
        for (size_t k = 0; k < sizeof setting / sizeof *setting; k++)
            REG(regs, EVCOT_SLOT(i, setting[k].reg)) = setting[k].value;
        REG(regs, EVCOT_SLOT(i, EVCOT_SLOT_COMMIT)) = 1;
    }
    while (REG(regs, EVCOT_STATUS) & EVCOT_STATUS_PENDING_MASK)
        ;
    REG(regs, EVCOT_CONTROL) = EVCOT_PUT(1, EVCOT_CONTROL_ENABLE);
    return REG(regs, EVCOT_FAULT);
}
