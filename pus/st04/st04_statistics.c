// SPDX-License-Identifier: Apache-2.0
#include "pus/st04/st04_statistics.h"

#include "base/assertion.h"
#include "generated/pus/st04_request_formats.h"
#include "pus/core/list_report.h"

#include <float.h>
#include <math.h>

enum {
    STATISTICS_REPORT = 2,
    DEFINITION_REPORT = 9
};

#define INTERVAL_KEY 0U // Key of the record of the reporting interval; no parameter id is 0.
#define ENTRY_MAX 60U   // Largest entry of TM[4,2] [octets].
#define NS_PER_S 1000000000U

void pus_statistics_init(pus_statistics_t* const self, const pus_statistics_config_t* const config)
{
    FSW_ASSERT((self != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->statistics != NULL) && (config->cycle_ns >= 1U));
    *self = (pus_statistics_t){.config = *config};
    pus_due_init(&self->due, config->due, config->positions, config->capacity);
    for (uint16_t i = 0U; i < config->capacity; i++) {
        config->statistics[i].in_use = false;
    }
}

/// Returns the number of whole cycles in an interval; 0 if the interval is shorter than one cycle, or
/// negative.
static uint64_t cycles_of(const pus_statistics_t* const self, const int64_t ticks)
{
    if (ticks <= 0) {
        return 0U;
    }
    const uint64_t whole = (uint64_t)ticks;
    const uint64_t ns    = ((whole / PUS_TIME_TICKS_PER_S) * NS_PER_S) +
                        (((whole % PUS_TIME_TICKS_PER_S) * NS_PER_S) / PUS_TIME_TICKS_PER_S);
    return ns / self->config.cycle_ns;
}

static pus_statistic_t* find(const pus_statistics_t* const self, const uint32_t parameter_id)
{
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        pus_statistic_t* const statistic = &self->config.statistics[i];
        if (statistic->in_use && (statistic->scalar.id == parameter_id)) {
            return statistic;
        }
    }
    return NULL;
}

static pus_statistic_t* find_free(const pus_statistics_t* const self)
{
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        if (!self->config.statistics[i].in_use) {
            return &self->config.statistics[i];
        }
    }
    return NULL;
}

// ---- Sampling ----

static void reset(pus_statistics_t* const self, const uint64_t now_ns)
{
    self->start_ns = now_ns;
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        self->config.statistics[i].samples = 0U;
    }
}

static void add_sample(pus_statistic_t* const statistic, const uint64_t bits, const double value,
                       const uint64_t time_ns)
{
    const value_type_t type = statistic->scalar.type;
    if (statistic->samples == 0U) {
        statistic->mean    = 0.0;
        statistic->squares = 0.0;
    }
    if ((statistic->samples == 0U) || (pus_scalar_compare(type, bits, statistic->maximum) == PUS_GREATER)) {
        statistic->maximum    = bits;
        statistic->maximum_ns = time_ns;
    }
    if ((statistic->samples == 0U) || (pus_scalar_compare(type, bits, statistic->minimum) == PUS_LESS)) {
        statistic->minimum    = bits;
        statistic->minimum_ns = time_ns;
    }
    statistic->samples++;
    // Welford's method: the mean of the squares minus the square of the mean would lose digits.
    const double distance = value - statistic->mean;
    statistic->mean += distance / statistic->samples;
    statistic->squares += distance * (value - statistic->mean);
}

static void sample(pus_statistics_t* const self, pus_statistic_t* const statistic, const uint64_t now_ns)
{
    uint64_t bits = 0U;
    if (pus_scalar_sample(&self->config.parameters, &statistic->scalar, &bits) != STATUS_OK) {
        self->counters.missing++;
        return;
    }
    const double value = pus_scalar_as_double(statistic->scalar.type, bits);
    if (!(fabs(value) <= DBL_MAX)) { // Also refuses NaN, for which the comparison is false.
        self->counters.not_finite++;
    } else if (statistic->samples < UINT32_MAX) {
        self->counters.samples++;
        add_sample(statistic, bits, value, self->config.process->epoch_ns + now_ns);
    } else {
        // The number of samples is at its maximum: no further sample is included.
    }
}

// ---- Reports ----

static void write_relative_time(octet_writer_t* const writer, const int64_t ticks)
{
    const uint64_t bits = (uint64_t)ticks;
    octet_write_u8(writer, (uint8_t)((bits >> 48U) & 0xFFU));
    octet_write_u16(writer, (uint16_t)((bits >> 32U) & 0xFFFFU));
    octet_write_u32(writer, (uint32_t)(bits & UINT32_MAX));
}

