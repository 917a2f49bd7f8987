// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"

#include "base/octets.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture_lines.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define EPOCH_S 2000000000U

fixture_t fixture;
const uint32_t fixture_values_id = PARAMETER_ID(FIXTURE_APID, VALUE_STRUCT, 0U);
const uint32_t fixture_limit_id  = PARAMETER_ID(FIXTURE_APID, VALUE_DOUBLE, 1U);
const uint32_t fixture_count_id  = PARAMETER_ID(FIXTURE_APID, VALUE_UINT16, 2U);

static descriptor_loader_t loader;
static uint16_t next_number;

const char* fixture_descriptor(void)
{
    return "<?xml version='1.0' encoding='UTF-8'?>\n"
           "<Subsystem name='ROBOT' id='16' samplingTime='10ms'>\n"
           "<Resources poolWarning='75' poolClear='65'/>\n"
           "<States><State name='SOFTWARE_INIT' timeout='50ms'/><State name='HARDWARE_INIT' "
           "timeout='50ms'/>\n"
           "<State name='PRE_OPERATIONAL' timeout='50ms'/><State name='SAFE_OPERATIONAL' timeout='5ms'/>\n"
           "<State name='OPERATIONAL' timeout='5ms'/><State name='ERROR_OPERATIONAL' timeout='5ms'/>\n"
           "<State name='POST_OPERATIONAL' timeout='5ms'/><State name='HARDWARE_DEINIT' timeout='50ms'/>\n"
           "<State name='SOFTWARE_DEINIT' timeout='50ms'/></States>\n"
           "<Parameters><StructRef name='VALUES' id='0' type='STRUCT'><ParamRef name='STATE' type='INT32'/>\n"
           "<ParamRef name='POSITION' type='DOUBLE' count='2' init='1 2'/></StructRef>\n"
           "<ParamRef name='LIMIT' id='1' type='DOUBLE' init='5' min='0' max='10' settable='true'/>\n"
           "<ParamRef name='COUNT' id='2' type='UINT16'/></Parameters>\n"
           "<Events><Event name='BROKEN' id='1' severity='HIGH'><ParamRef name='CODE' "
           "type='UINT16'/></Event>\n"
           "<Event name='STRAINED' id='2' severity='MEDIUM'/>\n"
           "<Event name='NOTE' id='3' severity='LOW'><ParamRef name='LIMIT'/></Event>\n"
           "<Event name='INFO' id='4' severity='INFORMATIVE'/><Event name='POOL_WARNING' id='5' "
           "severity='LOW'/>\n"
           "<Event name='LINK_STALE' id='6' severity='HIGH'/><Event name='STATE_TIMEOUT' id='10' "
           "severity='HIGH'/>\n"
           "<Event name='LINK_CLOSED' id='11' severity='LOW'/>\n"
           "<Event name='NETWORK_FAILED' id='12' severity='INFORMATIVE'/></Events>\n"
           "<Functions><Function name='MOVE' id='1' states='OPERATIONAL' configurations='ALONE'>\n"
           "<Argument name='TARGET' id='1' type='DOUBLE' count='2' min='-1' max='1'/>\n"
           "<Argument name='SPEED' id='2' type='UINT16' max='100'/></Function>\n"
           "<Function name='WAIT' id='2' states='HARDWARE_INIT PRE_OPERATIONAL SAFE_OPERATIONAL "
           "OPERATIONAL'/>\n"
           "</Functions>\n"
           "<Configuration name='ALONE' id='1' priority='10' samplingTime='1ms'>\n"
           "<Initial parameter='LIMIT' value='7'/>\n"
           "<HKService id='100' interval='10'><SampledOnce><ParamRef name='VALUES'/></SampledOnce>\n"
           "<SampledNREPTimes nrep='5'><ParamRef name='COUNT'/></SampledNREPTimes></HKService>\n"
           "</Configuration>\n"
           "<Configuration name='LINKED' id='2' priority='7' samplingTime='1ms'><RTLinkService>\n"
           "<Provides name='OUT' id='1' methods='SHARED_MEMORY UDP'><ParamRef name='A' "
           "type='DOUBLE'/></Provides>\n"
           "<Requires name='IN' id='2' methods='SHARED_MEMORY UDP' required='true' staleAfter='4ms'>\n"
           "<ParamRef name='B' type='DOUBLE' count='2'/></Requires>\n"
           "<Requires name='EXTRA' id='3' methods='SHARED_MEMORY' required='false' staleAfter='4ms'>\n"
           "<ParamRef name='C' type='UINT32'/></Requires>\n"
           "</RTLinkService></Configuration></Subsystem>\n";
}

