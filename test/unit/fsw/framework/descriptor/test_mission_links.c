// SPDX-License-Identifier: Apache-2.0
// One writer, several readers: links that a mission may have, and the lines in which wrong links are refused.
#include "fsw/framework/descriptor/descriptor.h"
#include "osal/include/osal/file.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define READERS 9U
#define FIRST_LINK_LINE 3U
#define HUB 100U

static descriptor_loader_t loader;
static subsystem_descriptor_t scratch;
static mission_descriptor_t mission;
static char directory[] = "/tmp/mission_links.XXXXXX";
static char path[64];
static char document[8192];
static size_t length;

static const char* path_of(const char* name)
{
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static void begin(void)
{
    length      = 0U;
    document[0] = '\0';
}

static void add(const char* words)
{
    TEST_ASSERT_LESS_THAN_UINT64(sizeof document - length, strlen(words));
    (void)strcpy(&document[length], words);
    length += strlen(words);
}

static void write_file(const char* name)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path_of(name)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, document, length));
    osal_file_close(&file);
}

static void add_ports(const char* kind, const char* name, unsigned count, unsigned first_id)
{
    for (unsigned i = 1U; i <= count; i++) {
        char port[160];
        (void)snprintf(port, sizeof port,
                       "<%s name='%s%u' id='%u' methods='UDP'%s><ParamRef name='A' type='DOUBLE'/></%s>",
                       kind, name, i, first_id + i, (kind[0] == 'R') ? " required='false'" : "", kind);
        add(port);
    }
}

static void write_subsystem(const char* name, unsigned id, unsigned provided, unsigned required)
{
    char words[128];
    begin();
    (void)snprintf(words, sizeof words,
                   "<Subsystem name='%s' id='%u'>"
                   "<Configuration name='C' id='1' priority='1' samplingTime='1ms'><RTLinkService>",
                   name, id);
    add(words);
    add_ports("Provides", "P", provided, 0U);
    add_ports("Requires", "Q", required, 20U);
    add("</RTLinkService></Configuration></Subsystem>");
    (void)snprintf(words, sizeof words, "%s.xml", name);
    write_file(words);
}

void setUp(void)
{
    descriptor_loader_init(&loader);
    write_subsystem("HUB", HUB, 3U, READERS);
    for (unsigned i = 1U; i <= READERS; i++) {
        char name[8];
        (void)snprintf(name, sizeof name, "R%u", i);
        write_subsystem(name, i, 2U, 2U);
    }
}

void tearDown(void)
{
}

typedef struct {
    const char* from;
    const char* to;
} link_t;

/// Load a mission with the hub, nine other subsystems and these links, one link on each line. If `is_own`,
/// load only what the program of the hub needs, otherwise the whole mission.
static status_t load(const link_t* links, size_t count, bool is_own)
{
    char words[128];
    begin();
    add("<Mission name='m' epoch='2026-06-01T12:00:00' power='1'><Subsystems>"
        "<Subsystem name='HUB' id='100' executable='hub' descriptor='HUB.xml'/>");
    for (unsigned i = 1U; i <= READERS; i++) {
        (void)snprintf(words, sizeof words,
                       "<Subsystem name='R%u' id='%u' executable='r' descriptor='R%u.xml'/>", i, i, i);
        add(words);
    }
    add("</Subsystems><Modes><Mode name='A' id='0' initial='true'/></Modes>\n<Permissions/><Links>\n");
    for (size_t i = 0U; i < count; i++) {
        (void)snprintf(words, sizeof words, "<Link name='L%u' from='%s' to='%s'/>\n", (unsigned)i + 1U,
                       links[i].from, links[i].to);
        add(words);
    }
    add("</Links><Ground address='127.0.0.1' port='10015'/></Mission>");
    write_file("m.xml");
    return descriptor_load_mission(&loader, path_of("m.xml"), is_own ? HUB : MISSION_ANY_TARGET,
                                   is_own ? NULL : &descriptor_mission_whole, &mission, &scratch);
}

static void expect_loaded(const link_t* links, size_t count)
{
    for (unsigned own = 0U; own < 2U; own++) {
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, load(links, count, own != 0U), descriptor_error(&loader));
        TEST_ASSERT_EQUAL(count, mission.link_count);
    }
}

/// Expect that the last link is refused with its line when the whole mission is read.
static void expect_refused(const link_t* links, size_t count, const char* reason)
{
    char expected[200];
    (void)snprintf(expected, sizeof expected, "m.xml:%u: %s", FIRST_LINK_LINE + (unsigned)count - 1U, reason);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, load(links, count, false), reason);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(descriptor_error(&loader), expected), descriptor_error(&loader));
    expect_loaded(links, count - 1U);
}

