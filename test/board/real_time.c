// SPDX-License-Identifier: Apache-2.0
// Linked to the program of the manipulator for a board: the program runs in real time, on the timers and the
// watchdog of the board, with its own loop, its own steps and its tasks for the loops of services. This file
// makes the run that the launcher makes on Linux, and replaces what a board does not have: the drives answer
// on a bus in memory (test/support/scripted_bus.h), and the datagrams to and from the supervisor pass through
// memory. A task of lower priority than the loop does both, half a period after the loop. The supervisor
// brings the manipulator to OPERATIONAL and back, and requests reports, which the slow loop sends. At the end
// it prints
//     LOOP <state> <steps> <microseconds> <missed> <early> <latest>     [counts of 40 ns]
//     STACK <task> <octets> <octets used>
//     REPORTS <packets that have arrived>
// `missed`: steps that were already due when the loop began to wait for them; `early`: steps that began
// before they were due; `latest`: longest time from when a step was due until it began. With the argument
// `hang` a step never ends, with `hang-service` a turn of a loop of services.
#include "base/apids.h"
#include "fsw/framework/subsystem/subsystem_core.h"
#include "fsw/programs/compiled_descriptors.h"
#include "fsw/programs/executive.h"
#include "fsw/programs/loop_tasks.h"
#include "osal/freertos/board.h"
#include "osal/freertos/port.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"
#include "pus/core/requester.h"
#include "pus/private/st129_management.h"
#include "pus/st20/st20_parameters.h"
#include "test/support/board/numbers.h"
#include "test/support/scripted_bus.h"

#include <limits.h>
#include <string.h>

#define MISSION "rokviss"
#define STAND_ALONE 1U
#define COUNTERS 0U // Place of the parameter that the requests for values name.
#define PERIOD_NS 500000U
#define MS 1000000ULL
#define HEARTBEAT_CYCLES 40U
#define REQUEST_CYCLES 100U ///< Cycles between two requests.
#define OPERATION_NS (2000U * MS)
#define HANG_NS (1000U * MS)
#define LIMIT_NS (15000U * MS) ///< The program ends then, whatever it has reached.
#define PRIORITY 50            ///< Below the loop of the manipulator (80), above its slow loop (20).
#define SUPERVISOR_PORT 1001U
#define MANIPULATOR_PORT 1000U
#define DATAGRAMS 16U

typedef struct {
    size_t size;
    uint8_t octets[MESSAGE_FRAME_MAX];
} datagram_t;

typedef struct { // One writer, one reader.
    uint32_t put;
    uint32_t taken;
    datagram_t datagrams[DATAGRAMS];
} way_t;

typedef struct { // Steps whose wait began in one state.
    uint32_t count;
    uint32_t missed;
    uint32_t early;
    uint32_t latest; ///< [counts of the timer]
    uint64_t first_ns;
    uint64_t last_ns; ///< Times at which the first and the last of them were due.
} waits_t;

static osal_shm_t run_shm;
static run_state_t* run;
static subsystem_t* manipulator;
static scripted_bus_t robot;
static scripted_bus_t robot_b; // No device is connected to it.
static way_t up;
static way_t down;
static osal_task_t surroundings;
static uint32_t is_over;
static uint32_t is_stopped;
static waits_t waits[STATE_COUNT];
static enum {
    HANG_NEVER,
    HANG_STEP,
    HANG_SERVICE
} hang;

// The supervisor.
static message_endpoint_t endpoint;
static message_slot_t place;
static pus_requester_t requester;
static uint32_t reports; ///< Packets that have arrived.
static uint64_t operational_ns;
static bool has_operated;

int __real_executive_run(int argument_count, char* const arguments[], const char* executable,
                         component_open_t open, const component_descriptors_t* descriptors);
int __wrap_executive_run(int argument_count, char* const arguments[], const char* executable,
                         component_open_t open, const component_descriptors_t* descriptors);
status_t __real_loop_tasks_start(loop_tasks_t* tasks, subsystem_t* component, uint64_t origin_ns);
status_t __wrap_loop_tasks_start(loop_tasks_t* tasks, subsystem_t* component, uint64_t origin_ns);
void __real_loop_tasks_stop(loop_tasks_t* tasks);
void __wrap_loop_tasks_stop(loop_tasks_t* tasks);
status_t __real_osal_clock_wait(osal_clock_t* clock, uint64_t wake_ns, osal_socket_t* const* sockets,
                                size_t socket_count);
