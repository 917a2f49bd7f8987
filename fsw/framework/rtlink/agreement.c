// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/rtlink/agreement.h"

#include "base/assertion.h"

#include <stddef.h>

rtlink_order_t rtlink_native_order(void)
{
    const uint16_t probe      = 1U;
    const uint8_t* const byte = (const uint8_t*)&probe;
    return (*byte == 1U) ? RTLINK_LITTLE_ENDIAN : RTLINK_BIG_ENDIAN;
}

/// Returns the lowest bit of a set; 0 for the empty set.
static uint8_t lowest_bit(const uint8_t set)
{
    return (uint8_t)(set & (uint8_t)(~set + 1U));
}

rtlink_verdict_t rtlink_negotiate(const rtlink_terms_t* const producer, const rtlink_terms_t* const consumer,
                                  rtlink_terms_t* const out_agreed)
{
    FSW_ASSERT((producer != NULL) && (consumer != NULL) && (out_agreed != NULL));
    *out_agreed            = *producer;
    out_agreed->max_age_us = consumer->max_age_us;
    if ((producer->layout_hash != consumer->layout_hash) ||
        (producer->layout_octets != consumer->layout_octets) || (producer->layout_octets == 0U) ||
        (producer->layout_octets > RTLINK_PAYLOAD_MAX)) {
        return RTLINK_REFUSED_LAYOUT;
    }
    if (producer->order > (uint8_t)RTLINK_LITTLE_ENDIAN) {
        return RTLINK_REFUSED_ORDER;
    }
    if ((producer->period_us == 0U) || (consumer->period_us == 0U) ||
        (((consumer->period_us % producer->period_us) != 0U) &&
         ((producer->period_us % consumer->period_us) != 0U))) {
        return RTLINK_REFUSED_PERIOD;
    }
    const uint8_t known  = (uint8_t)((1U << (unsigned)RTLINK_METHOD_COUNT) - 1U);
    const uint8_t common = (uint8_t)(producer->methods & consumer->methods & known);
    if (common == 0U) {
        return RTLINK_REFUSED_METHOD;
    }
    out_agreed->methods = lowest_bit(common);
    out_agreed->decimation =
        (consumer->period_us > producer->period_us) ? (consumer->period_us / producer->period_us) : 1U;
    return RTLINK_ACCEPTED;
}
