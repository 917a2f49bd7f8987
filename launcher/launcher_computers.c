// SPDX-License-Identifier: Apache-2.0
// The network between the components of a run: its on-board computers (network namespaces that a virtual
// Ethernet, veth, connects), and their sockets for messages and links.
#include "launcher/launcher_internal.h"
#include "launcher/launcher_relay.h"

#include "base/assertion.h"
#include "fsw/framework/rtlink/agreement.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/tipc.h"

#include <string.h>

#define NAMESPACES "/run/netns/"
#define TOOL_PATH "PATH=/usr/sbin:/usr/bin:/sbin:/bin"
#define WORDS_MAX 18U
#define WORD_MAX 16U
/// Size of the netem queue [frames]: two seconds of two links at 2 kHz. The longest delay is half a second.
#define NETEM_FRAMES "10000"
#define RECEIVE_OCTETS 425984U
/// Longest wall-clock time until each computer knows all TIPC names.
#define NEIGHBOUR_TIMEOUT_NS 15000000000ULL
#define NEIGHBOUR_ROUND_MS 100U
/// 10.0.0.1; the second computer has 10.0.0.2. They exist only inside the namespaces.
#define COMPUTER_IPV4 0x0A000001U

static const char* const interfaces[RUN_COMPUTERS_MAX] = {"node1", "node2"};
static const char* const addresses[RUN_COMPUTERS_MAX]  = {"10.0.0.1/30", "10.0.0.2/30"};
// The network of the links, if they have a delay: addresses of the computers + RUN_LINK_NETWORK.
static const char* const link_interfaces[RUN_COMPUTERS_MAX] = {"link1", "link2"};
static const char* const link_addresses[RUN_COMPUTERS_MAX]  = {"10.0.0.5/30", "10.0.0.6/30"};

// ---- On-board computers ----

static void name_computer(const char* const directory, const char* const identity, const unsigned computer,
                          char* const name, const size_t capacity)
{
    FSW_ASSERT(computer < RUN_COMPUTERS_MAX);
    (void)text_join(name, capacity,
                    (const char* const[]){directory, identity, ".", interfaces[computer], NULL});
}

bool launcher_enter_computer(launcher_t* const launcher, const unsigned computer)
{
    char path[RUN_NAME_MAX];
    if (launcher->run->computer_count < 2U) {
        return true;
    }
    name_computer(NAMESPACES, launcher->run->identity, computer, path, sizeof path);
    return (osal_network_enter(&launcher->home, path) == STATUS_OK) ||
           launcher_fail(launcher,
                         "cannot enter a network namespace; run it as root, or with --nodes 1: ", path);
}

void launcher_leave_computer(launcher_t* const launcher)
{
    if ((launcher->run->computer_count >= 2U) && (osal_network_leave(&launcher->home) != STATUS_OK)) {
        (void)launcher_fail(launcher, "cannot return to the network namespace of the launcher",
                            "; run it with --nodes 1");
    }
}

/// Run iproute2 with each list of words, until one fails. Its output is in console.log.
static bool run_ip(launcher_t* const launcher, const char* const commands[][WORDS_MAX + 1U],
                   const size_t count)
{
    bool is_good = true;
    for (size_t i = 0U; is_good && (i < count); i++) {
        arguments_t arguments = {.count = 0U};
        arguments_add_option(&arguments, "/usr/bin/env", TOOL_PATH);
        arguments_add_words(&arguments, commands[i]);
        is_good = launcher_run_tool(launcher, &arguments, "ip");
    }
    return is_good;
}

static bool is_by_tipc(const launcher_t* const launcher)
{
    const uint8_t tipc = (uint8_t)(1U << (unsigned)RTLINK_METHOD_TIPC);
    return (launcher->run->transport == (uint8_t)RUN_TRANSPORT_TIPC) ||
           ((launcher->run->link_methods & tipc) != 0U);
}

