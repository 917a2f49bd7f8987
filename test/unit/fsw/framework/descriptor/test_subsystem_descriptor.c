// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t arm;

void setUp(void)
{
    descriptor_loader_init(&loader);
}

void tearDown(void)
{
}

static status_t load(const char* const document)
{
    return descriptor_parse_subsystem(&loader, "arm.xml", document, strlen(document), &arm);
}

static void load_valid(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(arm_document));
    TEST_ASSERT_EQUAL_STRING("", descriptor_error(&loader));
}

static void identity_resources_and_times_are_read(void)
{
    load_valid();
    TEST_ASSERT_EQUAL_STRING("ARM", arm.name);
    TEST_ASSERT_EQUAL_UINT16(16U, arm.apid);
    TEST_ASSERT_EQUAL_UINT32(5000U, arm.sampling_us);
    TEST_ASSERT_FALSE(arm.is_sync_first);
    TEST_ASSERT_EQUAL_UINT8(80U, arm.pool_warn_percent);
    TEST_ASSERT_EQUAL_UINT8(70U, arm.pool_clear_percent);
    TEST_ASSERT_EQUAL_UINT32(2000000U, arm.timeout_us[2]);
    TEST_ASSERT_EQUAL_UINT32(1000000U, arm.timeout_us[0]); // The default, if the descriptor has none.
    static const char resources[] = "<Resources poolWarning='80' poolClear='70'/>";
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, resources, "")));
    TEST_ASSERT_EQUAL_UINT8(75U, arm.pool_warn_percent); // The default levels.
    TEST_ASSERT_EQUAL_UINT8(65U, arm.pool_clear_percent);
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, "id='16'", "id='16' sync='BEFORE_COMMANDS'")));
    TEST_ASSERT_TRUE(arm.is_sync_first);
}

typedef struct {
    int32_t state;
    double position[2];
    bool flag;
} cur_values_t;

typedef struct {
    bool fast;
    double position[2];
} move_to_t;

typedef struct {
    uint8_t kind;
    double position[2];
} hand_payload_t;

static void parameters_are_read_with_ids_and_layouts(void)
{
    load_valid();
    const descriptor_parameter_t* const values = descriptor_find_parameter(&arm, "CUR_VALUES");
    TEST_ASSERT_NOT_NULL(values);
    TEST_ASSERT_EQUAL_HEX32((16U << 21U) | (24U << 16U), values->id);
    TEST_ASSERT_TRUE(values->is_struct);
    TEST_ASSERT_FALSE(values->is_settable);
    TEST_ASSERT_EQUAL_UINT16(3U, values->field_count);
    TEST_ASSERT_EQUAL_UINT32(21U, values->wire_size);
    TEST_ASSERT_EQUAL_UINT32(sizeof(cur_values_t), values->memory_size);
    const descriptor_field_t* const position = &arm.fields[values->first_field + 1U];
    TEST_ASSERT_EQUAL_STRING("POSITION", position->name);
    TEST_ASSERT_EQUAL_STRING("rad", position->unit);
    TEST_ASSERT_EQUAL_STRING("0.5 -1", position->init);
    TEST_ASSERT_EQUAL_UINT32(offsetof(cur_values_t, position), position->offset);
    TEST_ASSERT_EQUAL_UINT32(offsetof(cur_values_t, flag), arm.fields[values->first_field + 2U].offset);
    const descriptor_parameter_t* const target = descriptor_find_parameter(&arm, "TARGET");
    TEST_ASSERT_EQUAL_HEX32((16U << 21U) | (25U << 16U) | 1U, target->id);
    TEST_ASSERT_TRUE(target->is_settable);
    TEST_ASSERT_EQUAL_DOUBLE(-1.5, arm.fields[target->first_field].min);
    TEST_ASSERT_NULL(arm.fields[target->first_field].init);
    const descriptor_parameter_t* const count = descriptor_find_parameter(&arm, "COUNT");
    // The same number, but another layout.
    TEST_ASSERT_EQUAL_HEX32((16U << 21U) | (2U << 16U) | 1U, count->id);
    TEST_ASSERT_EQUAL_DOUBLE(DBL_MAX, arm.fields[count->first_field].max);
    TEST_ASSERT_NULL(descriptor_find_parameter(&arm, "POSITION"));
}

static void events_of_both_kinds_are_read(void)
{
    load_valid();
    const descriptor_event_t* const limit = descriptor_find_event(&arm, 3U);
    TEST_ASSERT_EQUAL_STRING("LIMIT", limit->name);
    TEST_ASSERT_EQUAL(DESCRIPTOR_MEDIUM, limit->severity);
    TEST_ASSERT_EQUAL_UINT16(2U, limit->field_count);
    TEST_ASSERT_EQUAL_UINT16(0U, limit->reference_count);
    TEST_ASSERT_EQUAL_UINT32(9U, limit->octets);
    const descriptor_event_t* const note = descriptor_find_event_name(&arm, "NOTE");
    TEST_ASSERT_EQUAL_UINT16(2U, note->reference_count);
    TEST_ASSERT_EQUAL_STRING("COUNT", arm.parameters[arm.references[note->first_reference + 1U]].name);
    TEST_ASSERT_EQUAL_UINT32(25U, note->octets);
    TEST_ASSERT_EQUAL_UINT32(0U, descriptor_find_event(&arm, 1U)->octets);
    TEST_ASSERT_NULL(descriptor_find_event(&arm, 4U));
}

