// SPDX-License-Identifier: Apache-2.0
// One program runs on this processor: it has no child processes, no environment and no signals.
#include "osal/include/osal/process.h"

#include "base/assertion.h"
#include "osal/freertos/port.h"
#include "osal/freertos/semihosting.h"

#include <stddef.h>

status_t osal_process_start(osal_process_t* const process, const osal_process_start_t* const start)
{
    FSW_ASSERT((process != NULL) && (start != NULL));
    *process = (osal_process_t){.id = 0, .descriptor = -1};
    return STATUS_UNSUPPORTED;
}

status_t osal_process_loaded_size(const char* const path, uint64_t* const out_octets)
{
    FSW_ASSERT((path != NULL) && (out_octets != NULL));
    *out_octets = 0U;
    return STATUS_UNSUPPORTED;
}

status_t osal_process_poll(osal_process_t* const process, osal_process_result_t* const out_result)
{
    FSW_ASSERT((process != NULL) && (out_result != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_process_wait_any(osal_process_t* const* const processes, const size_t count,
                               const uint32_t timeout_ms)
{
    FSW_ASSERT(processes != NULL);
    (void)count;
    (void)timeout_ms;
    return STATUS_UNSUPPORTED;
}

status_t osal_process_stop(osal_process_t* const process, const bool by_force)
{
    FSW_ASSERT(process != NULL);
    (void)by_force;
    return STATUS_UNSUPPORTED;
}

status_t osal_process_suspend(osal_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    return STATUS_UNSUPPORTED;
}

status_t osal_process_look(const osal_process_t* const process, osal_process_look_t* const out_look)
{
    FSW_ASSERT((process != NULL) && (out_look != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_process_watch(osal_process_t* const process, const int32_t id)
{
    FSW_ASSERT(process != NULL);
    *process = (osal_process_t){.id = 0, .descriptor = -1};
    (void)id;
    return STATUS_UNSUPPORTED;
}

void osal_process_release(osal_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    process->descriptor = -1;
}

bool osal_process_is_alive(const osal_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    return false;
}

int32_t osal_process_own_id(void)
{
    return 1;
}

const char* osal_process_environment(const char* const name)
{
    FSW_ASSERT(name != NULL);
    return NULL;
}

void osal_process_catch_stop(void)
{
}

unsigned osal_process_stop_count(void)
{
    return 0U;
}

int osal_process_stop_descriptor(void)
{
    return -1;
}

void osal_process_take_stop(void)
{
}

void osal_process_ignore_interrupt(void)
{
}

void port_exit(const int code)
{
    semihosting_exit(code);
}
