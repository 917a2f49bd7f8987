// SPDX-License-Identifier: Apache-2.0
// Connects the descriptor, the parameters and the packet services.
#include "fsw/framework/subsystem/subsystem_internal.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/optional_services.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

#define MS_PER_S 1000U
#define HK_PARAMETERS_MAX PUS_HK_PARAMETERS_MAX

// ---- Parameters: ST[03] and ST[20] ----

static status_t find_parameter(void* const context, const uint32_t parameter_id, uint16_t* const out_handle,
                               uint16_t* const out_size)
{
    subsystem_t* const subsystem   = (subsystem_t*)context;
    const parameter_entry_t* entry = NULL;
    const status_t status          = parameter_find(&subsystem->dictionary, parameter_id, &entry);
    if (status == STATUS_OK) {
        *out_handle = (uint16_t)(entry - subsystem->entries);
        *out_size   = (uint16_t)entry->definition->wire_size;
    }
    return status;
}

static void read_parameter(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    subsystem_t* const subsystem = (subsystem_t*)context;
    const status_t status = parameter_read_entry(&subsystem->dictionary, &subsystem->entries[handle], writer);
    FSW_ASSERT(status == STATUS_OK);
}

static status_t write_parameter(void* const context, const uint16_t handle, const uint8_t* const octets,
                                const size_t size)
{
    subsystem_t* const subsystem = (subsystem_t*)context;
    const uint32_t id            = subsystem->entries[handle].definition->id;
    octet_reader_t reader        = octet_reader(octets, size);
    const status_t status        = parameter_write(&subsystem->dictionary, id, &reader);
    if ((status == STATUS_OK) && (subsystem->config.callbacks->parameter_set != NULL)) {
        subsystem->config.callbacks->parameter_set(subsystem->config.self, id);
    }
    return status;
}

/// True if a status is an error. STATUS_NOT_FOUND is not: a parameter that the subsystem did not publish is
/// unknown to all services.
static bool is_fault(const status_t status)
{
    return (status != STATUS_OK) && (status != STATUS_NOT_FOUND);
}

status_t subsystem_initialise_parameters(subsystem_t* const subsystem)
{
    const subsystem_descriptor_t* const descriptor = subsystem->descriptor;
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        status_t status =
            parameter_set_settable(&subsystem->dictionary, parameter->id, parameter->is_settable);
        for (uint16_t k = 0U; (k < parameter->field_count) && (status == STATUS_OK); k++) {
            const descriptor_field_t* const field = &descriptor->fields[parameter->first_field + k];
            status = parameter_set_bounds(&subsystem->dictionary, parameter->id, field->name, field->min,
                                          field->max);
            if (status == STATUS_OK) {
                status =
                    parameter_set_initial(&subsystem->dictionary, parameter->id, field->name, field->init);
            }
        }
        if (is_fault(status)) {
            return status;
        }
    }
    return STATUS_OK;
}

static status_t apply_initial_values(subsystem_t* const subsystem,
                                     const descriptor_configuration_t* const configuration)
{
    const subsystem_descriptor_t* const descriptor = subsystem->descriptor;
    for (uint16_t i = 0U; i < configuration->initial_count; i++) {
        const descriptor_initial_t* const initial = &descriptor->initials[configuration->first_initial + i];
        const uint32_t id                         = descriptor->parameters[initial->parameter].id;
        const status_t status                     = parameter_set_initial(&subsystem->dictionary, id,
                                                                          descriptor->fields[initial->field].name, initial->text);
        if (is_fault(status)) {
            return status;
        }
    }
    return STATUS_OK;
}

size_t subsystem_sample_auxiliary(subsystem_t* const subsystem, const descriptor_event_t* const event,
                                  uint8_t* const octets, const size_t capacity)
{
    octet_writer_t writer = octet_writer(octets, capacity);
    for (uint16_t i = 0U; i < event->reference_count; i++) {
        const uint16_t index = subsystem->descriptor->references[event->first_reference + i];
        const descriptor_parameter_t* const parameter = &subsystem->descriptor->parameters[index];
        if (parameter_read(&subsystem->dictionary, parameter->id, &writer) != STATUS_OK) {
            for (uint32_t k = 0U; k < parameter->wire_size; k++) {
                // A parameter that is not published is filled with zeros, so that the ground can decode the
                // rest.
                octet_write_u8(&writer, 0U);
            }
        }
    }
    while (writer.position < event->octets) { // Values that only the caller has are 0.
        octet_write_u8(&writer, 0U);
    }
    return writer.position;
}

