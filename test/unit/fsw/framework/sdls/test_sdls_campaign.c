// SPDX-License-Identifier: Apache-2.0
// A hundred thousand hostile frames for each of ten seeds. The attacker has recorded every frame that was
// ever sent, delivered or not, and sends frames on the operator's connection and on other ones, before and
// after restarts. The receiver must accept none of them, and must accept every telecommand of the operator.
#include "base/octets.h"
#include "test/support/recorded_media.h"
#include "test/support/sealer.h"
#include "unity.h"

#include <string.h>

#define ATTACKS 100000U
#define TAPE 256U ///< Frames that the attacker has recorded.
#define CONTENT 24U

typedef enum {
    FORGE,
    REPLAY,
    FLIP,
    TRUNCATE,
    REORDER,
    SPLICE,
    KINDS
} kind_t;

static const image_t empty[2];
static image_t disk[2];
static medium_t medium;
static sdls_receiver_t receiver;
static sdls_session_t own;     // The operator's connection.
static sdls_session_t hostile; // The connection of the attacker.
static sealed_t tape[TAPE];
static size_t taped;
static sealed_t next;
static uint64_t state;
static unsigned attacks[KINDS];
static unsigned restarts;
static unsigned served;

void setUp(void)
{
}

void tearDown(void)
{
}

static uint32_t random_below(const uint32_t limit) // Xorshift.
{
    state ^= state << 13U;
    state ^= state >> 7U;
    state ^= state << 17U;
    return (uint32_t)((state >> 32U) % limit);
}

static void record(const sealed_t* const frame)
{
    tape[taped % TAPE] = *frame;
    taped++;
}

static void prepare(const uint32_t session, const uint32_t count)
{
    uint8_t content[CONTENT];
    for (size_t i = 0U; i < sizeof content; i++) {
        content[i] = (uint8_t)random_below(256U);
    }
    next = (sealed_t){.session = session, .count = count, .spi = SDLS_SPI, .part = SEALER_WHOLE};
    seal(&next, sealer_key, content, 1U + random_below(CONTENT));
}

static void close_connections(void)
{
    sdls_begin(&own);
    prepare(next.session + 1U, 0U);
}

static void restart(void)
{
    recorded_copy(disk, recorded.image);
    recorded_clear(disk);
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_open(&receiver, sealer_key, &medium));
    sdls_begin(&hostile);
    close_connections();
    restarts++;
}

/// The operator's next telecommand arrives.
static void serve(void)
{
    sdls_frame_t checked;
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_look(&receiver, &own, next.octets, next.size, &checked));
    TEST_ASSERT_EQUAL(next.size, checked.taken);
    sdls_accept(&receiver, &own);
    record(&next);
    prepare(next.session, next.count + 1U);
    served++;
}

static void flip(sealed_t* const frame)
{
    const uint32_t bits = 1U + random_below(4U);
    const size_t from   = random_below((uint32_t)frame->size);
    for (uint32_t i = 0U; i < bits; i++) { // A different bit each time.
        frame->octets[(from + i) % frame->size] ^= (uint8_t)(1U << random_below(8U));
    }
}

static void truncate_frame(sealed_t* const frame)
{
    frame->size -= 1U + random_below((uint32_t)frame->size - 1U);
    if ((random_below(2U) == 0U) && (frame->size >= SDLS_FRAME_MIN)) {
        // The length field keeps its value.
        octets_put_u16(&frame->octets[2], (uint16_t)(frame->size - 1U));
    }
}

/// Take the headers of an expected frame; the rest is from a recorded frame or random.
static void splice(sealed_t* const frame, const bool is_forged)
{
    const sealed_t* const other = &tape[random_below(TAPE) % taped];
    *frame                      = next;
    for (size_t i = SDLS_CLEAR_OCTETS; i < frame->size; i++) {
        frame->octets[i] = is_forged ? (uint8_t)random_below(256U) : other->octets[i];
    }
}

static void make(const kind_t kind, sealed_t* const frame)
{
    *frame = (random_below(2U) == 0U) ? next : tape[random_below(TAPE) % taped];
    switch (kind) {
    case REPLAY:
        *frame = tape[random_below(TAPE) % taped];
        break;
    case FLIP:
        flip(frame);
        break;
    case TRUNCATE:
        truncate_frame(frame);
        break;
    case REORDER: { // A later frame of the operator overtakes it.
        const sealed_t kept = next;
        prepare(kept.session, kept.count + 1U + random_below(3U));
        *frame = next;
        next   = kept;
        break;
    }
    default:
        splice(frame, kind == FORGE);
        break;
    }
}

static void attack(void)
{
    const kind_t kind         = (kind_t)random_below(KINDS);
    sdls_session_t* const way = (random_below(2U) == 0U) ? &own : &hostile;
    const uint32_t accepted   = receiver.accepted;
    const uint32_t mark       = receiver.mark.session;
    sealed_t frame;
    sdls_frame_t checked;
    make(kind, &frame);
    if ((kind == FORGE || kind == SPLICE) && (memcmp(frame.octets, next.octets, next.size) == 0)) {
        return;
    }
    attacks[kind]++;
    TEST_ASSERT_NOT_EQUAL(STATUS_OK, sdls_look(&receiver, way, frame.octets, frame.size, &checked));
    TEST_ASSERT_NULL(checked.packet);
    TEST_ASSERT_EQUAL_UINT32(accepted, receiver.accepted);
    TEST_ASSERT_EQUAL_UINT32(mark, receiver.mark.session);
}

static void campaign(const uint64_t seed)
{
    state = seed;
    taped = 0U;
    memset(attacks, 0, sizeof attacks);
    recorded_clear(empty);
    medium = recorded_medium(0U);
    sealer_make_mark(&medium, sealer_key, 0U);
    next.session = 0U;
    restart();
    serve();
    for (unsigned total = 0U; total < ATTACKS;) {
        const uint32_t what = random_below(1000U);
        if (what < 60U) {
            serve();
        } else if (what < 65U) {
            close_connections();
        } else if (what < 70U) {
            record(&next); // The frame is lost; the attacker records it. The operator begins a new session.
            close_connections();
            serve();
        } else if (what < 75U) {
            restart();
            // Before this frame, the attacker's frames of an unused session would be as valid as the
            // operator's.
            serve();
        } else if (what < 85U) {
            sdls_begin(&hostile);
        } else {
            attack();
            total++;
        }
    }
}

static void no_hostile_frame_is_accepted(void)
{
    for (uint64_t seed = 10U; seed > 0U; seed--) {
        campaign(seed);
    }
    for (unsigned kind = 0U; kind < (unsigned)KINDS; kind++) {
        TEST_ASSERT_TRUE(attacks[kind] > (ATTACKS / 10U));
    }
    TEST_ASSERT_TRUE(restarts > 100U);
    TEST_ASSERT_TRUE(served > 1000U);
    TEST_ASSERT_TRUE(receiver.refused[SDLS_REFUSED_FORGED] > 0U);
    TEST_ASSERT_TRUE(receiver.refused[SDLS_REFUSED_REPLAYED] > 0U);
    TEST_ASSERT_TRUE(receiver.refused[SDLS_REFUSED_FRAME] > 0U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_hostile_frame_is_accepted);
    return UNITY_END();
}
