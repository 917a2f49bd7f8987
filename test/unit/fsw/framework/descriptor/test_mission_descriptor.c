// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "osal/include/osal/file.h"
#include "test/support/assertion.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t scratch;
static mission_descriptor_t mission;
static char directory[] = "/tmp/mission_descriptor.XXXXXX";
static char path[64];

static void write_file(const char* const name, const char* const document)
{
    osal_file_t file;
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, document, strlen(document)));
    osal_file_close(&file);
}

void setUp(void)
{
    descriptor_loader_init(&loader);
    write_file("arm.xml", arm_document);
    write_file("hand.xml", hand_document);
}

void tearDown(void)
{
}

static status_t load(const char* const document)
{
    write_file("flight.xml", document);
    return descriptor_load_mission(&loader, path, MISSION_ANY_TARGET, &descriptor_mission_whole, &mission,
                                   &scratch);
}

static void load_valid(void)
{
    const status_t status = load(flight_document);
    TEST_ASSERT_EQUAL_STRING("", descriptor_error(&loader));
    TEST_ASSERT_EQUAL(STATUS_OK, status);
}

static void mission_and_subsystems_are_read(void)
{
    load_valid();
    TEST_ASSERT_EQUAL_STRING("flight", mission.name);
    TEST_ASSERT_EQUAL_UINT32(2159006400U, mission.epoch_s); // date -d: 1780315200 + 378691200.
    TEST_ASSERT_EQUAL_UINT32(200U, mission.power_available_w);
    TEST_ASSERT_EQUAL_UINT16(2U, mission.subsystem_count);
    const mission_subsystem_t* const arm = descriptor_mission_find_subsystem(&mission, 16U);
    TEST_ASSERT_EQUAL_STRING("ARM", arm->name);
    TEST_ASSERT_EQUAL_STRING("arm", arm->executable);
    TEST_ASSERT_TRUE(arm->is_autostart);
    TEST_ASSERT_EQUAL_UINT32(4096U, arm->memory_kib);
    TEST_ASSERT_EQUAL_UINT8(3U, arm->restart_budget);
    TEST_ASSERT_EQUAL_UINT32(120U, arm->power_w[5]);
    TEST_ASSERT_EQUAL_UINT32(0U, arm->power_w[4]);
    TEST_ASSERT_EQUAL_UINT16(2U, arm->configuration_count);
    TEST_ASSERT_EQUAL_UINT16(2U, arm->port_count);
    TEST_ASSERT_EQUAL_UINT16(2U, arm->ports[1].configuration);
    TEST_ASSERT_TRUE(arm->ports[1].is_required);
    TEST_ASSERT_NULL(descriptor_mission_find_subsystem(&mission, 1U));
}

static void modes_log_buses_and_ground_are_read(void)
{
    load_valid();
    TEST_ASSERT_EQUAL_UINT16(3U, mission.initial_mode);
    TEST_ASSERT_EQUAL_STRING("NOMINAL", descriptor_mission_find_mode(&mission, 3U)->name);
    TEST_ASSERT_NULL(descriptor_mission_find_mode(&mission, 1U));
    TEST_ASSERT_EQUAL(MISSION_LOG_SQLITE, mission.log_strategy);
    TEST_ASSERT_EQUAL_UINT32(100U, mission.log_ring_records);
    TEST_ASSERT_EQUAL_UINT32(5000000U, mission.buses[0].data_bit_rate);
    TEST_ASSERT_EQUAL_UINT8(DESCRIPTOR_TIPC, mission.message_method);
    TEST_ASSERT_EQUAL_UINT8(DESCRIPTOR_UDP, mission.link_method);
    TEST_ASSERT_EQUAL_UINT16(10015U, mission.ground_port);
    TEST_ASSERT_EQUAL_UINT8(0U, mission.is_ground_open);
    TEST_ASSERT_EQUAL_STRING("", mission.ground_key);
    TEST_ASSERT_EQUAL_UINT16(1U, mission.users[0].id);
}