static void write_statistic(octet_writer_t* const writer, const pus_statistic_t* const statistic)
{
    const value_type_t type = statistic->scalar.type;
    octet_write_u32(writer, statistic->scalar.id);
    octet_write_u32(writer, statistic->samples);
    pus_scalar_write(writer, type, statistic->maximum);
    pus_time_write(writer, statistic->maximum_ns);
    pus_scalar_write(writer, type, statistic->minimum);
    pus_time_write(writer, statistic->minimum_ns);
    octet_write_f64(writer, statistic->mean);
    octet_write_f64(writer, sqrt(statistic->squares / statistic->samples));
}

static pus_reply_t report_statistics(const pus_statistics_t* const self,
                                     const pus_list_target_t* const target)
{
    uint8_t prefix[2U * PUS_TIME_SIZE];
    octet_writer_t times = octet_writer(prefix, sizeof prefix);
    pus_list_report_t list;
    pus_time_write(&times, self->config.process->epoch_ns + self->start_ns);
    pus_time_write(&times, self->config.process->epoch_ns + target->now_ns);
    pus_list_report_begin(&list, target, prefix, sizeof prefix);
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        const pus_statistic_t* const statistic = &self->config.statistics[i];
        if (statistic->in_use && (statistic->samples > 0U)) {
            write_statistic(pus_list_report_entry(&list, ENTRY_MAX), statistic);
        }
    }
    return pus_list_report_end(&list);
}

void pus_statistics_step(pus_statistics_t* const self, const uint64_t now_ns, const uint32_t cycle)
{
    FSW_ASSERT(self != NULL);
    // The difference modulo 2^32 extends the count of the caller to 64 bits.
    self->cycle += (uint32_t)(cycle - self->last_cycle);
    self->last_cycle = cycle;
    if (!self->is_started) {
        self->is_started = true;
        self->start_ns   = now_ns;
    }
    uint16_t index = 0U;
    while (pus_due_next(&self->due, self->cycle, &index)) {
        pus_due_repeat(&self->due, self->cycle, self->config.statistics[index].interval);
        sample(self, &self->config.statistics[index], now_ns);
    }
    if ((self->reporting_interval > 0U) && (self->cycle >= self->next_report)) {
        const pus_list_target_t target = {.process     = self->config.process,
                                          .service     = PUS_SERVICE_STATISTICS,
                                          .subtype     = STATISTICS_REPORT,
                                          .destination = PUS_USER_GROUND,
                                          .now_ns      = now_ns};
        self->counters.lost += (report_statistics(self, &target).kind == PUS_DONE) ? 0U : 1U;
        // Reset even if the report was lost: each report has the samples of one interval.
        reset(self, now_ns);
        self->next_report = self->cycle + self->reporting_interval;
    }
}

// ---- Records and definitions ----

static pus_failure_t keep(pus_statistics_t* const self, const uint32_t key, const int64_t ticks)
{
    const pus_persistence_t* const store = self->config.persistence;
    uint8_t octets[PUS_RELATIVE_TIME_SIZE];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    write_relative_time(&writer, ticks);
    const status_t status =
        (store == NULL) ? STATUS_OK
                        : store->put(store->context, PUS_SERVICE_STATISTICS, key, octets, sizeof octets);
    self->counters.unsaved += (status == STATUS_OK) ? 0U : 1U;
    return pus_failure((status == STATUS_OK) ? PUS_FAILURE_NONE : PUS_FAILURE_IO, (uint32_t)status);
}

/// Check a definition and find its entry in the table. `offset` of the definition in the request: detail of a
/// refusal.
static pus_failure_t prepare(const pus_statistics_t* const self, pus_statistic_t* const candidate,
                             pus_statistic_t** const out_entry, const uint32_t offset)
{
    candidate->interval = cycles_of(self, candidate->interval_ticks);
    if (candidate->interval == 0U) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    *out_entry = find(self, candidate->scalar.id);
    *out_entry = (*out_entry != NULL) ? *out_entry : find_free(self);
    return pus_failure((*out_entry != NULL) ? PUS_FAILURE_NONE : PUS_FAILURE_TABLE_FULL,
                       self->config.capacity);
}