// ---- Housekeeping structures of a configuration ----

static uint8_t list_parameters(const subsystem_descriptor_t* const descriptor, const uint16_t first,
                               const uint16_t count, uint32_t* const out_ids)
{
    for (uint16_t i = 0U; i < count; i++) {
        out_ids[i] = descriptor->parameters[descriptor->references[first + i]].id;
    }
    return (uint8_t)count;
}

static status_t add_structure(subsystem_t* const subsystem, const descriptor_structure_t* const structure)
{
    const subsystem_descriptor_t* const descriptor = subsystem->descriptor;
    uint32_t ids[HK_PARAMETERS_MAX];
    pus_hk_set_definition_t sets[PUS_HK_SETS_MAX];
    size_t used = structure->reference_count;
    for (uint16_t i = 0U; i < structure->sampled_count; i++) {
        used += descriptor->sampled[structure->first_sampled + i].reference_count;
    }
    FSW_ASSERT(used <= HK_PARAMETERS_MAX); // The descriptor lists each parameter at most once.
    if (structure->sampled_count > PUS_HK_SETS_MAX) {
        return STATUS_EXHAUSTED;
    }
    used = list_parameters(descriptor, structure->first_reference, structure->reference_count, ids);
    for (uint16_t i = 0U; i < structure->sampled_count; i++) {
        const descriptor_sampled_t* const sampled = &descriptor->sampled[structure->first_sampled + i];
        sets[i].repetitions                       = sampled->nrep;
        sets[i].parameters                        = &ids[used];
        sets[i].parameter_count =
            list_parameters(descriptor, sampled->first_reference, sampled->reference_count, &ids[used]);
        used += sampled->reference_count;
    }
    const pus_hk_definition_t definition = {.id              = structure->id,
                                            .interval        = structure->interval_cycles,
                                            .is_periodic     = structure->is_enabled,
                                            .loop            = structure->loop,
                                            .parameter_count = (uint8_t)structure->reference_count,
                                            .set_count       = (uint8_t)structure->sampled_count,
                                            .parameters      = ids,
                                            .sets            = sets};
    return pus_hk_add(&subsystem->housekeeping, &definition);
}

status_t subsystem_apply_configuration(subsystem_t* const subsystem)
{
    const descriptor_configuration_t* const configuration = subsystem->configuration;
    FSW_ASSERT(configuration != NULL);
    status_t status = apply_initial_values(subsystem, configuration);
    pus_hk_clear(&subsystem->housekeeping);
    subsystem_end_loops(subsystem);
    subsystem->cycle = 0U;
    for (uint16_t i = 0U; (i < configuration->structure_count) && (status == STATUS_OK); i++) {
        status =
            add_structure(subsystem, &subsystem->descriptor->structures[configuration->first_structure + i]);
    }
    subsystem->period_ns = (uint64_t)configuration->sampling_us * 1000U;
    if (status == STATUS_OK) {
        subsystem_begin_loops(subsystem);
    }
    return status;
}

void subsystem_revoke_configuration(subsystem_t* const subsystem)
{
    pus_hk_clear(&subsystem->housekeeping);
    subsystem_end_loops(subsystem);
    subsystem->configuration    = NULL;
    subsystem->configuration_id = 0U;
    subsystem_set_idle_period(subsystem);
}

// ---- Functions: ST[08] ----

static bool is_function_allowed(const subsystem_t* const subsystem,
                                const descriptor_function_t* const function)
{
    if ((function->states & (1U << (unsigned)subsystem->machine.state)) == 0U) {
        return false;
    }
    // Without a configuration, only functions are allowed that every configuration allows.
    if (subsystem->configuration == NULL) {
        const unsigned all = (1U << subsystem->descriptor->configuration_count) - 1U;
        return (function->configurations & all) == all;
    }
    const unsigned index = (unsigned)(subsystem->configuration - subsystem->descriptor->configurations);
    return (function->configurations & (1U << index)) != 0U;
}

