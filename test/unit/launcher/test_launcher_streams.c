// SPDX-License-Identifier: Apache-2.0
// Stream devices on hosts are refused in a run on two on-board computers. The reader of descriptors is
// mocked: each subsystem has one end node.
#include "launcher/launcher_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define MISSION "descriptors/missions/zoo.xml"

static launcher_t launcher;

status_t __wrap_descriptor_load_mission(descriptor_loader_t* loader, const char* path, uint16_t apid,
                                        const mission_scope_t* scope, mission_descriptor_t* out_mission,
                                        subsystem_descriptor_t* out_own)
{
    assert_ptr_equal(&launcher.loader, loader);
    assert_string_equal(MISSION, path);
    assert_ptr_equal(&descriptor_mission_whole, scope);
    assert_ptr_equal(&launcher.mission, out_mission);
    assert_ptr_equal(&launcher.scratch, out_own);
    check_expected(apid);
    (void)text_join(loader->path, sizeof loader->path, (const char* const[]){"descriptors/x.xml", NULL});
    (void)text_join(loader->error, sizeof loader->error, (const char* const[]){"x.xml:3: gone", NULL});
    out_own->endnode_count            = 1U;
    out_own->storage.endnodes[0].type = mock_type(descriptor_endnode_type_t);
    out_own->storage.endnodes[0].line = 70U + apid;
    return mock_type(status_t);
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    descriptor_subsystem_clear(&launcher.scratch);
    launcher.options.computers                  = 2U;
    launcher.mission.subsystem_count            = 2U;
    launcher.mission.storage.subsystems[0].apid = 1U;
    launcher.mission.storage.subsystems[1].apid = 7U;
    return 0;
}

static void expect_endnode(const uint16_t apid, const descriptor_endnode_type_t type, const status_t status)
{
    expect_value(__wrap_descriptor_load_mission, apid, apid);
    will_return(__wrap_descriptor_load_mission, type);
    will_return(__wrap_descriptor_load_mission, status);
}

static void one_computer_reaches_every_host(void** state)
{
    (void)state;
    launcher.options.computers = 1U;
    assert_true(launcher_check_streams(&launcher, MISSION)); // Reads no descriptor.
}

static void end_nodes_without_a_host_are_reached_from_two_computers(void** state)
{
    static const descriptor_endnode_type_t types[] = {DESCRIPTOR_ENDNODE_CAN, DESCRIPTOR_ENDNODE_SHM,
                                                      DESCRIPTOR_ENDNODE_MQUEUE, DESCRIPTOR_ENDNODE_SERIAL,
                                                      DESCRIPTOR_ENDNODE_FILE};
    (void)state;
    for (size_t i = 0U; i < (sizeof types / sizeof types[0]); i++) {
        expect_endnode(1U, types[i], STATUS_OK);
        expect_endnode(7U, DESCRIPTOR_ENDNODE_CAN, STATUS_OK);
        assert_true(launcher_check_streams(&launcher, MISSION));
    }
    assert_int_equal(0, launcher.exit_code);
}

static void hosts_are_refused_with_file_and_line(void** state)
{
    (void)state;
    expect_endnode(1U, DESCRIPTOR_ENDNODE_UDP, STATUS_OK);
    assert_false(launcher_check_streams(&launcher, MISSION));
    assert_non_null(
        strstr(launcher.reason, "descriptors/x.xml:71: type=\"UDP\" of <Endnode>: expected no host"));
    assert_non_null(
        strstr(launcher.reason, "fly with --nodes 1, or give the device another type of end node"));
    launcher.reason[0] = '\0';
    launcher.exit_code = 0;
    expect_endnode(1U, DESCRIPTOR_ENDNODE_SHM, STATUS_OK);
    expect_endnode(7U, DESCRIPTOR_ENDNODE_TCP, STATUS_OK);
    assert_false(launcher_check_streams(&launcher, MISSION));
    assert_non_null(strstr(launcher.reason, "descriptors/x.xml:77: type=\"TCP\""));
    assert_int_equal(1, launcher.exit_code);
}

static void a_descriptor_that_changed_in_between_is_refused(void** state)
{
    (void)state;
    expect_endnode(1U, DESCRIPTOR_ENDNODE_CAN, STATUS_INVALID);
    assert_false(launcher_check_streams(&launcher, MISSION));
    assert_string_equal("x.xml:3: gone", launcher.reason);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(one_computer_reaches_every_host, set_up),
        cmocka_unit_test_setup(end_nodes_without_a_host_are_reached_from_two_computers, set_up),
        cmocka_unit_test_setup(hosts_are_refused_with_file_and_line, set_up),
        cmocka_unit_test_setup(a_descriptor_that_changed_in_between_is_refused, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
