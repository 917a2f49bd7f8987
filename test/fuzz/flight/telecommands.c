// SPDX-License-Identifier: Apache-2.0
#include "test/fuzz/flight/telecommands.h"

#include "base/crc.h"
#include "base/octets.h"
#include "pus/core/packet.h"
#include "test/fuzz/fuzz.h"

#include <string.h>

#define SEQUENCES 16000U // Larger sequence counts belong to requests that are nested in others.
#define ENTRY_HEADER 6U
#define SHUTDOWN_SERVICE 131U
#define SHUTDOWN_SUBTYPE 5U
#define DATA_MAX (TELECOMMAND_MAX - PUS_TC_MIN)

uint32_t telecommands_random(telecommands_t* const self, const uint32_t below)
{
    self->random += 0x9E3779B97F4A7C15ULL; // splitmix64
    uint64_t mixed = self->random;
    mixed          = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    mixed          = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBULL;
    return (uint32_t)((mixed ^ (mixed >> 31U)) % below);
}

bool telecommands_init(telecommands_t* const self, const uint64_t seed, const uint8_t* const pool,
                       const size_t size)
{
    (void)memset(self, 0, sizeof *self);
    self->random = seed;
    size_t at    = 4U;
    while (((at + ENTRY_HEADER) <= size) && (self->count < (sizeof self->entry / sizeof self->entry[0]))) {
        self->entry[self->count] = &pool[at];
        self->count++;
        at += ENTRY_HEADER + octets_u16_at(&pool[at + 4U]);
    }
    if (size >= 4U) {
        self->script = octets_u16_at(pool);
        self->usual  = octets_u16_at(&pool[2]);
    }
    return (at == size) && (self->script <= self->usual) && (self->usual >= 1U) &&
           (self->usual < self->count);
}

static void seal(telecommand_t* const out)
{
    octets_put_u16(&out->octets[4], (uint16_t)(out->size - 7U));
    octets_put_u16(&out->octets[out->size - PUS_CRC_SIZE],
                   crc16_ccitt(out->octets, out->size - PUS_CRC_SIZE));
}

void telecommands_make(telecommands_t* const self, const uint16_t apid, const uint8_t service,
                       const uint8_t subtype, const uint8_t* const data, const size_t size,
                       telecommand_t* const out)
{
    const pus_tc_t tc = {.apid     = apid,
                         .sequence = self->sequence[apid],
                         .ack      = PUS_ACK_ALL,
                         .service  = service,
                         .subtype  = subtype,
                         .source   = TELECOMMAND_USER,
                         .data     = data,
                         .size     = size};
    FUZZ_CHECK(pus_tc_encode(&tc, out->octets, sizeof out->octets, &out->size) == STATUS_OK);
    self->sequence[apid] = (uint16_t)((self->sequence[apid] + 1U) % SEQUENCES);
    out->is_followed     = true;
}

/// Change octets, or the size, of application data.
static size_t change(telecommands_t* const self, uint8_t* const data, const size_t size)
{
    static const uint8_t edges[] = {0U, 1U, 2U, 3U, 0x7FU, 0x80U, 0xFEU, 0xFFU};
    size_t now                   = size;
    const uint32_t changes       = 1U + telecommands_random(self, 3U);
    for (uint32_t i = 0U; i < changes; i++) {
        const uint32_t place = (now > 0U) ? telecommands_random(self, (uint32_t)now) : 0U;
        switch (telecommands_random(self, 6U)) {
        case 0U:
            data[place] = (uint8_t)telecommands_random(self, 256U);
            break;
        case 1U:
            data[place] ^= (uint8_t)(1U << telecommands_random(self, 8U));
            break;
        case 2U:
            data[place] = edges[telecommands_random(self, sizeof edges)];
            break;
        case 3U: // All octets of a field.
            (void)memset(&data[place], edges[telecommands_random(self, sizeof edges)],
                         ((now - place) < 4U) ? (now - place) : 4U);
            break;
        case 4U:
            now = place;
            break;
        default:
            now += ((now + 8U) <= DATA_MAX) ? telecommands_random(self, 8U) : 0U;
            break;
        }
    }
    return now;
}

/// True for the request that ends the mission, which would end the flight.
static bool is_end(const uint8_t* const octets, const size_t size)
{
    return (size >= PUS_TC_MIN) && (octets[7] == SHUTDOWN_SERVICE) && (octets[8] == SHUTDOWN_SUBTYPE);
}

static void draw_octets(telecommands_t* const self, telecommand_t* const out)
{
    out->size = 7U + telecommands_random(self, 64U);
    for (size_t i = 0U; i < out->size; i++) {
        out->octets[i] = (uint8_t)telecommands_random(self, 256U);
    }
    if (telecommands_random(self, 2U) == 0U) { // Half of them get a header whose first fields are valid.
        static const uint8_t apids[] = {1U, 2U, 16U, 17U};
        out->octets[0]               = 0x18U;
        out->octets[1]               = apids[telecommands_random(self, sizeof apids)];
        out->octets[2] |= 0xC0U;
    }
    octets_put_u16(&out->octets[4], (uint16_t)(out->size - 7U));
    if (out->size >= (6U + PUS_CRC_SIZE)) {
        seal(out);
    }
    out->is_followed = false;
}

void telecommands_draw(telecommands_t* const self, telecommand_t* const out)
{
    uint8_t data[TELECOMMAND_MAX] = {0U};
    do {
        const uint32_t kind = telecommands_random(self, 100U);
        if (kind < 10U) {
            draw_octets(self, out);
            continue;
        }
        const uint32_t of_usual    = telecommands_random(self, self->usual);
        const uint32_t of_all      = telecommands_random(self, self->count);
        const uint8_t* const entry = self->entry[(kind < 55U) ? of_usual : of_all];
        size_t size                = octets_u16_at(&entry[4]);
        uint16_t apid              = octets_u16_at(entry);
        FUZZ_CHECK(size <= DATA_MAX);
        (void)memcpy(data, &entry[ENTRY_HEADER], size);
        if (kind >= 75U) {
            size = change(self, data, size);
        }
        if (telecommands_random(self, 50U) == 0U) {
            apid = (uint16_t)telecommands_random(self, 2047U); // The last APID is that of idle packets.
        }
        telecommands_make(self, apid, entry[2], entry[3], data, size, out);
    } while (is_end(out->octets, out->size));
}

static void take(telecommands_t* const self, const uint32_t index, telecommand_t* const out)
{
    const uint8_t* const entry = self->entry[index];
    telecommands_make(self, octets_u16_at(entry), entry[2], entry[3], &entry[ENTRY_HEADER],
                      octets_u16_at(&entry[4]), out);
}

void telecommands_draw_usual(telecommands_t* const self, telecommand_t* const out)
{
    take(self, telecommands_random(self, self->usual), out);
}

bool telecommands_take_script(telecommands_t* const self, const uint32_t index, telecommand_t* const out)
{
    if (index < self->script) {
        take(self, index, out);
    }
    return index < self->script;
}
