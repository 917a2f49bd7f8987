// SPDX-License-Identifier: Apache-2.0
/// Random telecommands with right checksums, drawn from a seed: requests of a pool, which random_flight.py
/// makes from the dictionary of the mission, as they are or with changed fields, and packets of random
/// octets. Each telecommand with a sound header asks for all reports, so its end can be followed.
#ifndef TEST_FUZZ_FLIGHT_TELECOMMANDS_H
#define TEST_FUZZ_FLIGHT_TELECOMMANDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define TELECOMMAND_USER 1U   ///< Source of those that are followed.
#define TELECOMMAND_MAX 1024U ///< Largest packet [octets].

typedef struct {
    uint64_t random;     // State of the generator.
    const uint8_t* pool; // Entries: apid u16 | service | subtype | size u16 | data.
    const uint8_t* entry[8192];
    uint32_t count;          // Entries of the pool.
    uint32_t usual;          // The first of them bring subsystems up; they are drawn as often as all others.
    uint32_t script;         // The first of these, in their order, lead to operation with links.
    uint16_t sequence[2048]; // Next sequence count of each APID.
} telecommands_t;

typedef struct {
    uint8_t octets[TELECOMMAND_MAX];
    size_t size;
    bool is_followed; ///< The header is valid: a report with the request id must accept or refuse it.
} telecommand_t;

/// Read the pool (header: number of entries of the script u16, of usual entries u16). The octets must outlive
/// `self`.
bool telecommands_init(telecommands_t* self, uint64_t seed, const uint8_t* pool, size_t size);
void telecommands_draw(telecommands_t* self, telecommand_t* out);
/// Draw one of the requests that bring subsystems up.
void telecommands_draw_usual(telecommands_t* self, telecommand_t* out);
/// Request number `index` of the script. False: it has fewer.
bool telecommands_take_script(telecommands_t* self, uint32_t index, telecommand_t* out);
/// A telecommand with a sound header and these data.
void telecommands_make(telecommands_t* self, uint16_t apid, uint8_t service, uint8_t subtype,
                       const uint8_t* data, size_t size, telecommand_t* out);
/// Returns a number below `below`.
uint32_t telecommands_random(telecommands_t* self, uint32_t below);

#endif // TEST_FUZZ_FLIGHT_TELECOMMANDS_H
