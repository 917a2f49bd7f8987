// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/scripts.h"

#include "fsw/framework/base/crc.h"
#include "unity.h"

#include <string.h>

scripts_t scripts;

static pus_procedure_t procedures[SCRIPT_PROCEDURES];
static pus_procedure_run_t runs[SCRIPT_SLOTS];
static uint8_t data[PUS_TC_DATA_MAX];

static status_t start(void* const context, const uint16_t slot, const char* const name,
                      const uint8_t* const code, const size_t size, const uint8_t* const arguments,
                      const size_t arguments_size, pus_call_t* const out_call)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    TEST_ASSERT_FALSE(scripts.slots[slot].is_running);
    TEST_ASSERT_TRUE((strlen(name) > 0U) && (code != NULL) && (size > 0U));
    TEST_ASSERT_TRUE(arguments_size <= sizeof scripts.arguments);
    memcpy(scripts.arguments, arguments, arguments_size);
    scripts.arguments_size = arguments_size;
    *out_call = (pus_call_t){.kind = PUS_CALL_FAILED, .number = 12U, .text = "no program at all"};
    scripts.slots[slot].is_running = scripts.start_status == STATUS_OK;
    scripts.slots[slot].next       = 0U;
    return scripts.start_status;
}

static void grant(void* const context, const uint16_t slot, const uint32_t budget)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    TEST_ASSERT_TRUE(scripts.slots[slot].is_running);
    scripts.slots[slot].budget += budget;
    scripts.slots[slot].last = budget;
}

static uint32_t used(void* const context, const uint16_t slot)
{
    (void)context;
    return scripts.slots[slot].uses;
}

static void run(void* const context, const uint16_t slot, const pus_answer_t* const answer,
                pus_call_t* const out_call)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    TEST_ASSERT_TRUE(scripts.slots[slot].is_running);
    scripts.slots[slot].answer = *answer;
    if (scripts.slots[slot].next == scripts.slots[slot].count) {
        *out_call = (pus_call_t){.kind = PUS_CALL_PAUSED, .text = ""};
        return;
    }
    *out_call = scripts.slots[slot].calls[scripts.slots[slot].next];
    scripts.slots[slot].next++;
    scripts.slots[slot].is_running =
        (out_call->kind != PUS_CALL_ENDED) && (out_call->kind != PUS_CALL_FAILED);
}

static void kill(void* const context, const uint16_t slot)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    TEST_ASSERT_TRUE(scripts.slots[slot].is_running);
    scripts.slots[slot].is_running = false;
}

static bool is_known(void* const context, const uint16_t event_id)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    return event_id == SCRIPT_KNOWN_EVENT;
}

static void raise_event(void* const context, const uint16_t event_id, const uint8_t* const auxiliary,
                        const size_t size, const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    (void)now_ns;
    scripts.events.count++;
    scripts.events.id   = event_id;
    scripts.events.size = size;
    memcpy(scripts.events.auxiliary, auxiliary, size);
}

static status_t read_value(void* const context, const uint32_t parameter_id, value_type_t* const out_type,
                           uint64_t* const out_bits)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    *out_type = VALUE_UINT16;
    *out_bits = 4711U;
    return (parameter_id == 77U) ? STATUS_OK : STATUS_NOT_FOUND;
}

static status_t read_named(void* const context, const char* const name, value_type_t* const out_type,
                           uint64_t* const out_bits)
{
    return (strcmp(name, "LEVEL") == 0) ? read_value(context, 77U, out_type, out_bits) : STATUS_NOT_FOUND;
}

static status_t take_request(void* const context, const uint8_t* const packet, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    if (scripts.sent.status == STATUS_OK) {
        pus_failure_t failure;
        scripts.sent.count++;
        memcpy(scripts.sent.packet, packet, size);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(scripts.sent.packet, size, &scripts.sent.last, &failure));
    }
    return scripts.sent.status;
}

