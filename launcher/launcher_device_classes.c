// SPDX-License-Identifier: Apache-2.0
// Checks that the data sheets of the device classes are those from which this build was made.
#include "launcher/launcher_internal.h"

#include "fsw/canopen/device_profile.h"
#include "base/crc.h"
#include "osal/include/osal/file.h"

#define SHEETS "descriptors/devices/"
#define PART_OCTETS 4096U
#define HASH_DIGITS 16U

/// Compute the FNV-1a hash of a file.
static status_t hash_file(const char* const path, uint64_t* const out_hash)
{
    uint8_t octets[PART_OCTETS];
    osal_file_t file = {-1};
    size_t size      = 1U;
    status_t status  = osal_file_open_read(&file, path);
    *out_hash        = FNV64_START;
    while ((status == STATUS_OK) && (size > 0U)) {
        status    = osal_file_read(&file, octets, sizeof octets, &size);
        *out_hash = (status == STATUS_OK) ? fnv64(*out_hash, octets, size) : *out_hash;
    }
    osal_file_close(&file);
    return status;
}

static bool is_of_sheet(launcher_t* const launcher, const canopen_device_profile_t* const class)
{
    char path[LAUNCH_PATH_MAX];
    char compiled[HASH_DIGITS + 3U];
    char found[HASH_DIGITS + 3U];
    uint64_t hash = 0U;
    const bool is_whole =
        text_join(path, sizeof path, (const char* const[]){SHEETS, class->type, ".eds", NULL});
    const status_t status = is_whole ? hash_file(path, &hash) : STATUS_TOO_LARGE;
    if ((status == STATUS_NOT_FOUND) || ((status == STATUS_OK) && (hash == class->sheet_hash))) {
        return true;
    }
    if (status != STATUS_OK) {
        return launcher_refuse(launcher, (const char* const[]){"cannot read the data sheet ", path, ": ",
                                                               status_text(status), NULL});
    }
    text_t text = text_in(compiled, sizeof compiled);
    text_add_hex(&text, class->sheet_hash, HASH_DIGITS);
    text = text_in(found, sizeof found);
    text_add_hex(&text, hash, HASH_DIGITS);
    return launcher_refuse(launcher, (const char* const[]){path, ": expected hash ", compiled,
                                                           ", from which the programs were built, found ",
                                                           found, ": run make", NULL});
}

bool launcher_check_device_classes(launcher_t* const launcher)
{
    size_t position                       = 0U;
    const canopen_device_profile_t* class = canopen_device_profile_at(position);
    while ((class != NULL) && is_of_sheet(launcher, class)) {
        position++;
        class = canopen_device_profile_at(position);
    }
    return class == NULL;
}