status_t __wrap_osal_clock_wait(osal_clock_t* clock, uint64_t wake_ns, osal_socket_t* const* sockets,
                                size_t socket_count);
uint64_t __real_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
uint64_t __wrap_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
uint64_t __real_subsystem_loop_step(subsystem_t* subsystem, uint8_t loop, uint64_t now_ns);
uint64_t __wrap_subsystem_loop_step(subsystem_t* subsystem, uint8_t loop, uint64_t now_ns);
unsigned __wrap_osal_process_stop_count(void);
status_t __wrap_osal_file_sync_names(const char* path);
status_t __wrap_osal_socket_adopt(osal_socket_t* sock, int descriptor);
status_t __wrap_osal_udp_open(osal_socket_t* sock, osal_address_t local, size_t receive_bytes);
status_t __wrap_osal_udp_send(osal_socket_t* sock, osal_address_t to, const uint8_t* octets, size_t size);
status_t __wrap_osal_udp_receive(osal_socket_t* sock, osal_address_t* out_from, uint8_t* octets,
                                 size_t capacity, size_t* out_size);

// ---- Datagrams ----

static status_t put_datagram(way_t* const way, const uint8_t* const octets, const size_t size)
{
    const uint32_t put = __atomic_load_n(&way->put, __ATOMIC_RELAXED);
    if (((put - __atomic_load_n(&way->taken, __ATOMIC_ACQUIRE)) == DATAGRAMS) || (size > MESSAGE_FRAME_MAX)) {
        return STATUS_FULL;
    }
    datagram_t* const datagram = &way->datagrams[put % DATAGRAMS];
    datagram->size             = size;
    (void)memcpy(datagram->octets, octets, size);
    __atomic_store_n(&way->put, put + 1U, __ATOMIC_RELEASE);
    return STATUS_OK;
}

static status_t take_datagram(way_t* const way, uint8_t* const octets, const size_t capacity,
                              size_t* const out_size)
{
    const uint32_t taken = __atomic_load_n(&way->taken, __ATOMIC_RELAXED);
    if (taken == __atomic_load_n(&way->put, __ATOMIC_ACQUIRE)) {
        return STATUS_EMPTY;
    }
    const datagram_t* const datagram = &way->datagrams[taken % DATAGRAMS];
    *out_size                        = datagram->size;
    (void)memcpy(octets, datagram->octets, (datagram->size < capacity) ? datagram->size : capacity);
    __atomic_store_n(&way->taken, taken + 1U, __ATOMIC_RELEASE);
    return STATUS_OK;
}

status_t __wrap_osal_socket_adopt(osal_socket_t* const sock, const int descriptor)
{
    (void)descriptor;
    sock->descriptor = INT_MAX;
    return STATUS_OK;
}

status_t __wrap_osal_udp_open(osal_socket_t* const sock, const osal_address_t local,
                              const size_t receive_bytes)
{
    (void)local;
    (void)receive_bytes;
    sock->descriptor = INT_MAX;
    return STATUS_OK;
}

status_t __wrap_osal_udp_send(osal_socket_t* const sock, const osal_address_t to, const uint8_t* const octets,
                              const size_t size)
{
    (void)sock;
    return (to.port == SUPERVISOR_PORT) ? put_datagram(&up, octets, size) : STATUS_IO;
}

status_t __wrap_osal_udp_receive(osal_socket_t* const sock, osal_address_t* const out_from,
                                 uint8_t* const octets, const size_t capacity, size_t* const out_size)
{
    (void)sock;
    *out_from = (osal_address_t){0U, SUPERVISOR_PORT};
    return take_datagram(&down, octets, capacity, out_size);
}

// ---- The supervisor ----

static void must(const status_t status)
{
    if (status != STATUS_OK) {
        osal_console_print_error(status_text(status));
        port_exit(1);
    }
}

static status_t send_frame(void* const context, const uint16_t to, const uint8_t* const frame,
                           const size_t size)
{
    (void)context;
    (void)to;
    return put_datagram(&down, frame, size);
}

