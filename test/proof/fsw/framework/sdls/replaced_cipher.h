// SPDX-License-Identifier: Apache-2.0
/// Replaces the cipher and the session mark in proofs of the protected ground link. The cipher decrypts to
/// any octets; a comparison of the MAC gives any result, which `cipher_is_authentic` records. The functions
/// prove that they get exactly the parts of the frame that the layout names
/// (docs/ground-link-security.md).
#ifndef TEST_PROOF_FSW_FRAMEWORK_SDLS_REPLACED_CIPHER_H
#define TEST_PROOF_FSW_FRAMEWORK_SDLS_REPLACED_CIPHER_H

#include "fsw/framework/sdls/sdls.h"
#include "test/proof/proof.h"

#include <nettle/memops.h>

static const uint8_t* cipher_frame; // Frame that is being examined.
static size_t cipher_content;       // Octets that were decrypted.
static bool cipher_is_checked;      // The MAC was compared.
static bool cipher_is_authentic;    // The comparison found the MAC right.

/// Call before each examination of a frame.
static void cipher_examine(const uint8_t* const frame)
{
    cipher_frame        = frame;
    cipher_content      = 0U;
    cipher_is_checked   = false;
    cipher_is_authentic = false;
}

void gcm_aes256_set_iv(struct gcm_aes256_ctx* const cipher, const size_t size, const uint8_t* const vector)
{
    (void)cipher;
    PROVE((size == 12U) && (vector == &cipher_frame[8]), "the initialization vector is that of the frame");
}

void gcm_aes256_update(struct gcm_aes256_ctx* const cipher, const size_t size, const uint8_t* const octets)
{
    (void)cipher;
    PROVE((size == 20U) && (octets == cipher_frame), "header, number and part are authenticated");
}

void gcm_aes256_decrypt(struct gcm_aes256_ctx* const cipher, const size_t size, uint8_t* const out,
                        const uint8_t* const octets)
{
    (void)cipher;
    PROVE((octets == &cipher_frame[20]) && __CPROVER_r_ok(octets, size), "the content is in the frame");
    PROVE((size > 0U) && __CPROVER_w_ok(out, size), "the content fits the packet");
    for (size_t i = 0U; i < size; i++) {
        out[i] = nondet_u8();
    }
    cipher_content = size;
}

void gcm_aes256_digest(struct gcm_aes256_ctx* const cipher, const size_t size, uint8_t* const out_mac)
{
    (void)cipher;
    PROVE(__CPROVER_w_ok(out_mac, size), "there is room for the MAC");
}

int memeql_sec(const void* const first, const void* const second, const size_t size)
{
    PROVE((size == 16U) && __CPROVER_r_ok(first, size) && __CPROVER_r_ok(second, size) &&
              (second == &cipher_frame[20U + cipher_content]),
          "the MAC is compared with that of the frame");
    cipher_is_checked   = true;
    cipher_is_authentic = nondet_bool();
    return cipher_is_authentic ? 1 : 0;
}

status_t sdls_session_mark_advance(sdls_session_mark_t* const mark, const uint32_t session)
{
    PROVE(cipher_is_authentic, "only an authentic frame begins a session");
    PROVE(session > mark->session, "the mark of the sessions only rises");
    if (nondet_bool()) {
        return STATUS_IO;
    }
    mark->session = session;
    return STATUS_OK;
}

#endif // TEST_PROOF_FSW_FRAMEWORK_SDLS_REPLACED_CIPHER_H
