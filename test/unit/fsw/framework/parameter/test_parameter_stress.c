// SPDX-License-Identifier: Apache-2.0
// The owner, two commanders and three readers use one dictionary, each in a task of its own: no task ever
// reads a partly written structure, whichever functions read and write.
#include "fsw/framework/parameter/parameter.h"
#include "test/support/consistent_parameter.h"

#include "osal/include/osal/task.h"
#include "unity.h"

#include <string.h>

#define READERS 3U
#define ROUNDS 20000U
#define PARTY_ROUNDS 100U ///< The owner stops when each party has completed at least this many rounds.
#define VALUES PARAMETER_ID(16U, VALUE_STRUCT, 1U)
#define COMMAND PARAMETER_ID(16U, VALUE_STRUCT, 2U)
#define SCALE PARAMETER_ID(16U, VALUE_DOUBLE, 3U)
#define WIRE_OCTETS 45U

typedef struct { // All numbers of a structure are equal.
    uint32_t first;
    struct {
        double pair[2];
        struct {
            uint8_t low; ///< Low octet of the same number.
        } inner;
    } group;
    uint64_t words[2];
    double last;
} values_t;

static const parameter_field_t fields[] = {
    {"FIRST", VALUE_UINT32, 1U, (uint32_t)offsetof(values_t, first)},
    {"GROUP.PAIR", VALUE_DOUBLE, 2U, (uint32_t)offsetof(values_t, group.pair)},
    {"GROUP.INNER.LOW", VALUE_UINT8, 1U, (uint32_t)offsetof(values_t, group.inner.low)},
    {"WORDS", VALUE_UINT64, 2U, (uint32_t)offsetof(values_t, words)},
    {"LAST", VALUE_DOUBLE, 1U, (uint32_t)offsetof(values_t, last)},
    {"SCALE", VALUE_DOUBLE, 1U, 0U},
};
static const parameter_definition_t definitions[] = {
    {"VALUES", VALUES, fields, 5U, (uint32_t)sizeof(values_t), WIRE_OCTETS},
    {"COMMAND", COMMAND, fields, 5U, (uint32_t)sizeof(values_t), WIRE_OCTETS},
    {"SCALE", SCALE, &fields[5], 1U, 8U, 8U},
};

typedef struct {
    osal_task_t task;
    uint32_t number; ///< Index among the tasks of its kind.
    uint32_t rounds;
    uint32_t torn; ///< Structures read whose numbers were not equal.
    uint32_t refused;
} party_t;

static parameter_dictionary_t dictionary;
static parameter_entry_t entries[4];
static parameter_bounds_t bounds[16];
static values_t values;
static values_t command;
static double scale;
static party_t readers[READERS];
static party_t commander;
static party_t scalar_commander;
static uint32_t is_over;

static void fill(values_t* structure, uint32_t number)
{
    structure->first           = number;
    structure->group.pair[0]   = (double)number;
    structure->group.pair[1]   = (double)number;
    structure->group.inner.low = (uint8_t)number;
    structure->words[0]        = number;
    structure->words[1]        = number;
    structure->last            = (double)number;
}

static void encode(octet_writer_t* writer, uint32_t number)
{
    octet_write_u32(writer, number);
    octet_write_f64(writer, (double)number);
    octet_write_f64(writer, (double)number);
    octet_write_u8(writer, (uint8_t)number);
    octet_write_u64(writer, number);
    octet_write_u64(writer, number);
    octet_write_f64(writer, (double)number);
}

static bool is_whole(const uint8_t octets[WIRE_OCTETS])
{
    uint8_t expected[WIRE_OCTETS];
    octet_reader_t reader = octet_reader(octets, WIRE_OCTETS);
    octet_writer_t writer = octet_writer(expected, sizeof expected);
    encode(&writer, octet_read_u32(&reader));
    return memcmp(octets, expected, WIRE_OCTETS) == 0;
}

void setUp(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_init(&dictionary, entries, 4U, bounds, 16U));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &definitions[0], &values));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &definitions[1], &command));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &definitions[2], &scale));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_settable(&dictionary, COMMAND, true));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_settable(&dictionary, SCALE, true));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_bounds(&dictionary, SCALE, "SCALE", 0.0, 1.0));
}

void tearDown(void)
{
    TEST_ASSERT_TRUE(parameter_is_consistent(&dictionary));
}

