// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/setting.h"

#include "fsw/canopen/cob.h"
#include "base/assertion.h"

#include <stddef.h>

void canopen_setting_run_begin(canopen_setting_run_t* const run, canopen_setting_t* const settings,
                               const uint16_t count)
{
    FSW_ASSERT((run != NULL) && ((settings != NULL) || (count == 0U)));
    *run = (canopen_setting_run_t){
        .settings = settings, .count = count, .result = (count > 0U) ? STATUS_BUSY : STATUS_OK};
}

static status_t start_access(const canopen_setting_t* const setting, canopen_sdo_client_t* const client)
{
    FSW_ASSERT((setting->octets >= 1U) && (setting->octets <= 8U));
    if (setting->kind != SETTING_WRITE) {
        return canopen_sdo_client_upload(client, setting->index, setting->subindex);
    }
    uint8_t octets[8];
    canopen_put(octets, setting->value, setting->octets);
    return canopen_sdo_client_download(client, setting->index, setting->subindex, octets, setting->octets);
}

/// Take the value of a finished upload. STATUS_OK, STATUS_INVALID (another size or value).
static status_t take_value(canopen_setting_run_t* const run, canopen_setting_t* const setting,
                           const canopen_sdo_client_t* const client)
{
    size_t size                 = 0U;
    const uint8_t* const octets = canopen_sdo_client_value(client, &size);
    // An expedited answer without a size counts as four octets: octets beyond the expected size are
    // ignored; a shorter answer is refused.
    if ((size < setting->octets) || ((size > setting->octets) && (size != 4U))) {
        return STATUS_INVALID;
    }
    const uint64_t value = canopen_at(octets, setting->octets);
    if (setting->kind == SETTING_READ) {
        setting->value = value;
        return STATUS_OK;
    }
    if (value != setting->value) {
        run->is_other_value = true;
        run->found          = value;
        return STATUS_INVALID;
    }
    return STATUS_OK;
}

status_t canopen_setting_run_step(canopen_setting_run_t* const run, canopen_sdo_client_t* const client)
{
    FSW_ASSERT((run != NULL) && (client != NULL));
    if (run->result != STATUS_BUSY) {
        return run->result;
    }
    canopen_setting_t* const setting = &run->settings[run->position];
    if (!run->is_started) { // The client was busy with another transfer: try again.
        run->is_started = (start_access(setting, client) == STATUS_OK);
        return STATUS_BUSY;
    }
    status_t status = canopen_sdo_client_result(client, &run->abort_code);
    if ((status == STATUS_OK) && (setting->kind != SETTING_WRITE)) {
        status = take_value(run, setting, client);
    }
    if (status == STATUS_OK) {
        run->position++;
        run->is_started = false;
        if (run->position < run->count) { // The next access begins in the cycle that ended this one.
            run->is_started = (start_access(&run->settings[run->position], client) == STATUS_OK);
            return STATUS_BUSY;
        }
    }
    if (status == STATUS_EMPTY) { // The client was reset meanwhile.
        status = STATUS_TIMEOUT;
    }
    run->result = status;
    return status;
}
