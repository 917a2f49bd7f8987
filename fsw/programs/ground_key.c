// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/ground_key.h"

#include "fsw/programs/file_medium.h"
#include "base/assertion.h"
#include "base/text.h"

#include <string.h>

#define HEX_OCTETS 64U
#define CONTENT_MAX 66U ///< One octet more than a key can have, so that a longer file is detected.
#define PATH_MAX_OCTETS 256U

static bool fail(char error[GROUND_KEY_ERROR_MAX], const char* const path, const char* const ending,
                 const char* const why)
{
    text_t text = text_in(error, GROUND_KEY_ERROR_MAX);
    text_add(&text, path);
    text_add(&text, ending);
    text_add(&text, ": ");
    text_add(&text, why);
    return false;
}

/// Returns the value of a hexadecimal digit; 16 if it is not one.
static uint8_t nibble_of(const uint8_t digit)
{
    if ((digit >= (uint8_t)'0') && (digit <= (uint8_t)'9')) {
        return (uint8_t)(digit - (uint8_t)'0');
    }
    const uint8_t lower = (uint8_t)(digit | 0x20U);
    return ((lower >= (uint8_t)'a') && (lower <= (uint8_t)'f')) ? (uint8_t)(lower - (uint8_t)'a' + 10U) : 16U;
}

/// Read 32 octets, or 64 hexadecimal digits with an optional line end.
static bool read_content(const uint8_t* const content, const size_t size, uint8_t key[SDLS_KEY_OCTETS])
{
    if (size == SDLS_KEY_OCTETS) {
        (void)memcpy(key, content, SDLS_KEY_OCTETS);
        return true;
    }
    const bool has_line_end = (size == (HEX_OCTETS + 1U)) && (content[HEX_OCTETS] == (uint8_t)'\n');
    bool is_right           = (size == HEX_OCTETS) || has_line_end;
    for (size_t i = 0U; is_right && (i < SDLS_KEY_OCTETS); i++) {
        const uint8_t high = nibble_of(content[2U * i]);
        const uint8_t low  = nibble_of(content[(2U * i) + 1U]);
        key[i]             = (uint8_t)((uint8_t)(high << 4U) | low);
        is_right           = (high < 16U) && (low < 16U);
    }
    return is_right;
}

static bool load_key(const char* const path, uint8_t key[SDLS_KEY_OCTETS], char error[GROUND_KEY_ERROR_MAX])
{
    uint8_t content[CONTENT_MAX];
    size_t size           = 0U;
    const status_t status = osal_file_load_secret(path, content, sizeof content, &size);
    const bool is_key     = (status == STATUS_OK) && read_content(content, size, key);
    sdls_wipe(content, sizeof content);
    if (is_key) {
        return true;
    }
    if (status == STATUS_FORBIDDEN) {
        return fail(error, path, "",
                    "other users than its owner have access to the key; run chmod 600 on it");
    }
    if ((status == STATUS_OK) || (status == STATUS_TOO_LARGE)) {
        return fail(error, path, "", "not a key; expected 32 octets or 64 hexadecimal digits");
    }
    return fail(error, path, "", "cannot read the key of the ground link; `gse key make FILE` makes one");
}

/// Open and lock the mark, the file PATH.received. It stores the last session, so that a recorded session is
/// not accepted again.
static bool open_mark(ground_key_t* const self, const char* const path, char error[GROUND_KEY_ERROR_MAX])
{
    char name[PATH_MAX_OCTETS];
    text_t text = text_in(name, sizeof name);
    text_add(&text, path);
    text_add(&text, ".received");
    uint8_t octet         = 0U;
    size_t size           = 0U;
    const status_t looked = text.cut ? STATUS_NOT_FOUND : osal_file_load_secret(name, &octet, 1U, &size);
    // The mark is not created here, because old sessions would then be accepted again.
    if (looked == STATUS_NOT_FOUND) {
        return fail(error, path, ".received",
                    "the mark of the key is missing; `gse key make FILE` makes a new key");
    }
    if (looked == STATUS_FORBIDDEN) { // A user who can write the mark can make old sessions valid again.
        return fail(error, path, ".received",
                    "other users than its owner have access to the mark of the key; run chmod 600 on it");
    }
    const status_t opened = osal_file_update(&self->mark, name);
    const status_t status = (opened == STATUS_OK) ? osal_file_lock(&self->mark) : opened;
    if (status != STATUS_OK) {
        return fail(error, name, "",
                    (status == STATUS_BUSY) ? "another flight uses this key" : status_text(status));
    }
    return true;
}

bool ground_key_open(ground_key_t* const self, const char* const path, char error[GROUND_KEY_ERROR_MAX])
{
    FSW_ASSERT((self != NULL) && (path != NULL) && (error != NULL));
    uint8_t key[SDLS_KEY_OCTETS];
    self->mark.descriptor = -1;
    bool is_open          = load_key(path, key, error) && open_mark(self, path, error);
    if (is_open) {
        const medium_t medium = file_medium(&self->mark);
        const status_t status = sdls_open(&self->receiver, key, &medium);
        is_open               = (status == STATUS_OK) ||
                  fail(error, path, ".received",
                       (status == STATUS_INVALID)
                           ? "damaged, or of another key; `gse key make FILE` makes a new key"
                           : status_text(status));
    }
    sdls_wipe(key, sizeof key);
    if (!is_open) {
        ground_key_close(self);
    }
    return is_open;
}

void ground_key_close(ground_key_t* const self)
{
    FSW_ASSERT(self != NULL);
    sdls_close(&self->receiver);
    osal_file_close(&self->mark);
}
