// SPDX-License-Identifier: Apache-2.0
/// Encoding a parameter of 64 octets. Baseline: a copy under a bare mutex with the same guarantees (priority
/// inheritance, robust, errors reported).
#define _GNU_SOURCE
#include "fsw/framework/parameter/parameter.h"
#include "test/bench/measure.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define WORK 16U
#define PARAMETERS 32U
#define IN_THE_MIDDLE 13U

static const parameter_field_t fields[] = {{"VALUE", VALUE_DOUBLE, 8U, 0U}};
static parameter_definition_t definitions[PARAMETERS];
static char names[PARAMETERS][3];
static double values[PARAMETERS][8];
static parameter_entry_t entries[PARAMETERS];
static parameter_bounds_t bounds[PARAMETERS];
static parameter_dictionary_t dictionary;
static const parameter_entry_t* entry;
static uint8_t wire[64];
static pthread_mutex_t mutex;
static volatile uint8_t sink; // Keeps the compiler from removing the work.

static void read_entry(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        octet_writer_t writer = octet_writer(wire, sizeof wire);
        if (parameter_read_entry(&dictionary, entry, &writer) != STATUS_OK) {
            abort();
        }
        sink = wire[7];
    }
}

static void read_by_id(void)
{
    const uint32_t id = definitions[IN_THE_MIDDLE].id;
    for (unsigned i = 0U; i < WORK; i++) {
        octet_writer_t writer = octet_writer(wire, sizeof wire);
        if (parameter_read(&dictionary, id, &writer) != STATUS_OK) {
            abort();
        }
        sink = wire[7];
    }
}

static void lock_and_copy(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        (void)pthread_mutex_lock(&mutex);
        (void)memcpy(wire, values[IN_THE_MIDDLE], sizeof wire);
        (void)pthread_mutex_unlock(&mutex);
        sink = wire[7];
    }
}

static void* end_at_once(void* context)
{
    return context;
}

int main(void)
{
    pthread_t thread;
    pthread_mutexattr_t attributes;
    if ((pthread_create(&thread, NULL, end_at_once, NULL) != 0) || (pthread_join(thread, NULL) != 0) ||
        (parameter_init(&dictionary, entries, PARAMETERS, bounds, PARAMETERS) != STATUS_OK)) {
        return 1;
    }
    (void)pthread_mutexattr_init(&attributes);
    (void)pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
    (void)pthread_mutexattr_setrobust(&attributes, PTHREAD_MUTEX_ROBUST);
    (void)pthread_mutexattr_settype(&attributes, PTHREAD_MUTEX_ERRORCHECK);
    (void)pthread_mutex_init(&mutex, &attributes);
    for (uint16_t i = 0U; i < PARAMETERS; i++) {
        names[i][0]    = (char)('A' + (i / 8U));
        names[i][1]    = (char)('A' + (i % 8U));
        definitions[i] = (parameter_definition_t){
            names[i], PARAMETER_ID(16U, VALUE_ARRAY, i), fields, 1U, sizeof values[i], sizeof values[i]};
        if (parameter_publish(&dictionary, &definitions[i], values[i]) != STATUS_OK) {
            return 1;
        }
    }
    if (parameter_find(&dictionary, definitions[IN_THE_MIDDLE].id, &entry) != STATUS_OK) {
        return 1;
    }
    measure_compare("parameter_read_64_octets", read_entry, lock_and_copy, WORK, "ns", 1.0);
    measure_compare("parameter_read_64_octets_by_id", read_by_id, lock_and_copy, WORK, "ns", 1.0);
    return 0;
}