static void links_are_resolved_to_the_ids_of_ports(void)
{
    load_valid();
    const mission_link_t* const back = descriptor_mission_find_link(&mission, 17U, 4U, 16U, 2U);
    TEST_ASSERT_EQUAL_STRING("BACK", back->name);
    TEST_ASSERT_EQUAL_UINT16(2U, back->number);
    TEST_ASSERT_TRUE(back->is_required);
    const mission_link_t* const forth = descriptor_mission_find_link(&mission, 16U, 1U, 17U, 3U);
    TEST_ASSERT_EQUAL_STRING("FORTH", forth->name);
    TEST_ASSERT_FALSE(forth->is_required);
    TEST_ASSERT_NULL(descriptor_mission_find_link(&mission, 16U, 2U, 17U, 4U));
    TEST_ASSERT_NULL(descriptor_mission_find_link(&mission, 16U, 1U, 16U, 3U));
    TEST_ASSERT_NULL(descriptor_mission_find_link(&mission, 16U, 1U, 17U, 4U));
}

static void plans_are_resolved_and_the_first_that_matches_is_found(void)
{
    load_valid();
    const mission_plan_t* const lost = descriptor_mission_find_plan(&mission, DESCRIPTOR_HIGH, 17U, 9U);
    TEST_ASSERT_EQUAL_STRING("HAND_LOST", lost->name);
    TEST_ASSERT_EQUAL(MISSION_ACTION_LOG, mission.actions[lost->first_action].kind);
    const mission_plan_t* const down = descriptor_mission_find_plan(&mission, DESCRIPTOR_HIGH, 17U, 8U);
    TEST_ASSERT_EQUAL_STRING("DOWN", down->name);
    TEST_ASSERT_EQUAL_PTR(down, descriptor_mission_find_plan(&mission, DESCRIPTOR_HIGH, 16U, 9U));
    TEST_ASSERT_EQUAL_UINT16(2U, down->action_count);
    const mission_action_t* const first = &mission.actions[down->first_action];
    TEST_ASSERT_EQUAL_UINT16(MISSION_NETWORK, first->target);
    TEST_ASSERT_EQUAL_UINT8(0U, first->state);
    TEST_ASSERT_EQUAL_UINT32(500000U, first->after_us);
    TEST_ASSERT_EQUAL(MISSION_ACTION_MODE, mission.actions[down->first_action + 1U].kind);
    TEST_ASSERT_EQUAL_UINT8(0U, mission.actions[down->first_action + 1U].mode);
    TEST_ASSERT_NULL(descriptor_mission_find_plan(&mission, DESCRIPTOR_MEDIUM, 17U, 9U));
}

typedef struct {
    const char* find;
    const char* replacement;
    unsigned line;
    const char* reason;
} damage_t;

