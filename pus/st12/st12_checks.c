// SPDX-License-Identifier: Apache-2.0
#include "base/assertion.h"
#include "pus/st12/st12_internal.h"

#include <string.h>

/// True for the statuses of a violated criterion.
static bool is_out(const uint8_t status)
{
    return (status == (uint8_t)PUS_CHECK_LOW) || (status == (uint8_t)PUS_CHECK_HIGH);
}

static uint16_t index_of(const pus_monitoring_t* const self, const pus_pmon_t* const pmon)
{
    return (uint16_t)(pmon - self->config.pmons);
}

void monitoring_schedule(pus_monitoring_t* const self, const pus_pmon_t* const pmon)
{
    if (self->is_enabled && pmon->is_enabled) {
        pus_due_set(&self->due, index_of(self, pmon), self->cycle + 1U);
    }
}

void monitoring_uncheck(pus_monitoring_t* const self, pus_pmon_t* const pmon)
{
    pmon->status      = PUS_CHECK_UNCHECKED;
    pmon->verdict     = PUS_CHECK_UNCHECKED;
    pmon->verdicts    = 0U;
    pmon->differences = 0U;
    pmon->has_first   = false;
    pus_due_remove(&self->due, index_of(self, pmon));
    monitoring_touch(self, pmon);
}

bool monitoring_is_valid(const pus_monitoring_t* const self, const pus_validity_t* const validity)
{
    uint64_t value = 0U;
    if (validity->scalar.id == 0U) {
        return true;
    }
    return (pus_scalar_sample(&self->config.parameters, &validity->scalar, &value) == STATUS_OK) &&
           ((value & validity->mask) == validity->expected);
}

// ---- Reports of transitions ----

/// Send the transitions in the list, until the port refuses a report.
static void send_transitions(pus_monitoring_t* const self, const uint64_t now_ns)
{
    pus_check_transition_t* const list = self->config.transitions;
    status_t status                    = STATUS_OK;
    while ((self->transition_count > 0U) && (status == STATUS_OK)) {
        octet_writer_t writer =
            pus_tm_begin(self->config.process, PUS_SERVICE_MONITORING, 12U, PUS_USER_GROUND, now_ns);
        // Not null, because there is room.
        uint8_t* const head = octet_write_space(&writer, sizeof(uint16_t));
        uint16_t count      = 0U;
        while ((count < self->transition_count) &&
               ((writer.capacity - writer.position) >= MONITORING_TRANSITION_MAX)) {
            monitoring_write_transition(&writer, &list[count]);
            count++;
        }
        octets_put_u16(head, count);
        status = pus_tm_send(self->config.process, &writer);
        if (status == STATUS_OK) {
            self->transition_count = (uint16_t)(self->transition_count - count);
            (void)memmove(list, &list[count], self->transition_count * sizeof list[0]);
        }
    }
}

static void list_transition(pus_monitoring_t* const self, const pus_check_transition_t* const transition,
                            const uint64_t now_ns)
{
    self->counters.transitions++;
    if (self->transition_count == self->config.transition_capacity) {
        send_transitions(self, now_ns);
    }
    if (self->transition_count == self->config.transition_capacity) {
        self->counters.lost++;
        return;
    }
    if (self->transition_count == 0U) {
        self->transitions_since = self->cycle;
    }
    self->config.transitions[self->transition_count] = *transition;
    self->transition_count++;
}

static void raise_event(const pus_monitoring_t* const self, const pus_check_transition_t* const transition,
                        const uint16_t event_id, const uint64_t now_ns)
{
    uint8_t octets[MONITORING_PMON_EVENT];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, transition->pmon_id);
    octet_write_u32(&writer, transition->parameter_id);
    octet_write_u8(&writer, transition->check_type);
    octet_write_u8(&writer, transition->current);
    octet_write_f64(&writer,
                    pus_scalar_as_double(pus_scalar_type(transition->parameter_id), transition->value));
    self->config.events.raise(self->config.events.context, event_id, octets, sizeof octets, now_ns);
}

/// Returns the value for the field limit_crossed in the report of a transition. For a transition to nominal
/// it is the limit that the parameter had violated.
static uint64_t limit_of(const pus_pmon_t* const pmon, const uint8_t status)
{
    if (pmon->check_type == (uint8_t)PUS_CHECK_EXPECTED) {
        return pmon->high;
    }
    const uint8_t crossed = is_out(status) ? status : pmon->status;
    if (crossed == (uint8_t)PUS_CHECK_LOW) {
        return pmon->low;
    }
    return (crossed == (uint8_t)PUS_CHECK_HIGH) ? pmon->high : 0U;
}

static void change(pus_monitoring_t* const self, pus_pmon_t* const pmon, const uint8_t status,
                   const uint64_t value, const uint64_t now_ns)
{
    pmon->last   = (pus_check_transition_t){.pmon_id      = pmon->id,
                                            .parameter_id = pmon->scalar.id,
                                            .check_type   = pmon->check_type,
                                            .previous     = pmon->status,
                                            .current      = status,
                                            .mask         = pmon->low,
                                            .value        = value,
                                            .limit        = limit_of(pmon, status),
                                            .time_ns      = self->config.process->epoch_ns + now_ns};
    pmon->status = status;
    list_transition(self, &pmon->last, now_ns);
    const uint16_t event = (status == (uint8_t)PUS_CHECK_HIGH) ? pmon->high_event : pmon->low_event;
    if (is_out(status) && (event != 0U)) {
        raise_event(self, &pmon->last, event, now_ns);
    }
}