// ---- Callbacks ----

static status_t act(state_action_t action, const char* name)
{
    if (fixture.shows_actions) {
        fixture_line("* %s", name);
    }
    if (fixture.in_action != NULL) {
        fixture.in_action(action);
    }
    if (fixture.delays[action] > 0U) {
        fixture.delays[action]--;
        return STATUS_BUSY;
    }
    return fixture.results[action];
}

static status_t software_init(void* self)
{
    static const parameter_field_t fields[] = {
        {"STATE", VALUE_INT32, 1U, 0U},
        {"POSITION", VALUE_DOUBLE, 2U, 8U},
        {"LIMIT", VALUE_DOUBLE, 1U, 0U},
        {"COUNT", VALUE_UINT16, 1U, 0U},
    };
    static const parameter_definition_t definitions[] = {
        {"VALUES", PARAMETER_ID(FIXTURE_APID, VALUE_STRUCT, 0U), &fields[0], 2U, 24U, 20U},
        {"LIMIT", PARAMETER_ID(FIXTURE_APID, VALUE_DOUBLE, 1U), &fields[2], 1U, 8U, 8U},
        {"COUNT", PARAMETER_ID(FIXTURE_APID, VALUE_UINT16, 2U), &fields[3], 1U, 2U, 2U},
    };
    (void)self;
    void* const storage[] = {&fixture.values, &fixture.limit, &fixture.count};
    const status_t first  = act(ACTION_SOFTWARE_INIT, "software_init");
    for (unsigned i = 0U; (i < 3U) && (first == STATUS_OK); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, subsystem_publish(&fixture.subsystem, &definitions[i], storage[i]));
    }
    return first;
}

static status_t configure(void* self, const descriptor_configuration_t* configuration)
{
    (void)self;
    TEST_ASSERT_TRUE(configuration == subsystem_configuration(&fixture.subsystem));
    return act(ACTION_CONFIGURE, "configure");
}