/// Returns the index of the first argument with an element outside its bounds; argument_count if there is
/// none.
static uint16_t first_out_of_bounds(const subsystem_t* const subsystem,
                                    const descriptor_function_t* const function, const uint16_t table_index,
                                    const void* const arguments)
{
    const pus_argument_t* argument  = subsystem->function_table[table_index].arguments;
    const descriptor_field_t* field = &subsystem->descriptor->fields[function->first_argument];
    for (uint16_t i = 0U; i < function->argument_count; i++) {
        const uint8_t* memory = (const uint8_t*)arguments + argument->offset;
        for (uint16_t k = 0U; k < field->count; k++) {
            const double number = value_as_double(field->type, memory);
            memory += value_size(field->type);
            if (!((number >= field->min) && (number <= field->max))) { // NaN is refused as well.
                return i;
            }
        }
        argument++;
        field++;
    }
    return function->argument_count;
}

/// Open an entry for the token of a function that continues. Returns its number, or 0 if none is free. The
/// last entry is reserved for the ground, so that requests released on board cannot block its commands.
static uint32_t open_call_token(subsystem_t* const subsystem, const pus_token_t* const token)
{
    const bool is_ground = ((token->source & PUS_USER_ONBOARD) == 0U);
    pus_token_t* const block =
        is_ground ? pool_take_reserved(&subsystem->call_tokens) : pool_take(&subsystem->call_tokens);
    if (block == NULL) {
        return 0U;
    }
    uint32_t i = 0U;
    // The search ends, because a free block in the pool means a free entry.
    while (subsystem->open_call_tokens[i] != NULL) {
        i++;
        FSW_ASSERT(i < SUBSYSTEM_CALL_TOKENS);
    }
    *block                         = *token;
    subsystem->open_call_tokens[i] = block;
    return i + 1U;
}

static void close_call_token(subsystem_t* const subsystem, const uint32_t call_token)
{
    const status_t status =
        pool_release(&subsystem->call_tokens, subsystem->open_call_tokens[call_token - 1U]);
    FSW_ASSERT(status == STATUS_OK);
    subsystem->open_call_tokens[call_token - 1U] = NULL;
}

static pus_reply_t reply_of(subsystem_t* const subsystem, const status_t status, const uint32_t call_token,
                            const uint16_t function_id)
{
    const bool is_aborted = (status == STATUS_BUSY) && (subsystem->machine.state >= STATE_ERROR_OPERATIONAL);
    if ((status == STATUS_BUSY) && !is_aborted) {
        return pus_later();
    }
    if (subsystem->open_call_tokens[call_token - 1U] == NULL) {
        return pus_later(); // subsystem_function_done has ended the request already.
    }
    close_call_token(subsystem, call_token);
    switch (status) {
    case STATUS_OK:
        return pus_done();
    case STATUS_FORBIDDEN:
        return pus_refused(PUS_FAILURE_STATE, function_id);
    case STATUS_OUT_OF_RANGE:
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    case STATUS_BUSY: // The function has begun, and an event that it raised has aborted it.
        return pus_failed(PUS_FAILURE_ABORTED, 0U);
    default:
        return pus_failed(PUS_FAILURE_DEVICE, (uint32_t)status);
    }
}

/// Perform a function command, if state, configuration and bounds of the arguments permit it.
static pus_reply_t perform_function(void* const context, const uint16_t index, const void* const arguments,
                                    const pus_token_t* const token, const uint64_t now_ns)
{
    subsystem_t* const subsystem                = (subsystem_t*)context;
    const descriptor_function_t* const function = &subsystem->descriptor->functions[index];
    subsystem->now_ns                           = now_ns;
    if ((subsystem->config.callbacks->perform == NULL) || !is_function_allowed(subsystem, function)) {
        return pus_refused(PUS_FAILURE_STATE, function->id);
    }
    const uint16_t bad = first_out_of_bounds(subsystem, function, index, arguments);
    if (bad < function->argument_count) {
        pus_reply_t reply         = pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
        reply.failure.instruction = (uint16_t)(bad + 1U);
        return reply;
    }
    const uint32_t call_token = open_call_token(subsystem, token);
    if (call_token == 0U) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, SUBSYSTEM_CALL_TOKENS);
    }
    const subsystem_function_t call = {
        .function_id = function->id, .arguments = arguments, .call_token = call_token};
    subsystem->token_in_call = call_token;
    const status_t status    = subsystem->config.callbacks->perform(subsystem->config.self, &call);
    subsystem->token_in_call = 0U;
    return reply_of(subsystem, status, call_token, function->id);
}

