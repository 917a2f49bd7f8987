// SPDX-License-Identifier: Apache-2.0
// The on-board computers of a run: which component is on which, the commands that make their network, and the
// missions that are refused. Tools and the operating system are mocked.
#include "launcher/launcher_internal.h"

#include "fsw/framework/rtlink/agreement.h"
#include "launcher/launcher_relay.h"
#include "osal/include/osal/tipc.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static launcher_t launcher;
static run_state_t run;

/// The words of the command after `env PATH=...`.
bool __wrap_launcher_run_tool(launcher_t* self, const arguments_t* arguments, const char* name)
{
    char words[512];
    text_t text = text_in(words, sizeof words);
    assert_ptr_equal(&launcher, self);
    assert_string_equal("ip", name);
    assert_string_equal("/usr/bin/env", arguments->list[0]);
    for (size_t i = 2U; arguments->list[i] != NULL; i++) {
        text_add(&text, (i > 2U) ? " " : "");
        text_add(&text, arguments->list[i]);
    }
    check_expected_ptr(words);
    return mock_type(bool);
}

bool __wrap_osal_file_exists(const char* path)
{
    check_expected_ptr(path);
    return mock_type(bool);
}

status_t __wrap_osal_network_remove(const char* path)
{
    check_expected_ptr(path);
    return mock_type(status_t);
}

status_t __wrap_osal_tipc_open(osal_socket_t* socket, osal_tipc_kind_t kind, const osal_tipc_name_t* name,
                               osal_tipc_scope_t scope)
{
    assert_non_null(socket);
    assert_true((name == NULL) || (kind == OSAL_TIPC_MESSAGE));
    assert_int_equal(OSAL_TIPC_NODE, scope); // All tests with sockets are on one computer.
    return mock_type(status_t);
}

static int set_up(void** state)
{
    (void)state;
    (void)memset(&launcher, 0, sizeof launcher);
    descriptor_mission_clear(&launcher.mission);
    (void)memset(&run, 0, sizeof run);
    launcher.run               = &run;
    launcher.options.computers = 2U;
    (void)strcpy(run.identity, "hirosco-9");
    (void)strcpy(run.directory, "runs/x");
    (void)strcpy(run.mission_path, "m.xml");
    run.component_count = 3U;
    for (uint16_t i = 0U; i < 3U; i++) {
        run.components[i].apid                          = (uint16_t)(10U + i);
        launcher.mission.storage.subsystems[i].computer = (i == 2U) ? 2U : 1U;
    }
    return 0;
}

static void expect_ip(const char* const words, const bool is_good)
{
    expect_string(__wrap_launcher_run_tool, words, words);
    will_return(__wrap_launcher_run_tool, is_good);
}

static void expect_first_network(const bool has_bearer)
{
    expect_ip("ip netns add hirosco-9.node1", true);
    expect_ip("ip netns add hirosco-9.node2", true);
    expect_ip("ip -n hirosco-9.node1 link add node1 type veth peer name node2", true);
    expect_ip("ip -n hirosco-9.node1 link set node2 netns hirosco-9.node2", true);
    expect_ip("ip -n hirosco-9.node1 link set lo up", true);
    expect_ip("ip -n hirosco-9.node1 address add 10.0.0.1/30 dev node1", true);
    expect_ip("ip -n hirosco-9.node1 link set node1 up", true);
    if (has_bearer) {
        expect_ip("ip netns exec hirosco-9.node1 tipc bearer enable media eth device node1", true);
    }
    expect_ip("ip -n hirosco-9.node2 link set lo up", true);
    expect_ip("ip -n hirosco-9.node2 address add 10.0.0.2/30 dev node2", true);
    expect_ip("ip -n hirosco-9.node2 link set node2 up", true);
    if (has_bearer) {
        expect_ip("ip netns exec hirosco-9.node2 tipc bearer enable media eth device node2", true);
    }
}

static void one_computer_needs_no_network(void** state)
{
    (void)state;
    launcher.options.computers = 1U;
    for (unsigned i = 0U; i < 3U; i++) {
        run.components[i].computer = 7U;
    }
    assert_true(launcher_create_computers(&launcher));
    assert_int_equal(1U, run.computer_count);
    assert_int_equal(OSAL_IPV4_LOOPBACK, run.computer_ipv4[0]);
    for (unsigned i = 0U; i < 3U; i++) {
        assert_int_equal(0U, run.components[i].computer);
    }
    assert_true(launcher_enter_computer(&launcher, 1U));
    launcher_leave_computer(&launcher);
    assert_int_equal(0, launcher.exit_code);
}

