// SPDX-License-Identifier: Apache-2.0
// Connects ST[21] to the supervisor. Delays use the time of the run, which counts cycles and is never
// corrected.
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/supervisor_internal.h"

static pus_service_t open_sequences(supervisor_t* const supervisor)
{
    spacecraft_sequences_t* const sequences = &supervisor->spacecraft.sequences;
    pus_block_chains_init(&sequences->chains, sequences->blocks, sequences->slots,
                          SPACECRAFT_SEQUENCE_BLOCKS);
    const pus_sequences_config_t config = {
        .process        = subsystem_process(&supervisor->subsystem),
        .release        = {supervisor, spacecraft_release},
        .persistence    = spacecraft_persistence(supervisor),
        .files          = spacecraft_file_port(supervisor),
        .sequences      = sequences->sequences,
        .nodes          = sequences->nodes,
        .sequence_count = spacecraft_capacity(supervisor, PUS_SERVICE_SEQUENCES, SPACECRAFT_SEQUENCES),
        .octets_max     = SPACECRAFT_SEQUENCE_OCTETS,
        .chains         = &sequences->chains};
    pus_sequences_init(&sequences->service, &config);
    return pus_sequences_service(&sequences->service);
}

static status_t restore_sequences(supervisor_t* const supervisor, const uint32_t key,
                                  const uint8_t* const octets, const size_t size)
{
    return pus_sequences_restore(&supervisor->spacecraft.sequences.service, key, octets, size);
}

static uint64_t step_sequences(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_sequences_t* const service = &supervisor->spacecraft.sequences.service;
    pus_sequences_step(service, now_ns, now_ns);
    const uint64_t next_ns  = pus_sequences_next_ns(service);
    const uint64_t retry_ns = now_ns + SPACECRAFT_RETRY_NS;
    return ((next_ns <= now_ns) || pus_sequences_is_waiting(service)) ? retry_ns : next_ns;
}

const spacecraft_binding_t spacecraft_sequences = {.type    = PUS_SERVICE_SEQUENCES,
                                                   .open    = open_sequences,
                                                   .restore = restore_sequences,
                                                   .step    = step_sequences};