/// Make the table of functions and arguments. The offsets are those of the generated argument structure, as
/// descriptor_subsystem_builder_lay_out has set them.
static void tabulate_functions(subsystem_t* const subsystem)
{
    const subsystem_descriptor_t* const descriptor = subsystem->descriptor;
    size_t used                                    = 0U;
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        const descriptor_function_t* const function = &descriptor->functions[i];
        pus_function_t* const entry                 = &subsystem->function_table[i];
        FSW_ASSERT((used + function->argument_count) <= SUBSYSTEM_ARGUMENTS);
        entry->arguments      = &subsystem->arguments[used];
        entry->argument_count = (uint8_t)function->argument_count;
        (void)memset(entry->name, 0, sizeof entry->name);
        for (size_t k = 0U; (k < PUS_NAME_SIZE) && (function->name[k] != '\0'); k++) {
            entry->name[k] = function->name[k];
        }
        FSW_ASSERT(function->memory_size <= sizeof subsystem->argument_area);
        for (uint16_t k = 0U; k < function->argument_count; k++) {
            const descriptor_field_t* const field = &descriptor->fields[function->first_argument + k];
            subsystem->arguments[used]            = (pus_argument_t){.id     = field->id,
                                                                     .type   = field->type,
                                                                     .count  = field->count,
                                                                     .offset = (uint16_t)field->offset};
            used++;
        }
    }
}

// ---- Events and management ----

static void tabulate_events(subsystem_t* const subsystem)
{
    const subsystem_descriptor_t* const descriptor = subsystem->descriptor;
    for (uint16_t i = 0U; i < descriptor->event_count; i++) {
        const descriptor_event_t* const event = &descriptor->events[i];
        subsystem->event_definitions[i]       = (pus_event_definition_t){
                  .id          = event->id,
                  .severity    = (uint8_t)event->severity,
                  .burst       = event->burst,
                  .aux_size    = (uint16_t)event->octets,
                  .interval_ms = (uint16_t)((event->per_second > 0U)
                                                ? ((MS_PER_S + event->per_second - 1U) / event->per_second)
                                                : 0U)};
    }
}

static void read_status(void* const context, pus_subsystem_status_t* const out_status)
{
    const subsystem_t* const subsystem = (const subsystem_t*)context;
    *out_status                        = (pus_subsystem_status_t){.state              = (uint8_t)subsystem->machine.state,
                                                                  .phase              = (uint8_t)subsystem->machine.phase,
                                                                  .target             = (uint8_t)subsystem->machine.target,
                                                                  .configuration      = subsystem->configuration_id,
                                                                  .interface_hash     = subsystem->descriptor->interface_hash,
                                                                  .configuration_hash = subsystem->descriptor->configuration_hash,
                                                                  .epoch              = subsystem->config.start_count,
                                                                  .cycle              = subsystem->cycle};
}

/// True if the descriptor or the configuration may be changed: no device is in use.
static bool may_change(const subsystem_t* const subsystem)
{
    const state_phase_t phase = subsystem->machine.phase;
    return (subsystem->machine.state == STATE_OFFLINE) || (phase == PHASE_UNCONFIGURED);
}

/// Initialise ST[05] and ST[08] from their tables, with counters at zero.
static void init_tabulated(subsystem_t* const subsystem)
{
    const pus_function_port_t functions = {subsystem, perform_function};
    pus_events_init(&subsystem->events, &subsystem->process, subsystem->event_definitions,
                    subsystem->event_states, subsystem->descriptor->event_count);
    const descriptor_event_t* const reporter =
        descriptor_find_event_name(subsystem->descriptor, "EVENTS_SUPPRESSED");
    pus_events_report_suppressed_by(
        &subsystem->events,
        ((reporter != NULL) && (reporter->octets == PUS_SUPPRESSED_AUX)) ? reporter->id : 0U);
    pus_functions_init(&subsystem->functions, subsystem->function_table,
                       subsystem->descriptor->function_count, &functions, subsystem->argument_area,
                       sizeof subsystem->argument_area);
}