/// Set addresses and TIPC bearer of one on-board computer. The veth already exists.
static bool set_up_computer(launcher_t* const launcher, const char* const name, const unsigned computer)
{
    const char* const interface                  = interfaces[computer];
    const char* const commands[][WORDS_MAX + 1U] = {
        {"ip", "-n", name, "link", "set", "lo", "up"},
        {"ip", "-n", name, "address", "add", addresses[computer], "dev", interface},
        {"ip", "-n", name, "link", "set", interface, "up"},
        {"ip", "netns", "exec", name, "tipc", "bearer", "enable", "media", "eth", "device", interface},
    };
    const size_t count = (sizeof commands / sizeof commands[0]) - (is_by_tipc(launcher) ? 0U : 1U);
    return run_ip(launcher, commands, count);
}

static void write_us(char* const word, const size_t capacity, const uint32_t us)
{
    text_t text = text_in(word, capacity);
    text_add_unsigned(&text, us);
    text_add(&text, "us");
}

/// Configure one end of the network with delay: netem delays the frames that leave this end, reorders them by
/// jitter, and loses some. Its queue must have room for all delayed frames.
static bool delay_link_end(launcher_t* const launcher, const char* const name, const unsigned computer)
{
    char delay[WORD_MAX];
    char jitter[WORD_MAX];
    write_us(delay, sizeof delay, launcher->run->relay.delay_us);
    write_us(jitter, sizeof jitter, launcher->run->relay.jitter_us);
    const char* const command[][WORDS_MAX + 1U] = {
        {"ip", "netns", "exec", name, "tc", "qdisc", "add", "dev", link_interfaces[computer], "root", "netem",
         "limit", NETEM_FRAMES, "delay", delay, jitter, "loss", LAUNCHER_RELAY_LOSS_TEXT},
    };
    return run_ip(launcher, command, 1U) ||
           launcher_fail(
               launcher,
               "--delay --nodes 2: cannot delay the network between the nodes: it needs `tc` of iproute2 "
               "and netem in the kernel (see console.log for the output of `tc`); load it as root: `modprobe "
               "sch_netem`, or fly in the micro-VM (`make vm`): ",
               launcher->run->directory);
}

static bool set_up_link_end(launcher_t* const launcher, const char* const name, const unsigned computer)
{
    const char* const interface                  = link_interfaces[computer];
    const char* const commands[][WORDS_MAX + 1U] = {
        {"ip", "-n", name, "address", "add", link_addresses[computer], "dev", interface},
        {"ip", "-n", name, "link", "set", interface, "up"},
    };
    return run_ip(launcher, commands, sizeof commands / sizeof commands[0]) &&
           delay_link_end(launcher, name, computer);
}

/// Create the second veth, on which links have a delay.
static bool create_link_network(launcher_t* const launcher, const char* const first, const char* const second)
{
    const char* const commands[][WORDS_MAX + 1U] = {
        {"ip", "-n", first, "link", "add", link_interfaces[0], "type", "veth", "peer", "name",
         link_interfaces[1]},
        {"ip", "-n", first, "link", "set", link_interfaces[1], "netns", second},
    };
    return run_ip(launcher, commands, sizeof commands / sizeof commands[0]) &&
           set_up_link_end(launcher, first, 0U) && set_up_link_end(launcher, second, 1U);
}

/// Create two namespaces and the veth that connects them.
static bool create_namespaces(launcher_t* const launcher)
{
    char first[RUN_NAME_MAX];
    char second[RUN_NAME_MAX];
    name_computer("", launcher->run->identity, 0U, first, sizeof first);
    name_computer("", launcher->run->identity, 1U, second, sizeof second);
    const char* const commands[][WORDS_MAX + 1U] = {
        {"ip", "netns", "add", first},
        {"ip", "netns", "add", second},
        {"ip", "-n", first, "link", "add", interfaces[0], "type", "veth", "peer", "name", interfaces[1]},
        {"ip", "-n", first, "link", "set", interfaces[1], "netns", second},
    };
    return run_ip(launcher, commands, sizeof commands / sizeof commands[0]) &&
           set_up_computer(launcher, first, 0U) && set_up_computer(launcher, second, 1U) &&
           (!launcher->run->relay.is_network || create_link_network(launcher, first, second));
}

