// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world_instrument.h"

#include "sim/world/world_internal.h"

#include <string.h>

#define CHOICE(attribute, member, is_optional)                                                               \
    {                                                                                                        \
        attribute, FIELD_NAME, offsetof(world_instrument_t, member), 0.0, 0.0, is_optional                   \
    }

const field_t world_instrument_fields[WORLD_INSTRUMENT_FIELDS] = {
    CHOICE("name", name, false),
    CHOICE("type", type_name, false),
    {"channel", FIELD_TEXT, offsetof(world_instrument_t, channel), 0.0, 0.0, false},
    CHOICE("framing", framing, true),
    CHOICE("order", order, true),
    CHOICE("checksum", checksum, true),
    {"period", FIELD_TIME, offsetof(world_instrument_t, period_ns), 1e5, 1e10, false},
    CHOICE("value", value_name, false),
    {"scale", FIELD_NUMBER, offsetof(world_instrument_t, scale), -GREAT, GREAT, true},
    {"offset", FIELD_NUMBER, offsetof(world_instrument_t, offset), -GREAT, GREAT, true},
    {"speed", FIELD_NUMBER, offsetof(world_instrument_t, speed), 0.0, GREAT, false}};

/// Find the index of a word in a list; an empty word means the first one. False: the list does not contain
/// the word; the error text says what is expected.
static bool take_word(const element_t* const element, const char* const word, const char* const* const words,
                      const char* const expected, unsigned* const out_index)
{
    *out_index = 0U;
    for (unsigned i = 0U; words[i] != NULL; i++) {
        if ((word[0] == '\0') || (strcmp(word, words[i]) == 0)) {
            *out_index = i;
            return true;
        }
    }
    (void)element_refuse(element, word, expected);
    return false;
}

status_t world_instrument_finish(world_t* const world, const element_t* const element, void* const record)
{
    static const char* const types[]    = {"SHM", "MQUEUE", "UDP", "TCP", "SERIAL", "FILE", NULL};
    static const char* const framings[] = {"LENGTH", "SLIP", NULL};
    static const char* const orders[]   = {"BIG", "LITTLE", NULL};
    static const char* const flags[]    = {"false", "true", NULL};
    static const char* const values[]   = {"INT16", "INT32", "FLOAT", "DOUBLE", NULL};
    world_instrument_t* instrument      = record;
    unsigned framing                    = 0U;
    unsigned order                      = 0U;
    unsigned checksum                   = 0U;
    if (!take_word(element, instrument->type_name, types, "SHM MQUEUE UDP TCP SERIAL or FILE",
                   &instrument->type) ||
        !take_word(element, instrument->framing, framings, "LENGTH or SLIP", &framing) ||
        !take_word(element, instrument->order, orders, "BIG or LITTLE", &order) ||
        !take_word(element, instrument->checksum, flags, "true or false", &checksum) ||
        !take_word(element, instrument->value_name, values, "INT16 INT32 FLOAT or DOUBLE",
                   &instrument->value)) {
        return STATUS_INVALID;
    }
    if (element_attribute(element, "scale") == NULL) {
        instrument->scale = 1.0;
    }
    if (instrument->scale == 0.0) {
        return element_refuse(element, "0", "a scale other than 0");
    }
    for (const world_instrument_t* other = world->instrument; other < instrument; other++) {
        if (strcmp(other->name, instrument->name) == 0) {
            return element_refuse(element, instrument->name, "a name that no Instrument above has");
        }
        if ((other->type == instrument->type) && (strcmp(other->channel, instrument->channel) == 0)) {
            return element_refuse(element, instrument->channel,
                                  "a channel that no Instrument of this type above has");
        }
    }
    for (size_t i = 0U; i < world->bus_count; i++) {
        if (strcmp(world->bus[i], instrument->name) == 0) {
            return element_refuse(element, instrument->name,
                                  "a name that no bus has: `fault unplug` names a bus or an Instrument");
        }
    }
    instrument->line         = element->line;
    instrument->is_slip      = (framing == 1U);
    instrument->is_little    = (order == 1U);
    instrument->has_checksum = (checksum == 1U);
    return STATUS_OK;
}
