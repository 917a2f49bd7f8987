// SPDX-License-Identifier: Apache-2.0
#include "launcher/eeprom_image.h"

#include "base/assertion.h"
#include "base/text.h"
#include "fsw/programs/run_state.h"

#include <string.h>

#define PIECE_OCTETS 4096U
#define BLANK 0xFF

/// Add blank octets up to the size of an image. This also completes an image whose creation was interrupted.
static status_t fill(osal_file_t* const image, const uint64_t size)
{
    uint8_t piece[PIECE_OCTETS];
    status_t status = STATUS_OK;
    uint64_t end    = size;
    (void)memset(piece, BLANK, sizeof piece);
    while ((status == STATUS_OK) && (end < TARGET_EEPROM_OCTETS)) {
        const uint64_t rest = TARGET_EEPROM_OCTETS - end;
        const size_t count  = (rest < sizeof piece) ? (size_t)rest : sizeof piece;
        status              = osal_file_write_at(image, end, piece, count);
        end += count;
    }
    return (status == STATUS_OK) ? osal_file_sync(image) : status;
}

/// Lock the image that is open for writing, and complete it.
static status_t prepare(osal_file_t* const file, const char* const path)
{
    uint64_t size   = 0U;
    status_t status = osal_file_lock(file);
    status          = (status == STATUS_OK) ? osal_file_size(file, &size) : status;
    if ((status == STATUS_OK) && (size > TARGET_EEPROM_OCTETS)) {
        status = STATUS_TOO_LARGE;
    }
    if ((status == STATUS_OK) && (size < TARGET_EEPROM_OCTETS)) {
        status = fill(file, size);
        status = (status == STATUS_OK) ? osal_file_sync_names(path) : status;
    }
    return status;
}

status_t eeprom_image_open(eeprom_image_t* const image, const char* const storage,
                           const char* const component)
{
    FSW_ASSERT((image != NULL) && (storage != NULL) && (component != NULL));
    char path[RUN_PATH_MAX];
    *image = (eeprom_image_t){{-1}, {-1}};
    if (!text_join(path, sizeof path, (const char* const[]){storage, "/", component, ".eeprom", NULL})) {
        return STATUS_TOO_LARGE;
    }
    status_t status = osal_file_update(&image->file, path);
    status          = (status == STATUS_OK) ? prepare(&image->file, path) : status;
    status          = (status == STATUS_OK) ? osal_file_open_read(&image->reader, path) : status;
    if (status != STATUS_OK) {
        eeprom_image_close(image);
    }
    return status;
}

void eeprom_image_close(eeprom_image_t* const image)
{
    FSW_ASSERT(image != NULL);
    osal_file_close(&image->file);
    osal_file_close(&image->reader);
}