static status_t open_file(void* const context, const pus_file_name_t* const name, uint32_t* const out_file,
                          uint32_t* const out_size)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    TEST_ASSERT_EQUAL_UINT16(2U, name->path_size);
    TEST_ASSERT_EQUAL_UINT16(3U, name->name_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("/p", name->path, 2U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("a.b", name->name, 3U);
    *out_file = 5U;
    *out_size = scripts.file.size;
    scripts.file.opened += (scripts.file.open == STATUS_OK) ? 1U : 0U;
    return scripts.file.open;
}

static status_t read_file(void* const context, const uint32_t file, const uint32_t offset,
                          uint8_t* const octets, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    TEST_ASSERT_EQUAL_UINT32(5U, file);
    TEST_ASSERT_EQUAL_UINT32(0U, offset);
    memset(octets, 'f', size);
    return scripts.file.read;
}

static status_t close_file(void* const context, const uint32_t file)
{
    TEST_ASSERT_EQUAL_PTR(&scripts, context);
    TEST_ASSERT_EQUAL_UINT32(5U, file);
    scripts.file.closed++;
    return STATUS_OK;
}

static void begin(void)
{
    static const pus_file_port_t files = {
        .context = &scripts, .open = open_file, .read = read_file, .close = close_file};
    const pus_port_t port                = {.context = &scripts, .send = take_request};
    const pus_procedures_config_t config = {
        .process             = &bench.process,
        .engine              = {&scripts, SCRIPT_SLOTS, start, grant, used, run, kill},
        .requester           = &scripts.requester,
        .telemetry           = {&scripts, read_value, read_named},
        .events              = {.context = &scripts, .is_known = is_known, .raise = raise_event},
        .files               = &files,
        .persistence         = records_port(),
        .procedures          = procedures,
        .runs                = runs,
        .capacity            = SCRIPT_PROCEDURES,
        .budget              = 100U,
        .calls               = SCRIPT_CALLS_EACH,
        .cycle_ns            = SCRIPT_CYCLE_NS,
        .verification_cycles = SCRIPT_TIMEOUT,
        .observation_event   = SCRIPT_OBSERVATION,
        .failure_event       = SCRIPT_FAILURE,
    };
    memset(&scripts, 0, sizeof scripts);
    memset(procedures, 0xA5, sizeof procedures);
    memset(runs, 0xA5, sizeof runs);
    bench_start();
    pus_requester_init(&scripts.requester, TEST_APID, &port);
    pus_procedures_init(&scripts.service, &config);
    bench_serve(pus_procedures_service(&scripts.service));
    pus_dispatcher_persist(&bench.dispatcher, records_port());
}

void scripts_start(void)
{
    records_start();
    begin();
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_procedures_restore(self, key, octets, size);
}

void scripts_restart(void)
{
    records_cut();
    begin();
    (void)records_replay(PUS_SERVICE_PROCEDURES, restore, &scripts.service);
}

void scripts_step(const unsigned cycles)
{
    bench_clear();
    for (unsigned i = 0U; i < cycles; i++) {
        scripts.cycle++;
        pus_dispatcher_step(&bench.dispatcher, scripts.cycle * SCRIPT_CYCLE_NS, scripts.cycle);
    }
}

status_t script_send(const uint8_t subtype, const char* const id, const void* const octets, const size_t size)
{
    char padded[PUS_NAME_SIZE] = {0};
    memcpy(padded, id, strlen(id));
    octet_writer_t writer = octet_writer(data, sizeof data);
    octet_write_octets(&writer, (const uint8_t*)padded, PUS_NAME_SIZE);
    if (size > 0U) {
        octet_write_octets(&writer, octets, size);
    }
    bench_clear();
    return bench_request(subtype, data, writer.position);
}

void script_loaded(const char* const id, const size_t size, const uint8_t fill)
{
    static uint8_t body[PUS_TC_DATA_MAX];
    octet_writer_t writer = octet_writer(body, sizeof body);
    octet_write_u16(&writer, (uint16_t)size);
    uint8_t* const code = octet_write_space(&writer, size);
    memset(code, fill, size);
    octet_write_u16(&writer, crc16_ccitt(code, size));
    TEST_ASSERT_EQUAL(STATUS_OK, script_send(1U, id, body, writer.position));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

void script_activated(const char* const id, const uint8_t level)
{
    const uint8_t octets[] = {level, 0};
    TEST_ASSERT_EQUAL(STATUS_OK, script_send(3U, id, octets, sizeof octets));
    EXPECT_MESSAGES(1, 1, 1, 3);
}

static pus_call_t* add(const uint16_t slot, const pus_call_kind_t kind)
{
    TEST_ASSERT_TRUE(scripts.slots[slot].count < SCRIPT_CALLS);
    pus_call_t* const call = &scripts.slots[slot].calls[scripts.slots[slot].count];
    scripts.slots[slot].count++;
    *call = (pus_call_t){.kind = kind, .text = "LEVEL"};
    return call;
}

void script_call(const uint16_t slot, const pus_call_kind_t kind, const uint32_t number)
{
    add(slot, kind)->number = number;
}

void script_wait(const uint16_t slot, const pus_call_kind_t kind, const double seconds)
{
    add(slot, kind)->seconds = seconds;
}

void script_request(const uint16_t slot, const bool does_wait)
{
    pus_call_t* const call = add(slot, PUS_CALL_SEND);
    call->apid             = 33U;
    call->service          = 17U;
    call->subtype          = 1U;
    call->does_wait        = does_wait;
    call->octets           = (const uint8_t*)"xyz";
    call->size             = does_wait ? 3U : 0U;
}

void expect_script_status(const uint8_t status)
{
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, NULL, 0U));
    EXPECT_MESSAGES(1, 1, 1, 3, 18, 9, 1, 7);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(1U, octet_read_u16(&reader));
    (void)octet_read_octets(&reader, PUS_NAME_SIZE + 2U);
    TEST_ASSERT_EQUAL_UINT8(status, octet_read_u8(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

void expect_observation(const uint16_t event, const char* const id, const uint8_t what, const uint16_t step,
                        const uint32_t detail)
{
    octet_reader_t reader = octet_reader(scripts.events.auxiliary, scripts.events.size);
    TEST_ASSERT_EQUAL_UINT16(event, scripts.events.id);
    TEST_ASSERT_EQUAL_UINT64(60U, scripts.events.size);
    TEST_ASSERT_EQUAL_STRING_LEN(id, octet_read_octets(&reader, PUS_NAME_SIZE), strlen(id));
    TEST_ASSERT_EQUAL_UINT8(what, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT16(step, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT32(detail, octet_read_u32(&reader));
}