static const descriptor_function_t* function_of(const char* name)
{
    return descriptor_named(arm.functions, arm.function_count, sizeof arm.functions[0], name);
}

static void functions_are_read(void)
{
    load_valid();
    const descriptor_function_t* const move_to = function_of("MOVE_TO");
    TEST_ASSERT_EQUAL_UINT16(1U, move_to->id);
    TEST_ASSERT_EQUAL_HEX16(1U << 5U, move_to->states);
    TEST_ASSERT_EQUAL_HEX16(1U, move_to->configurations);
    TEST_ASSERT_EQUAL_UINT16(2U, move_to->argument_count);
    TEST_ASSERT_EQUAL_UINT16(7U, arm.fields[move_to->first_argument].id);
    TEST_ASSERT_EQUAL_UINT32(offsetof(move_to_t, position), arm.fields[move_to->first_argument + 1U].offset);
    TEST_ASSERT_EQUAL_UINT32(sizeof(move_to_t), move_to->memory_size);
    const descriptor_function_t* const stop = function_of("STOP");
    TEST_ASSERT_EQUAL_HEX16(0x3FFU, stop->states);
    TEST_ASSERT_EQUAL_HEX16(3U, stop->configurations);
    TEST_ASSERT_EQUAL_UINT32(0U, stop->memory_size);
    TEST_ASSERT_NULL(function_of("MOVE_T"));
}

static void housekeeping_of_a_configuration_is_read(void)
{
    load_valid();
    const descriptor_configuration_t* const alone = descriptor_find_configuration(&arm, 1U);
    TEST_ASSERT_EQUAL_UINT32(1000U, alone->sampling_us);
    TEST_ASSERT_EQUAL_UINT8(80U, alone->priority);
    TEST_ASSERT_EQUAL_UINT16(2U, alone->structure_count);
    TEST_ASSERT_NULL(descriptor_find_configuration(&arm, 3U));
    const descriptor_structure_t* const paper = &arm.structures[alone->first_structure];
    TEST_ASSERT_EQUAL_UINT16(4711U, paper->id);
    TEST_ASSERT_EQUAL_UINT32(500U, paper->interval_cycles);
    TEST_ASSERT_TRUE(paper->is_enabled);
    TEST_ASSERT_EQUAL_UINT32(21U + (5U * 16U), paper->octets);
    TEST_ASSERT_EQUAL_STRING("CUR_VALUES", arm.parameters[arm.references[paper->first_reference]].name);
    const descriptor_sampled_t* const sampled = &arm.sampled[paper->first_sampled];
    TEST_ASSERT_EQUAL_UINT16(5U, sampled->nrep);
    TEST_ASSERT_EQUAL_STRING("TARGET", arm.parameters[arm.references[sampled->first_reference]].name);
    TEST_ASSERT_FALSE(arm.structures[alone->first_structure + 1U].is_enabled);
    TEST_ASSERT_EQUAL_UINT16(2U, alone->initial_count);
    TEST_ASSERT_EQUAL_STRING("1 2", arm.initials[alone->first_initial].text);
    TEST_ASSERT_EQUAL_STRING("POSITION", arm.fields[arm.initials[alone->first_initial].field].name);
}

static const descriptor_device_t* device_of(const descriptor_configuration_t* configuration, const char* name)
{
    return descriptor_named(&arm.devices[configuration->first_device], configuration->device_count,
                            sizeof arm.devices[0], name);
}

