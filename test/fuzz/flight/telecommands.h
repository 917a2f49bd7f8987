// SPDX-License-Identifier: Apache-2.0
/// Random telecommands with correct checksums; a seed determines them. They are requests of a pool, unchanged
/// or with changed fields, and packets of random octets. random_flight.py makes the pool from the dictionary
/// of the mission. Each telecommand with a valid header requests all verification reports, so its end can be
/// followed.
#ifndef TEST_FUZZ_FLIGHT_TELECOMMANDS_H
#define TEST_FUZZ_FLIGHT_TELECOMMANDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define TELECOMMAND_USER 1U   ///< Source of the telecommands that are followed.
#define TELECOMMAND_MAX 1024U ///< Largest packet [octets].

typedef struct {
    uint64_t random;     // State of the generator.
    const uint8_t* pool; // Entries: apid u16 | service | subtype | size u16 | data.
    const uint8_t* entry[8192];
    uint32_t count;          // Entries of the pool.
    uint32_t usual;          // The first `usual` entries bring subsystems up; they are drawn more often.
    uint32_t script;         // The first `script` of these, in order, lead to operation with links.
    uint16_t sequence[2048]; // Next sequence count of each APID.
} telecommands_t;

typedef struct {
    uint8_t octets[TELECOMMAND_MAX];
    size_t size;
    bool is_followed; ///< The header is valid: a report with the request id must accept or refuse it.
} telecommand_t;

/// Read the pool, whose header is the number of entries of the script (u16) and of usual entries (u16). The
/// octets must outlive `self`.
bool telecommands_init(telecommands_t* self, uint64_t seed, const uint8_t* pool, size_t size);
void telecommands_draw(telecommands_t* self, telecommand_t* out);
/// Draw one of the requests that bring subsystems up.
void telecommands_draw_usual(telecommands_t* self, telecommand_t* out);
/// Get request number `index` of the script. False if the script has fewer requests.
bool telecommands_take_script(telecommands_t* self, uint32_t index, telecommand_t* out);
/// Make a telecommand with a valid header and these data.
void telecommands_make(telecommands_t* self, uint16_t apid, uint8_t service, uint8_t subtype,
                       const uint8_t* data, size_t size, telecommand_t* out);
/// Returns a number below `below`.
uint32_t telecommands_random(telecommands_t* self, uint32_t below);

#endif // TEST_FUZZ_FLIGHT_TELECOMMANDS_H
