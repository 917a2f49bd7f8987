// SPDX-License-Identifier: Apache-2.0
// Frames of the authenticated ground link. Octets of the input were made without the key and are never
// accepted unchanged. Frames that the target seals with the key are accepted exactly if their number is the
// next one, over connections, restarts and failing disks. Each record is a frame, or content that is sealed.
#include "base/crc.h"
#include "base/octets.h"
#include "fsw/framework/sdls/sdls.h"
#include "test/fuzz/fuzz.h"

#include <string.h>

#define CONNECTIONS 3U
#define CONTENT_MAX (SDLS_FRAME_MAX - SDLS_CLEAR_OCTETS - SDLS_MAC_OCTETS)

// Bits of a record's kind.
#define SEALED 0x01U  ///< Seal {session u8, number u8, segment header u8, content}; else: a frame as it is.
#define HANG_UP 0x02U ///< Before the record, its connection ends and a new one begins.
#define RESTART 0x04U ///< Before the record, all connections end and the receiver is opened again.
#define REFUSE 0x08U  ///< During the record, the disk refuses writes.
#define LEAVE 0x10U   ///< The caller does not take the frame that the receiver has accepted.

static const uint8_t secret[SDLS_KEY_OCTETS] = {0x77U, 0x13U};

typedef struct {
    uint8_t octets[SESSION_MARK_APART + SESSION_MARK_RECORD];
    bool refuses;
} disk_t;

typedef struct {      // The next frame that a connection may accept.
    bool is_bound;    // A frame was accepted, so that the session of the connection is fixed.
    uint32_t session; // Only if is_bound; otherwise each session above `highest` may begin.
    uint32_t next;    // Number of the frame.
} expected_t;

static disk_t disk;
static sdls_receiver_t receiver;
static sdls_session_t sessions[CONNECTIONS];
static expected_t expected[CONNECTIONS];
static uint32_t highest;

static status_t read_disk(void* const context, const uint64_t offset, uint8_t* const octets,
                          const size_t size)
{
    (void)context;
    FUZZ_CHECK((offset + size) <= sizeof disk.octets);
    (void)memcpy(octets, &disk.octets[offset], size);
    return STATUS_OK;
}

static status_t write_disk(void* const context, const uint64_t offset, const uint8_t* const octets,
                           const size_t size)
{
    (void)context;
    FUZZ_CHECK((offset + size) <= sizeof disk.octets);
    if (disk.refuses) {
        return STATUS_FULL;
    }
    (void)memcpy(&disk.octets[offset], octets, size);
    return STATUS_OK;
}

static status_t sync_disk(void* const context)
{
    (void)context;
    return STATUS_OK;
}

static void restart(void)
{
    const medium_t medium = {.read = read_disk, .write = write_disk, .sync = sync_disk};
    FUZZ_CHECK(sdls_open(&receiver, secret, &medium) == STATUS_OK);
    FUZZ_CHECK(receiver.mark.session == highest);
    for (size_t i = 0U; i < CONNECTIONS; i++) {
        sdls_begin(&sessions[i]);
        expected[i] = (expected_t){false, 0U, 0U};
    }
}

static void key_check(const uint8_t key[SDLS_KEY_OCTETS], uint8_t out_check[SESSION_MARK_CHECK])
{
    static const uint8_t unused[SDLS_VECTOR_OCTETS] = {0};
    struct gcm_aes256_ctx cipher;
    gcm_aes256_set_key(&cipher, key);
    gcm_aes256_set_iv(&cipher, sizeof unused, unused);
    gcm_aes256_digest(&cipher, SESSION_MARK_CHECK, out_check);
}

static void begin(void)
{
    uint8_t* const octets = disk.octets;
    (void)memset(&disk, 0, sizeof disk);
    (void)memcpy(octets, "SDLS\1", 5U);
    key_check(secret, &octets[12]);
    octets_put_u32(&octets[28], crc32_iso(octets, 28U));
    (void)memcpy(&octets[SESSION_MARK_APART], octets, SESSION_MARK_RECORD);
    highest = 0U;
    restart();
}