static void ports_and_devices_of_a_configuration_are_read(void)
{
    static const char layout[] = "KIND:UINT8:1\nPOSITION:DOUBLE:2\n";
    load_valid();
    const descriptor_configuration_t* const coupled = descriptor_find_configuration(&arm, 2U);
    const descriptor_port_t* const hand             = descriptor_find_port(&arm, coupled, 2U);
    TEST_ASSERT_FALSE(hand->is_provided);
    TEST_ASSERT_TRUE(hand->is_required);
    TEST_ASSERT_EQUAL_HEX32(crc32_iso((const uint8_t*)layout, sizeof layout - 1U), hand->layout_hash);
    TEST_ASSERT_EQUAL_UINT32(17U, hand->octets);
    TEST_ASSERT_EQUAL_UINT32(sizeof(hand_payload_t), hand->memory_size);
    TEST_ASSERT_EQUAL_UINT32(offsetof(hand_payload_t, position), arm.fields[hand->first_field + 1U].offset);
    TEST_ASSERT_EQUAL_UINT32(3000U, hand->stale_us);
    TEST_ASSERT_EQUAL_UINT8(1U, hand->method_count);
    const descriptor_port_t* const state = descriptor_find_port(&arm, coupled, 1U);
    TEST_ASSERT_TRUE(state->is_provided);
    TEST_ASSERT_EQUAL_UINT8(DESCRIPTOR_SHARED_MEMORY, state->methods[0]);
    TEST_ASSERT_EQUAL_UINT8(DESCRIPTOR_UDP, state->methods[1]);
    TEST_ASSERT_EQUAL_UINT32(500U, state->period_us);
    TEST_ASSERT_NULL(descriptor_find_port(&arm, descriptor_find_configuration(&arm, 1U), 1U));
    const descriptor_device_t* const joint = device_of(coupled, "JOINT1");
    TEST_ASSERT_EQUAL_UINT16(2U, joint->setting_count);
    TEST_ASSERT_EQUAL_HEX16(0x6060U, arm.settings[joint->first_setting].index);
    TEST_ASSERT_EQUAL_HEX64(0xF8U, arm.settings[joint->first_setting].bits);
    TEST_ASSERT_EQUAL_HEX8(0x0AU, arm.settings[joint->first_setting + 1U].subindex);
    TEST_ASSERT_EQUAL_HEX64(0x60400010U, arm.settings[joint->first_setting + 1U].bits);
    TEST_ASSERT_EQUAL_STRING("robot", arm.endnodes[joint->first_endnode].bus);
    TEST_ASSERT_EQUAL_HEX8(0x11U, arm.endnodes[joint->first_endnode].node);
    TEST_ASSERT_EQUAL_UINT16(10015U, arm.endnodes[device_of(coupled, "GROUND")->first_endnode].port);
    const descriptor_endnode_t* const ground = &arm.endnodes[device_of(coupled, "GROUND")->first_endnode];
    TEST_ASSERT_EQUAL(FLOW_FRAMING_LENGTH, ground[0].format.framing);
    TEST_ASSERT_EQUAL(FLOW_ORDER_LITTLE, ground[0].format.order);
    TEST_ASSERT_EQUAL_UINT32(0U, ground[0].format.baud);
    TEST_ASSERT_EQUAL(DESCRIPTOR_ENDNODE_SERIAL, ground[1].type);
    TEST_ASSERT_EQUAL(FLOW_FRAMING_SLIP, ground[1].format.framing);
    TEST_ASSERT_EQUAL(FLOW_ORDER_BIG, ground[1].format.order);
    TEST_ASSERT_EQUAL_UINT32(19200U, ground[1].format.baud);
    TEST_ASSERT_EQUAL(DESCRIPTOR_ENDNODE_FILE, ground[2].type);
    TEST_ASSERT_EQUAL(FLOW_FRAMING_RAW, ground[2].format.framing);
    TEST_ASSERT_EQUAL(FLOW_DIRECTION_READ, ground[2].format.direction);
    TEST_ASSERT_NULL(device_of(coupled, "JOINT2"));
}

static void quantities_of_a_device_are_read(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK,
                      load(damaged(arm_document, "<Endnode type='CAN' bus='robot'",
                                   "<Quantity name='Q' id='3' object='0x2210:0B' type='INT16' scale='-0.5'/>"
                                   "<Endnode type='CAN' bus='robot'")));
    TEST_ASSERT_EQUAL_UINT16(1U, arm.quantity_count);
    TEST_ASSERT_EQUAL_HEX16(0x2210U, arm.quantities[0].index);
    TEST_ASSERT_EQUAL_HEX8(0x0BU, arm.quantities[0].subindex);
    TEST_ASSERT_TRUE(arm.quantities[0].scale == -0.5);
}

static void records_of_a_device_and_times_of_its_end_node_are_read(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(arm_document));
    const descriptor_device_t* const device = device_of(descriptor_find_configuration(&arm, 2U), "GROUND");
    const descriptor_endnode_t* const file  = &arm.endnodes[device->first_endnode + 2U];
    TEST_ASSERT_EQUAL_UINT16(2U, device->record_field_count);
    const descriptor_record_field_t* const fields = &arm.record_fields[device->first_record_field];
    TEST_ASSERT_EQUAL_STRING("RATE", fields[0].name);
    TEST_ASSERT_EQUAL_STRING("1/s", fields[0].unit);
    TEST_ASSERT_FALSE(fields[0].is_out);
    TEST_ASSERT_EQUAL(VALUE_INT16, fields[0].type);
    TEST_ASSERT_TRUE((fields[0].scale == -1e-3) && (fields[0].offset == 2.0));
    TEST_ASSERT_TRUE(fields[1].is_out);
    TEST_ASSERT_TRUE((fields[1].scale == 1.0) && (fields[1].offset == 0.0) && (fields[1].safe == 1.0));
    TEST_ASSERT_EQUAL_UINT32(3000U, file->silence_us);
    TEST_ASSERT_EQUAL_UINT32(10000U, file->retry_us);
    TEST_ASSERT_EQUAL_UINT32(1000000U, file->longest_us);
    TEST_ASSERT_FALSE(file->has_checksum);
}

static void each_bit_rate_of_a_serial_line_is_read(void)
{
    static const uint32_t rates[] = {9600U, 19200U, 38400U, 57600U, 115200U, 230400U, 460800U, 921600U};
    for (size_t i = 0U; i < (sizeof rates / sizeof rates[0]); i++) {
        char baud[24];
        (void)snprintf(baud, sizeof baud, "baud='%u'", (unsigned)rates[i]);
        TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, "baud='19200'", baud)));
        const descriptor_configuration_t* const coupled = descriptor_find_configuration(&arm, 2U);
        TEST_ASSERT_EQUAL_UINT32(rates[i],
                                 arm.endnodes[device_of(coupled, "GROUND")->first_endnode + 1U].format.baud);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, "baud='19200'", "")));
    const descriptor_configuration_t* const coupled = descriptor_find_configuration(&arm, 2U);
    TEST_ASSERT_EQUAL_UINT32(115200U,
                             arm.endnodes[device_of(coupled, "GROUND")->first_endnode + 1U].format.baud);
}