static status_t send_packet(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    return message_send(&endpoint, run->components[0].apid, packet, size);
}

static void open_supervisor(void)
{
    static const pus_port_t port = {NULL, send_packet};
    const uint16_t apid          = run->components[0].apid;
    message_open(&endpoint, SUPERVISOR_APID, 1U, (message_carrier_t){NULL, send_frame}, &place, 1U);
    must(message_add_peer(&endpoint, apid));
    must(message_set_window(&endpoint, SUPERVISOR_APID, MESSAGE_SMALL_WINDOW_OCTETS));
    must(message_set_window(&endpoint, apid, MESSAGE_SMALL_WINDOW_OCTETS));
    message_set_life(&endpoint, apid, 1U);
    pus_requester_init(&requester, SUPERVISOR_APID, &port);
}

static void request_state(const state_t target)
{
    octet_writer_t writer = pus_tc_begin(&requester, run->components[0].apid, PUS_SERVICE_MANAGEMENT,
                                         PUS_MANAGEMENT_REQUEST_STATE, PUS_ACK_ALL);
    octet_write_u8(&writer, (uint8_t)target);
    must(pus_tc_send(&requester, &writer, NULL));
}

static void select_configuration(void)
{
    octet_writer_t writer = pus_tc_begin(&requester, run->components[0].apid, PUS_SERVICE_MANAGEMENT,
                                         PUS_MANAGEMENT_SELECT, PUS_ACK_ALL);
    octet_write_u16(&writer, STAND_ALONE);
    must(pus_tc_send(&requester, &writer, NULL));
}

/// Request the values of a parameter, which the slow loop reports.
static void request_values(void)
{
    octet_writer_t writer = pus_tc_begin(&requester, run->components[0].apid, PUS_SERVICE_PARAMETERS,
                                         PUS_PARAMETERS_REPORT, PUS_ACK_ALL);
    octet_write_u8(&writer, 1U);
    octet_write_u32(&writer, manipulator->entries[COUNTERS].definition->id);
    must(pus_tc_send(&requester, &writer, NULL));
}

/// Request the next state on the way to OPERATIONAL, and back when the time of operation has passed.
static void command(const uint64_t now_ns)
{
    const state_machine_t* const machine = &manipulator->machine;
    request_values();
    if (machine->state == STATE_OPERATIONAL) {
        operational_ns = has_operated ? operational_ns : now_ns;
        has_operated   = true;
        if ((hang == HANG_NEVER) && ((now_ns - operational_ns) > OPERATION_NS)) {
            request_state(STATE_OFFLINE);
        }
    } else if (has_operated) {
        __atomic_store_n(&is_stopped, (machine->state == STATE_OFFLINE) ? 1U : 0U, __ATOMIC_RELEASE);
    } else if (machine->state == STATE_OFFLINE) {
        request_state(STATE_PRE_OPERATIONAL);
    } else if ((machine->state == STATE_PRE_OPERATIONAL) && (machine->phase == PHASE_UNCONFIGURED)) {
        select_configuration();
    } else if ((machine->state == STATE_PRE_OPERATIONAL) && (machine->phase == PHASE_CONFIGURED)) {
        request_state(STATE_SAFE_OPERATIONAL);
    } else if ((machine->state == STATE_SAFE_OPERATIONAL) && (machine->phase == PHASE_IDLE)) {
        request_state(STATE_OPERATIONAL);
    } else {
        // A transition or an action runs.
    }
}

static void receive(void)
{
    static uint8_t packet[MESSAGE_PAYLOAD_MAX];
    size_t size   = 0U;
    uint16_t from = 0U;
    while (take_datagram(&up, endpoint.frame, sizeof endpoint.frame, &size) == STATUS_OK) {
        must(message_accept(&endpoint, STATUS_OK, size));
    }
    message_take_control(&endpoint);
    while (message_receive(&endpoint, &from, packet, sizeof packet, &size) == STATUS_OK) {
        reports++;
    }
}

// ---- Drives and supervisor, in a task of their own ----