static void a_provided_port_has_four_readers_and_no_more(void)
{
    static const link_t links[] = {{"HUB.P1", "R1.Q1"},
                                   {"HUB.P1", "R2.Q1"},
                                   {"HUB.P1", "R3.Q1"},
                                   {"HUB.P1", "R4.Q1"},
                                   {"HUB.P1", "R5.Q1"}};
    expect_refused(links, 5U, "from=\"HUB.P1\" of <Link>: expected a port with at most 4 links");
}

static void one_subsystem_may_read_a_port_by_two_ports_of_its_own(void)
{
    static const link_t links[] = {{"HUB.P1", "R1.Q1"}, {"HUB.P1", "R1.Q2"}};
    expect_loaded(links, 2U);
}

static void a_subsystem_has_eight_links_and_no_more(void)
{
    static const link_t out[] = {{"HUB.P1", "R1.Q1"}, {"HUB.P1", "R2.Q1"}, {"HUB.P1", "R3.Q1"},
                                 {"HUB.P1", "R4.Q1"}, {"HUB.P2", "R5.Q1"}, {"HUB.P2", "R6.Q1"},
                                 {"HUB.P2", "R7.Q1"}, {"HUB.P2", "R8.Q1"}, {"HUB.P3", "R9.Q1"}};
    expect_refused(out, 9U, "too many links of HUB, at most 8");
    static const link_t in[] = {{"R1.P1", "HUB.Q1"}, {"R2.P1", "HUB.Q2"}, {"R3.P1", "HUB.Q3"},
                                {"R4.P1", "HUB.Q4"}, {"HUB.P1", "R5.Q1"}, {"HUB.P1", "R6.Q1"},
                                {"HUB.P2", "R7.Q1"}, {"HUB.P2", "R8.Q1"}, {"R9.P1", "HUB.Q9"}};
    expect_refused(in, 9U, "too many links of HUB, at most 8");
}

static void a_required_port_has_one_writer(void)
{
    static const link_t links[] = {{"R1.P1", "HUB.Q1"}, {"R2.P1", "HUB.Q2"}, {"R3.P1", "HUB.Q1"}};
    expect_refused(links, 3U, "to=\"HUB.Q1\" of <Link>: expected a port that no other link leads to");
}

static void no_subsystem_reads_its_own_port(void)
{
    static const link_t links[] = {{"HUB.P1", "HUB.Q1"}};
    expect_refused(links, 1U, "to=\"HUB.Q1\" of <Link>: expected a port of another subsystem");
}

static void expect_ports(uint16_t link, uint16_t producer, uint16_t consumer)
{
    TEST_ASSERT_EQUAL_UINT16(producer, mission.links[link].producer_port);
    TEST_ASSERT_EQUAL_UINT16(consumer, mission.links[link].consumer_port);
}

/// A subsystem that reads only its own descriptor knows the ids of its own ports; those of the others are 0.
static void a_subsystem_knows_its_own_ports(void)
{
    static const link_t links[] = {
        {"HUB.P2", "R1.Q1"}, {"R2.P1", "HUB.Q3"}, {"R1.P1", "R2.Q1"}, {"HUB.P9", "R3.Q1"}, {"HUB", "HU.Q1"}};
    TEST_ASSERT_EQUAL(STATUS_OK, load(links, 3U, false));
    expect_ports(0U, 2U, 21U);
    expect_ports(1U, 1U, 23U);
    expect_ports(2U, 1U, 21U);
    TEST_ASSERT_EQUAL(STATUS_OK, load(links, 5U, true));
    expect_ports(0U, 2U, 0U);
    expect_ports(1U, 0U, 23U);
    expect_ports(2U, 0U, 0U);
    expect_ports(3U, 0U, 0U);
    expect_ports(4U, 0U, 0U);
    TEST_ASSERT_EQUAL_UINT16(0U, mission.links[4].consumer_apid);
}

int main(void)
{
    if (mkdtemp(directory) == NULL) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(a_provided_port_has_four_readers_and_no_more);
    RUN_TEST(one_subsystem_may_read_a_port_by_two_ports_of_its_own);
    RUN_TEST(a_subsystem_has_eight_links_and_no_more);
    RUN_TEST(a_required_port_has_one_writer);
    RUN_TEST(no_subsystem_reads_its_own_port);
    RUN_TEST(a_subsystem_knows_its_own_ports);
    for (unsigned i = 0U; i <= READERS; i++) {
        char name[16];
        (void)snprintf(name, sizeof name, (i == 0U) ? "HUB.xml" : "R%u.xml", i);
        (void)unlink(path_of(name));
    }
    (void)unlink(path_of("m.xml"));
    (void)rmdir(directory);
    return UNITY_END();
}