/// Load the descriptor again and use it. If the status is not STATUS_OK, it says why the descriptor was
/// refused.
static status_t change_descriptor(subsystem_t* const subsystem)
{
    const subsystem_descriptor_t* descriptor = NULL;
    const status_t status = subsystem->config.reload(subsystem->config.reload_context, &descriptor);
    if (status != STATUS_OK) {
        return status;
    }
    subsystem->descriptor = descriptor;
    subsystem_set_idle_period(subsystem);
    subsystem_set_pool_thresholds(subsystem);
    tabulate_functions(subsystem);
    tabulate_events(subsystem);
    if (subsystem->machine.phase == PHASE_INVALID) {
        init_tabulated(subsystem); // The component had no descriptor until now.
        subsystem_state_machine_validate(&subsystem->machine);
        subsystem_after_change(subsystem);
    }
    return subsystem_initialise_parameters(subsystem);
}

void subsystem_take_reload(subsystem_t* const subsystem)
{
    if (!subsystem->has_reload || !may_change(subsystem)) {
        return;
    }
    subsystem->has_reload = false;
    const status_t status = change_descriptor(subsystem);
    pus_verify_ended(&subsystem->process, &subsystem->reload,
                     pus_failure((status == STATUS_OK) ? PUS_FAILURE_NONE : PUS_FAILURE_IO, (uint32_t)status),
                     subsystem->now_ns);
}

static pus_reply_t reload_descriptor(void* const context, const pus_token_t* const token,
                                     const uint64_t now_ns)
{
    subsystem_t* const subsystem = (subsystem_t*)context;
    subsystem->now_ns            = now_ns;
    if (subsystem->config.reload == NULL) {
        return pus_refused(PUS_FAILURE_SUBTYPE, ((uint32_t)token->service << 8U) | token->subtype);
    }
    if (subsystem->has_reload) {
        return pus_refused(PUS_FAILURE_STATE, (uint32_t)subsystem->machine.state);
    }
    // Reading a file takes milliseconds, so the request waits while devices are controlled.
    if (!may_change(subsystem)) {
        subsystem->has_reload = true;
        subsystem->reload     = *token;
        return pus_later();
    }
    const status_t status = change_descriptor(subsystem);
    return (status == STATUS_OK) ? pus_done() : pus_failed(PUS_FAILURE_IO, (uint32_t)status);
}

// ---- Connection test: ST[17] ----

/// TC[17,3]: a subsystem communicates only with the supervisor, which has sent this request, so it can
/// confirm only the supervisor and itself.
static pus_reply_t connect(void* const context, const uint16_t apid, const pus_token_t* const token,
                           const uint64_t now_ns)
{
    (void)token;
    (void)now_ns;
    const subsystem_t* const subsystem = (const subsystem_t*)context;
    const bool is_reached              = (apid == subsystem->process.apid) || (apid == SUPERVISOR_APID);
    return is_reached ? pus_done() : pus_refused(PUS_FAILURE_UNKNOWN_ID, apid);
}

// ---- Optional services ----

static void add(subsystem_t* const subsystem, const pus_service_t* const service)
{
    FSW_ASSERT(subsystem->service_count < SUBSYSTEM_SERVICES);
    subsystem->services[subsystem->service_count] = *service;
    subsystem->service_count++;
}

void subsystem_add_service(subsystem_t* const subsystem, const pus_service_t* const service,
                           const subsystem_restore_t restore)
{
    FSW_ASSERT((subsystem != NULL) && (service != NULL) &&
               (subsystem->optional_count < SUBSYSTEM_OPTIONAL_SERVICES));
    subsystem->optional[subsystem->optional_count] = (subsystem_optional_t){*service, restore};
    subsystem->optional_count++;
    add(subsystem, service);
}

pus_parameter_port_t subsystem_parameter_port(subsystem_t* const subsystem)
{
    FSW_ASSERT(subsystem != NULL);
    return (pus_parameter_port_t){subsystem, find_parameter, read_parameter, write_parameter};
}

const pus_persistence_t* subsystem_persistence(const subsystem_t* const subsystem)
{
    FSW_ASSERT(subsystem != NULL);
    return subsystem->config.persistence;
}

void subsystem_step_optional(subsystem_t* const subsystem)
{
    subsystem->optional_cycle++;
    for (size_t i = 0U; i < subsystem->optional_count; i++) {
        const pus_service_t* const service = &subsystem->optional[i].service;
        if (service->step != NULL) {
            service->step(service->self, subsystem->now_ns, subsystem->optional_cycle);
        }
    }
}