/// Fails the test if the socket is not bound to this port of this machine. Closes the socket.
static void expect_socket(osal_socket_t* const socket, const uint16_t port, const int32_t descriptor)
{
    osal_address_t local = {0U, 0U};
    assert_int_equal(STATUS_OK, osal_socket_local_address(socket, &local));
    assert_int_equal(OSAL_IPV4_LOOPBACK, local.ipv4);
    assert_true(port != 0U);
    assert_int_equal(port, local.port);
    assert_int_equal(osal_socket_descriptor(socket), descriptor);
    osal_socket_close(socket);
}

static void components_links_and_the_relay_receive_on_sockets_of_their_own(void** state)
{
    (void)state;
    launcher.options.computers = 1U;
    assert_true(launcher_create_computers(&launcher));
    launcher.mission.link_count                     = 1U;
    launcher.mission.storage.links[0].consumer_apid = 11U;
    run.link_methods   = (1U << (unsigned)RTLINK_METHOD_SHARED_MEMORY) | (1U << (unsigned)RTLINK_METHOD_UDP);
    run.relay.delay_us = 1000U;
    assert_true(launcher_open_sockets(&launcher));
    for (unsigned i = 0U; i < 3U; i++) {
        expect_socket(&launcher.messages[i], run.components[i].message_port,
                      run.components[i].message_descriptor);
    }
    expect_socket(&launcher.links[0], run.link_ports[0], run.link_descriptors[0]);
    expect_socket(&launcher.relays[0], run.relay.ports[0], run.relay.descriptors[0]);
    assert_int_equal(1U, run.relay.consumers[0]);
}

static void links_in_shared_memory_and_components_of_an_image_have_no_sockets(void** state)
{
    (void)state;
    launcher.options.computers = 1U;
    launcher.options.is_image  = true;
    assert_true(launcher_create_computers(&launcher));
    launcher.mission.link_count                     = 1U;
    launcher.mission.storage.links[0].consumer_apid = 11U;
    run.link_methods                                = 1U << (unsigned)RTLINK_METHOD_SHARED_MEMORY;
    assert_true(launcher_open_sockets(&launcher));
    assert_int_equal(0U, run.components[0].message_port);
    assert_int_equal(0U, run.link_ports[0]);
}

/// No socket is opened after the one that fails.
static void a_kernel_without_tipc_is_refused(void** state)
{
    (void)state;
    launcher.options.computers = 1U;
    launcher.options.transport = "tipc";
    launcher.options.links     = "udp";
    run.transport              = (uint8_t)RUN_TRANSPORT_TIPC;
    assert_true(launcher_create_computers(&launcher));
    will_return(__wrap_osal_tipc_open, STATUS_OK);
    assert_true(launcher_check_system(&launcher));
    will_return(__wrap_osal_tipc_open, STATUS_OK);
    will_return(__wrap_osal_tipc_open, STATUS_IO);
    assert_false(launcher_open_sockets(&launcher));
    assert_non_null(strstr(launcher.reason, "cannot open a TIPC socket; use --transport udp: "));
    will_return(__wrap_osal_tipc_open, STATUS_UNSUPPORTED);
    assert_false(launcher_check_system(&launcher));
}

static void two_computers_are_joined_by_a_veth(void** state)
{
    (void)state;
    expect_first_network(false);
    assert_true(launcher_create_computers(&launcher));
    assert_int_equal(2U, run.computer_count);
    assert_int_equal(0x0A000001U, run.computer_ipv4[0]);
    assert_int_equal(0x0A000002U, run.computer_ipv4[1]);
    assert_int_equal(0U, run.components[0].computer);
    assert_int_equal(0U, run.components[1].computer);
    assert_int_equal(1U, run.components[2].computer);
}

static void tipc_has_a_bearer_on_each(void** state)
{
    (void)state;
    run.transport = (uint8_t)RUN_TRANSPORT_TIPC;
    expect_first_network(true);
    assert_true(launcher_create_computers(&launcher));
    run.transport    = 0U;
    run.link_methods = (uint8_t)(1U << (unsigned)RTLINK_METHOD_TIPC);
    expect_first_network(true);
    assert_true(launcher_create_computers(&launcher));
}

