// SPDX-License-Identifier: Apache-2.0
// Connects ST[18] to the supervisor.
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/supervisor_internal.h"
#include "pus/core/scalar.h"

// Size of the auxiliary data of an event that a procedure raises: id and step of the procedure.
#define OWN_EVENT_OCTETS 10U

// ---- Events ----

static bool may_raise(void* const context, const uint16_t event_id)
{
    const supervisor_t* const supervisor  = context;
    const descriptor_event_t* const event = descriptor_find_event(supervisor->config.descriptor, event_id);
    return (event != NULL) && (event->octets == OWN_EVENT_OCTETS);
}

static void raise_event(void* const context, const uint16_t event_id, const uint8_t* const auxiliary,
                        const size_t size, const uint64_t now_ns)
{
    supervisor_t* const supervisor = context;
    (void)now_ns; // subsystem_raise uses the time of the component.
    (void)subsystem_raise(&supervisor->subsystem, event_id, auxiliary, size);
}

// ---- Telemetry ----

static status_t read_scalar(const supervisor_t* const supervisor, const telemetry_scalar_t* const scalar,
                            value_type_t* const out_type, uint64_t* const out_bits)
{
    const uint8_t* octets = NULL;
    uint16_t size         = 0U;
    if ((supervisor_telemetry_cache_value(&supervisor->spacecraft.cache, scalar->parameter_id, &octets,
                                          &size) != STATUS_OK) ||
        ((scalar->offset + value_size(scalar->type)) > size)) {
        return STATUS_NOT_FOUND;
    }
    octet_reader_t reader = octet_reader(&octets[scalar->offset], value_size(scalar->type));
    *out_type             = scalar->type;
    *out_bits             = pus_scalar_read(&reader, scalar->type);
    return STATUS_OK;
}

static status_t read_value(void* const context, const uint32_t parameter_id, value_type_t* const out_type,
                           uint64_t* const out_bits)
{
    const telemetry_scalar_t scalar = {.parameter_id = parameter_id, .type = pus_scalar_type(parameter_id)};
    return (scalar.type == VALUE_SCALARS) ? STATUS_NOT_FOUND
                                          : read_scalar(context, &scalar, out_type, out_bits);
}

static status_t read_named(void* const context, const char* const name, value_type_t* const out_type,
                           uint64_t* const out_bits)
{
    const supervisor_t* const supervisor = context;
    telemetry_scalar_t scalar            = {0};
    const status_t status =
        supervisor_telemetry_directory_find(&supervisor->spacecraft.directory, name, &scalar);
    return (status == STATUS_OK) ? read_scalar(supervisor, &scalar, out_type, out_bits) : status;
}

// ---- The service ----

static pus_service_t open_procedures(supervisor_t* const supervisor)
{
    spacecraft_procedures_t* const procedures = &supervisor->spacecraft.procedures;
    const pus_port_t release                  = {supervisor, spacecraft_release};
    procedure_engine_init(&procedures->engine, procedures->slots, SPACECRAFT_PROCEDURE_SLOTS,
                          procedures->memory, SPACECRAFT_PROCEDURE_OCTETS, procedures->map);
    pus_requester_init(&procedures->requester, SUPERVISOR_APID, &release);
    pus_requester_count_with(&procedures->requester, &supervisor->requester);
    const pus_procedures_config_t config = {
        .process             = subsystem_process(&supervisor->subsystem),
        .engine              = procedure_engine_port(&procedures->engine),
        .requester           = &procedures->requester,
        .telemetry           = {supervisor, read_value, read_named},
        .events              = {supervisor, may_raise, NULL, raise_event},
        .files               = spacecraft_file_port(supervisor),
        .persistence         = spacecraft_persistence(supervisor),
        .procedures          = procedures->procedures,
        .runs                = procedures->runs,
        .capacity            = spacecraft_capacity(supervisor, PUS_SERVICE_PROCEDURES, SPACECRAFT_PROCEDURES),
        .budget              = SPACECRAFT_PROCEDURE_BUDGET,
        .calls               = SPACECRAFT_PROCEDURE_CALLS,
        .cycle_ns            = SPACECRAFT_PROCEDURE_CYCLE_NS,
        .verification_cycles = (uint32_t)(SPACECRAFT_PROCEDURE_TIMEOUT_NS / SPACECRAFT_PROCEDURE_CYCLE_NS),
        .observation_event   = SUPERVISOR_EVENT_PROCEDURE_OBSERVED,
        .failure_event       = SUPERVISOR_EVENT_PROCEDURE_FAILED};
    procedures->next_cycle_ns = 0U;
    pus_procedures_init(&procedures->service, &config);
    pus_service_t service = pus_procedures_service(&procedures->service);
    service.step          = NULL; // The binding calls the step.
    return service;
}

static status_t restore_procedures(supervisor_t* const supervisor, const uint32_t key,
                                   const uint8_t* const octets, const size_t size)
{
    return pus_procedures_restore(&supervisor->spacecraft.procedures.service, key, octets, size);
}

static uint64_t step_procedures(supervisor_t* const supervisor, const uint64_t now_ns)
{
    spacecraft_procedures_t* const procedures = &supervisor->spacecraft.procedures;
    if (!pus_procedures_are_active(&procedures->service)) {
        return SPACECRAFT_NEVER;
    }
    if (now_ns >= procedures->next_cycle_ns) {
        const uint64_t cycle = now_ns / SPACECRAFT_PROCEDURE_CYCLE_NS;
        pus_procedures_step(&procedures->service, now_ns, (uint32_t)cycle);
        procedures->next_cycle_ns = (cycle + 1U) * SPACECRAFT_PROCEDURE_CYCLE_NS;
    }
    return procedures->next_cycle_ns;
}

static void observe_verification(supervisor_t* const supervisor, const pus_tm_t* const tm,
                                 const uint8_t* const packet, const size_t size)
{
    (void)packet;
    (void)size;
    pus_procedures_observe(&supervisor->spacecraft.procedures.service, tm);
}

const spacecraft_binding_t spacecraft_procedures = {.type    = PUS_SERVICE_PROCEDURES,
                                                    .open    = open_procedures,
                                                    .restore = restore_procedures,
                                                    .step    = step_procedures,
                                                    .observe = observe_verification};
