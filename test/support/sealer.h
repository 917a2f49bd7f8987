// SPDX-License-Identifier: Apache-2.0
/// A sender of protected telecommand frames for tests, which can set each field to any value.
#ifndef TEST_SUPPORT_SEALER_H
#define TEST_SUPPORT_SEALER_H

#include "fsw/framework/sdls/sdls.h"

#define SEALER_WHOLE 0xC0U
#define SEALER_FIRST 0x40U
#define SEALER_MIDDLE 0x00U
#define SEALER_LAST 0x80U

extern const uint8_t sealer_key[SDLS_KEY_OCTETS]; ///< 0, 1, 2, ...

typedef struct {
    uint32_t session;
    uint32_t count;
    uint16_t spi;
    uint8_t part;
    uint8_t octets[SDLS_FRAME_MAX];
    size_t size;
} sealed_t;

/// Make a frame with the content (1..988 octets) under the key.
void seal(sealed_t* frame, const uint8_t key[SDLS_KEY_OCTETS], const uint8_t* content, size_t size);
/// Compute the value that identifies a key in its mark, as the ground does.
void sealer_key_check(const uint8_t key[SDLS_KEY_OCTETS], uint8_t out_check[SESSION_MARK_CHECK]);
/// Write the mark of a key for a session to a medium, as the ground does.
void sealer_make_mark(const medium_t* medium, const uint8_t key[SDLS_KEY_OCTETS], uint32_t session);

#endif // TEST_SUPPORT_SEALER_H