/// True if a link connects two on-board computers.
static bool has_link_between(const launcher_t* const launcher)
{
    const run_state_t* const run = launcher->run;
    bool is_found                = false;
    for (uint16_t i = 0U; i < launcher->mission.link_count; i++) {
        unsigned from = 0U;
        unsigned to   = 0U;
        is_found      = is_found || (run_state_find(run, launcher->mission.links[i].producer_apid, &from) &&
                                run_state_find(run, launcher->mission.links[i].consumer_apid, &to) &&
                                (run->components[from].computer != run->components[to].computer));
    }
    return is_found;
}

bool launcher_check_system(launcher_t* const launcher)
{
    const launch_options_t* const options = &launcher->options;
    osal_network_t home                   = {-1};
    osal_socket_t probe                   = OSAL_SOCKET_CLOSED;
    const bool is_tipc =
        (strcmp(options->transport, "tipc") == 0) || (strstr(options->links, "tipc") != NULL);
    if (is_tipc && (osal_tipc_open(&probe, OSAL_TIPC_SAMPLE, NULL, OSAL_TIPC_NODE) == STATUS_UNSUPPORTED)) {
        return launcher_fail(
            launcher,
            "this kernel has no TIPC; load it as root: `modprobe tipc`, or fly in the micro-VM: "
            "`make vm SECONDS=3600 CMD='make sim-run TRANSPORT=tipc'`",
            "");
    }
    osal_socket_close(&probe);
    if (options->computers < 2U) {
        return true;
    }
    const status_t status = osal_network_enter(&home, "/proc/thread-self/ns/net");
    if ((status != STATUS_OK) || (osal_network_leave(&home) != STATUS_OK)) {
        return launcher_fail(
            launcher,
            "--nodes 2: network namespaces are not permitted to this user; run it as root: "
            "`sudo make sim-run NODES=2`, or in the micro-VM: `make vm SECONDS=3600 CMD='make "
            "sim-run NODES=2'`",
            "");
    }
    return true;
}

bool launcher_create_computers(launcher_t* const launcher)
{
    run_state_t* const run = launcher->run;
    const unsigned asked   = launcher->options.computers;
    run->computer_ipv4[0]  = OSAL_IPV4_LOOPBACK;
    run->computer_count    = 1U;
    bool has_second        = false;
    for (uint16_t i = 0U; i < run->component_count; i++) {
        run->components[i].computer =
            (asked < 2U) ? 0U : (uint8_t)(launcher->mission.subsystems[i].computer - 1U);
        has_second = has_second || (run->components[i].computer == 1U);
    }
    if (asked < 2U) {
        return true;
    }
    if (!has_second) {
        return launcher_fail(launcher,
                             "--nodes 2: the mission puts no subsystem on the second computer; write "
                             "node=\"2\" into a <Subsystem> of ",
                             run->mission_path);
    }
    if (run->relay.is_network && !has_link_between(launcher)) {
        return launcher_fail(launcher,
                             "--delay --nodes 2: no link goes from one node to the other; give the "
                             "<Subsystem> at one end of a link another node=\"\" in ",
                             run->mission_path);
    }
    run->computer_ipv4[0] = COMPUTER_IPV4;
    run->computer_ipv4[1] = COMPUTER_IPV4 + 1U;
    run->computer_count   = RUN_COMPUTERS_MAX;
    return create_namespaces(launcher) ||
           launcher_fail(
               launcher,
               "--nodes 2: cannot create two network namespaces and a veth between them (needs iproute2 and "
               "root; see console.log for the output of `ip`): ",
               run->directory);
}

void launcher_remove_computers(const char* const identity)
{
    for (unsigned computer = 0U; computer < RUN_COMPUTERS_MAX; computer++) {
        char path[RUN_NAME_MAX];
        name_computer(NAMESPACES, identity, computer, path, sizeof path);
        if (osal_file_exists(path)) {
            (void)osal_network_remove(path);
        }
    }
}

// ---- Sockets ----