static void surround(void* const context)
{
    osal_clock_t clock;
    (void)context;
    osal_clock_open_real(&clock, run->origin_ns);
    uint64_t wake_ns = PERIOD_NS / 2U;
    for (uint32_t cycle = 1U; __atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U; cycle++) {
        wake_ns += PERIOD_NS;
        if (osal_clock_wait(&clock, wake_ns, NULL, 0U) != STATUS_OK) {
            return;
        }
        scripted_bus_run(&robot);
        scripted_bus_run(&robot_b);
        if ((cycle % HEARTBEAT_CYCLES) == 0U) {
            scripted_bus_heartbeat(&robot);
        }
        receive();
        if ((cycle % REQUEST_CYCLES) == 0U) {
            command(wake_ns);
        }
        if (wake_ns > LIMIT_NS) {
            __atomic_store_n(&is_stopped, 1U, __ATOMIC_RELEASE);
        }
    }
}

unsigned __wrap_osal_process_stop_count(void)
{
    return __atomic_load_n(&is_stopped, __ATOMIC_ACQUIRE);
}

// ---- The loop ----

/// The timer counts down from its largest value.
static uint32_t counts(void)
{
    return UINT32_MAX - *(volatile const uint32_t*)(BOARD_FREE_TIMER + 4U);
}

/// Only the loop of the program waits with sockets. The port does not support such a wait in real time,
/// so a message waits for the next step.
status_t __wrap_osal_clock_wait(osal_clock_t* const clock, const uint64_t wake_ns,
                                osal_socket_t* const* const sockets, const size_t socket_count)
{
    (void)sockets;
    if ((socket_count == 0U) || (manipulator == NULL)) {
        return __real_osal_clock_wait(clock, wake_ns, NULL, 0U);
    }
    waits_t* const row    = &waits[manipulator->machine.state];
    const uint64_t due_ns = clock->origin_ns + wake_ns;
    row->missed += (osal_clock_monotonic_ns() > due_ns) ? 1U : 0U;
    row->first_ns         = (row->count == 0U) ? wake_ns : row->first_ns;
    row->last_ns          = wake_ns;
    const status_t status = __real_osal_clock_wait(clock, wake_ns, NULL, 0U);
    const int32_t late    = (int32_t)(counts() - (uint32_t)(due_ns / BOARD_CLOCK_NS));
    row->count++;
    row->early += (late < 0) ? 1U : 0U;
    row->latest = ((late > 0) && ((uint32_t)late > row->latest)) ? (uint32_t)late : row->latest;
    return status;
}

uint64_t __wrap_subsystem_step(subsystem_t* const subsystem, const uint64_t now_ns)
{
    while ((hang == HANG_STEP) && (now_ns > HANG_NS)) {
    }
    return __real_subsystem_step(subsystem, now_ns);
}

uint64_t __wrap_subsystem_loop_step(subsystem_t* const subsystem, const uint8_t loop, const uint64_t now_ns)
{
    while ((hang == HANG_SERVICE) && (loop == 0U) && (now_ns > HANG_NS)) {
    }
    return __real_subsystem_loop_step(subsystem, loop, now_ns);
}

// ---- Beginning and end ----

status_t __wrap_osal_file_sync_names(const char* const path)
{
    (void)path;
    return STATUS_OK; // The files are those of the machine that runs the emulator.
}

static void print_results(void)
{
    port_stack_t stacks[PORT_STACKS_MAX];
    const size_t count = port_stacks(stacks);
    for (uint32_t state = 0U; state < (uint32_t)STATE_COUNT; state++) {
        const waits_t* const row = &waits[state];
        const uint32_t numbers[] = {
            state,       row->count, (uint32_t)((row->last_ns - row->first_ns) / 1000U),
            row->missed, row->early, row->latest};
        if (row->count > 0U) {
            print_numbers("LOOP", "", numbers, sizeof numbers / sizeof numbers[0]);
        }
    }
    for (size_t i = 0U; i < count; i++) {
        const uint32_t numbers[] = {(uint32_t)stacks[i].size, (uint32_t)stacks[i].used};
        print_numbers("STACK ", stacks[i].name, numbers, 2U);
    }
    print_numbers("REPORTS", "", &reports, 1U);
}

status_t __wrap_loop_tasks_start(loop_tasks_t* const tasks, subsystem_t* const component,
                                 const uint64_t origin_ns)
{
    manipulator = component;
    must(osal_task_start(&surroundings, surround, NULL, PRIORITY));
    return __real_loop_tasks_start(tasks, component, origin_ns);
}

