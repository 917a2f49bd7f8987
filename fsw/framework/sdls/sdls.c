// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/sdls/sdls.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <nettle/memops.h>
#include <string.h>

#define FIRST_WORD (0x2000U | SDLS_SPACECRAFT) ///< Version 0, bypass, no control command, spacecraft.
#define LENGTH_OFFSET 2U
#define NUMBER_OFFSET 4U
#define SEGMENT_OFFSET 5U
#define SPI_OFFSET 6U
#define VECTOR_OFFSET 8U
#define SESSION_OFFSET 12U
#define COUNT_OFFSET 16U

#define PART_MIDDLE 0x00U
#define PART_FIRST 0x40U
#define PART_LAST 0x80U
#define PART_WHOLE 0xC0U

void sdls_wipe(void* const secret, const size_t size)
{
    volatile uint8_t* const octets = (volatile uint8_t*)secret;
    for (size_t i = 0U; i < size; i++) {
        octets[i] = 0U;
    }
}

void sdls_close(sdls_receiver_t* const self)
{
    FSW_ASSERT(self != NULL);
    sdls_wipe(self, sizeof *self);
}

status_t sdls_open(sdls_receiver_t* const self, const uint8_t key[SDLS_KEY_OCTETS],
                   const medium_t* const medium)
{
    FSW_ASSERT((self != NULL) && (key != NULL) && (medium != NULL));
    // No frame uses the initialization vector of session 0, because sessions begin with 1.
    static const uint8_t unused[SDLS_VECTOR_OCTETS] = {0};
    // The first output of the cipher identifies the key without revealing it.
    uint8_t check[SESSION_MARK_CHECK];
    sdls_close(self);
    gcm_aes256_set_key(&self->cipher, key);
    gcm_aes256_set_iv(&self->cipher, sizeof unused, unused);
    gcm_aes256_digest(&self->cipher, sizeof check, check);
    const status_t status = sdls_session_mark_open(&self->mark, medium, check);
    self->is_open         = (status == STATUS_OK);
    return status;
}

void sdls_begin(sdls_session_t* const session)
{
    FSW_ASSERT(session != NULL);
    (void)memset(session, 0, offsetof(sdls_session_t, packet));
}

/// Returns the length of the frame; 0 if it is not a frame of this link.
static size_t length_of(const uint8_t* const octets)
{
    const uint16_t word = octets_u16_at(&octets[LENGTH_OFFSET]); // Virtual channel 0, and the length minus 1.
    const size_t length = (size_t)word + 1U;
    const bool is_ours  = (octets_u16_at(octets) == FIRST_WORD) && (octets[NUMBER_OFFSET] == 0U) &&
                         (length >= SDLS_FRAME_MIN) && (length <= SDLS_FRAME_MAX);
    return is_ours ? length : 0U;
}

/// Decrypt the frame after the received parts of the packet. True if the MAC is correct;
/// otherwise the decrypted octets must not be used.
static bool is_authentic(sdls_receiver_t* const self, sdls_session_t* const session,
                         const uint8_t* const octets, const size_t content)
{
    uint8_t mac[SDLS_MAC_OCTETS];
    gcm_aes256_set_iv(&self->cipher, SDLS_VECTOR_OCTETS, &octets[VECTOR_OFFSET]);
    gcm_aes256_update(&self->cipher, SDLS_CLEAR_OCTETS, octets);
    gcm_aes256_decrypt(&self->cipher, content, &session->packet[session->held], &octets[SDLS_CLEAR_OCTETS]);
    gcm_aes256_digest(&self->cipher, sizeof mac, mac);
    const bool is_right = (memeql_sec(mac, &octets[SDLS_CLEAR_OCTETS + content], sizeof mac) != 0);
    if (!is_right) {
        sdls_wipe(&session->packet[session->held], content);
    }
    return is_right;
}

/// True if the frame has the number that is next on this connection.
static bool is_next(const sdls_receiver_t* const self, const sdls_session_t* const session,
                    const uint8_t* const octets)
{
    const uint32_t number = octets_u32_at(&octets[SESSION_OFFSET]);
    const uint32_t count  = octets_u32_at(&octets[COUNT_OFFSET]);
    if (octets_u32_at(&octets[VECTOR_OFFSET]) != 0U) {
        return false;
    }
    return session->is_bound
               ? ((number == session->session) && (count == session->next) && !session->is_spent)
               : ((number > self->mark.session) && (count == 0U));
}