static bool open_udp(launcher_t* const launcher, osal_socket_t* const socket, const unsigned computer,
                     const uint32_t offset, uint16_t* const out_port)
{
    osal_address_t local = {launcher->run->computer_ipv4[computer] + offset, 0U};
    status_t status      = osal_udp_open(socket, local, RECEIVE_OCTETS);
    status               = (status == STATUS_OK) ? osal_socket_local_address(socket, &local) : status;
    if (status != STATUS_OK) {
        return launcher_refuse(
            launcher,
            (const char* const[]){"cannot open a UDP socket on ",
                                  (launcher->run->computer_count < 2U) ? "127.0.0.1" : addresses[computer],
                                  ": ", status_text(status), "; raise `ulimit -n`", NULL});
    }
    *out_port = local.port;
    return true;
}

static bool open_tipc(launcher_t* const launcher, osal_socket_t* const socket, const osal_tipc_kind_t kind,
                      const osal_tipc_name_t name)
{
    const osal_tipc_scope_t scope = (launcher->run->computer_count < 2U) ? OSAL_TIPC_NODE : OSAL_TIPC_CLUSTER;
    const status_t status         = osal_tipc_open(socket, kind, &name, scope);
    return (status == STATUS_OK) ||
           launcher_fail(launcher, "cannot open a TIPC socket; use --transport udp: ", status_text(status));
}

static bool open_message_socket(launcher_t* const launcher, const uint16_t index)
{
    run_component_t* const component = &launcher->run->components[index];
    osal_socket_t* const socket      = &launcher->messages[index];
    const osal_tipc_name_t name      = {run_message_type(launcher->run), component->apid};
    const bool is_open               = (launcher->run->transport == (uint8_t)RUN_TRANSPORT_TIPC)
                                           ? open_tipc(launcher, socket, OSAL_TIPC_MESSAGE, name)
                                           : open_udp(launcher, socket, component->computer, 0U, &component->message_port);
    component->message_descriptor    = osal_socket_descriptor(socket);
    return is_open;
}

static bool open_link_socket(launcher_t* const launcher, const uint16_t index, const unsigned computer)
{
    run_state_t* const run      = launcher->run;
    osal_socket_t* const socket = &launcher->links[index];
    const osal_tipc_name_t name = {run_link_type(run), launcher->mission.links[index].number};
    const bool is_tipc          = ((run->link_methods & (uint8_t)(1U << (unsigned)RTLINK_METHOD_TIPC)) != 0U);
    const bool is_open =
        is_tipc ? open_tipc(launcher, socket, OSAL_TIPC_SAMPLE, name)
                : open_udp(launcher, socket, computer, run->relay.is_network ? RUN_LINK_NETWORK : 0U,
                           &run->link_ports[index]);
    run->link_descriptors[index] = osal_socket_descriptor(socket);
    return is_open;
}

/// Open the socket on which the relay receives the frames of a link from its producer.
static bool open_relay_socket(launcher_t* const launcher, const uint16_t index, const unsigned consumer,
                              const unsigned computer)
{
    run_relay_t* const relay    = &launcher->run->relay;
    osal_socket_t* const socket = &launcher->relays[index];
    relay->consumers[index]     = (uint8_t)consumer;
    const bool is_open          = open_udp(launcher, socket, computer, 0U, &relay->ports[index]);
    relay->descriptors[index]   = osal_socket_descriptor(socket);
    return is_open;
}

static bool has_relay(const run_state_t* const run)
{
    return (run->relay.delay_us > 0U) && !run->relay.is_network;
}