static const damage_t damages[] = {
    {"name='flight'", "name='Flight'", 1U, "a lower-case identifier"},
    {"2026-06-01T12:00:00", "2026-06-01 12:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-02-29T12:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-06-01T24:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "1957-12-31T23:59:59", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2O26-06-01T12:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2/26-06-01T12:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-06-01T12:00:00Z", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-06-01T12:60:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-06-01T12:00:60", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2094-01-01T00:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-00-01T12:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-13-01T12:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-06-00T12:00:00", 1U, "a TAI time"},
    {"2026-06-01T12:00:00", "2026-06-31T12:00:00", 1U, "a TAI time"},
    {"name='HAND' id='17'", "name='HAND' id='16'", 5U, "id 16 is taken in line 3"},
    {"name='HAND' id='17'", "name='ARM' id='17'", 5U, "name ARM is taken in line 3"},
    {"name='HAND' id='17'", "name='HAND' id='18'", 5U, "expected name and id HAND 17 as in its descriptor"},
    {"descriptor='hand.xml'", "descriptor='arm.xml'", 5U, "HAND: expected name and id ARM 16 as in"},
    {"descriptor='hand.xml'", "descriptor='hand.xml' supervisorTimeout='99ms'", 5U,
     "supervisorTimeout=\"99ms\" of <Subsystem>: expected a time"},
    {"descriptor='hand.xml'", "descriptor='hand.xml' supervisorTimeout='3601s'", 5U, "a time"},
    {"<Power state='OPERATIONAL'", "<Power state='RUNNING'", 4U, "the name of a state"},
    {"<Power state='OPERATIONAL' watts='120'/>",
     "<Power state='OPERATIONAL' watts='120'/><Power state='OPERATIONAL' watts='1'/>", 4U, "each state once"},
    {" initial='true'", "", 7U, "exactly one <Mode>"},
    {"name='SAFE' id='0'", "name='SAFE' id='0' initial='true'", 7U, "exactly one <Mode>"},
    {"name='SAFE' id='0'", "name='SAFE' id='1'", 7U, "one <Mode> must have fallback=\"true\" or id 0"},
    {"<Mode name='SAFE' id='0'/>\n<Mode name",
     "<Mode name='SAFE' id='0' fallback='true'/>\n<Mode fallback='true' name", 7U,
     "one <Mode> must have fallback"},
    {"name='NOMINAL' id='3'", "name='NOMINAL' id='0'", 8U, "id 0 is taken in line 7"},
    {"name='NOMINAL' id='3'", "name='NOMINAL' id='8'", 8U, "a number from 0 to 7"},
    {"tc='8,1'", "tc='8.1'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='8,256'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='0,1'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='8,1,1'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='8,a'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='8,'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='8888,1'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='0008,1'", 11U, "service and subtype like 8,1"},
    {"tc='8,1'", "tc='8,**'", 11U, "service and subtype like 8,1, or 11,*"},
    {"tc='8,1'", "tc='88888,1'", 11U, "service and subtype like 8,1, or 11,*"},
    {"tc='8,1'", "tc='8'", 11U, "service and subtype like 8,1, or 11,*"},
    {"tc='8,1'", "tc='*,1'", 11U, "service and subtype like 8,1, or 11,*"},
    {"tc='8,1'", "tc='8,0'", 11U, "service and subtype like 8,1, or 11,*"},
    {"select='MOVE_TO'", "select='FLY_TO'", 11U, "expected a function of its target"},
    {"to='ARM' modes='NOMINAL' states='OPERATIONAL'", "to='HAND' modes='NOMINAL' states='OPERATIONAL'", 11U,
     "expected a function of its target"},
    {"to='ARM' modes", "to='LEG' modes", 11U, "one of ARM HAND *"},
    {"modes='NOMINAL' states='OPERATIONAL'", "modes='WILD' states='OPERATIONAL'", 11U, "of SAFE NOMINAL"},
    {"modes='NOMINAL' states='OPERATIONAL'", "modes='NOMINAL' states='RUNNING'", 11U, "of OFFLINE"},
    {"select='PRE_OPERATIONAL'", "select='SOFTWARE_INIT'", 13U, "one of OFFLINE PRE_OPERATIONAL"},
    {"select='COUPLED'", "select='ALONE'", 14U, "expected a configuration of its target"},
    {"select='COUPLED' to='HAND'", "select='COUPLED' to='*'", 14U, "each subsystem numbers"},
    {"select='BACK'", "select='SIDEWAYS'", 15U, "expected a link of the mission"},
    {"tc='20,3'", "tc='20,3' select='X'", 16U, "* for this telecommand"},
    {"from='ARM.ARM_STATE'", "from='ARM.STATE'", 18U, "expected SUBSYSTEM.PORT, a provided port"},
    {"from='ARM.ARM_STATE'", "from='ARM.HAND'", 18U, "expected SUBSYSTEM.PORT, a provided port"},
    {"from='ARM.ARM_STATE'", "from='ARM'", 18U, "expected SUBSYSTEM.PORT, a provided port"},
    {"from='ARM.ARM_STATE'", "from='AR.ARM_STATE'", 18U, "expected SUBSYSTEM.PORT, a provided port"},
    {"to='HAND.ARM'", "to='HAND.LEG'", 18U, "to=\"HAND.LEG\" of <Link>: expected SUBSYSTEM.PORT, a required"},
    {"to='HAND.ARM'", "to='ARM.HAND'", 18U, "<Link>: expected two ports with the same layout"},
    {"to='ARM.HAND'", "to='HAND.ARM'", 19U, "<Link>: expected two ports with the same layout"},
    {"<Link name='BACK'", "<Link name='AGAIN' from='ARM.ARM_STATE' to='HAND.ARM'/><Link name='BACK'", 19U,
     "to=\"HAND.ARM\" of <Link>: expected a port that no other link leads to"},
    {"name='BACK'", "name='FORTH'", 19U, "name FORTH is taken in line 18"},
    {"event='LOST'", "event='LATE'", 21U, "expected an event of that severity"},
    {"severity='HIGH' subsystem='HAND'", "severity='LOW' subsystem='HAND'", 21U, "an event of that severity"},
    {" subsystem='HAND' event", " event", 21U, "needs a subsystem"},
    {"<Action do='LOG'/>", "", 21U, "<Plan> has no <Action>"},
    {"target='NETWORK'", "target='NOBODY'", 22U, "one of ARM HAND SELF NETWORK"},
    {" state='OFFLINE' after", " after", 22U, "needs attribute state"},
    {"mode='SAFE'/", "mode='SAFE' state='OFFLINE'/", 23U, "cannot have attribute state"},
    {"mode='SAFE'/", "mode='MILD'/", 23U, "one of SAFE NOMINAL"},
    {"strategy='SQLITE'", "strategy='PAPER'", 25U, "one of ASCII SQLITE POSTGRESQL RING"},
    {"bitRate='1000000'", "bitRate='9999'", 26U, "a number from 10000"},
    {"<Bus name='robot'", "<Bus name='sixteen-letters-'", 26U, "name=\"sixteen-letters-\" of <Bus>: "},
    {"<Bus name='robot'", "<Bus redundantTo='sixteen-letters-' name='robot'", 26U, "at most 15 characters"},
    // The bus is named in arm.xml.
    {"<Bus name='robot'", "<Bus name='other'", 47U, "expected a bus of the mission"},
    {"<Ground address='127.0.0.1' port='10015'/>\n", "", 1U, "<Mission> has no <Ground>"},
    {"address='127.0.0.1' port", "address='10.0.0.1' port", 28U, "one of 127.0.0.1"},
    {"address='127.0.0.1' port", "address='0.0.0.0' port", 28U, "needs a key"},
    {"port='10015'/", "port='10015' key=''/", 28U, "the path of a file"},
    {"<Users>", "<Users/><Users>", 9U, "a second <Users>: expected one"},
    {"<User name='CLI' id='1'/>", "<User name='CLI' id='1'/>\n<User name='CLI' id='2'/>", 10U,
     "name CLI is taken in line 9"},
    {"<User name='CLI' id='1'/>", "<User name='CLI' id='1'/>\n<User name='WEB' id='1'/>", 10U,
     "id 1 is taken in line 9"},
    {"<Subsystems>", "<Permissions/><Subsystems>", 2U,
     "expected <Subsystems> and <Modes>, not empty, before <Permissions>"},
    {"<Modes>", "<RecoveryPlans/><Modes>", 7U,
     "expected <Subsystems> and <Modes>, not empty, before <RecoveryPlans>"},
};

