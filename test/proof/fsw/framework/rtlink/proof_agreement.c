// SPDX-License-Identifier: Apache-2.0
// Proves: rtlink_negotiate accepts terms if and only if the layouts are equal, their size fits, the
//     producer's byte order exists, one period is a multiple of the other, and both have a common method. The
//     agreed terms have exactly one method, which this software and both ends know, and the decimation that
//     leads from the producer's period to the consumer's; it is 1 if the producer's period is not shorter.
// Bounds: any terms; periods of up to 2^10 us, because the remainder of larger ones takes the checker too
//     long.
// Replaced: nothing.
// Sources: fsw/framework/rtlink/agreement.c
// Options:
// Quick: yes
// Fault: fsw/framework/rtlink/agreement.c
//   - return (uint8_t)(set & (uint8_t)(~set + 1U));
//   + return (uint8_t)(set & (uint8_t)(~set + 2U));
// Fault: fsw/framework/rtlink/agreement.c
//   - ((producer->period_us % consumer->period_us) != 0U))) {
//   + (producer->period_us < consumer->period_us))) {
// Fault: fsw/framework/rtlink/agreement.c
//   - const uint8_t common = (uint8_t)(producer->methods & consumer->methods & known);
//   + const uint8_t common = (uint8_t)(producer->methods & consumer->methods);
// Fault: fsw/framework/rtlink/agreement.c
//   - (producer->layout_octets > RTLINK_PAYLOAD_MAX)) {
//   + (producer->layout_octets >= RTLINK_PAYLOAD_MAX)) {
#include "fsw/framework/rtlink/agreement.h"
#include "test/proof/proof.h"

void proof(void)
{
    rtlink_terms_t producer;
    rtlink_terms_t consumer;
    rtlink_terms_t agreed;
    ASSUME((producer.period_us <= 1024U) && (consumer.period_us <= 1024U));
    const bool is_accepted = (rtlink_negotiate(&producer, &consumer, &agreed) == RTLINK_ACCEPTED);
    const bool has_periods = (producer.period_us >= 1U) && (consumer.period_us >= 1U);
    const bool is_multiple = has_periods && (((consumer.period_us % producer.period_us) == 0U) ||
                                             ((producer.period_us % consumer.period_us) == 0U));
    PROVE(is_accepted == ((producer.layout_hash == consumer.layout_hash) &&
                          (producer.layout_octets == consumer.layout_octets) &&
                          (producer.layout_octets >= 1U) && (producer.layout_octets <= RTLINK_PAYLOAD_MAX) &&
                          (producer.order <= (uint8_t)RTLINK_LITTLE_ENDIAN) && is_multiple &&
                          ((producer.methods & consumer.methods & 7U) != 0U)),
          "terms are accepted if and only if they are compatible");
    if (is_accepted) {
        const uint8_t method = agreed.methods;
        PROVE((method == 1U) || (method == 2U) || (method == 4U), "exactly one method, which is known");
        PROVE((method & producer.methods & consumer.methods) == method, "both ends have the method");
        PROVE((agreed.layout_hash == consumer.layout_hash) &&
                  (agreed.layout_octets == consumer.layout_octets) && (agreed.layout_octets >= 1U) &&
                  (agreed.layout_octets <= RTLINK_PAYLOAD_MAX),
              "the layout is that of both, and fits");
        PROVE((agreed.order <= (uint8_t)RTLINK_LITTLE_ENDIAN) && (agreed.order == producer.order),
              "the byte order is the producer's");
        PROVE((agreed.decimation >= 1U) && (producer.period_us >= 1U) && (consumer.period_us >= 1U),
              "decimation and periods are at least 1");
        PROVE((agreed.decimation * producer.period_us == consumer.period_us) ||
                  ((agreed.decimation == 1U) && (producer.period_us % consumer.period_us == 0U)),
              "one period is a multiple of the other, and the decimation fits");
        PROVE(agreed.max_age_us == consumer.max_age_us, "the consumer decides the age");
    }
}