/// Open the sockets of all components of one on-board computer in its network namespace.
static bool open_on_computer(launcher_t* const launcher, const unsigned computer)
{
    run_state_t* const run  = launcher->run;
    const uint8_t in_memory = (uint8_t)(1U << (unsigned)RTLINK_METHOD_SHARED_MEMORY);
    const bool has_links    = ((run->link_methods & (uint8_t)~in_memory) != 0U);
    bool is_open            = launcher_enter_computer(launcher, computer);
    if (!is_open) {
        return false;
    }
    for (uint16_t i = 0U; is_open && !launcher->options.is_image && (i < run->component_count); i++) {
        is_open = (run->components[i].computer != computer) || open_message_socket(launcher, i);
    }
    for (uint16_t i = 0U; is_open && has_links && (i < launcher->mission.link_count) && (i < RUN_LINKS_MAX);
         i++) {
        unsigned consumer  = 0U;
        const bool is_here = run_state_find(run, launcher->mission.links[i].consumer_apid, &consumer) &&
                             (run->components[consumer].computer == computer);
        is_open = !is_here || open_link_socket(launcher, i, computer);
        if (is_open && is_here && has_relay(run)) {
            is_open = open_relay_socket(launcher, i, consumer, computer);
        }
    }
    launcher_leave_computer(launcher);
    return is_open;
}

/// Wait until the TIPC topology service of this namespace has reported `expected` names. The names appear
/// with a delay, because TIPC nodes discover each other only some time after their bearers are up.
static bool wait_for_names(launcher_t* const launcher, const uint32_t type, const unsigned expected)
{
    const uint64_t end_ns = osal_clock_monotonic_ns() + NEIGHBOUR_TIMEOUT_NS;
    osal_socket_t watch   = OSAL_SOCKET_CLOSED;
    unsigned seen         = 0U;
    status_t status       = osal_tipc_watch_open(&watch, type);
    while ((status == STATUS_OK) && (seen < expected) && (osal_clock_monotonic_ns() < end_ns)) {
        osal_tipc_event_t event = {false, 0U};
        status                  = osal_tipc_watch_next(&watch, &event);
        if (status == STATUS_OK) {
            seen += event.is_published ? 1U : 0U;
        } else if (status == STATUS_EMPTY) {
            status = osal_socket_wait_readable(&watch, NEIGHBOUR_ROUND_MS);
            status = (status == STATUS_TIMEOUT) ? STATUS_OK : status;
        } else {
            // The topology service has ended the watch, so no more names are reported.
        }
    }
    osal_socket_close(&watch);
    return (seen >= expected) || launcher_fail(launcher,
                                               "the on-board computers do not know each other's TIPC names; "
                                               "see `tipc link list` in their namespaces",
                                               "");
}

static bool wait_for_neighbours(launcher_t* const launcher)
{
    const run_state_t* const run = launcher->run;
    const bool is_transport      = (run->transport == (uint8_t)RUN_TRANSPORT_TIPC);
    bool is_seen                 = true;
    for (unsigned computer = 0U; is_seen && (computer < run->computer_count); computer++) {
        is_seen = launcher_enter_computer(launcher, computer);
        if (is_seen) {
            is_seen = is_transport
                          ? wait_for_names(launcher, run_message_type(run), run->component_count)
                          : wait_for_names(launcher, run_link_type(run), launcher->mission.link_count);
            launcher_leave_computer(launcher);
        }
    }
    return is_seen;
}

/// Store the identities by which receivers recognise the sockets of their peers. Must be called after the
/// wait for the names, because a TIPC node gets its address some time after its bearer is up.
static bool note_identities(launcher_t* const launcher)
{
    const bool is_tipc =
        (launcher->run->transport == (uint8_t)RUN_TRANSPORT_TIPC) && !launcher->options.is_image;
    bool is_noted = true;
    for (uint16_t i = 0U; is_tipc && is_noted && (i < launcher->run->component_count); i++) {
        is_noted = (osal_tipc_identity(&launcher->messages[i],
                                       &launcher->run->components[i].message_identity) == STATUS_OK);
    }
    return is_noted ||
           launcher_fail(launcher,
                         "cannot read the identities of the components' TIPC sockets; use --transport udp",
                         "");
}

bool launcher_open_sockets(launcher_t* const launcher)
{
    bool is_open = true;
    for (unsigned computer = 0U; is_open && (computer < launcher->run->computer_count); computer++) {
        is_open = open_on_computer(launcher, computer);
    }
    const bool has_neighbours = (launcher->run->computer_count >= 2U) && is_by_tipc(launcher);
    return is_open && (!has_neighbours || wait_for_neighbours(launcher)) && note_identities(launcher);
}
