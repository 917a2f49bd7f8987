// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/device_profile.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

#define MICRO 1.0e-6

static const canopen_device_profile_t profiles[] = {
    {.type           = "cia402-drive",
     .device_type    = 0x00020192U, // CiA 402, servo drive
     .product_code   = 0x00004010U,
     .axis_count     = 1U,
     .position_rad   = MICRO,
     .velocity_rad_s = MICRO,
     .transmit_count = 2U,
     .transmit       = {{.cob_base     = 0x180U,
                         .is_valid     = true,
                         .is_each_sync = true,
                         .entry_count  = 3U,
                         .entries      = {{0x6041U, 0U, 2U}, {0x6064U, 0U, 4U}, {0x6077U, 0U, 2U}}},
                        {.cob_base    = 0x280U,
                         .is_valid    = true,
                         .entry_count = 3U,
                         .entries     = {{0x606CU, 0U, 4U}, {0x6078U, 0U, 2U}, {0x2210U, 0U, 2U}}}},
     .receive_count  = 2U,
     .receive        = {{.cob_base    = 0x200U,
                         .is_valid    = true,
                         .entry_count = 3U,
                         .entries     = {{0x6040U, 0U, 2U}, {0x607AU, 0U, 4U}, {0x60B2U, 0U, 2U}}},
                        {.cob_base    = 0x300U,
                         .is_valid    = false,
                         .entry_count = 3U,
                         .entries     = {{0x6040U, 0U, 2U}, {0x6071U, 0U, 2U}, {0x60FFU, 0U, 4U}}}}},
    {.type           = "joystick",
     .device_type    = 0xFFFF0192U, // CiA 402, several axes
     .product_code   = 0x00002015U,
     .axis_count     = 2U,
     .position_rad   = MICRO,
     .velocity_rad_s = MICRO,
     .transmit_count = 2U,
     .transmit       = {{.cob_base     = 0x180U,
                         .is_valid     = true,
                         .is_each_sync = true,
                         .entry_count  = 2U,
                         .entries      = {{0x6064U, 0U, 4U}, {0x6864U, 0U, 4U}}},
                        {.cob_base     = 0x280U,
                         .is_valid     = true,
                         .is_each_sync = true,
                         .entry_count  = 3U,
                         .entries      = {{0x6041U, 0U, 2U}, {0x6841U, 0U, 2U}, {0x60FDU, 0U, 4U}}}},
     .receive_count  = 1U,
     .receive        = {{.cob_base    = 0x200U,
                         .is_valid    = true,
                         .entry_count = 4U,
                         .entries = {{0x6071U, 0U, 2U}, {0x6871U, 0U, 2U}, {0x6040U, 0U, 2U}, {0x6840U, 0U, 2U}}}}},
};

const canopen_device_profile_t* canopen_device_profile_find(const char* const type)
{
    FSW_ASSERT(type != NULL);
    for (size_t i = 0U; i < (sizeof profiles / sizeof profiles[0]); i++) {
        if (strcmp(profiles[i].type, type) == 0) {
            return &profiles[i];
        }
    }
    return NULL;
}

uint8_t canopen_device_profile_pdo_octets(const canopen_profile_pdo_t* const pdo)
{
    FSW_ASSERT(pdo != NULL);
    uint8_t octets = 0U;
    for (uint8_t i = 0U; i < pdo->entry_count; i++) {
        octets = (uint8_t)(octets + pdo->entries[i].octets);
    }
    return octets;
}