/// Define a statistic. It is sampled from the next cycle on; if it was defined before, it restarts.
static void define(pus_statistics_t* const self, pus_statistic_t* const entry,
                   const pus_statistic_t* const candidate)
{
    *entry = *candidate;
    pus_due_set(&self->due, (uint16_t)(entry - self->config.statistics), self->cycle + 1U);
}

static pus_failure_t add(pus_statistics_t* const self, pus_statistic_t* const candidate,
                         const uint32_t offset)
{
    pus_statistic_t* entry = NULL;
    const uint32_t id      = candidate->scalar.id;
    const status_t status  = pus_scalar_find(&self->config.parameters, id, &candidate->scalar);
    if (status != STATUS_OK) {
        return pus_failure(pus_scalar_failure(status), id);
    }
    pus_failure_t failure = prepare(self, candidate, &entry, offset);
    if (failure.code == PUS_FAILURE_NONE) {
        failure = keep(self, candidate->scalar.id, candidate->interval_ticks);
    }
    if (failure.code == PUS_FAILURE_NONE) {
        FSW_ASSERT(entry != NULL); // `prepare` has found an entry, because there is no failure.
        define(self, entry, candidate);
    }
    return failure;
}

static void set_reporting(pus_statistics_t* const self, const int64_t ticks)
{
    self->reporting_ticks    = ticks;
    self->reporting_interval = cycles_of(self, ticks);
    self->next_report        = self->cycle + self->reporting_interval;
}

status_t pus_statistics_restore(pus_statistics_t* const self, const uint32_t key, const uint8_t* const octets,
                                const size_t size)
{
    FSW_ASSERT((self != NULL) && ((octets != NULL) || (size == 0U)));
    octet_reader_t reader = octet_reader(octets, size);
    const int64_t ticks   = pus_relative_time_read(&reader);
    if (!octet_reader_is_done(&reader)) {
        return STATUS_INVALID;
    }
    if (key == INTERVAL_KEY) {
        set_reporting(self, ticks);
        return STATUS_OK;
    }
    pus_statistic_t candidate = {
        .in_use = true, .scalar = {.id = key, .type = pus_scalar_type(key)}, .interval_ticks = ticks};
    pus_statistic_t* entry      = NULL;
    const pus_failure_t failure = prepare(self, &candidate, &entry, 0U);
    if ((candidate.scalar.type == VALUE_SCALARS) || (failure.code == PUS_FAILURE_OUT_OF_RANGE)) {
        return STATUS_INVALID;
    }
    if (entry == NULL) {
        return STATUS_EXHAUSTED;
    }
    define(self, entry, &candidate);
    return STATUS_OK;
}

// ---- Requests ----

static void perform_or_refuse(pus_statistics_t* const self, pus_request_t* const request,
                              const uint16_t instruction, const pus_failure_t* const failure)
{
    if (failure->code == PUS_FAILURE_NONE) {
        pus_request_perform(request);
    } else {
        self->counters.refused++;
        pus_request_refuse(request, instruction, failure->code, failure->detail);
    }
}

static pus_reply_t reply_of(pus_statistics_t* const self, const pus_failure_t* const failure)
{
    if (failure->code == PUS_FAILURE_NONE) {
        return pus_done();
    }
    self->counters.refused++;
    return pus_refused(failure->code, failure->detail);
}

static pus_reply_t report(void* const context, pus_request_t* const request)
{
    pus_statistics_t* const self   = context;
    const bool does_reset          = octet_read_u8(&request->reader) != 0U;
    const pus_list_target_t target = pus_list_answer(request, STATISTICS_REPORT);
    pus_request_perform(request);
    const pus_reply_t reply = report_statistics(self, &target);
    if (does_reset && (reply.kind == PUS_DONE)) {
        reset(self, request->now_ns);
    }
    return reply;
}

static pus_reply_t reset_all(void* const self, pus_request_t* const request)
{
    reset(self, request->now_ns);
    return pus_done();
}

static pus_reply_t enable_reporting(void* const context, pus_request_t* const request)
{
    pus_statistics_t* const self = context;
    const int64_t ticks          = pus_relative_time_read(&request->reader);
    pus_failure_t failure        = pus_failure(PUS_FAILURE_OUT_OF_RANGE, 0U);
    if (cycles_of(self, ticks) > 0U) {
        failure = keep(self, INTERVAL_KEY, ticks);
    }
    if (failure.code == PUS_FAILURE_NONE) {
        set_reporting(self, ticks);
    }
    return reply_of(self, &failure);
}

