// SPDX-License-Identifier: Apache-2.0
// Joins descriptor, parameters and packet services: the one place that knows all three.
#include "fsw/framework/subsystem/component_internal.h"

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
    component_t* const component   = (component_t*)context;
    const parameter_entry_t* entry = NULL;
    const status_t status          = parameter_find(&component->dictionary, parameter_id, &entry);
    if (status == STATUS_OK) {
        *out_handle = (uint16_t)(entry - component->entries);
        *out_size   = (uint16_t)entry->definition->wire_size;
    }
    return status;
}

static void read_parameter(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    component_t* const component = (component_t*)context;
    const status_t status = parameter_read_entry(&component->dictionary, &component->entries[handle], writer);
    FSW_ASSERT(status == STATUS_OK);
}

static status_t write_parameter(void* const context, const uint16_t handle, const uint8_t* const octets,
                                const size_t size)
{
    component_t* const component = (component_t*)context;
    const uint32_t id            = component->entries[handle].definition->id;
    octet_reader_t reader        = octet_reader(octets, size);
    const status_t status        = parameter_write(&component->dictionary, id, &reader);
    if ((status == STATUS_OK) && (component->config.callbacks->parameter_set != NULL)) {
        component->config.callbacks->parameter_set(component->config.self, id);
    }
    return status;
}

/// A parameter that the subsystem did not publish is no error; it is unknown to all services.
static bool is_fault(const status_t status)
{
    return (status != STATUS_OK) && (status != STATUS_NOT_FOUND);
}

status_t component_initialise_parameters(component_t* const component)
{
    const subsystem_descriptor_t* const descriptor = component->descriptor;
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        status_t status =
            parameter_set_settable(&component->dictionary, parameter->id, parameter->is_settable);
        for (uint16_t k = 0U; (k < parameter->field_count) && (status == STATUS_OK); k++) {
            const descriptor_field_t* const field = &descriptor->fields[parameter->first_field + k];
            status = parameter_set_bounds(&component->dictionary, parameter->id, field->name, field->min,
                                          field->max);
            if (status == STATUS_OK) {
                status =
                    parameter_set_initial(&component->dictionary, parameter->id, field->name, field->init);
            }
        }
        if (is_fault(status)) {
            return status;
        }
    }
    return STATUS_OK;
}

static status_t apply_initial_values(component_t* const component,
                                     const descriptor_configuration_t* const configuration)
{
    const subsystem_descriptor_t* const descriptor = component->descriptor;
    for (uint16_t i = 0U; i < configuration->initial_count; i++) {
        const descriptor_initial_t* const initial = &descriptor->initials[configuration->first_initial + i];
        const uint32_t id                         = descriptor->parameters[initial->parameter].id;
        const status_t status                     = parameter_set_initial(&component->dictionary, id,
                                                                          descriptor->fields[initial->field].name, initial->text);
        if (is_fault(status)) {
            return status;
        }
    }
    return STATUS_OK;
}

