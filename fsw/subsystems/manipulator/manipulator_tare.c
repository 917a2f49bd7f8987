// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/manipulator/manipulator_tare.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

// A joint that is faster is moving; below this speed, a joint is at rest and its speed is noise.
#define REST_RAD_S 0.02

void manipulator_arm_tare_init(manipulator_arm_tare_t* const tare)
{
    FSW_ASSERT(tare != NULL);
    *tare = (manipulator_arm_tare_t){.result = STATUS_EMPTY};
}

void manipulator_arm_tare_begin(manipulator_arm_tare_t* const tare)
{
    FSW_ASSERT(tare != NULL);
    tare->result    = STATUS_BUSY;
    tare->samples   = 0U;
    tare->sum_nm[0] = 0.0;
    tare->sum_nm[1] = 0.0;
}

static void finish(manipulator_arm_tare_t* const tare, const double ceiling_nm)
{
    double mean[ARM_JOINTS];
    bool is_free = true;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        mean[i] = tare->sum_nm[i] / (double)tare->samples;
        is_free = is_free && (control_absolute(mean[i]) <= ceiling_nm);
    }
    tare->result = is_free ? STATUS_OK : STATUS_OUT_OF_RANGE;
    for (unsigned i = 0U; is_free && (i < ARM_JOINTS); i++) {
        tare->offset_nm[i] = mean[i];
    }
}

status_t manipulator_arm_tare_step(manipulator_arm_tare_t* const tare,
                                   const manipulator_arm_tare_sample_t* const sample, const uint32_t samples,
                                   const double ceiling_nm)
{
    FSW_ASSERT((tare != NULL) && (sample != NULL));
    if (tare->result != STATUS_BUSY) {
        return tare->result;
    }
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        if (control_absolute(sample->velocity_rad_s[i]) > REST_RAD_S) {
            manipulator_arm_tare_begin(tare);
            return STATUS_BUSY;
        }
    }
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        tare->sum_nm[i] += sample->difference_nm[i];
    }
    tare->samples++;
    if (tare->samples >= samples) {
        finish(tare, ceiling_nm);
    }
    return tare->result;
}