static size_t seal(const fuzz_record_t* const record, uint8_t frame[SDLS_FRAME_MAX])
{
    struct gcm_aes256_ctx cipher;
    const size_t content = record->size - 3U;
    const size_t size    = SDLS_CLEAR_OCTETS + content + SDLS_MAC_OCTETS;
    (void)memset(frame, 0, SDLS_CLEAR_OCTETS);
    octets_put_u16(frame, 0x2000U | SDLS_SPACECRAFT);
    octets_put_u16(&frame[2], (uint16_t)(size - 1U));
    frame[5]  = record->octets[2];
    frame[7]  = SDLS_SPI;
    frame[15] = record->octets[0];
    frame[19] = record->octets[1];
    gcm_aes256_set_key(&cipher, secret);
    gcm_aes256_set_iv(&cipher, SDLS_VECTOR_OCTETS, &frame[8]);
    gcm_aes256_update(&cipher, SDLS_CLEAR_OCTETS, frame);
    gcm_aes256_encrypt(&cipher, content, &frame[SDLS_CLEAR_OCTETS], &record->octets[3]);
    gcm_aes256_digest(&cipher, SDLS_MAC_OCTETS, &frame[SDLS_CLEAR_OCTETS + content]);
    return size;
}

/// The number of the frame must be the next one of its connection; after this it counts as used.
static void check_number(const size_t connection, const uint8_t* const frame, const bool is_taken)
{
    expected_t* const own  = &expected[connection];
    const uint32_t session = octets_u32_at(&frame[12]);
    FUZZ_CHECK(octets_u32_at(&frame[16]) == own->next);
    FUZZ_CHECK(own->is_bound ? (session == own->session) : (session > highest));
    *own    = (expected_t){true, session, own->next + (is_taken ? 1U : 0U)};
    highest = (session > highest) ? session : highest;
}

static void show(const fuzz_record_t* const record, const uint8_t* const frame, const size_t size,
                 const bool is_sealed)
{
    sdls_frame_t shown;
    const size_t connection       = record->argument % CONNECTIONS;
    sdls_session_t* const session = &sessions[connection];
    const uint32_t accepted       = receiver.accepted;
    const status_t status         = sdls_look(&receiver, session, frame, size, &shown);
    FUZZ_CHECK(shown.taken <= size);
    FUZZ_CHECK((status == STATUS_OK) || (shown.packet == NULL));
    if (status == STATUS_OK) {
        const bool is_taken = ((record->kind & LEAVE) == 0U);
        FUZZ_CHECK(is_sealed && (shown.taken == size) && (shown.size <= SDLS_PACKET_MAX));
        check_number(connection, frame, is_taken);
        if (is_taken) {
            sdls_accept(&receiver, session);
        }
    }
    FUZZ_CHECK((receiver.accepted - accepted) <= 1U);
    FUZZ_CHECK(session->held <= SDLS_PACKET_MAX);
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    uint8_t frame[SDLS_FRAME_MAX];
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    while (fuzz_next(&input, &record)) {
        const size_t connection = record.argument % CONNECTIONS;
        const bool is_sealed =
            ((record.kind & SEALED) != 0U) && (record.size > 3U) && (record.size <= (CONTENT_MAX + 3U));
        if ((record.kind & RESTART) != 0U) {
            restart();
        }
        if ((record.kind & HANG_UP) != 0U) {
            sdls_begin(&sessions[connection]);
            expected[connection] = (expected_t){false, 0U, 0U};
        }
        disk.refuses = ((record.kind & REFUSE) != 0U);
        if (is_sealed) {
            show(&record, frame, seal(&record, frame), true);
        } else {
            show(&record, record.octets, record.size, false);
        }
        disk.refuses = false;
    }
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, NULL);
}