size_t component_sample_auxiliary(component_t* const component, const descriptor_event_t* const event,
                                  uint8_t* const octets, const size_t capacity)
{
    octet_writer_t writer = octet_writer(octets, capacity);
    for (uint16_t i = 0U; i < event->reference_count; i++) {
        const uint16_t index = component->descriptor->references[event->first_reference + i];
        const descriptor_parameter_t* const parameter = &component->descriptor->parameters[index];
        if (parameter_read(&component->dictionary, parameter->id, &writer) != STATUS_OK) {
            for (uint32_t k = 0U; k < parameter->wire_size; k++) {
                octet_write_u8(&writer,
                               0U); // Not published (yet): its place stays, so that the ground can decode.
            }
        }
    }
    while (writer.position < event->octets) { // Values that only the raiser could have given.
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

static status_t add_structure(component_t* const component, const descriptor_structure_t* const structure)
{
    const subsystem_descriptor_t* const descriptor = component->descriptor;
    uint32_t ids[HK_PARAMETERS_MAX];
    pus_hk_set_definition_t sets[PUS_HK_SETS_MAX];
    size_t used = structure->reference_count;
    for (uint16_t i = 0U; i < structure->sampled_count; i++) {
        used += descriptor->sampled[structure->first_sampled + i].reference_count;
    }
    FSW_ASSERT(used <= HK_PARAMETERS_MAX); // Each parameter of the descriptor once.
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
    return pus_hk_add(&component->housekeeping, &definition);
}

status_t component_apply_configuration(component_t* const component)
{
    const descriptor_configuration_t* const configuration = component->configuration;
    FSW_ASSERT(configuration != NULL);
    status_t status = apply_initial_values(component, configuration);
    pus_hk_clear(&component->housekeeping);
    component_end_loops(component);
    component->cycle = 0U;
    pus_hk_step(&component->housekeeping, component->now_ns, 0U);
    for (uint16_t i = 0U; (i < configuration->structure_count) && (status == STATUS_OK); i++) {
        status =
            add_structure(component, &component->descriptor->structures[configuration->first_structure + i]);
    }
    component->period_ns = (uint64_t)configuration->sampling_us * 1000U;
    if (status == STATUS_OK) {
        component_begin_loops(component);
    }
    return status;
}

void component_revoke_configuration(component_t* const component)
{
    pus_hk_clear(&component->housekeeping);
    component_end_loops(component);
    component->configuration    = NULL;
    component->configuration_id = 0U;
    component_set_idle_period(component);
}

// ---- Functions: ST[08] ----

static bool is_function_allowed(const component_t* const component,
                                const descriptor_function_t* const function)
{
    if ((function->states & (1U << (unsigned)component->machine.state)) == 0U) {
        return false;
    }
    if (component->configuration == NULL) { // Only what every configuration allows.
        const unsigned all = (1U << component->descriptor->configuration_count) - 1U;
        return (function->configurations & all) == all;
    }
    const unsigned index = (unsigned)(component->configuration - component->descriptor->configurations);
    return (function->configurations & (1U << index)) != 0U;
}

/// Index of the first argument with an element outside its bounds, or argument_count.
static uint16_t first_out_of_bounds(const component_t* const component,
                                    const descriptor_function_t* const function, const uint16_t table_index,
                                    const void* const arguments)
{
    const pus_argument_t* argument  = component->function_table[table_index].arguments;
    const descriptor_field_t* field = &component->descriptor->fields[function->first_argument];
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

/// An entry for the token of a function that continues, or 0 if there is none. The last one is reserved for
/// the ground: requests released on board must not block its commands.
static uint32_t open_ticket(component_t* const component, const pus_token_t* const token)
{
    const bool is_ground = ((token->source & PUS_USER_ONBOARD) == 0U);
    pus_token_t* const block =
        is_ground ? pool_take_reserved(&component->tickets) : pool_take(&component->tickets);
    if (block == NULL) {
        return 0U;
    }
    uint32_t i = 0U;
    while (component->open_tickets[i] != NULL) { // Each open one holds a block, and there was one more.
        i++;
        FSW_ASSERT(i < COMPONENT_TICKETS);
    }
    *block                     = *token;
    component->open_tickets[i] = block;
    return i + 1U;
}

static void close_ticket(component_t* const component, const uint32_t ticket)
{
    const status_t status = pool_release(&component->tickets, component->open_tickets[ticket - 1U]);
    FSW_ASSERT(status == STATUS_OK);
    component->open_tickets[ticket - 1U] = NULL;
}

static pus_reply_t reply_of(component_t* const component, const status_t status, const uint32_t ticket,
                            const uint16_t function_id)
{
    const bool is_aborted = (status == STATUS_BUSY) && (component->machine.state >= STATE_ERROR_OPERATIONAL);
    if ((status == STATUS_BUSY) && !is_aborted) {
        return pus_later();
    }
    if (component->open_tickets[ticket - 1U] != NULL) {
        close_ticket(component, ticket);
    }
    switch (status) {
    case STATUS_OK:
        return pus_done();
    case STATUS_FORBIDDEN:
        return pus_refused(PUS_FAILURE_STATE, function_id);
    case STATUS_OUT_OF_RANGE:
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    case STATUS_BUSY: // Begun, and ended by an error that the function itself raised.
        return pus_failed(PUS_FAILURE_ABORTED, 0U);
    default:
        return pus_failed(PUS_FAILURE_DEVICE, (uint32_t)status);
    }
}

static pus_reply_t perform_function(void* const context, const uint16_t index, const void* const arguments,
                                    const pus_token_t* const token, const uint64_t now_ns)
{
    component_t* const component                = (component_t*)context;
    const descriptor_function_t* const function = &component->descriptor->functions[index];
    component->now_ns                           = now_ns;
    if ((component->config.callbacks->perform == NULL) || !is_function_allowed(component, function)) {
        return pus_refused(PUS_FAILURE_STATE, function->id);
    }
    const uint16_t bad = first_out_of_bounds(component, function, index, arguments);
    if (bad < function->argument_count) {
        pus_reply_t reply         = pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
        reply.failure.instruction = (uint16_t)(bad + 1U);
        return reply;
    }
    const uint32_t ticket = open_ticket(component, token);
    if (ticket == 0U) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, COMPONENT_TICKETS);
    }
    const subsystem_function_t call = {.function_id = function->id, .arguments = arguments, .ticket = ticket};
    component->ticket_in_call       = ticket;
    const status_t status           = component->config.callbacks->perform(component->config.self, &call);
    component->ticket_in_call       = 0U;
    return reply_of(component, status, ticket, function->id);
}

/// Offsets as a C compiler lays out the generated argument struct: each scalar aligned to its size.
static void tabulate_functions(component_t* const component)
{
    const subsystem_descriptor_t* const descriptor = component->descriptor;
    size_t used                                    = 0U;
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        const descriptor_function_t* const function = &descriptor->functions[i];
        pus_function_t* const entry                 = &component->function_table[i];
        FSW_ASSERT((used + function->argument_count) <= COMPONENT_ARGUMENTS);
        entry->arguments      = &component->arguments[used];
        entry->argument_count = (uint8_t)function->argument_count;
        (void)memset(entry->name, 0, sizeof entry->name);
        for (size_t k = 0U; (k < PUS_NAME_SIZE) && (function->name[k] != '\0'); k++) {
            entry->name[k] = function->name[k];
        }
        FSW_ASSERT(function->memory_size <= sizeof component->argument_area);
        for (uint16_t k = 0U; k < function->argument_count; k++) {
            const descriptor_field_t* const field = &descriptor->fields[function->first_argument + k];
            component->arguments[used]            = (pus_argument_t){.id     = field->id,
                                                                     .type   = field->type,
                                                                     .count  = field->count,
                                                                     .offset = (uint16_t)field->offset};
            used++;
        }
    }
}