static bool is_part_expected(const sdls_session_t* const session, const uint8_t part)
{
    const bool is_first = (part == PART_FIRST) || (part == PART_WHOLE);
    const bool is_more  = (part == PART_MIDDLE) || (part == PART_LAST); // Other frames belong to another MAP.
    return (session->held == 0U) ? is_first : is_more;
}

static status_t refuse(sdls_receiver_t* const self, const sdls_refusal_t reason)
{
    static const status_t statuses[SDLS_REFUSALS] = {
        [SDLS_REFUSED_FRAME] = STATUS_INVALID,      [SDLS_REFUSED_ASSOCIATION] = STATUS_NOT_FOUND,
        [SDLS_REFUSED_FORGED] = STATUS_CHECKSUM,    [SDLS_REFUSED_REPLAYED] = STATUS_STALE,
        [SDLS_REFUSED_PARTS] = STATUS_OUT_OF_RANGE, [SDLS_REFUSED_NOT_KEPT] = STATUS_IO};
    self->refused[reason]++;
    return statuses[reason];
}

/// Bind a session to its number at its first frame. The number is stored first, so that no other session can
/// use it later.
static bool bind_session(sdls_receiver_t* const self, sdls_session_t* const session, const uint32_t number)
{
    if (session->is_bound) {
        return true;
    }
    session->is_bound = (sdls_session_mark_advance(&self->mark, number) == STATUS_OK);
    session->session  = number;
    return session->is_bound;
}

status_t sdls_look(sdls_receiver_t* const self, sdls_session_t* const session, const uint8_t* const octets,
                   const size_t size, sdls_frame_t* const out_frame)
{
    FSW_ASSERT((self != NULL) && (session != NULL) && (octets != NULL) && (out_frame != NULL));
    *out_frame         = (sdls_frame_t){0U, NULL, 0U};
    session->candidate = 0U;
    if (size < SDLS_HEADER_OCTETS) {
        return STATUS_TRUNCATED;
    }
    const size_t length = length_of(octets);
    if (length == 0U) {
        return refuse(self, SDLS_REFUSED_FRAME);
    }
    if (size < length) {
        return STATUS_TRUNCATED;
    }
    const size_t content = length - SDLS_CLEAR_OCTETS - SDLS_MAC_OCTETS;
    out_frame->taken     = length;
    if (!self->is_open) {
        return refuse(self, SDLS_REFUSED_NOT_KEPT);
    }
    if (octets_u16_at(&octets[SPI_OFFSET]) != SDLS_SPI) {
        return refuse(self, SDLS_REFUSED_ASSOCIATION);
    }
    if (content > (sizeof session->packet - session->held)) {
        return refuse(self, SDLS_REFUSED_PARTS);
    }
    // The MAC is checked before the receiver uses the number and the part of the frame.
    if (!is_authentic(self, session, octets, content)) {
        return refuse(self, SDLS_REFUSED_FORGED);
    }
    if (!is_next(self, session, octets)) {
        return refuse(self, SDLS_REFUSED_REPLAYED);
    }
    if (!is_part_expected(session, octets[SEGMENT_OFFSET])) {
        return refuse(self, SDLS_REFUSED_PARTS);
    }
    if (!bind_session(self, session, octets_u32_at(&octets[SESSION_OFFSET]))) {
        return refuse(self, SDLS_REFUSED_NOT_KEPT);
    }
    session->candidate = content;
    session->is_last   = ((octets[SEGMENT_OFFSET] & PART_LAST) != 0U);
    if (session->is_last) {
        out_frame->packet = session->packet;
        out_frame->size   = session->held + content;
    }
    return STATUS_OK;
}

void sdls_accept(sdls_receiver_t* const self, sdls_session_t* const session)
{
    FSW_ASSERT((self != NULL) && (session != NULL) && (session->candidate > 0U));
    session->held      = session->is_last ? 0U : (session->held + session->candidate);
    session->candidate = 0U;
    session->is_spent  = (session->next == UINT32_MAX);
    session->next++;
    self->accepted++;
}