static void no_command_runs_after_one_that_fails(void** state)
{
    (void)state;
    expect_ip("ip netns add hirosco-9.node1", true);
    expect_ip("ip netns add hirosco-9.node2", false);
    assert_false(launcher_create_computers(&launcher));
    assert_non_null(strstr(launcher.reason, "cannot create two network namespaces"));
    assert_non_null(strstr(launcher.reason, "runs/x"));
}

static void two_computers_are_refused_for_a_mission_on_one(void** state)
{
    (void)state;
    launcher.mission.storage.subsystems[2].computer = 1U;
    assert_false(launcher_create_computers(&launcher));
    assert_non_null(strstr(launcher.reason, "the mission puts no subsystem on the second computer"));
    assert_non_null(strstr(launcher.reason, "m.xml"));
}

/// If a link connects the computers, a second veth delays the frames at both ends.
static void a_delay_between_computers_is_a_network_of_its_own(void** state)
{
    (void)state;
    run.relay.is_network                            = true;
    run.relay.delay_us                              = 50000U;
    run.relay.jitter_us                             = 2000U;
    launcher.mission.link_count                     = 1U;
    launcher.mission.storage.links[0].producer_apid = 10U;
    launcher.mission.storage.links[0].consumer_apid = 11U;
    assert_false(launcher_create_computers(&launcher));
    assert_non_null(strstr(launcher.reason, "no link goes from one node to the other"));
    launcher.mission.storage.links[0].consumer_apid = 12U;
    expect_first_network(false);
    expect_ip("ip -n hirosco-9.node1 link add link1 type veth peer name link2", true);
    expect_ip("ip -n hirosco-9.node1 link set link2 netns hirosco-9.node2", true);
    expect_ip("ip -n hirosco-9.node1 address add 10.0.0.5/30 dev link1", true);
    expect_ip("ip -n hirosco-9.node1 link set link1 up", true);
    expect_ip("ip netns exec hirosco-9.node1 tc qdisc add dev link1 root netem limit 10000 delay 50000us "
              "2000us loss " LAUNCHER_RELAY_LOSS_TEXT,
              true);
    expect_ip("ip -n hirosco-9.node2 address add 10.0.0.6/30 dev link2", true);
    expect_ip("ip -n hirosco-9.node2 link set link2 up", true);
    expect_ip("ip netns exec hirosco-9.node2 tc qdisc add dev link2 root netem limit 10000 delay 50000us "
              "2000us loss " LAUNCHER_RELAY_LOSS_TEXT,
              true);
    assert_true(launcher_create_computers(&launcher));
}

static void only_namespaces_that_are_there_are_removed(void** state)
{
    (void)state;
    expect_string(__wrap_osal_file_exists, path, "/run/netns/hirosco-9.node1");
    will_return(__wrap_osal_file_exists, false);
    expect_string(__wrap_osal_file_exists, path, "/run/netns/hirosco-9.node2");
    will_return(__wrap_osal_file_exists, true);
    expect_string(__wrap_osal_network_remove, path, "/run/netns/hirosco-9.node2");
    will_return(__wrap_osal_network_remove, STATUS_OK);
    launcher_remove_computers("hirosco-9");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(one_computer_needs_no_network, set_up),
        cmocka_unit_test_setup(components_links_and_the_relay_receive_on_sockets_of_their_own, set_up),
        cmocka_unit_test_setup(links_in_shared_memory_and_components_of_an_image_have_no_sockets, set_up),
        cmocka_unit_test_setup(a_kernel_without_tipc_is_refused, set_up),
        cmocka_unit_test_setup(two_computers_are_joined_by_a_veth, set_up),
        cmocka_unit_test_setup(tipc_has_a_bearer_on_each, set_up),
        cmocka_unit_test_setup(no_command_runs_after_one_that_fails, set_up),
        cmocka_unit_test_setup(two_computers_are_refused_for_a_mission_on_one, set_up),
        cmocka_unit_test_setup(a_delay_between_computers_is_a_network_of_its_own, set_up),
        cmocka_unit_test_setup(only_namespaces_that_are_there_are_removed, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