// ---- Events and management ----

static void tabulate_events(component_t* const component)
{
    const subsystem_descriptor_t* const descriptor = component->descriptor;
    for (uint16_t i = 0U; i < descriptor->event_count; i++) {
        const descriptor_event_t* const event = &descriptor->events[i];
        component->event_definitions[i]       = (pus_event_definition_t){
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
    const component_t* const component = (const component_t*)context;
    *out_status                        = (pus_subsystem_status_t){.state              = (uint8_t)component->machine.state,
                                                                  .phase              = (uint8_t)component->machine.phase,
                                                                  .target             = (uint8_t)component->machine.target,
                                                                  .configuration      = component->configuration_id,
                                                                  .interface_hash     = component->descriptor->interface_hash,
                                                                  .configuration_hash = component->descriptor->configuration_hash,
                                                                  .epoch              = component->config.start_count,
                                                                  .cycle              = component->cycle};
}

static bool may_change(const component_t* const component)
{
    const state_phase_t phase = component->machine.phase;
    return (component->machine.state == STATE_OFFLINE) || (phase == PHASE_UNCONFIGURED);
}

/// Set up events and functions from their tables, with counters at zero.
static void init_tabulated(component_t* const component)
{
    const pus_function_port_t functions = {component, perform_function};
    pus_events_init(&component->events, &component->process, component->event_definitions,
                    component->event_states, component->descriptor->event_count);
    const descriptor_event_t* const teller =
        descriptor_find_event_name(component->descriptor, "EVENTS_SUPPRESSED");
    pus_events_tell_by(&component->events,
                       ((teller != NULL) && (teller->octets == PUS_SUPPRESSED_AUX)) ? teller->id : 0U);
    pus_functions_init(&component->functions, component->function_table,
                       component->descriptor->function_count, &functions, component->argument_area,
                       sizeof component->argument_area);
}

/// STATUS_OK, or why the old descriptor stays in force.
static status_t change_descriptor(component_t* const component)
{
    const subsystem_descriptor_t* descriptor = NULL;
    const status_t status = component->config.reload(component->config.reload_context, &descriptor);
    if (status != STATUS_OK) {
        return status;
    }
    component->descriptor = descriptor;
    component_set_idle_period(component);
    component_set_pool_thresholds(component);
    tabulate_functions(component);
    tabulate_events(component);
    if (component->machine.phase == PHASE_INVALID) {
        init_tabulated(component); // The component had no descriptor until now.
        state_machine_validate(&component->machine);
        component_after_change(component);
    }
    return component_initialise_parameters(component);
}

void component_take_reload(component_t* const component)
{
    if (!component->has_reload || !may_change(component)) {
        return;
    }
    component->has_reload = false;
    const status_t status = change_descriptor(component);
    pus_verify_ended(&component->process, &component->reload,
                     pus_failure((status == STATUS_OK) ? PUS_FAILURE_NONE : PUS_FAILURE_IO, (uint32_t)status),
                     component->now_ns);
}

static pus_reply_t reload_descriptor(void* const context, const pus_token_t* const token,
                                     const uint64_t now_ns)
{
    component_t* const component = (component_t*)context;
    component->now_ns            = now_ns;
    if (component->config.reload == NULL) {
        return pus_refused(PUS_FAILURE_SUBTYPE, ((uint32_t)token->service << 8U) | token->subtype);
    }
    if (component->has_reload) {
        return pus_refused(PUS_FAILURE_STATE, (uint32_t)component->machine.state);
    }
    if (!may_change(component)) { // A file takes milliseconds to read: not while devices are controlled.
        component->has_reload = true;
        component->reload     = *token;
        return pus_later();
    }
    const status_t status = change_descriptor(component);
    return (status == STATUS_OK) ? pus_done() : pus_failed(PUS_FAILURE_IO, (uint32_t)status);
}

// ---- Connection test: ST[17] ----

/// A subsystem communicates only with the supervisor, which has sent the request.
static pus_reply_t connect(void* const context, const uint16_t apid, const pus_token_t* const token,
                           const uint64_t now_ns)
{
    (void)token;
    (void)now_ns;
    const component_t* const component = (const component_t*)context;
    const bool is_reached = (apid == component->process.apid) || (apid == COMPONENT_SUPERVISOR_APID);
    return is_reached ? pus_done() : pus_refused(PUS_FAILURE_UNKNOWN_ID, apid);
}

// ---- Optional services ----

static void add(component_t* const component, const pus_service_t* const service)
{
    FSW_ASSERT(component->service_count < COMPONENT_SERVICES);
    component->services[component->service_count] = *service;
    component->service_count++;
}

void component_add_service(component_t* const component, const pus_service_t* const service,
                           const component_restore_t restore)
{
    FSW_ASSERT((component != NULL) && (service != NULL) &&
               (component->optional_count < COMPONENT_OPTIONAL_SERVICES));
    component->optional[component->optional_count] = (component_optional_t){*service, restore};
    component->optional_count++;
    add(component, service);
}

pus_parameter_port_t component_parameter_port(component_t* const component)
{
    FSW_ASSERT(component != NULL);
    return (pus_parameter_port_t){component, find_parameter, read_parameter, write_parameter};
}

const pus_persistence_t* component_persistence(const component_t* const component)
{
    FSW_ASSERT(component != NULL);
    return component->config.persistence;
}

void component_step_optional(component_t* const component)
{
    component->optional_cycle++;
    for (size_t i = 0U; i < component->optional_count; i++) {
        const pus_service_t* const service = &component->optional[i].service;
        if (service->step != NULL) {
            service->step(service->self, component->now_ns, component->optional_cycle);
        }
    }
}

status_t component_restore(component_t* const component, const uint8_t table, const uint32_t key,
                           const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((component != NULL) && (octets != NULL));
    if (table == PUS_SERVICE_HOUSEKEEPING) {
        return pus_hk_restore(&component->housekeeping, key, octets, size);
    }
    if (table == PUS_SERVICE_PARAMETERS) {
        return pus_parameters_restore(&component->parameters, key, octets, size);
    }
    for (size_t i = 0U; i < component->optional_count; i++) {
        const component_optional_t* const optional = &component->optional[i];
        if ((optional->service.type == table) && (optional->restore != NULL)) {
            return optional->restore(optional->service.self, key, octets, size);
        }
    }
    return STATUS_NOT_FOUND;
}

/// Those of the configuration, of the links, and of the descriptor.
static void add_further(component_t* const component)
{
    const component_services_t* const optional = &component->config.optional;
    bool has_own_links                         = false;
    bool has_own_test                          = false;
    for (size_t i = 0U; i < component->config.service_count; i++) {
        add(component, &component->config.services[i]);
        has_own_links |= (component->config.services[i].type == PUS_SERVICE_RTLINK);
        has_own_test |= (component->config.services[i].type == PUS_SERVICE_TEST);
    }
    if (!has_own_test) { // The supervisor has its own.
        const pus_service_t test = pus_test_service(&component->test);
        add(component, &test);
    }
    if (!has_own_links) { // The supervisor brings its own: it is the manager of the links.
        const pus_service_t links = pus_rtlink_service(&component->rtlink);
        add(component, &links);
    }
    if (optional->add != NULL) {
        optional->add(optional->storage, component);
    }
}

void component_register_services(component_t* const component)
{
    const pus_parameter_port_t values      = component_parameter_port(component);
    const pus_hk_config_t hk               = {.process          = &component->process,
                                              .parameters       = values,
                                              .structures       = component->structures,
                                              .structure_count  = COMPONENT_STRUCTURES,
                                              .samples          = component->samples,
                                              .sample_size      = COMPONENT_SAMPLE_OCTETS,
                                              .guard            = &component->loop_guard,
                                              .functional       = component->functional,
                                              .functional_count = COMPONENT_FUNCTIONAL,
                                              .persistence      = component->config.persistence};
    const pus_management_port_t management = {component, component_request_state,
                                              component_select_configuration, reload_descriptor, read_status};
    const pus_rtlink_port_t links          = component_link_port(component);
    const pus_test_port_t connection       = {component, connect};
    component_create_guards(component); // Services lock them from their own start on.
    tabulate_functions(component);
    tabulate_events(component);
    pus_test_init(&component->test, &connection);
    pus_hk_init(&component->housekeeping, &hk);
    init_tabulated(component);
    pus_parameters_init(&component->parameters, &values);
    pus_management_init(&component->management, &management);
    pus_rtlink_init(&component->rtlink, &links);
    const pus_service_t own[] = {
        pus_hk_service(&component->housekeeping), pus_events_service(&component->events),
        pus_functions_service(&component->functions), pus_parameters_service(&component->parameters),
        pus_management_service(&component->management)};
    (void)memcpy(component->services, own, sizeof own);
    component->service_count = sizeof own / sizeof own[0];
    add_further(component);
    pus_dispatcher_init(&component->dispatcher, &component->process, component->services,
                        component->service_count);
    if (component->config.persistence != NULL) {
        pus_dispatcher_persist(&component->dispatcher, component->config.persistence);
    }
    component_init_loops(component, &values);
}