static void each_error_contains_file_line_and_cause(void)
{
    for (size_t i = 0U; i < (sizeof damages / sizeof damages[0]); i++) {
        const damage_t* const damage = &damages[i];
        char location[32];
        (void)snprintf(location, sizeof location, ".xml:%u: ", damage->line);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID,
                                  load(damaged(flight_document, damage->find, damage->replacement)),
                                  damage->reason);
        if ((strstr(descriptor_error(&loader), location) == NULL) ||
            (strstr(descriptor_error(&loader), damage->reason) == NULL)) {
            char message[512];
            (void)snprintf(message, sizeof message, "expected line %u, \"%s\"; got \"%s\"", damage->line,
                           damage->reason, descriptor_error(&loader));
            TEST_FAIL_MESSAGE(message);
        }
        TEST_ASSERT_EQUAL_UINT16(0U, mission.subsystem_count);
    }
}

static void a_ground_with_a_key_may_be_open(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "address='127.0.0.1' port='10015'",
                                              "address='0.0.0.0' port='10015' key='../ground.key'")));
    TEST_ASSERT_EQUAL_UINT8(1U, mission.is_ground_open);
    TEST_ASSERT_EQUAL_STRING("../ground.key", mission.ground_key);
}

static void an_error_in_a_subsystem_names_its_file(void)
{
    write_file("hand.xml", damaged(hand_document, "id='9'", "id='0'"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, load(flight_document));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader), "/hand.xml:3: id=\"0\""));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, load(damaged(flight_document, "hand.xml", "foot.xml")));
    TEST_ASSERT_NOT_NULL(
        strstr(descriptor_error(&loader),
               "/flight.xml:5: descriptor=\"foot.xml\" of <Subsystem>: expected a file, found none"));
}