#define CALLBACK(name, action)                                                                               \
    static status_t name(void* self)                                                                         \
    {                                                                                                        \
        (void)self;                                                                                          \
        return act(action, #name);                                                                           \
    }
CALLBACK(hardware_init, ACTION_HARDWARE_INIT)
CALLBACK(start_control, ACTION_START_CONTROL)
CALLBACK(stop_control, ACTION_STOP_CONTROL)
CALLBACK(engage, ACTION_ENGAGE)
CALLBACK(disengage, ACTION_DISENGAGE)
CALLBACK(secure, ACTION_SECURE)
CALLBACK(post, ACTION_POST)
CALLBACK(hardware_deinit, ACTION_HARDWARE_DEINIT)
CALLBACK(software_deinit, ACTION_SOFTWARE_DEINIT)

static void cycle_part(const char* name, void (*hook)(void))
{
    if (fixture.shows_cycle) {
        fixture_line("* %s", name);
    }
    if (hook != NULL) {
        hook();
    }
}

static void sense(void* self)
{
    (void)self;
    cycle_part("sense", fixture.in_sense);
}

static void control(void* self)
{
    (void)self;
    cycle_part("control", fixture.in_control);
}

static void emit(void* self)
{
    (void)self;
    cycle_part("emit", NULL);
}

static status_t perform(void* self, const subsystem_function_t* function)
{
    (void)self;
    fixture.last_call_token = function->call_token;
    if (function->function_id == 1U) {
        (void)memcpy(&fixture.moved, function->arguments, sizeof fixture.moved);
    }
    return (fixture.in_perform != NULL) ? fixture.in_perform(function) : STATUS_OK;
}

static void parameter_set(void* self, uint32_t parameter_id)
{
    (void)self;
    fixture.set_id = parameter_id;
}

static void release(void* self)
{
    (void)self;
    fixture.releases++;
}

static const subsystem_callbacks_t callbacks = {
    software_init,   hardware_init, configure, start_control, stop_control,
    engage,          disengage,     secure,    post,          hardware_deinit,
    software_deinit, sense,         control,   emit,          perform,
    parameter_set,   NULL,          NULL,      NULL,          NULL,
    release,         NULL};

// ---- Ports ----

static status_t send(void* context, const uint8_t* packet, size_t size)
{
    (void)context;
    if (fixture.is_port_closed) {
        return STATUS_FULL;
    }
    fixture_line_of_report(packet, size);
    return STATUS_OK;
}

static bool shm_name(void* context, uint16_t link, char* out_name, size_t capacity)
{
    (void)context;
    return snprintf(out_name, capacity, "/hirosco-fixture.%ld.%u", (long)getpid(), link) < (int)capacity;
}

static bool no_route(void* context, uint16_t link, osal_socket_t** out_socket, osal_address_t* out_consumer)
{
    (void)context;
    (void)link;
    (void)out_socket;
    (void)out_consumer;
    return false;
}

static const rtlink_resolver_t resolver = {.shm_name = shm_name, .udp_route = no_route};

const rtlink_resolver_t* fixture_links(void)
{
    return &resolver;
}

static status_t reload(void* context, const subsystem_descriptor_t** out_descriptor)
{
    (void)context;
    *out_descriptor = fixture.next_descriptor;
    return (fixture.next_descriptor != NULL) ? STATUS_OK : STATUS_INVALID;
}

// ---- Life ----

bool fixture_parse(const char* xml, subsystem_descriptor_t* out_descriptor)
{
    descriptor_loader_init(&loader);
    const status_t status =
        descriptor_parse_subsystem(&loader, "fixture.xml", xml, strlen(xml), out_descriptor);
    if (status != STATUS_OK) {
        (void)printf("%s\n", descriptor_error(&loader));
    }
    return status == STATUS_OK;
}

void fixture_begin(const subsystem_config_t* config)
{
    subsystem_init(&fixture.subsystem, config);
    fixture.next_sequence = 0U;
    fixture_forget();
}

static void begin(bool is_valid)
{
    const subsystem_config_t config = {.descriptor            = &fixture.descriptor,
                                       .is_descriptor_valid   = is_valid,
                                       .callbacks             = &callbacks,
                                       .self                  = &fixture,
                                       .mission_epoch_s       = EPOCH_S,
                                       .start_count           = 3U,
                                       .port                  = {&fixture, send},
                                       .links                 = &resolver,
                                       .link_methods          = 1U << RTLINK_METHOD_SHARED_MEMORY,
                                       .supervisor_timeout_ns = 3000000000U,
                                       .status_interval_ns    = SUBSYSTEM_STATUS_INTERVAL_NS,
                                       .reload                = reload};
    fixture_begin(&config);
}

static void clear(void)
{
    (void)memset(&fixture, 0, sizeof fixture);
    fixture.source = FIXTURE_USER;
    fixture.ack    = PUS_ACK_ALL;
    next_number    = 0U;
    fixture_forget_ends();
}

void fixture_open(const char* xml)
{
    clear();
    TEST_ASSERT_TRUE(fixture_parse((xml != NULL) ? xml : fixture_descriptor(), &fixture.descriptor));
    begin(true);
}

void fixture_open_with(const char* old, const char* with)
{
    static char xml[16384];
    const char* from = fixture_descriptor();
    size_t used      = 0U;
    for (const char* at = strstr(from, old); at != NULL; at = strstr(from, old)) {
        TEST_ASSERT_TRUE((used + (size_t)(at - from) + strlen(with) + strlen(at)) < sizeof xml);
        (void)memcpy(&xml[used], from, (size_t)(at - from));
        used += (size_t)(at - from);
        (void)memcpy(&xml[used], with, strlen(with));
        used += strlen(with);
        from = &at[strlen(old)];
    }
    (void)memcpy(&xml[used], from, strlen(from) + 1U);
    TEST_ASSERT_TRUE(used > 0U);
    fixture_close();
    fixture_open(xml);
}

void fixture_open_invalid(void)
{
    clear();
    fixture.descriptor.apid = FIXTURE_APID;
    fixture.descriptor.name = "ROBOT";
    begin(false);
}

void fixture_close(void)
{
    for (unsigned i = 0U; i < SUBSYSTEM_LINKS; i++) { // Leave no shared memory behind.
        rtlink_producer_close(&fixture.subsystem.links[i].producer);
        rtlink_consumer_close(&fixture.subsystem.links[i].consumer);
    }
}

// ---- Input ----

void fixture_accept(const uint8_t* octets, size_t size)
{
    subsystem_accept(&fixture.subsystem, octets, size, fixture.now_ns);
}

uint16_t fixture_command(uint8_t service, uint8_t subtype, const void* data, size_t size)
{
    uint8_t packet[PUS_PACKET_MAX];
    size_t packet_size = 0U;
    const pus_tc_t tc  = {.apid     = FIXTURE_APID,
                          .sequence = next_number,
                          .ack      = fixture.ack,
                          .service  = service,
                          .subtype  = subtype,
                          .source   = fixture.source,
                          .data     = data,
                          .size     = size};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, sizeof packet, &packet_size));
    fixture_sent(next_number);
    fixture_accept(packet, packet_size);
    return next_number++;
}