// ---- Checks of a value ----

/// Result of a limit check. NaN, which is neither less nor greater than a limit, counts as low.
static uint8_t check_limit(const pus_pmon_t* const pmon, const uint64_t value)
{
    const pus_comparison_t low = pus_scalar_compare(pmon->scalar.type, value, pmon->low);
    if ((low == PUS_LESS) || (low == PUS_UNORDERED)) {
        return PUS_CHECK_LOW;
    }
    return (pus_scalar_compare(pmon->scalar.type, value, pmon->high) == PUS_GREATER) ? PUS_CHECK_HIGH
                                                                                     : PUS_CHECK_NOMINAL;
}

/// Result of a delta check: PUS_CHECK_UNCHECKED until the number of differences is that of a block. The last
/// value of a block is the first value of the next block. NaN counts as low.
static uint8_t check_delta(pus_pmon_t* const pmon, const uint64_t value)
{
    if (!pmon->has_first) {
        pmon->has_first   = true;
        pmon->first       = value;
        pmon->differences = 0U;
        return PUS_CHECK_UNCHECKED;
    }
    pmon->differences++;
    if (pmon->differences < pmon->deltas) {
        return PUS_CHECK_UNCHECKED;
    }
    const uint64_t first = pmon->first;
    const pus_comparison_t low =
        pus_scalar_compare_delta(pmon->scalar.type, first, value, pmon->deltas, pmon->low);
    const pus_comparison_t high =
        pus_scalar_compare_delta(pmon->scalar.type, first, value, pmon->deltas, pmon->high);
    pmon->first       = value;
    pmon->differences = 0U;
    if ((low == PUS_LESS) || (low == PUS_UNORDERED)) {
        return PUS_CHECK_LOW;
    }
    return (high == PUS_GREATER) ? PUS_CHECK_HIGH : PUS_CHECK_NOMINAL;
}

static uint8_t check_value(pus_pmon_t* const pmon, const uint64_t value)
{
    if (pmon->check_type == (uint8_t)PUS_CHECK_EXPECTED) {
        return ((value & pmon->low) == pmon->high) ? PUS_CHECK_NOMINAL : PUS_CHECK_LOW;
    }
    return (pmon->check_type == (uint8_t)PUS_CHECK_LIMIT) ? check_limit(pmon, value)
                                                          : check_delta(pmon, value);
}

static void check(pus_monitoring_t* const self, pus_pmon_t* const pmon, const uint64_t now_ns)
{
    uint64_t value        = 0U;
    const status_t status = pus_scalar_sample(&self->config.parameters, &pmon->scalar, &value);
    self->counters.checks++;
    monitoring_touch(self, pmon);
    // Without a valid value the status becomes invalid at once, and the count of repetitions starts again.
    if ((status != STATUS_OK) || !monitoring_is_valid(self, &pmon->validity)) {
        pmon->verdict   = PUS_CHECK_UNCHECKED;
        pmon->verdicts  = 0U;
        pmon->has_first = false;
        if (pmon->status != (uint8_t)PUS_CHECK_INVALID) {
            change(self, pmon, PUS_CHECK_INVALID, value, now_ns);
        }
        return;
    }
    const uint8_t verdict = check_value(pmon, value);
    if (verdict == (uint8_t)PUS_CHECK_UNCHECKED) {
        return;
    }
    if (verdict != pmon->verdict) {
        pmon->verdict  = verdict;
        pmon->verdicts = 0U;
    }
    if (pmon->verdicts < pmon->repetition) {
        pmon->verdicts++;
    }
    if ((pmon->verdicts == pmon->repetition) && (verdict != pmon->status)) {
        change(self, pmon, verdict, value, now_ns);
    }
}

void pus_monitoring_step(pus_monitoring_t* const self, const uint64_t now_ns, const uint32_t cycle)
{
    FSW_ASSERT(self != NULL);
    // The difference modulo 2^32 extends the count of the caller to 64 bits.
    self->cycle += (uint32_t)(cycle - self->last_cycle);
    self->last_cycle = cycle;
    monitoring_link(self);
    uint16_t index = 0U;
    while (pus_due_next(&self->due, self->cycle, &index)) {
        pus_pmon_t* const pmon = &self->config.pmons[index];
        pus_due_repeat(&self->due, self->cycle, pmon->interval);
        check(self, pmon, now_ns);
    }
    monitoring_evaluate_touched(self, now_ns);
    if ((self->transition_count == self->config.transition_capacity) ||
        ((self->transition_count > 0U) &&
         ((self->cycle - self->transitions_since) >= self->reporting_delay))) {
        send_transitions(self, now_ns);
    }
}