/// Leap years, the first days of two months, and the ends: `date -u -d DATE +%s` plus the 378691200 s from
/// 1958 to 1970.
static void epochs_are_read_in_leap_years_and_at_both_limits(void)
{
    static const struct {
        const char* words;
        uint32_t epoch_s;
    } epochs[] = {{"1958-01-01T00:00:00", 0U},
                  {"1972-02-29T00:00:00", 68169600U + 378691200U},
                  {"2000-03-01T01:02:03", 951872523U + 378691200U},
                  {"2027-04-01T00:00:00", 1806537600U + 378691200U},
                  {"2027-05-01T00:00:00", 1809129600U + 378691200U},
                  {"2093-12-31T23:59:59", 3913142399U + 378691200U}};
    for (size_t i = 0U; i < (sizeof epochs / sizeof epochs[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "2026-06-01T12:00:00", epochs[i].words)));
        TEST_ASSERT_EQUAL_UINT32(epochs[i].epoch_s, mission.epoch_s);
    }
}

static void time_is_reported_in_the_format_of_the_mission(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(flight_document));
    TEST_ASSERT_EQUAL(2U, mission.time_reports);
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "power=", "timeReports='CDS' power=")));
    TEST_ASSERT_EQUAL(3U, mission.time_reports);
    TEST_ASSERT_EQUAL(STATUS_INVALID, load(damaged(flight_document, "power=", "timeReports='UTC' power=")));
}

static void the_mission_sets_the_time_a_subsystem_waits_for_its_supervisor(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(flight_document));
    TEST_ASSERT_EQUAL_UINT32(3000000U,
                             descriptor_mission_find_subsystem(&mission, 17U)->supervisor_timeout_us);
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "descriptor='hand.xml'",
                                              "descriptor='hand.xml' supervisorTimeout='100ms'")));
    TEST_ASSERT_EQUAL_UINT32(3000000U,
                             descriptor_mission_find_subsystem(&mission, 16U)->supervisor_timeout_us);
    TEST_ASSERT_EQUAL_UINT32(100000U,
                             descriptor_mission_find_subsystem(&mission, 17U)->supervisor_timeout_us);
}

static void the_fallback_mode_is_the_marked_one_or_mode_0(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(flight_document));
    TEST_ASSERT_EQUAL_UINT8(0U, mission.fallback_mode);
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "id='3'", "id='3' fallback='true'")));
    TEST_ASSERT_EQUAL_UINT8(3U, mission.fallback_mode);
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "name='SAFE' id='0'",
                                              "name='SAFE' id='5' fallback='true'")));
    TEST_ASSERT_EQUAL_UINT8(5U, mission.fallback_mode);
}

static void a_rule_may_be_for_any_selector(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "select='MOVE_TO'", "select='*'")));
    TEST_ASSERT_TRUE(mission.rules[0].is_any);
    TEST_ASSERT_FALSE(mission.rules[1].is_any);
}

/// If an element has several mistakes, the message is about the first one only.
static void the_first_of_several_mistakes_is_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      load(damaged(flight_document, "mode='SAFE'/", "state='OFFLINE' target='SELF'/")));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader),
                                "flight.xml:23: <Action do=\"MODE\"> cannot have attribute target"));
    TEST_ASSERT_NULL(strstr(descriptor_error(&loader), "OFFLINE"));
}

static void paths_are_relative_to_the_mission_or_absolute(void)
{
    char here[256];
    char where[600];
    TEST_ASSERT_NOT_NULL(getcwd(here, sizeof here));
    (void)snprintf(where, sizeof where, "descriptor='%s/hand.xml'", directory);
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "descriptor='hand.xml'", where)));
    TEST_ASSERT_EQUAL(STATUS_OK, load(flight_document)); // This writes the files for the next call.
    TEST_ASSERT_EQUAL(0, chdir(directory));
    const status_t status = descriptor_load_mission(&loader, "flight.xml", MISSION_ANY_TARGET,
                                                    &descriptor_mission_whole, &mission, &scratch);
    TEST_ASSERT_EQUAL(0, chdir(here));
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, status, descriptor_error(&loader));
    size_t length = (size_t)snprintf(where, sizeof where, "%s", directory);
    while (length < (DESCRIPTOR_PATH_CHARACTERS - 12U)) {
        length += (size_t)snprintf(&where[length], sizeof where - length, "/.");
    }
    (void)snprintf(&where[length], sizeof where - length, "/flight.xml");
    const char* const long_name =
        damaged(flight_document, "descriptor='arm.xml'", "descriptor='./././././././arm.xml'");
    write_file("flight.xml", long_name);
    TEST_ASSERT_EQUAL(STATUS_INVALID, descriptor_load_mission(&loader, where, MISSION_ANY_TARGET,
                                                              &descriptor_mission_whole, &mission, &scratch));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader), "expected a path of at most 255 characters"));
}

