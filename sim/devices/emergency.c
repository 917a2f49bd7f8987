// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/emergency.h"

#include <stddef.h>
#include <string.h>

// Bits of the error register.
#define REGISTER_GENERIC 0x01U
#define REGISTER_CURRENT 0x02U
#define REGISTER_VOLTAGE 0x04U
#define REGISTER_TEMPERATURE 0x08U
#define REGISTER_COMMUNICATION 0x10U
#define REGISTER_PROFILE 0x20U
#define REGISTER_MANUFACTURER 0x80U

static uint32_t register_bit(const uint16_t code)
{
    switch (code >> 12) {
    case 0x2U:
        return REGISTER_CURRENT;
    case 0x3U:
        return REGISTER_VOLTAGE;
    case 0x4U:
        return REGISTER_TEMPERATURE;
    case 0x7U:
        return REGISTER_PROFILE;
    case 0x8U:
        return (code < 0x8300U) ? REGISTER_COMMUNICATION : REGISTER_PROFILE;
    case 0xFU:
        return REGISTER_MANUFACTURER;
    default:
        return 0U;
    }
}

static void renew_register(emergencies_t* const emergencies)
{
    uint32_t bits = (emergencies->present_count != 0U) ? REGISTER_GENERIC : 0U;
    for (unsigned i = 0U; i < emergencies->present_count; i++) {
        bits |= register_bit(emergencies->present[i].code);
    }
    object_set(emergencies->error_register, (int64_t)bits);
}

void emergencies_init(emergencies_t* const emergencies, const dictionary_t* const dictionary)
{
    *emergencies                = (emergencies_t){0};
    emergencies->error_register = dictionary_find(dictionary, 0x1001U, 0U);
    emergencies->history_count  = dictionary_find(dictionary, 0x1003U, 0U);
    for (uint8_t i = 0U; i < EMERGENCY_HISTORY; i++) {
        emergencies->history[i] = dictionary_find(dictionary, 0x1003U, (uint8_t)(i + 1U));
    }
}

void emergencies_reset(emergencies_t* const emergencies)
{
    emergencies->present_count = 0U;
    renew_register(emergencies);
}

static unsigned position_of(const emergencies_t* const emergencies, const uint16_t code, const uint8_t axis)
{
    unsigned i = 0U;
    while ((i < emergencies->present_count) &&
           ((emergencies->present[i].code != code) || (emergencies->present[i].axis != axis))) {
        i++;
    }
    return i;
}

bool emergency_is_present(const emergencies_t* const emergencies, const uint16_t code, const uint8_t axis)
{
    return position_of(emergencies, code, axis) < emergencies->present_count;
}

static void remember(emergencies_t* const emergencies, const uint16_t code, const uint8_t axis)
{
    if ((emergencies->history_count == NULL) || (emergencies->history[EMERGENCY_HISTORY - 1U] == NULL)) {
        return;
    }
    for (unsigned i = EMERGENCY_HISTORY - 1U; i > 0U; i--) {
        emergencies->history[i]->value = emergencies->history[i - 1U]->value;
    }
    emergencies->history[0]->value = (uint64_t)code | ((uint64_t)axis << 16);
    if (emergencies->history_count->value < EMERGENCY_HISTORY) {
        emergencies->history_count->value++;
    }
}

static void compose(const emergencies_t* const emergencies, const uint16_t code, const uint8_t axis,
                    const int32_t raw, uint8_t message[EMERGENCY_OCTETS])
{
    message[0] = (uint8_t)code;
    message[1] = (uint8_t)(code >> 8);
    message[2] = (uint8_t)emergencies->error_register->value;
    message[3] = axis;
    for (unsigned i = 0U; i < 4U; i++) {
        message[4U + i] = (uint8_t)((uint32_t)raw >> (8U * i));
    }
}

bool emergency_raise(emergencies_t* const emergencies, const uint16_t code, const uint8_t axis,
                     const int32_t raw, uint8_t message[EMERGENCY_OCTETS])
{
    if (emergency_is_present(emergencies, code, axis) ||
        (emergencies->present_count == EMERGENCY_PRESENT_MAX)) {
        return false;
    }
    emergencies->present[emergencies->present_count] = (emergency_t){.code = code, .axis = axis};
    emergencies->present_count++;
    renew_register(emergencies);
    remember(emergencies, code, axis);
    compose(emergencies, code, axis, raw, message);
    return true;
}

bool emergency_clear(emergencies_t* const emergencies, const uint16_t code, const uint8_t axis,
                     uint8_t message[EMERGENCY_OCTETS])
{
    const unsigned position = position_of(emergencies, code, axis);
    if (position == emergencies->present_count) {
        return false;
    }
    emergencies->present_count--;
    for (unsigned i = position; i < emergencies->present_count; i++) {
        emergencies->present[i] = emergencies->present[i + 1U];
    }
    renew_register(emergencies);
    compose(emergencies, EMERGENCY_NONE, axis, 0, message);
    return emergencies->present_count == 0U;
}