#define SERVICES(name, services)                                                                             \
    "<Loop name='" name "' samplingTime='10ms' priority='20' services='" services "'/>"
#define LOOP(name) "<Loop name='" name "' samplingTime='10ms' priority='20'/>"

static void loops_of_a_configuration_are_read(void)
{
    const char* const with =
        LOOP("FAST") "<Loop name='SLOW' samplingTime='2s' priority='7' services='20 17'/>"
                     "<HKService loop='SLOW' id='4712'";
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(arm_document, "<HKService id='4712'", with)));
    const descriptor_configuration_t* const alone = descriptor_find_configuration(&arm, 1U);
    TEST_ASSERT_EQUAL_UINT16(2U, alone->loop_count);
    const descriptor_loop_t* const slow = &arm.loops[alone->first_loop + 1U];
    TEST_ASSERT_EQUAL_STRING("SLOW", slow->name);
    TEST_ASSERT_EQUAL_UINT32(2000000U, slow->sampling_us);
    TEST_ASSERT_EQUAL_UINT8(7U, slow->priority);
    TEST_ASSERT_EQUAL_HEX8(DESCRIPTOR_LOOP_TEST | DESCRIPTOR_LOOP_PARAMETERS, slow->services);
    TEST_ASSERT_EQUAL_HEX8(0U, arm.loops[alone->first_loop].services);
    TEST_ASSERT_EQUAL_UINT8(0U, arm.structures[alone->first_structure].loop);
    TEST_ASSERT_EQUAL_UINT8(2U, arm.structures[alone->first_structure + 1U].loop);
    TEST_ASSERT_EQUAL_UINT16(0U, descriptor_find_configuration(&arm, 2U)->loop_count);
    const uint64_t interface_hash = arm.interface_hash;
    load_valid();
    // Loops belong to the configuration, not to the interface.
    TEST_ASSERT_TRUE(arm.interface_hash == interface_hash);
    const char* const many = LOOP("A") LOOP("B") LOOP("C") "<HKService id='4712'";
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, load(damaged(arm_document, "<HKService id='4712'", many)));
    TEST_ASSERT_NOT_NULL(
        strstr(descriptor_error(&loader), "too many <Loop> in one configuration, at most 2"));
}

typedef struct {
    const char* find;
    const char* replacement;
    unsigned line;
    const char* reason; ///< Part of the expected message.
} damage_t;