#define BUS(name) "<Bus name='" name "' bitRate='1000000'/>"
#define SPARE(name, of) "<Bus name='" name "' redundantTo='" of "' bitRate='1000000'/>"

static void a_bus_is_the_redundant_one_of_at_most_one_other(void)
{
    static const struct {
        const char* buses;
        const char* endnode;
        const char* reason; ///< "" if the mission is valid.
    } cases[] = {
        {SPARE("spare", "robot"), "", ""},
        {SPARE("spare", "robot"), " redundantBus='spare'", ""},
        {SPARE("spare", "none"), "", "redundantTo=\"none\" of <Bus>: expected a bus of the mission"},
        {SPARE("spare", "robot") SPARE("third", "spare"), "", "redundantTo=\"spare\" of <Bus>: expected"},
        {SPARE("spare", "robot") SPARE("third", "robot"), "", "redundantTo=\"robot\" of <Bus>: expected"},
        {SPARE("spare", "robot"), " redundantBus='none'", "redundantBus=\"none\" of <Endnode>: expected"},
        {SPARE("spare", "robot") BUS("other"), " redundantBus='other'",
         "redundantBus=\"other\" of <Endnode>: expected a bus of the mission that is redundantTo its bus"},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        char text[512];
        (void)snprintf(text, sizeof text, "bus='robot'%s", cases[i].endnode);
        write_file("arm.xml", damaged(arm_document, "bus='robot'", text));
        (void)snprintf(text, sizeof text, "%s</Buses>", cases[i].buses);
        const status_t status = load(damaged(flight_document, "</Buses>", text));
        TEST_ASSERT_EQUAL_MESSAGE((cases[i].reason[0] == '\0') ? STATUS_OK : STATUS_INVALID, status,
                                  descriptor_error(&loader));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(descriptor_error(&loader), cases[i].reason),
                                     descriptor_error(&loader));
    }
}

#define DEVICE(bus)                                                                                          \
    "<Devices><Device name='D' type='x'>\n<Endnode type='CAN' bus='robot" bus                                \
    "' node='1'/></Device></Devices>"

/// Two masters on one bus would react to each other's devices.
static void a_bus_has_the_devices_of_one_subsystem(void)
{
    static const char* const buses[] = {"", "-b"};
    for (size_t i = 0U; i < 2U; i++) {
        char reason[160];
        write_file("arm.xml", damaged(arm_document, "bus='robot'", "bus='robot' redundantBus='robot-b'"));
        write_file("hand.xml",
                   damaged(hand_document, "</RTLinkService>\n",
                           (i == 0U) ? "</RTLinkService>" DEVICE("") : "</RTLinkService>" DEVICE("-b")));
        TEST_ASSERT_EQUAL(STATUS_INVALID,
                          load(damaged(flight_document, "</Buses>", SPARE("robot-b", "robot") "</Buses>")));
        (void)snprintf(
            reason, sizeof reason,
            "hand.xml:12: bus=\"robot%s\" of <Endnode>: expected a bus of its own, not that of ARM",
            buses[i]);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(descriptor_error(&loader), reason), descriptor_error(&loader));
    }
}

static void devices_of_one_subsystem_share_its_bus(void)
{
    write_file("arm.xml", damaged(arm_document, "node='0x11'/></Device>\n",
                                  "node='0x11'/></Device>\n<Device name='JOINT2' type='joint-drive'>"
                                  "<Endnode type='CAN' bus='robot' node='0x12'/></Device>\n"));
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, load(flight_document), descriptor_error(&loader));
}

static void a_directory_is_refused_as_a_descriptor(void)
{
    TEST_ASSERT_EQUAL(STATUS_IO, descriptor_load_subsystem(&loader, directory, &scratch));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader), ":0: cannot read: "));
}

static void ports_that_share_no_method_make_no_link(void)
{
    write_file("hand.xml", damaged(hand_document, "methods='SHARED_MEMORY UDP'", "methods='SHARED_MEMORY'"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, load(flight_document));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader),
                                "flight.xml:19: <Link>: expected two ports that share a transfer method"));
}