uint16_t fixture_state(state_t target)
{
    const uint8_t data[1] = {(uint8_t)target};
    return fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REQUEST_STATE, data, sizeof data);
}

uint16_t fixture_order(state_t target, state_cause_t cause)
{
    const uint8_t data[2] = {(uint8_t)target, (uint8_t)cause};
    return fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_ORDER_STATE, data, sizeof data);
}

uint16_t fixture_select(uint16_t configuration)
{
    const uint8_t data[2] = {(uint8_t)(configuration >> 8U), (uint8_t)configuration};
    return fixture_command(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_SELECT, data, sizeof data);
}

uint16_t fixture_function(const char* name, const void* arguments, size_t size)
{
    uint8_t data[256] = {0U};
    (void)memcpy(data, name, strlen(name));
    if (size > 0U) {
        (void)memcpy(&data[PUS_NAME_SIZE], arguments, size);
    }
    return fixture_command(PUS_SERVICE_FUNCTIONS, 1U, data, PUS_NAME_SIZE + ((size > 0U) ? size : 1U));
}

void fixture_heartbeat(void)
{
    uint8_t packet[64];
    size_t size       = 0U;
    const pus_tm_t tm = {.apid = 1U, .service = 129U, .subtype = 5U};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_encode(&tm, packet, sizeof packet, &size));
    fixture_accept(packet, size);
}

// ---- Time ----

static void step_until(uint64_t end_ns, bool has_heartbeat)
{
    uint64_t beat_ns = fixture.now_ns;
    while (fixture.now_ns <= end_ns) {
        if (has_heartbeat && (fixture.now_ns >= beat_ns)) {
            fixture_heartbeat();
            beat_ns = fixture.now_ns + 500000000U;
        }
        const uint64_t wake_ns = subsystem_step(&fixture.subsystem, fixture.now_ns);
        TEST_ASSERT_TRUE_MESSAGE(wake_ns > fixture.now_ns, "the next wake is in the past");
        if (wake_ns > end_ns) {
            return;
        }
        fixture.now_ns = wake_ns;
    }
}

void fixture_run(unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        (void)subsystem_step(&fixture.subsystem, fixture.now_ns);
        fixture.now_ns += subsystem_period_ns(&fixture.subsystem);
    }
}

void fixture_run_until(uint64_t end_ns)
{
    step_until(end_ns, true);
    fixture.now_ns = end_ns;
}

void fixture_bring(state_t state, uint16_t configuration)
{
    static const state_t way[] = {STATE_PRE_OPERATIONAL, STATE_SAFE_OPERATIONAL, STATE_OPERATIONAL};
    for (unsigned i = 0U; (i < 3U) && (way[i] <= state); i++) {
        (void)fixture_state(way[i]);
        fixture_run(6U);
        TEST_ASSERT_EQUAL(way[i], subsystem_state(&fixture.subsystem));
        if ((way[i] == STATE_PRE_OPERATIONAL) && (configuration != 0U)) {
            (void)fixture_select(configuration);
            fixture_run(2U);
            TEST_ASSERT_EQUAL(PHASE_CONFIGURED, fixture.subsystem.machine.phase);
        }
        if (way[i] == state) {
            break;
        }
    }
    if (state == STATE_ERROR_OPERATIONAL) {
        (void)fixture_state(state);
        fixture_run(2U);
    }
    TEST_ASSERT_EQUAL(state, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_EQUAL(ACTION_NONE, fixture.subsystem.machine.action);
    fixture_forget();
    next_number = 0U;
}
