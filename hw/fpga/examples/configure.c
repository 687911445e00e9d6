/* SPDX-License-Identifier: Apache-2.0 */
/* Sets up evcot_top from C. `regs`: where its 16 KiB of registers are mapped, for example /dev/uio0 with mmap. */
#include "evcot_regs.h"

#include <stddef.h>

#ifndef EVCOT_READ /* define both for another way to the registers */
#define EVCOT_READ(regs, address) ((regs)[(address) / 4u])
#define EVCOT_WRITE(regs, address, value) ((regs)[(address) / 4u] = (value))
#endif

/* One seeded tracker in each slot; cot_motion has no other registers in a slot, and with it the default filters begin.
 * Returns 0, the word `fault` if the hardware clamped or refused a value, or UINT32_MAX if no evcot_top
 * of this version of the registers answers. */
uint32_t evcot_configure(volatile uint32_t *regs) {
    static const struct {
        uint32_t reg, value;
    } setting[] = {
        {EVCOT_SLOT_MODE, 2}, /* seeded; the others are not in cot_motion */
        {EVCOT_SLOT_INIT_RADIX, 12}, {EVCOT_SLOT_RADIX_TH, 4},   {EVCOT_SLOT_RADIX_STEP, 1},
        {EVCOT_SLOT_RADIX_MIN, 6},   {EVCOT_SLOT_RADIX_MAX, 40}, {EVCOT_SLOT_HIST_AVG, 3},
        {EVCOT_SLOT_MAX_TICKS, 50000}, {EVCOT_SLOT_CLUST_NEV, 32}, {EVCOT_SLOT_NEV_MIN, 8},
        {EVCOT_SLOT_NEV_MAX, 64},    {EVCOT_SLOT_NEV_TH, 2000},  {EVCOT_SLOT_DETECT_TICKS, 5000},
    };
    if (EVCOT_READ(regs, EVCOT_ID) != EVCOT_ID_VALUE ||
        EVCOT_GET(EVCOT_READ(regs, EVCOT_VERSION), EVCOT_VERSION_MAJOR) != EVCOT_VERSION_MAJOR_VALUE)
        return UINT32_MAX;
    const uint32_t slots = EVCOT_GET(EVCOT_READ(regs, EVCOT_SHAPE0), EVCOT_SHAPE0_N_SLOTS);
    const uint32_t tracker = EVCOT_GET(EVCOT_READ(regs, EVCOT_BUILD), EVCOT_BUILD_TRACKER);
    const size_t settings = tracker == EVCOT_TRACKER_MOTION ? 1 : sizeof setting / sizeof *setting;

    EVCOT_WRITE(regs, EVCOT_FAULT, EVCOT_READ(regs, EVCOT_FAULT)); /* forget earlier faults */
    for (uint32_t i = 0; i < slots; i++) {
        for (size_t k = 0; k < settings; k++)
            EVCOT_WRITE(regs, EVCOT_SLOT(i, setting[k].reg), setting[k].value);
        EVCOT_WRITE(regs, EVCOT_SLOT(i, EVCOT_SLOT_COMMIT), 1);
    }
    if (tracker == EVCOT_TRACKER_MOTION && EVCOT_GET(EVCOT_READ(regs, EVCOT_BUILD), EVCOT_BUILD_FILTERS))
        EVCOT_WRITE(regs, EVCOT_FILTER_COMMIT, 1); /* the values after reset are those of the default configuration */
    while (EVCOT_READ(regs, EVCOT_STATUS) & EVCOT_STATUS_PENDING_MASK)
        ;
    const uint32_t fault = EVCOT_READ(regs, EVCOT_FAULT);
    if (fault & 0xf)
        return fault;
    EVCOT_WRITE(regs, EVCOT_CONTROL, EVCOT_PUT(1, EVCOT_CONTROL_ENABLE));
    return 0;
}

/* Loads weights into the classifier of hardware with CLASSIFY = 1, reads them back, and turns it on. `words`: those of
 * evcot.recognition.weight_memory.memory_words. `values`: registers from EVCOT_CLASSIFIER_WINDOW_LOG2 on, in their order.
 * Returns 0, the word `fault`, or UINT32_MAX if there is no such classifier or a word reads back differently. */
uint32_t evcot_load_weights(volatile uint32_t *regs, const uint32_t *words, size_t count, const uint32_t values[6]) {
    if (EVCOT_GET(EVCOT_READ(regs, EVCOT_BUILD), EVCOT_BUILD_CLASSIFIER) != EVCOT_CLASSIFIER_VERSION ||
        EVCOT_GET(EVCOT_READ(regs, EVCOT_WEIGHTS), EVCOT_WEIGHTS_NEEDED) != count)
        return UINT32_MAX;
    EVCOT_WRITE(regs, EVCOT_FAULT, EVCOT_READ(regs, EVCOT_FAULT));
    EVCOT_WRITE(regs, EVCOT_CLASSIFIER_ENABLE, 0);
    EVCOT_WRITE(regs, EVCOT_CLASSIFIER_COMMIT, 1);
    while (EVCOT_READ(regs, EVCOT_STATUS) & EVCOT_STATUS_PENDING_MASK)
        ;
    EVCOT_WRITE(regs, EVCOT_WEIGHT_ADDRESS, 0);
    for (size_t i = 0; i < count; i++)
        EVCOT_WRITE(regs, EVCOT_WEIGHT_DATA, words[i]); /* counts the address up */
    for (size_t i = 0; i < count; i++) {
        EVCOT_WRITE(regs, EVCOT_WEIGHT_ADDRESS, (uint32_t)i);
        if (EVCOT_READ(regs, EVCOT_WEIGHT_DATA) != words[i])
            return UINT32_MAX;
    }
    for (uint32_t i = 0; i < 6; i++)
        EVCOT_WRITE(regs, EVCOT_CLASSIFIER_WINDOW_LOG2 + 4 * i, values[i]);
    EVCOT_WRITE(regs, EVCOT_CLASSIFIER_ENABLE, 1);
    EVCOT_WRITE(regs, EVCOT_CLASSIFIER_COMMIT, 1);
    while (EVCOT_READ(regs, EVCOT_STATUS) & EVCOT_STATUS_PENDING_MASK)
        ;
    const uint32_t fault = EVCOT_READ(regs, EVCOT_FAULT);
    return fault & 0xf ? fault : 0;
}
