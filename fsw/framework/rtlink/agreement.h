// SPDX-License-Identifier: Apache-2.0
/// The offers of the two ends of a real-time link, and their negotiation to one agreed record or a refusal.
/// Pure functions; no state, no time.
#ifndef FSW_FRAMEWORK_RTLINK_AGREEMENT_H
#define FSW_FRAMEWORK_RTLINK_AGREEMENT_H

#include "base/status.h"

#include <stdint.h>

#ifndef RTLINK_PAYLOAD_MAX
#define RTLINK_PAYLOAD_MAX 1024U ///< Octets of one sample.
#endif

typedef enum { // Transfer method; these numbers are used on the wire.
    RTLINK_METHOD_SHARED_MEMORY = 0,
    RTLINK_METHOD_TIPC          = 1,
    RTLINK_METHOD_UDP           = 2,
    RTLINK_METHOD_COUNT         = 3
} rtlink_method_t;

typedef enum { // Byte order of the payload, on the wire.
    RTLINK_BIG_ENDIAN    = 0,
    RTLINK_LITTLE_ENDIAN = 1
} rtlink_order_t;

typedef enum { // Reasons of a refusal, on the wire (TM[130,5]).
    RTLINK_ACCEPTED         = 0,
    RTLINK_REFUSED_LAYOUT   = 1,
    RTLINK_REFUSED_ORDER    = 2,
    RTLINK_REFUSED_PERIOD   = 3,
    RTLINK_REFUSED_METHOD   = 4,
    RTLINK_REFUSED_RESOURCE = 5,
    RTLINK_REFUSED_STATE    = 6,
    RTLINK_REFUSED_PORT     = 7
} rtlink_verdict_t;

typedef struct {            // Terms that one end offers; after negotiation, the terms of both ends.
    uint32_t layout_hash;   ///< CRC-32 of the canonical text of the payload's fields.
    uint32_t layout_octets; ///< Payload size [octets], 1..RTLINK_PAYLOAD_MAX.
    uint8_t order;          ///< Byte order of the payload (rtlink_order_t).
    uint32_t period_us;     ///< Sampling period [us], >= 1.
    uint8_t methods;        ///< Offer: bit set of 1 << rtlink_method_t. Agreement: exactly one bit.
    uint32_t decimation;    ///< Agreement: samples in a period of the consumer, >= 1. Not on the wire.
    uint32_t max_age_us;    ///< Age beyond which a sample is stale [us]; the consumer's value applies.
} rtlink_terms_t;

/// Returns the byte order of this machine.
rtlink_order_t rtlink_native_order(void);
/// Agree on the terms of a link. Layouts must be equal; the byte order is the producer's; one of the periods
/// must be an integer multiple of the other: a slower consumer reads every n-th sample (decimation), a faster
/// one reads each sample several times; the method is the lowest common bit. Returns RTLINK_ACCEPTED and the
/// agreed terms, or the reason of the refusal; *out_agreed must then not be used.
rtlink_verdict_t rtlink_negotiate(const rtlink_terms_t* producer, const rtlink_terms_t* consumer,
                                  rtlink_terms_t* out_agreed);

#endif // FSW_FRAMEWORK_RTLINK_AGREEMENT_H