static const damage_t damages[] = {
    // Structure: where each element may occur, and its attributes.
    {"<Subsystem ", "<Mission ", 1U, "<Mission>: expected <Subsystem>"},
    {"<Parameters>", "<Parameter>", 4U,
     "<Parameter> in <Subsystem>: expected <Resources> or <States> or <Enumerations> or <Failures> or "},
    {"<State name", "<Mode name", 3U, "<Mode> in <States>: expected <State>"},
    {"<Event name='LOST' id='1' severity='HIGH'/>", "<ParamRef name='A'/>", 14U, "<ParamRef> in <Events>"},
    {" poolClear='70'", " clear='70'", 2U,
     "attribute clear of <Resources>: expected one of poolWarning poolClear"},
    {" samplingTime='500us'", "", 35U, "<Configuration> needs attribute samplingTime"},
    {"</Events>", "</Events><Events/>", 19U, "a second <Events>: expected one"},
    {"<SampledNREPTimes nrep='5'>",
     "<SampledOnce><ParamRef name='COUNT'/></SampledOnce><SampledNREPTimes nrep='5'>", 31U,
     "a second <SampledOnce>"},
    // Names and numbers.
    {"name='ARM'", "name='Arm'", 1U, "name=\"Arm\" of <Subsystem>: expected an upper-case identifier ("},
    {"name='ARM'", "name='A2345678901234567890123456789012X'", 1U, "at most 32"},
    {"name='MOVE_TO'", "name='MOVE_THERE'", 21U, "at most 8"},
    {"id='16'", "id='0'", 1U, "a number from 1 to 2046"},
    {"id='16'", "id='2047'", 1U, "a number from 1 to 2046"},
    {"id='16'", "id='18446744073709551616'", 1U, "a number from 1 to 2046"},
    {"id='16'", "id='16 '", 1U, "a number"},
    {"id='16'", "id='-16'", 1U, "a number"},
    {"priority='80'", "priority='100'", 26U, "a number from 1 to 99"},
    {"samplingTime='1ms'", "samplingTime='1'", 26U, "a time like 500us, 2ms or 1s"},
    {"samplingTime='1ms'", "samplingTime='99us'", 26U, "from 100us"},
    {"samplingTime='1ms'", "samplingTime='9999999999s'", 26U, "a time"},
    {"timeout='2s'", "timeout='2 s'", 3U, "a time"},
    {"id='16'", "id='16' sync='FIRST'", 1U,
     "sync=\"FIRST\" of <Subsystem>: expected one of AFTER_COMMANDS BEFORE_COMMANDS"},
    {"poolClear='70'", "poolClear='80'", 2U, "expected poolClear < poolWarning"},
    {"<States>", "<States count='1'>", 3U, "attribute count of <States>: expected none"},
    {"<State name='HARDWARE_INIT'", "<State name='HARDWARE'", 3U, "the name of a state"},
    {"<State name='HARDWARE_INIT' timeout='2s'/>",
     "<State name='HARDWARE_INIT' timeout='2s'/><State name='HARDWARE_INIT' timeout='2s'/>", 3U, "already"},
    // Parameters.
    {"name='STATE' id='0'", "name='POSITION' id='0'", 7U, "name POSITION is taken in line 6"},
    {"name='COUNT' id='1'", "name='TARGET' id='1'", 11U, "name TARGET is taken in line 10"},
    {"name='COUNT' id='1' type='UINT32'", "name='COUNT' id='1' type='DOUBLE' count='2'", 11U,
     "layout and id of COUNT are those of TARGET in line 10"},
    {"type='INT32'", "type='INTEGER'", 6U, "UINT8..UINT64"},
    {"type='STRUCT'", "type='DOUBLE'", 5U, "one of STRUCT"},
    {"count='2' unit='rad' init", "count='257' unit='rad' init", 7U, "a number from 1 to 256"},
    {"init='0.5 -1'", "init='0.5'", 7U, "2 number(s) of type DOUBLE"},
    {"init='0.5 -1'", "init='0.5 -1 2'", 7U, "2 number(s) of type DOUBLE"},
    {"init='0.5 -1'", "init='0.5  -1'", 7U, "one space between"},
    {"init='0.5 -1'", "init='0.5 1e400'", 7U, "2 number(s) of type DOUBLE"},
    {"init='0.5 -1'", "init='0.5 nan'", 7U, "2 number(s) of type DOUBLE"},
    {"init='true'", "init='2'", 8U, "1 number(s) of type BOOL"},
    {"min='-1.5' max='1.5' settable", "min='1.6' max='1.5' settable", 10U, "at most max"},
    {"min='-1.5' max='1.5' settable", "init='0 1.6' max='1.5' settable", 10U, "numbers within min and max"},
    {"settable='true'", "settable='yes'", 10U, "true or false"},
    {"unit='rad' min", "unit='radians per second' min", 10U, "a text of at most 16 characters"},
    // Events.
    {"id='3' severity='MEDIUM'", "id='1' severity='MEDIUM'", 15U, "id 1 is taken in line 14"},
    {"name='LIMIT'", "name='LOST'", 15U, "name LOST is taken in line 14"},
    {"severity='MEDIUM'", "severity='SEVERE'", 15U, "one of INFORMATIVE LOW MEDIUM HIGH"},
    {"<ParamRef name='COUNT'/></Event>", "<ParamRef name='COUNTS'/></Event>", 18U, "the name of a parameter"},
    {"<ParamRef name='COUNT'/></Event>", "<ParamRef name='CUR_VALUES'/></Event>", 18U, "each parameter once"},
    {"<ParamRef name='COUNT'/></Event>", "<ParamRef name='N' type='UINT8'/></Event>", 18U,
     "either all <ParamRef>"},
    {"<ParamRef name='COUNT'/></Event>", "<ParamRef name='COUNT' unit='m'/></Event>", 18U,
     "cannot have count, unit or enumeration"},
    {"<ParamRef name='COUNT'/></Event>", "<ParamRef name='COUNT' count='2'/></Event>", 18U,
     "cannot have count, unit or enumeration"},
    // Functions.
    {"states='OPERATIONAL'", "states='OPERATING'", 21U, "of OFFLINE SOFTWARE_INIT"},
    {"states='OPERATIONAL'", "states='OPERATIONAL OPERATIONAL'", 21U, "each once"},
    {"configurations='ALONE'", "configurations='LONELY'", 21U, "configurations of this subsystem"},
    {"configurations='ALONE'", "configurations='ALONE ALONE'", 21U, "each once"},
    {"configurations='ALONE'", "critical='yes'", 21U, "true or false"},
    {"name='STOP' id='2'", "name='STOP' id='1'", 24U, "id 1 is taken in line 21"},
    {"name='FAST' id='7'", "name='FAST' id='1'", 23U, "id 1 is taken in line 22"},
    {"name='FAST' id='7'", "name='POSITION' id='7'", 23U, "name POSITION is taken in line 22"},
    // Configurations and housekeeping.
    {"name='COUPLED' id='2'", "name='COUPLED' id='1'", 35U, "id 1 is taken in line 26"},
    {"name='COUPLED' id='2'", "name='ALONE' id='2'", 35U, "name ALONE is taken in line 26"},
    {"parameter='CUR_VALUES' field='POSITION'", "parameter='NONE' field='POSITION'", 27U,
     "the name of a parameter"},
    {"parameter='CUR_VALUES' field='POSITION'", "parameter='CUR_VALUES'", 27U, "name its field"},
    {"parameter='CUR_VALUES' field='POSITION'", "parameter='CUR_VALUES' field='SPEED'", 27U,
     "the name of a field"},
    {"parameter='TARGET' value", "parameter='TARGET' field='TARGET' value", 28U, "no structure"},
    {"value='0.25 0.5'", "value='0.25 1.6'", 28U, "numbers within min and max"},
    {"value='0.25 0.5'", "value='-1.6 0.5'", 28U, "numbers within min and max"},
    {"<Initial parameter='TARGET' value='0.25 0.5'/>",
     "<Initial parameter='CUR_VALUES' field='POSITION' value='1 2'/>", 28U,
     "field POSITION is taken in line 27"},
    {"nrep='5'", "nrep='3'", 31U, "a divisor of the interval 500"},
    {"nrep='5'", "nrep='0'", 31U, "a number from 2 to 1000"},
    {"interval='500'", "interval='0'", 29U, "a number from 1"},
    {"id='4712'", "id='4711'", 33U, "id 4711 is taken in line 29"},
    {"<ParamRef name='TARGET'/></SampledNREPTimes>", "<ParamRef name='CUR_VALUES'/></SampledNREPTimes>", 31U,
     "each parameter once in a report"},
    {"<SampledOnce><ParamRef name='COUNT'/></SampledOnce>", "", 33U, "<HKService> has no <ParamRef>"},
    {"<SampledOnce><ParamRef name='COUNT'/></SampledOnce>",
     "<SampledOnce/><SampledNREPTimes nrep='2'><ParamRef name='COUNT'/></SampledNREPTimes>", 33U,
     "<SampledOnce> has no <ParamRef>"},
    {"<ParamRef name='TARGET'/></SampledNREPTimes>", "</SampledNREPTimes>", 31U,
     "<SampledNREPTimes> has no <ParamRef>"},
    {"nrep='5'", "nrep='250'", 29U, "octets in one report, at most 4000"},
    // Loops.
    {"<HKService id='4712'",
     "<Loop name='SLOW' samplingTime='10ms' priority='20'/><HKService loop='FAST' id='4712'", 33U,
     "loop=\"FAST\" of <HKService>: expected the name of a <Loop> above in this configuration"},
    {"<HKService id='4712'", "<HKService loop='SLOW' id='4712'", 33U, "a <Loop> above"},
    {"<HKService id='4712'", "<HKService display='yes' id='4712'", 33U, "true or false"},
    {"<HKService id='4711'", "<Loop name='SLOW' samplingTime='10ms' priority='0'/><HKService id='4711'", 29U,
     "a number from 1 to 99"},
    {"<HKService id='4711'", "<Loop name='SLOW' samplingTime='90us' priority='1'/><HKService id='4711'", 29U,
     "from 100us"},
    {"<HKService id='4711'",
     "<Loop name='SLOW' samplingTime='1s' priority='1'/>\n<Loop name='SLOW' samplingTime='2s' "
     "priority='1'/><HKService id='4711'",
     30U, "name SLOW is taken in line 29"},
    {"<HKService id='4711'", SERVICES("A", "8") "<HKService id='4711'", 29U,
     "service 8 cannot have a <Loop> of its own: functions act on devices"},
    {"<HKService id='4711'", SERVICES("A", "17 129") "<HKService id='4711'", 29U,
     "service 129 cannot have a <Loop> of its own: the state machine starts and stops the control"},
    {"<HKService id='4711'", SERVICES("A", "130 17") "<HKService id='4711'", 29U,
     "service 130 cannot have a <Loop> of its own: links are opened, read and written in the cycle of the "
     "control"},
    {"<HKService id='4711'", SERVICES("A", "3") "<HKService id='4711'", 29U,
     "service 3 cannot have a <Loop> of its own: each <HKService> names its loop"},
    {"<HKService id='4711'", SERVICES("A", "17 5 20") "<HKService id='4711'", 29U,
     "service 5 cannot have a <Loop> of its own: an event is reported in the cycle that raises it"},
    {"<HKService id='4711'", SERVICES("A", "1") "<HKService id='4711'", 29U,
     "service 1 cannot have a <Loop> of its own: the loop that performs a request verifies it"},
    {"<HKService id='4711'", SERVICES("A", "13017") "<HKService id='4711'", 29U, "of 17 20"},
    {"<HKService id='4711'", SERVICES("A", "17 17") "<HKService id='4711'", 29U, "of 17 20"},
    {"<HKService id='4711'", SERVICES("A", "") "<HKService id='4711'", 29U, "of 17 20"},
    {"<HKService id='4711'", SERVICES("A", "17") SERVICES("B", "20 17") "<HKService id='4711'", 29U,
     "services 20 17 is taken in line 29"},
    // Ports.
    {"methods='UDP' required", "methods='CARRIER_PIGEON' required", 39U, "SHARED_MEMORY TIPC UDP"},
    {"name='HAND' id='2'", "name='HAND' id='1'", 39U, "id 1 is taken in line 37"},
    {"name='HAND' id='2'", "name='ARM_STATE' id='2'", 39U, "name ARM_STATE is taken in line 37"},
    {"type='DOUBLE' count='2' unit='rad'/></Provides>", "type='DOUBLE' count='129'/></Provides>", 37U,
     "1032 octets in one sample, at most 1024"},
    {"<ParamRef name='POSITION' type='DOUBLE' count='2' unit='rad'/></Provides>", "</Provides>", 37U,
     "<Provides> has no <ParamRef>"},
    {"staleAfter='3ms'", "staleAfter='0us'", 39U, "a time"},
    {"</HKService>\n</Configuration>",
     "</HKService>\n<RTLinkService><Provides name='HAND' id='2' methods='UDP'><ParamRef name='A' "
     "type='INT8'/>"
     "</Provides></RTLinkService></Configuration>",
     39U, "port HAND differs from port HAND in line 34"},
    {"</HKService>\n</Configuration>",
     "</HKService>\n<RTLinkService><Provides name='HAND' id='2' methods='UDP'><ParamRef name='KIND' "
     "type='UINT8'/><ParamRef name='POSITION' type='DOUBLE' count='2'/></Provides></RTLinkService>"
     "</Configuration>",
     39U, "port HAND differs from port HAND in line 34"}, // The same layout, but another direction.
    {"</HKService>\n</Configuration>",
     "</HKService>\n<RTLinkService><Requires name='HAND' id='2' methods='UDP'><ParamRef name='KIND' "
     "type='UINT8'/></Requires></RTLinkService></Configuration>",
     39U, "port HAND differs from port HAND in line 34"}, // The same direction, but another layout.
    {"</HKService>\n</Configuration>",
     "</HKService>\n<RTLinkService><Requires name='HAND' id='3' methods='UDP'><ParamRef name='KIND' "
     "type='UINT8'/><ParamRef name='POSITION' type='DOUBLE' count='2'/></Requires></RTLinkService>"
     "</Configuration>",
     39U, "port HAND differs from port HAND in line 34"},
    {"</HKService>\n</Configuration>",
     "</HKService>\n<RTLinkService><Requires name='HEAD' id='2' methods='UDP'><ParamRef name='KIND' "
     "type='UINT8'/></Requires></RTLinkService></Configuration>",
     39U, "port HAND differs from port HEAD in line 34: expected one id, direction and layout for a name"},
    // Devices.
    {"object='0x6060:00'", "object='6060:00'", 45U, "an object like 0x6060:00"},
    {"object='0x6060:00'", "object='0x6060:0'", 45U, "an object like 0x6060:00"},
    {"object='0x6060:00'", "object='0x60 0:00'", 45U, "an object like 0x6060:00"},
    {"type='INT8' value='-8'", "type='INT8' value='-129'", 45U, "a number of type INT8"},
    {"type='INT8' value='-8'", "type='DOUBLE' value='-8x'", 45U, "a number of type DOUBLE"},
    {"type='INT8' value='-8'", "type='BOOL' value='1'", 45U, "a type other than BOOL"},
    {"node='0x11'", "node='128'", 47U, "a number from 1 to 127"},
    {"bus='robot' ", "", 47U, "<Endnode> of type CAN needs attribute bus"},
    {"bus='robot' node", "bus='robot' port='1' node", 47U,
     "<Endnode> of type CAN cannot have attribute port"},
    {"bus='robot'", "bus='Robot'", 47U, "a lower-case identifier"},
    {"bus='robot'", "bus='sixteen-letters-'", 47U,
     "a lower-case identifier (a-z 0-9 _ -) of at most 15 characters"},
    {"bus='robot'", "bus='robot' redundantBus='sixteen-letters-'", 47U, "of at most 15 characters"},
    {"bus='robot'", "bus='robot' redundantBus='B'", 47U, "redundantBus=\"B\""},
    {"bus='robot' node='0x11'", "redundantBus='robot-b' node='0x11'", 47U, "needs attribute bus"},
    {"framing='LENGTH'", "framing='TLV'", 48U, "one of RAW LENGTH SLIP LINE"},
    {"order='LITTLE'", "order='MIDDLE'", 48U, "one of BIG LITTLE"},
    {"order='LITTLE'", "baud='9600'", 48U, "<Endnode> of type TCP cannot have attribute baud"},
    {"order='LITTLE'", "direction='READ'", 48U, "<Endnode> of type TCP cannot have attribute direction"},
    {"baud='19200'", "baud='19201'", 48U, "one of 9600 19200 38400"},
    {"direction='READ'", "direction='UP'", 48U, "one of BOTH READ WRITE"},
    {"bus='robot' node", "bus='robot' framing='RAW' node", 47U,
     "<Endnode> of type CAN cannot have attribute framing"},
    {"bus='robot' node", "bus='robot' order='BIG' node", 47U,
     "<Endnode> of type CAN cannot have attribute order"},
    {"bus='robot' node", "bus='robot' checksum='true' node", 47U,
     "<Endnode> of type CAN cannot have attribute checksum"},
    {"bus='robot' node", "bus='robot' retry='1ms' node", 47U,
     "<Endnode> of type CAN cannot have attribute retry"},
    {"silence='3ms'", "silence='3'", 48U, "a time like"},
    {"silence='3ms'", "checksum='yes'", 48U, "true or false"},
    {"silence='3ms'", "retry='2s' retryLongest='1s'", 48U, "a retryLongest of at least retry, 2000000 us"},
    {"direction='IN'", "direction='UP'", 48U, "one of IN OUT"},
    {"direction='IN' type='INT16'", "direction='IN' type='BOOL'", 48U, "an integer type, FLOAT or DOUBLE"},
    {"scale='-1e-3'", "scale='0'", 48U, "a number other than 0"},
    {"scale='-1e-3'", "scale='much'", 48U, "a number of type DOUBLE"},
    {"offset='2'", "safe='2'", 48U, "<Field> of direction IN cannot have attribute safe"},
    {"name='ON'", "name='RATE'", 48U, "name RATE is taken in line 48"},
    {"name='GROUND'", "name='JOINT1'", 48U, "name JOINT1 is taken in line 44"},
};

