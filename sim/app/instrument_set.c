// SPDX-License-Identifier: Apache-2.0
#include "sim/app/instrument_set.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#define PATH_OCTETS 4096U
#define NS_PER_S 1000000000U

typedef struct {
    instrument_set_t* all;
    const char* name;
    instrument_t* instrument;
} set_entry_t;

struct instrument_set {
    set_entry_t entry[WORLD_INSTRUMENTS_MAX];
    size_t count;
    FILE* log;
};

static void log_octets(void* const context, const uint64_t now_ns, const bool is_sent,
                       const uint8_t* const octets, const size_t size)
{
    const set_entry_t* entry = context;
    FILE* log                = entry->all->log;
    if (log != NULL) {
        (void)fprintf(log, "%" PRIu64 ".%09" PRIu64 " %s %c ", now_ns / NS_PER_S, now_ns % NS_PER_S,
                      entry->name, is_sent ? '>' : '<');
        for (size_t i = 0U; i < size; i++) {
            (void)fprintf(log, "%02x", octets[i]);
        }
        (void)fputc('\n', log);
    }
}

static status_t open_one(instrument_set_t* const instruments, const world_t* const world,
                         const world_instrument_t* const wanted, const simulator_config_t* const run,
                         char error[SIMULATOR_ERROR_MAX])
{
    char reason[STREAM_PORT_ERROR_MAX];
    set_entry_t* entry               = &instruments->entry[instruments->count];
    *entry                           = (set_entry_t){.all = instruments, .name = wanted->name};
    const instrument_config_t config = {
        .port         = {.kind       = (stream_port_kind_t)wanted->type,
                         .run        = run->flows,
                         .channel    = wanted->channel,
                         .framing    = {.is_slip = wanted->is_slip, .is_little = wanted->is_little},
                         .is_counted = run->are_flows_counted},
        .value        = (instrument_value_t)wanted->value,
        .has_checksum = wanted->has_checksum,
        .scale        = wanted->scale,
        .offset       = wanted->offset,
        .speed        = wanted->speed,
        .period_ns    = (uint64_t)wanted->period_ns,
        .seen         = log_octets,
        .context      = entry};
    const status_t status = instrument_open(&config, &entry->instrument, reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s:%u: %s", world->path, wanted->line, reason);
        return status;
    }
    instruments->count++;
    return STATUS_OK;
}

static status_t open_log(instrument_set_t* const instruments, const char* const directory,
                         char error[SIMULATOR_ERROR_MAX])
{
    char path[PATH_OCTETS];
    (void)snprintf(path, sizeof path, "%s/records.log", directory);
    instruments->log = fopen(path, "we");
    if (instruments->log == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: cannot write records.log in '%s'; does the directory exist?", directory);
        return STATUS_IO;
    }
    return STATUS_OK;
}

status_t instrument_set_open(const world_t* const world, const simulator_config_t* const config,
                             instrument_set_t** const out_instruments, char error[SIMULATOR_ERROR_MAX])
{
    *out_instruments = NULL;
    if ((world->instrument_count == 0U) || (config->flows == NULL)) {
        return STATUS_OK;
    }
    instrument_set_t* instruments = calloc(1U, sizeof *instruments);
    if (instruments == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: out of memory");
        return STATUS_EXHAUSTED;
    }
    status_t status =
        (config->output_path != NULL) ? open_log(instruments, config->output_path, error) : STATUS_OK;
    for (size_t i = 0U; (i < world->instrument_count) && (status == STATUS_OK); i++) {
        status = open_one(instruments, world, &world->instrument[i], config, error);
    }
    if (status != STATUS_OK) {
        (void)instrument_set_close(instruments);
        return status;
    }
    *out_instruments = instruments;
    return STATUS_OK;
}

status_t instrument_set_close(instrument_set_t* const instruments)
{
    bool is_complete = true;
    if (instruments != NULL) {
        for (size_t i = 0U; i < instruments->count; i++) {
            instrument_close(instruments->entry[i].instrument);
        }
        if (instruments->log != NULL) {
            is_complete = (ferror(instruments->log) == 0);
            is_complete = (fclose(instruments->log) == 0) && is_complete;
        }
        free(instruments);
    }
    return is_complete ? STATUS_OK : STATUS_IO;
}

size_t instrument_set_count(const instrument_set_t* const instruments)
{
    return (instruments != NULL) ? instruments->count : 0U;
}

instrument_t* instrument_set_at(const instrument_set_t* const instruments, const size_t index)
{
    return instruments->entry[index].instrument;
}

const char* instrument_set_name(const instrument_set_t* const instruments, const size_t index)
{
    return instruments->entry[index].name;
}

void instrument_set_step(instrument_set_t* const instruments, const uint64_t now_ns, const uint64_t end_ns)
{
    for (size_t i = 0U; i < instrument_set_count(instruments); i++) {
        instrument_step(instruments->entry[i].instrument, now_ns, end_ns);
    }
}

uint64_t instrument_set_lost(const instrument_set_t* const instruments)
{
    uint64_t lost = 0U;
    for (size_t i = 0U; i < instrument_set_count(instruments); i++) {
        lost += instrument_lost(instruments->entry[i].instrument);
    }
    return lost;
}

void instrument_set_flush(instrument_set_t* const instruments)
{
    if ((instruments != NULL) && (instruments->log != NULL)) {
        (void)fflush(instruments->log);
    }
}