static void the_hashes_of_a_mission_depend_on_every_subsystem(void)
{
    load_valid();
    const uint64_t interface_hash     = mission.interface_hash;
    const uint64_t configuration_hash = mission.configuration_hash;
    char lines[96];
    (void)snprintf(lines, sizeof lines, "ARM %016llx\nHAND %016llx\n",
                   (unsigned long long)mission.subsystems[0].interface_hash,
                   (unsigned long long)mission.subsystems[1].interface_hash);
    TEST_ASSERT_EQUAL_HEX64(fnv64(FNV64_START, (const uint8_t*)lines, strlen(lines)), interface_hash);
    write_file("hand.xml", damaged(hand_document, "priority='90'", "priority='91'"));
    load_valid();
    TEST_ASSERT_TRUE(mission.interface_hash == interface_hash);
    TEST_ASSERT_TRUE(mission.configuration_hash != configuration_hash);
    write_file("hand.xml", damaged(hand_document, "name='TORQUE'", "name='FORCE'"));
    load_valid();
    TEST_ASSERT_TRUE(mission.interface_hash != interface_hash);
    write_file("hand.xml", hand_document);
    write_file("arm.xml", damaged(arm_document, "name='FLAG'", "name='BRAKE'"));
    load_valid();
    TEST_ASSERT_TRUE(mission.interface_hash != interface_hash);
    TEST_ASSERT_TRUE(mission.configuration_hash != configuration_hash);
    write_file("arm.xml", damaged(arm_document, "interval='500'", "interval='505'"));
    load_valid();
    TEST_ASSERT_TRUE(mission.interface_hash == interface_hash);
    TEST_ASSERT_TRUE(mission.configuration_hash != configuration_hash);
    write_file("arm.xml", arm_document);
    TEST_ASSERT_EQUAL(STATUS_OK, load(damaged(flight_document, "watts='120'", "watts='121'")));
    TEST_ASSERT_TRUE(mission.interface_hash == interface_hash);
    TEST_ASSERT_TRUE(mission.configuration_hash != configuration_hash);
}

/// The program of a subsystem reads the mission and the descriptor of this subsystem only.
static void a_subsystem_reads_no_descriptor_but_its_own(void)
{
    write_file("arm.xml", "<Nonsense>");
    write_file("flight.xml", flight_document);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK,
                              descriptor_load_mission(&loader, path, 17U, NULL, &mission, &scratch),
                              descriptor_error(&loader));
    TEST_ASSERT_EQUAL_STRING("HAND", scratch.name);
    TEST_ASSERT_EQUAL_UINT16(1U, scratch.configuration_count);
    TEST_ASSERT_EQUAL_UINT16(2U, mission.subsystem_count);
    TEST_ASSERT_EQUAL_STRING("ARM", mission.subsystems[0].name);
    TEST_ASSERT_EQUAL_UINT16(0U, mission.subsystems[0].port_count);
    TEST_ASSERT_EQUAL_UINT16(1U, mission.bus_count);
    TEST_ASSERT_EQUAL_UINT16(2U, mission.link_count);
    TEST_ASSERT_EQUAL_UINT16(16U, mission.links[0].producer_apid);
    TEST_ASSERT_EQUAL_UINT16(17U, mission.links[0].consumer_apid);
    TEST_ASSERT_EQUAL_UINT16(17U, mission.links[1].producer_apid);
    TEST_ASSERT_EQUAL_UINT16(16U, mission.links[1].consumer_apid);
    TEST_ASSERT_EQUAL_UINT16(0U, mission.rule_count);
    TEST_ASSERT_EQUAL_UINT16(0U, mission.plan_count);
    TEST_ASSERT_EQUAL_UINT16(0U, mission.action_count);
    TEST_ASSERT_TRUE((mission.interface_hash == 0U) && (mission.configuration_hash == 0U));
}

/// The program of the supervisor reads the complete mission and keeps the supervisor's own model at the end.
static void loading_a_mission_leaves_the_requested_model(void)
{
    load_valid();
    const uint64_t interface_hash     = mission.interface_hash;
    const uint64_t configuration_hash = mission.configuration_hash;
    TEST_ASSERT_EQUAL(STATUS_OK, descriptor_load_mission(&loader, path, 16U, &descriptor_mission_whole,
                                                         &mission, &scratch));
    TEST_ASSERT_EQUAL_STRING("ARM", scratch.name);
    TEST_ASSERT_TRUE(mission.interface_hash == interface_hash);
    TEST_ASSERT_TRUE(mission.configuration_hash == configuration_hash);
    TEST_ASSERT_EQUAL_UINT16(6U, mission.rule_count);
    TEST_ASSERT_NOT_NULL(descriptor_mission_find_link(&mission, 17U, 4U, 16U, 2U));
}