static void each_error_contains_file_line_and_cause(void)
{
    for (size_t i = 0U; i < (sizeof damages / sizeof damages[0]); i++) {
        const damage_t* const damage = &damages[i];
        char location[32];
        (void)snprintf(location, sizeof location, "arm.xml:%u: ", damage->line);
        TEST_ASSERT_EQUAL_MESSAGE(
            STATUS_INVALID, load(damaged(arm_document, damage->find, damage->replacement)), damage->reason);
        const char* const error = descriptor_error(&loader);
        if ((strncmp(error, location, strlen(location)) != 0) || (strstr(error, damage->reason) == NULL)) {
            char message[512];
            (void)snprintf(message, sizeof message, "expected line %u, \"%s\"; got \"%s\"", damage->line,
                           damage->reason, error);
            TEST_FAIL_MESSAGE(message);
        }
        TEST_ASSERT_EQUAL_UINT16(0U, arm.apid); // A partly read descriptor leaves no content.
        TEST_ASSERT_EQUAL_STRING("", arm.name);
    }
    load_valid();
}

static void a_file_cut_at_every_octet_is_an_error(void)
{
    const size_t end = strlen(arm_document) - 1U;
    for (size_t size = 0U; size < end; size++) {
        const status_t status = descriptor_parse_subsystem(&loader, "cut", arm_document, size, &arm);
        TEST_ASSERT_TRUE((status == STATUS_TRUNCATED) || (status == STATUS_INVALID));
        TEST_ASSERT_EQUAL_STRING_LEN("cut:", descriptor_error(&loader), 4U);
    }
}