/// Prints before the tasks of the loops are stopped, because their stacks exist only until then.
void __wrap_loop_tasks_stop(loop_tasks_t* const tasks)
{
    __atomic_store_n(&is_over, 1U, __ATOMIC_RELEASE);
    osal_task_join(&surroundings);
    print_results();
    __real_loop_tasks_stop(tasks);
}

static void open_buses(void)
{
    scripted_bus_open(&robot, "robot");
    scripted_bus_open(&robot_b, "robot-b");
    for (unsigned i = 0U; i < 2U; i++) {
        scripted_node_t* const joint = scripted_bus_add(&robot, SCRIPTED_DRIVE, (uint8_t)(0x11U + i));
        // The arm rests in its home pose; gravity acts on it.
        joint->position[0] = (i == 0U) ? 1047935 : -1570531;
        joint->torque[0]   = (i == 0U) ? 590 : 212;
    }
}

/// Write what the launcher writes on Linux. *context stays false if the program was not compiled for the
/// mission.
static void make_run(void* const context)
{
    bool* const is_made                          = (bool*)context;
    const compiled_descriptors_t* const compiled = compiled_descriptors_of_program();
    const compiled_descriptor_t* entry           = NULL;
    for (size_t i = 0U; i < compiled->count; i++) {
        entry = (strcmp(compiled->entries[i].mission->name, MISSION) == 0) ? &compiled->entries[i] : entry;
    }
    if ((entry == NULL) || (run_state_create(&run_shm, "board", &run) != STATUS_OK)) {
        return;
    }
    run->is_real         = true;
    run->origin_ns       = ((osal_clock_monotonic_ns() / MS) + 1U) * MS;
    run->mission_hash    = entry->mission_hash;
    run->link_methods    = (uint8_t)(1U << (unsigned)RTLINK_METHOD_UDP);
    run->component_count = 2U;
    run->components[0] =
        (run_component_t){.apid = entry->apid, .name = "MANIPULATOR", .message_port = MANIPULATOR_PORT};
    run->components[1] =
        (run_component_t){.apid = SUPERVISOR_APID, .name = "SUPERVISOR", .message_port = SUPERVISOR_PORT};
    for (unsigned i = 0U; i < 2U; i++) {
        run->components[i].message_window = MESSAGE_SMALL_WINDOW_OCTETS;
        run->components[i].life           = 1U;
        run->components[i].found_life     = 1U;
        run->components[i].process        = (uint32_t)RUN_PROCESS_RUNNING;
    }
    for (unsigned i = 0U; i < RUN_LINKS_MAX; i++) {
        run->link_descriptors[i] = -1;
    }
    (void)strcpy(run->storage, ".");
    (void)strcpy(run->mission_path, "descriptors/missions/" MISSION ".xml");
    open_buses();
    for (uint16_t i = 0U; i < entry->mission->bus_count; i++) {
        const char* const name    = entry->mission->buses[i].name;
        const char* const address = (strcmp(name, "robot") == 0)     ? robot.address
                                    : (strcmp(name, "robot-b") == 0) ? robot_b.address
                                                                     : "";
        (void)strcpy(run->buses[i].flight, address);
    }
    open_supervisor();
    *is_made = true;
}

int __wrap_executive_run(const int argument_count, char* const arguments[], const char* const executable,
                         const component_open_t open, const component_descriptors_t* const descriptors)
{
    char program[]                 = "manipulator";
    char run_option[]              = "--run";
    char run_of_board[]            = "/board.run";
    char component_option[]        = "--component";
    char component[]               = "0";
    char* const arguments_of_run[] = {program, run_option, run_of_board, component_option, component, NULL};
    if (argument_count > 1) {
        hang = (strcmp(arguments[1], "hang") == 0) ? HANG_STEP : HANG_SERVICE;
    }
    bool is_made = false;
    must(osal_task_start(&surroundings, make_run, &is_made, 0)); // In a task, to spare the stack of main.
    osal_task_join(&surroundings);
    if (!is_made) {
        osal_console_print_error("the program was not compiled for " MISSION);
        return 1;
    }
    return __real_executive_run(5, arguments_of_run, executable, open, descriptors);
}
