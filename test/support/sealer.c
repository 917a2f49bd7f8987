// SPDX-License-Identifier: Apache-2.0
#include "test/support/sealer.h"

#include "base/crc.h"
#include "base/octets.h"

#include "unity.h"

#include <string.h>

const uint8_t sealer_key[SDLS_KEY_OCTETS] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
                                             16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31};

void seal(sealed_t* const frame, const uint8_t key[SDLS_KEY_OCTETS], const uint8_t* const content,
          const size_t size)
{
    struct gcm_aes256_ctx cipher;
    uint8_t* const octets = frame->octets;
    frame->size           = SDLS_CLEAR_OCTETS + size + SDLS_MAC_OCTETS;
    TEST_ASSERT_TRUE(frame->size <= SDLS_FRAME_MAX);
    memset(octets, 0, SDLS_CLEAR_OCTETS);
    octets_put_u16(octets, 0x2000U | SDLS_SPACECRAFT);
    octets_put_u16(&octets[2], (uint16_t)(frame->size - 1U));
    octets[5] = frame->part;
    octets_put_u16(&octets[6], frame->spi);
    octets_put_u32(&octets[12], frame->session);
    octets_put_u32(&octets[16], frame->count);
    gcm_aes256_set_key(&cipher, key);
    gcm_aes256_set_iv(&cipher, GCM_IV_SIZE, &octets[8]);
    gcm_aes256_update(&cipher, SDLS_CLEAR_OCTETS, octets);
    gcm_aes256_encrypt(&cipher, size, &octets[SDLS_CLEAR_OCTETS], content);
    gcm_aes256_digest(&cipher, SDLS_MAC_OCTETS, &octets[SDLS_CLEAR_OCTETS + size]);
}

void sealer_key_check(const uint8_t key[SDLS_KEY_OCTETS], uint8_t out_check[SESSION_MARK_CHECK])
{
    static const uint8_t unused[SDLS_VECTOR_OCTETS] = {0};
    struct gcm_aes256_ctx cipher;
    gcm_aes256_set_key(&cipher, key);
    gcm_aes256_set_iv(&cipher, sizeof unused, unused);
    gcm_aes256_digest(&cipher, SESSION_MARK_CHECK, out_check);
}

void sealer_make_mark(const medium_t* const medium, const uint8_t key[SDLS_KEY_OCTETS],
                      const uint32_t session)
{
    uint8_t record[SESSION_MARK_RECORD] = {'S', 'D', 'L', 'S', 1U};
    octets_put_u32(&record[8], session);
    sealer_key_check(key, &record[12]);
    octets_put_u32(&record[28], crc32_iso(record, 28U));
    TEST_ASSERT_EQUAL(STATUS_OK, medium->write(medium->context, 0U, record, sizeof record));
    TEST_ASSERT_EQUAL(STATUS_OK, medium->write(medium->context, SESSION_MARK_APART, record, sizeof record));
    TEST_ASSERT_EQUAL(STATUS_OK, medium->sync(medium->context));
}