static pus_reply_t disable_reporting(void* const context, pus_request_t* const request)
{
    (void)request;
    pus_statistics_t* const self = context;
    const pus_failure_t failure  = keep(self, INTERVAL_KEY, 0);
    if (failure.code == PUS_FAILURE_NONE) {
        set_reporting(self, 0);
    }
    return reply_of(self, &failure);
}

static pus_reply_t add_definitions(void* const context, pus_request_t* const request)
{
    pus_statistics_t* const self = context;
    const uint8_t count          = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint32_t offset       = (uint32_t)request->reader.position;
        pus_statistic_t candidate   = {.in_use = true, .scalar = {.id = octet_read_u32(&request->reader)}};
        candidate.interval_ticks    = pus_relative_time_read(&request->reader);
        const pus_failure_t failure = add(self, &candidate, offset);
        perform_or_refuse(self, request, i, &failure);
    }
    return pus_done();
}

static pus_failure_t delete_statistic(pus_statistics_t* const self, pus_statistic_t* const statistic)
{
    const pus_persistence_t* const store = self->config.persistence;
    const status_t status                = (store == NULL)
                                               ? STATUS_OK
                                               : store->erase(store->context, PUS_SERVICE_STATISTICS, statistic->scalar.id);
    if ((status != STATUS_OK) && (status != STATUS_NOT_FOUND)) {
        self->counters.unsaved++;
        return pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    }
    statistic->in_use = false;
    pus_due_remove(&self->due, (uint16_t)(statistic - self->config.statistics));
    return pus_no_failure();
}

static pus_reply_t delete_all(pus_statistics_t* const self)
{
    pus_failure_t failure = pus_no_failure();
    for (uint16_t i = 0U; (i < self->config.capacity) && (failure.code == PUS_FAILURE_NONE); i++) {
        if (self->config.statistics[i].in_use) {
            failure = delete_statistic(self, &self->config.statistics[i]);
        }
    }
    return (failure.code == PUS_FAILURE_NONE) ? pus_done() : pus_failed(failure.code, failure.detail);
}

static pus_reply_t delete_definitions(void* const context, pus_request_t* const request)
{
    pus_statistics_t* const self = context;
    const uint8_t count          = octet_read_u8(&request->reader);
    if (count == 0U) {
        return delete_all(self);
    }
    for (uint16_t i = 1U; i <= count; i++) {
        const uint32_t id                = octet_read_u32(&request->reader);
        pus_statistic_t* const statistic = find(self, id);
        const pus_failure_t failure =
            (statistic == NULL) ? pus_failure(PUS_FAILURE_UNKNOWN_ID, id) : delete_statistic(self, statistic);
        perform_or_refuse(self, request, i, &failure);
    }
    return pus_done();
}

static pus_reply_t report_definitions(void* const context, pus_request_t* const request)
{
    const pus_statistics_t* const self = context;
    const pus_list_target_t target     = pus_list_answer(request, DEFINITION_REPORT);
    uint8_t prefix[PUS_RELATIVE_TIME_SIZE];
    octet_writer_t interval = octet_writer(prefix, sizeof prefix);
    pus_list_report_t list;
    write_relative_time(&interval, self->reporting_ticks);
    pus_request_perform(request);
    pus_list_report_begin(&list, &target, prefix, sizeof prefix);
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        const pus_statistic_t* const statistic = &self->config.statistics[i];
        if (statistic->in_use) {
            octet_writer_t* const writer =
                pus_list_report_entry(&list, sizeof(uint32_t) + PUS_RELATIVE_TIME_SIZE);
            octet_write_u32(writer, statistic->scalar.id);
            write_relative_time(writer, statistic->interval_ticks);
        }
    }
    return pus_list_report_end(&list);
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    pus_statistics_step(self, now_ns, cycle);
}

pus_service_t pus_statistics_service(pus_statistics_t* const self)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(4, 1, report),
        PUS_REQUEST(4, 3, reset_all),
        PUS_REQUEST(4, 4, enable_reporting),
        PUS_REQUEST(4, 5, disable_reporting),
        PUS_REQUEST(4, 6, add_definitions),
        PUS_REQUEST(4, 7, delete_definitions),
        PUS_REQUEST(4, 8, report_definitions),
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_STATISTICS, subtypes, sizeof subtypes / sizeof subtypes[0], self);
    service.step = step;
    return service;
}