status_t subsystem_restore(subsystem_t* const subsystem, const uint8_t table, const uint32_t key,
                           const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((subsystem != NULL) && (octets != NULL));
    if (table == PUS_SERVICE_HOUSEKEEPING) {
        return pus_hk_restore(&subsystem->housekeeping, key, octets, size);
    }
    if (table == PUS_SERVICE_PARAMETERS) {
        return pus_parameters_restore(&subsystem->parameters, key, octets, size);
    }
    for (size_t i = 0U; i < subsystem->optional_count; i++) {
        const subsystem_optional_t* const optional = &subsystem->optional[i];
        if ((optional->service.type == table) && (optional->restore != NULL)) {
            return optional->restore(optional->service.self, key, octets, size);
        }
    }
    return STATUS_NOT_FOUND;
}

/// Add the further services of the program, ST[17], service 130, and the services that the descriptor
/// lists.
static void add_further(subsystem_t* const subsystem)
{
    const subsystem_services_t* const optional = &subsystem->config.optional;
    bool has_own_links                         = false;
    bool has_own_test                          = false;
    for (size_t i = 0U; i < subsystem->config.service_count; i++) {
        add(subsystem, &subsystem->config.services[i]);
        has_own_links |= (subsystem->config.services[i].type == PUS_SERVICE_RTLINK);
        has_own_test |= (subsystem->config.services[i].type == PUS_SERVICE_TEST);
    }
    if (!has_own_test) { // The supervisor passes its own ST[17].
        const pus_service_t test = pus_test_service(&subsystem->test);
        add(subsystem, &test);
    }
    if (!has_own_links) { // The supervisor passes its own service 130, because it manages the links.
        const pus_service_t links = pus_rtlink_service(&subsystem->rtlink);
        add(subsystem, &links);
    }
    if (optional->add != NULL) {
        optional->add(optional->storage, subsystem);
    }
}

void subsystem_register_services(subsystem_t* const subsystem)
{
    const pus_parameter_port_t values      = subsystem_parameter_port(subsystem);
    const pus_hk_config_t hk               = {.process          = &subsystem->process,
                                              .parameters       = values,
                                              .structures       = subsystem->structures,
                                              .structure_count  = SUBSYSTEM_STRUCTURES,
                                              .samples          = subsystem->samples,
                                              .sample_size      = SUBSYSTEM_SAMPLE_OCTETS,
                                              .mutex            = &subsystem->loop_mutex,
                                              .functional       = subsystem->functional,
                                              .functional_count = SUBSYSTEM_FUNCTIONAL,
                                              .persistence      = subsystem->config.persistence};
    const pus_management_port_t management = {subsystem, subsystem_request_state,
                                              subsystem_select_configuration, reload_descriptor, read_status};
    const pus_rtlink_port_t links          = subsystem_link_port(subsystem);
    const pus_test_port_t connection       = {subsystem, connect};
    subsystem_create_mutexes(subsystem); // Services may lock the mutexes as soon as they are initialised.
    tabulate_functions(subsystem);
    tabulate_events(subsystem);
    pus_test_init(&subsystem->test, &connection);
    pus_hk_init(&subsystem->housekeeping, &hk);
    init_tabulated(subsystem);
    pus_parameters_init(&subsystem->parameters, &values);
    pus_management_init(&subsystem->management, &management);
    pus_rtlink_init(&subsystem->rtlink, &links);
    const pus_service_t own[] = {
        pus_hk_service(&subsystem->housekeeping), pus_events_service(&subsystem->events),
        pus_functions_service(&subsystem->functions), pus_parameters_service(&subsystem->parameters),
        pus_management_service(&subsystem->management)};
    (void)memcpy(subsystem->services, own, sizeof own);
    subsystem->service_count = sizeof own / sizeof own[0];
    add_further(subsystem);
    pus_dispatcher_init(&subsystem->dispatcher, &subsystem->process, subsystem->services,
                        subsystem->service_count);
    if (subsystem->config.persistence != NULL) {
        pus_dispatcher_persist(&subsystem->dispatcher, subsystem->config.persistence);
    }
    subsystem_init_loops(subsystem, &values);
}