static void hostile_documents_are_errors_with_a_line(void)
{
    static char nested[30001];
    for (size_t i = 0U; i < 30000U; i += 3U) {
        memcpy(&nested[i], "<A>", 3U);
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, load(nested));
    TEST_ASSERT_EQUAL(STATUS_INVALID, load("<!DOCTYPE S [<!ENTITY a 'x'>]>\n<Subsystem name='&a;' id='1'/>"));
    TEST_ASSERT_EQUAL_STRING("arm.xml:1: document type declarations are not allowed",
                             descriptor_error(&loader));
    TEST_ASSERT_EQUAL(STATUS_INVALID, load("<Subsystem name='A' id='1'>\n\xC3\x28</Subsystem>"));
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, load(""));
}

static void a_missing_file_is_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, descriptor_load_subsystem(&loader, "no/such/file.xml", &arm));
    TEST_ASSERT_EQUAL_STRING("no/such/file.xml:0: cannot read: not found", descriptor_error(&loader));
}

/// Random damage: the reader may accept or refuse the document, but must not crash, and must not exceed its
/// list of fields.
static void random_damage_never_crashes_the_reader(void)
{
    static char document[8192];
    const size_t size = strlen(arm_document);
    uint32_t random   = 0xBADC0DEU;
    for (unsigned i = 0U; i < 20000U; i++) {
        memcpy(document, arm_document, size + 1U);
        for (unsigned n = 0U; n < (1U + (i % 3U)); n++) {
            random                          = (random * 1664525U) + 1013904223U;
            const char letters[]            = "ABCxyz019<>/'=\" \n_.-";
            document[(random >> 8U) % size] = letters[(random >> 3U) % (sizeof letters - 1U)];
        }
        if (descriptor_parse_subsystem(&loader, "x", document, size, &arm) == STATUS_OK) {
            TEST_ASSERT_LESS_OR_EQUAL_UINT16(DESCRIPTOR_FIELDS_MAX, arm.field_count);
        } else {
            TEST_ASSERT_NOT_EQUAL(0, descriptor_error(&loader)[0]);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(identity_resources_and_times_are_read);
    RUN_TEST(parameters_are_read_with_ids_and_layouts);
    RUN_TEST(events_of_both_kinds_are_read);
    RUN_TEST(functions_are_read);
    RUN_TEST(housekeeping_of_a_configuration_is_read);
    RUN_TEST(quantities_of_a_device_are_read);
    RUN_TEST(records_of_a_device_and_times_of_its_end_node_are_read);
    RUN_TEST(each_bit_rate_of_a_serial_line_is_read);
    RUN_TEST(loops_of_a_configuration_are_read);
    RUN_TEST(ports_and_devices_of_a_configuration_are_read);
    RUN_TEST(each_error_contains_file_line_and_cause);
    RUN_TEST(a_file_cut_at_every_octet_is_an_error);
    RUN_TEST(hostile_documents_are_errors_with_a_line);
    RUN_TEST(a_missing_file_is_reported);
    RUN_TEST(random_damage_never_crashes_the_reader);
    return UNITY_END();
}