/// Read the parameters in turn, by id or by an entry that was found before.
static void read_all(void* context)
{
    party_t* const self = context;
    while (__atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U) {
        uint8_t octets[WIRE_OCTETS];
        octet_writer_t writer          = octet_writer(octets, sizeof octets);
        const uint32_t id              = ((self->rounds % 2U) == 0U) ? VALUES : COMMAND;
        const parameter_entry_t* entry = NULL;
        status_t status                = STATUS_OK;
        if ((self->rounds % 3U) == 0U) {
            status = parameter_read(&dictionary, id, &writer);
        } else {
            status = parameter_find(&dictionary, id, &entry);
            status = (status == STATUS_OK) ? parameter_read_entry(&dictionary, entry, &writer) : status;
        }
        self->refused += (status != STATUS_OK) ? 1U : 0U;
        self->torn += is_whole(octets) ? 0U : 1U;
        __atomic_fetch_add(&self->rounds, 1U, __ATOMIC_RELAXED);
    }
}

/// Write complete structures.
static void command_all(void* context)
{
    party_t* const self = context;
    while (__atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U) {
        uint8_t octets[WIRE_OCTETS];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        encode(&writer, self->rounds * 3U);
        octet_reader_t reader = octet_reader(octets, writer.position);
        self->refused += (parameter_write(&dictionary, COMMAND, &reader) != STATUS_OK) ? 1U : 0U;
        __atomic_fetch_add(&self->rounds, 1U, __ATOMIC_RELAXED);
    }
}

/// Write a scalar; every second value is refused.
static void command_scalar(void* context)
{
    party_t* const self = context;
    while (__atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U) {
        uint8_t octets[sizeof(double)];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_f64(&writer, ((self->rounds % 2U) == 0U) ? 0.5 : 1.5);
        octet_reader_t reader = octet_reader(octets, writer.position);
        const status_t status = parameter_write(&dictionary, SCALE, &reader);
        const status_t wanted = ((self->rounds % 2U) == 0U) ? STATUS_OK : STATUS_OUT_OF_RANGE;
        self->refused += (status != wanted) ? 1U : 0U;
        __atomic_fetch_add(&self->rounds, 1U, __ATOMIC_RELAXED);
    }
}

static void start(party_t* party, void (*entry)(void* context))
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&party->task, entry, party, 0));
}

static void finish(party_t* party)
{
    osal_task_join(&party->task);
    TEST_ASSERT_EQUAL_UINT32(0U, party->torn);
    TEST_ASSERT_EQUAL_UINT32(0U, party->refused);
    TEST_ASSERT_TRUE(party->rounds >= PARTY_ROUNDS);
}

static bool has_taken_part(const party_t* party)
{
    return __atomic_load_n(&party->rounds, __ATOMIC_RELAXED) >= PARTY_ROUNDS;
}

static bool have_all_taken_part(void)
{
    bool all = has_taken_part(&commander) && has_taken_part(&scalar_commander);
    for (unsigned i = 0U; i < READERS; i++) {
        all = all && has_taken_part(&readers[i]);
    }
    return all;
}

static void no_reader_reads_a_partly_written_structure(void)
{
    for (unsigned i = 0U; i < READERS; i++) {
        start(&readers[i], read_all);
    }
    start(&commander, command_all);
    start(&scalar_commander, command_scalar);
    for (uint32_t round = 0U; (round < ROUNDS) || !have_all_taken_part(); round++) {
        uint8_t octets[WIRE_OCTETS];
        values_t seen;
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        parameter_lock(&dictionary);
        fill(&values, round); // The owner, in place.
        seen = command;
        parameter_unlock(&dictionary);
        TEST_ASSERT_TRUE((seen.first == seen.words[0]) && (seen.first == seen.words[1]) &&
                         (seen.last == (double)seen.first));
        TEST_ASSERT_EQUAL(STATUS_OK, parameter_read(&dictionary, VALUES, &writer));
        TEST_ASSERT_TRUE(is_whole(octets));
    }
    __atomic_store_n(&is_over, 1U, __ATOMIC_RELEASE);
    for (unsigned i = 0U; i < READERS; i++) {
        finish(&readers[i]);
    }
    finish(&commander);
    finish(&scalar_commander);
    TEST_ASSERT_EQUAL_UINT32(scalar_commander.rounds / 2U, dictionary.refusals.out_of_range);
    TEST_ASSERT_EQUAL_UINT32(0U, dictionary.refusals.unknown + dictionary.refusals.malformed);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_reader_reads_a_partly_written_structure);
    return UNITY_END();
}