static void load_nothing_of_a_mission(void)
{
    (void)!descriptor_load_mission(&loader, path, MISSION_ANY_TARGET, NULL, &mission, &scratch);
}

static void loading_a_part_of_a_mission_without_a_subsystem_is_a_coding_error(void)
{
    write_file("flight.xml", flight_document);
    TEST_ASSERT_TRUE(assertion_fails(load_nothing_of_a_mission));
}

/// A subsystem checks only its own entry and descriptor; launcher and supervisor check the conditions between
/// descriptors.
static void a_subsystem_without_an_entry_or_a_descriptor_is_refused(void)
{
    static const struct {
        uint16_t apid;
        const char* find;
        const char* replacement;
        const char* reason;
    } cases[] = {
        {18U, "'HAND'", "'HAND'", "flight.xml:1: no subsystem has id 18"},
        {0U, "'HAND'", "'HAND'", "flight.xml:1: no subsystem has id 0"},
        {17U, "'hand.xml'", "'none.xml'", "descriptor=\"none.xml\" of <Subsystem>: expected"},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        write_file("flight.xml", damaged(flight_document, cases[i].find, cases[i].replacement));
        TEST_ASSERT_NOT_EQUAL(
            STATUS_OK, descriptor_load_mission(&loader, path, cases[i].apid, NULL, &mission, &scratch));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(descriptor_error(&loader), cases[i].reason),
                                     descriptor_error(&loader));
        TEST_ASSERT_EQUAL_UINT16(0U, mission.subsystem_count);
    }
}

static void a_mission_cut_at_every_octet_is_an_error(void)
{
    const size_t end = strlen(flight_document) - 1U;
    static char document[8192];
    for (size_t size = 0U; size < end; size++) {
        memcpy(document, flight_document, size);
        document[size]        = '\0';
        const status_t status = load(document);
        TEST_ASSERT_TRUE((status == STATUS_TRUNCATED) || (status == STATUS_INVALID));
    }
}

int main(void)
{
    if (mkdtemp(directory) == NULL) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(mission_and_subsystems_are_read);
    RUN_TEST(modes_log_buses_and_ground_are_read);
    RUN_TEST(links_are_resolved_to_the_ids_of_ports);
    RUN_TEST(plans_are_resolved_and_the_first_that_matches_is_found);
    RUN_TEST(each_error_contains_file_line_and_cause);
    RUN_TEST(a_ground_with_a_key_may_be_open);
    RUN_TEST(an_error_in_a_subsystem_names_its_file);
    RUN_TEST(ports_that_share_no_method_make_no_link);
    RUN_TEST(epochs_are_read_in_leap_years_and_at_both_limits);
    RUN_TEST(time_is_reported_in_the_format_of_the_mission);
    RUN_TEST(the_mission_sets_the_time_a_subsystem_waits_for_its_supervisor);
    RUN_TEST(the_fallback_mode_is_the_marked_one_or_mode_0);
    RUN_TEST(a_rule_may_be_for_any_selector);
    RUN_TEST(the_first_of_several_mistakes_is_reported);
    RUN_TEST(paths_are_relative_to_the_mission_or_absolute);
    RUN_TEST(a_bus_is_the_redundant_one_of_at_most_one_other);
    RUN_TEST(a_bus_has_the_devices_of_one_subsystem);
    RUN_TEST(devices_of_one_subsystem_share_its_bus);
    RUN_TEST(a_directory_is_refused_as_a_descriptor);
    RUN_TEST(the_hashes_of_a_mission_depend_on_every_subsystem);
    RUN_TEST(a_subsystem_reads_no_descriptor_but_its_own);
    RUN_TEST(loading_a_mission_leaves_the_requested_model);
    RUN_TEST(loading_a_part_of_a_mission_without_a_subsystem_is_a_coding_error);
    RUN_TEST(a_subsystem_without_an_entry_or_a_descriptor_is_refused);
    RUN_TEST(a_mission_cut_at_every_octet_is_an_error);
    static const char* const names[] = {"arm.xml", "hand.xml", "flight.xml"};
    for (size_t i = 0U; i < 3U; i++) {
        (void)snprintf(path, sizeof path, "%s/%s", directory, names[i]);
        (void)unlink(path);
    }
    (void)rmdir(directory);
    return UNITY_END();
}
