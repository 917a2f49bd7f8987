// SPDX-License-Identifier: Apache-2.0
// The CAN buses of a run. They are rings in shared memory, or virtual interfaces, which the launcher creates
// and removes, or real controllers, which it checks.
#include "launcher/launcher_internal.h"

#include "osal/include/osal/can.h"
#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/console.h"

#include <string.h>

/// Label of an interface that a run has created. A later run recognizes it by the label and removes it.
#define LABEL "hirosco: removed with its run"
#define MTU_FD "72"
#define MTU_CLASSIC "16"

// ---- Refusals ----

static bool refuse(launcher_t* const launcher, const char* const first, const char* const second,
                   const char* const third, const char* const fourth)
{
    return launcher_refuse(launcher, (const char* const[]){first, second, third, fourth, NULL});
}

/// Refuse the run because a virtual interface cannot be created. If the kernel supports it, the message
/// contains the commands by which root creates both interfaces of the bus.
static bool refuse_to_create(launcher_t* const launcher, const launcher_bus_t* const bus,
                             const status_t status)
{
    text_t text         = text_in(launcher->reason, sizeof launcher->reason);
    launcher->exit_code = 1;
    if (status == STATUS_UNSUPPORTED) {
        text_add(&text, "this kernel has no SocketCAN, or no vcan: --bus shm needs neither, and "
                        "the micro-VM, which `make vm` starts, has both");
        return false;
    }
    text_add(&text, (status == STATUS_DENIED)
                        ? "creating CAN interfaces is not permitted here; as root, once:"
                        : "cannot create the CAN interfaces; try as root:");
    const char* const names[] = {bus->published, bus->flight};
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        text_add_words(&text, (const char* const[]){" ip link add ", names[i], " mtu ",
                                                    bus->is_fd ? MTU_FD : MTU_CLASSIC,
                                                    " type vcan; ip link set ", names[i], " up;", NULL});
    }
    text_add(&text, " and the same for each bus");
    return false;
}

/// Add the bit rates of a bus: the nominal one, and that of the data phase if there is one.
static void add_rates(text_t* const text, const uint32_t bit_rate, const uint32_t data_bit_rate)
{
    text_add_unsigned(text, bit_rate);
    if (data_bit_rate > 0U) {
        text_add(text, "/");
        text_add_unsigned(text, data_bit_rate);
    }
}

static bool refuse_rate(launcher_t* const launcher, const mission_bus_t* const wanted, const char* const name,
                        const osal_can_interface_t* const seen)
{
    text_t text = text_in(launcher->reason, sizeof launcher->reason);
    text_add(&text, name);
    text_add(&text, " runs at ");
    add_rates(&text, seen->bit_rate, seen->data_bit_rate);
    text_add_words(&text, (const char* const[]){" bit/s, bus ", wanted->name, " of the mission at ", NULL});
    add_rates(&text, wanted->bit_rate, wanted->data_bit_rate);
    text_add_words(&text, (const char* const[]){"; as root: ip link set ", name, " down; ip link set ", name,
                                                " up type can bitrate ", NULL});
    text_add_unsigned(&text, wanted->bit_rate);
    if (wanted->data_bit_rate > 0U) {
        text_add(&text, " dbitrate ");
        text_add_unsigned(&text, wanted->data_bit_rate);
        text_add(&text, " fd on");
    }
    launcher->exit_code = 1;
    return false;
}

/// Refuse the run because of the state of an interface. The message contains the command that takes the
/// interface down and up again with the change.
static bool refuse_state(launcher_t* const launcher, const char* const name, const char* const what,
                         const char* const change)
{
    return launcher_refuse(launcher,
                           (const char* const[]){name, what, "; as root: ip link set ", name,
                                                 " down; ip link set ", name, " up ", change, NULL});
}

/// Refuse the run because the properties of an interface cannot be read.
static bool refuse_query(launcher_t* const launcher, const char* const name, const status_t status)
{
    switch (status) {
    case STATUS_INVALID:
        return refuse(launcher,
                      "no interface can have this name, which has more than 15 characters or a "
                      "character that is not allowed: ",
                      name, "", "");
    case STATUS_UNSUPPORTED:
        return refuse(launcher, "this kernel has no SocketCAN, which ", name,
                      " needs: use --bus shm, or a kernel with it (make vm)", "");
    case STATUS_NOT_FOUND:
        return refuse(launcher, "there is no interface ", name,
                      "; `ip -details link show type can` lists the controllers", "");
    case STATUS_NOT_OURS:
        return refuse(launcher, name, " is an interface, but not for CAN; `ip link show type can` lists them",
                      "", "");
    default:
        return refuse(launcher, "cannot query the interface ", name, ": ", status_text(status));
    }
}

// ---- Required properties of interfaces ----

/// Check that the interface is up, not bus-off, and carries the frames of the mission's bus, and that it has
/// the bit rate of the bus if the kernel reports one.
static bool is_fit(launcher_t* const launcher, const mission_bus_t* const wanted, const char* const name,
                   const osal_can_interface_t* const seen)
{
    const bool is_fd = (wanted->data_bit_rate > 0U);
    if (is_fd && !seen->carries_fd && !seen->is_virtual) {
        return refuse(launcher, name, " carries classic frames only (mtu 16), and bus ", wanted->name,
                      " of the mission is CAN FD: enable FD (ip link set ... type can ... fd on), or fly a "
                      "mission whose bus has no dataBitRate, such as --mission classic");
    }
    if (is_fd && !seen->carries_fd) {
        return refuse_state(launcher, name,
                            " carries classic frames only (mtu 16), and the mission's bus is CAN FD",
                            "mtu 72");
    }
    const bool is_reported = (seen->bit_rate > 0U);
    if (is_reported &&
        ((seen->bit_rate != wanted->bit_rate) || (is_fd && (seen->data_bit_rate != wanted->data_bit_rate)))) {
        return refuse_rate(launcher, wanted, name, seen);
    }
    if (!seen->is_up) {
        return refuse(launcher, name, " is down; as root: ip link set ", name, " up");
    }
    if (seen->is_bus_off) {
        return refuse_state(launcher, name, " is bus-off; check wiring and termination", "");
    }
    return true;
}

// ---- Virtual interfaces ----

/// Use the existing interface, or create it. If an existing interface has LABEL, a run that was killed has
/// created it; *out_is_made is true for it, too, so that this run removes it at its end.
static bool prepare_virtual(launcher_t* const launcher, launcher_bus_t* const bus,
                            const mission_bus_t* const wanted, const char* const name,
                            bool* const out_is_made)
{
    osal_can_interface_t seen;
    status_t status = osal_can_interface_look(name, &seen);
    if (status == STATUS_NOT_FOUND) {
        status       = osal_can_interface_create(name, bus->is_fd, LABEL);
        *out_is_made = (status == STATUS_OK);
        return *out_is_made || refuse_to_create(launcher, bus, status);
    }
    if (status == STATUS_UNSUPPORTED) {
        return refuse_to_create(launcher, bus, status);
    }
    if (status != STATUS_OK) {
        return refuse_query(launcher, name, status);
    }
    *out_is_made = (strcmp(seen.label, LABEL) == 0);
    return is_fit(launcher, wanted, name, &seen);
}

/// Make the names of the two virtual interfaces of a bus: "fsw-BUS" connects flight software and simulator,
/// and "vcan-BUS" shows the frames to other programs. False if the name of the bus is too long.
static bool name_virtual(launcher_bus_t* const bus, const mission_bus_t* const wanted)
{
    return text_join(bus->published, sizeof bus->published,
                     (const char* const[]){"vcan-", wanted->name, NULL}) &&
           text_join(bus->flight, sizeof bus->flight, (const char* const[]){"fsw-", wanted->name, NULL});
}

static bool create_vcan(launcher_t* const launcher, launcher_bus_t* const bus,
                        const mission_bus_t* const wanted)
{
    if (!name_virtual(bus, wanted)) {
        return refuse(launcher, "the name of bus ", wanted->name,
                      " is too long: vcan-BUS is the name of an interface, at most 15 characters", "");
    }
    const status_t status = osal_can_interface_claim(bus->published, &bus->claim);
    if ((status != STATUS_OK) && (status != STATUS_EXISTS)) {
        return refuse(launcher, "cannot claim the interface ", bus->published, ": ", status_text(status));
    }
    if (status == STATUS_EXISTS) {
        return refuse(launcher, "another run flies on ", bus->published,
                      ": wait for its end, or start this run in another network namespace (ip netns add, "
                      "ip netns exec)",
                      "");
    }
    return prepare_virtual(launcher, bus, wanted, bus->published, &bus->is_published_made) &&
           prepare_virtual(launcher, bus, wanted, bus->flight, &bus->is_flight_made);
}

// ---- Real controllers ----

/// Returns the interface that the command line names for a bus; null if there is none.
static const char* interface_of(const char* const* const list, const size_t count, const char* const bus)
{
    const size_t length = strlen(bus);
    for (size_t i = 0U; i < count; i++) {
        if ((strncmp(list[i], bus, length) == 0) && (list[i][length] == '=')) {
            return &list[i][length + 1U];
        }
    }
    return NULL;
}

static bool check_controller(launcher_t* const launcher, const mission_bus_t* const wanted,
                             const char* const name)
{
    osal_can_interface_t seen;
    const status_t status = osal_can_interface_look(name, &seen);
    return (status == STATUS_OK) ? is_fit(launcher, wanted, name, &seen)
                                 : refuse_query(launcher, name, status);
}

static bool check_controllers(launcher_t* const launcher, launcher_bus_t* const bus,
                              const mission_bus_t* const wanted)
{
    const launch_options_t* const options = &launcher->options;
    const char* const flight = interface_of(options->interfaces, options->interface_count, wanted->name);
    const char* const simulated =
        interface_of(options->sim_interfaces, options->sim_interface_count, wanted->name);
    if ((flight == NULL) && (wanted->redundant_to[0] != '\0')) {
        return true; // The bus is a channel B, which this run does not have.
    }
    if (flight == NULL) {
        return refuse(launcher, "no interface is named for bus ", wanted->name,
                      " of the mission: add --interface BUS=INTERFACE (make: ROBOT_IF=, JOYSTICK_IF=)", "");
    }
    if ((simulated == NULL) && (options->sim_interface_count > 0U)) {
        return refuse(launcher, "no interface of the simulator is named for bus ", wanted->name,
                      ": add --sim-interface BUS=INTERFACE (make: SIM_ROBOT_IF=, SIM_JOYSTICK_IF=)", "");
    }
    // Both ends may use one virtual interface. A real controller needs another node on the wire, which
    // acknowledges its frames.
    osal_can_interface_t seen;
    if ((simulated != NULL) && (strcmp(flight, simulated) == 0) &&
        ((osal_can_interface_look(flight, &seen) != STATUS_OK) || !seen.is_virtual)) {
        return refuse(launcher, "flight and simulator need separate controllers; both have ", flight,
                      " for bus ", wanted->name);
    }
    if (!check_controller(launcher, wanted, flight) ||
        ((simulated != NULL) && !check_controller(launcher, wanted, simulated))) {
        return false;
    }
    (void)text_join(bus->flight, sizeof bus->flight, (const char* const[]){flight, NULL});
    (void)text_join(bus->simulator, sizeof bus->simulator, (const char* const[]){simulated, NULL});
    return true;
}

/// Check that each bus that the command line names is a bus of the mission.
static bool are_buses_known(launcher_t* const launcher, const char* const* const list, const size_t count)
{
    for (size_t i = 0U; i < count; i++) {
        bool is_known = false;
        for (uint16_t k = 0U; k < launcher->mission.bus_count; k++) {
            is_known = is_known || (interface_of(&list[i], 1U, launcher->mission.buses[k].name) != NULL);
        }
        if (!is_known) {
            return refuse(launcher, "the mission has no such bus: ", list[i],
                          "; its file lists them in <Buses>", "");
        }
    }
    return true;
}

// ---- All kinds of buses ----

/// Compose the address of a bus: "shm:SHARED", "can:INTERFACE" or "can:INTERFACE@SHARED".
static void write_address(char out_address[RUN_NAME_MAX], const char* const interface,
                          const char* const shared)
{
    const bool is_shm    = (interface[0] == '\0');
    const char* const at = (!is_shm && (shared[0] != '\0')) ? "@" : "";
    (void)text_join(out_address, RUN_NAME_MAX,
                    (const char* const[]){is_shm ? "shm:" : "can:", interface, at, shared, NULL});
}

bool launcher_ready_interfaces(launcher_t* const launcher)
{
    const launch_options_t* const options = &launcher->options;
    bool is_ready = are_buses_known(launcher, options->interfaces, options->interface_count) &&
                    are_buses_known(launcher, options->sim_interfaces, options->sim_interface_count);
    for (uint16_t i = 0U; is_ready && (i < launcher->mission.bus_count); i++) {
        const mission_bus_t* const wanted = &launcher->mission.buses[i];
        launcher_bus_t* const bus         = &launcher->buses[i];
        bus->is_fd                        = (wanted->data_bit_rate > 0U);
        if (options->bus == LAUNCH_BUS_VCAN) {
            is_ready = create_vcan(launcher, bus, wanted);
        } else if (options->bus == LAUNCH_BUS_CAN) {
            is_ready = check_controllers(launcher, bus, wanted);
        } else {
            // Shared memory needs no preparation.
        }
    }
    return is_ready;
}

static bool create_bus(launcher_t* const launcher, const uint16_t index)
{
    const launcher_bus_t* const bus = &launcher->buses[index];
    run_bus_t* const address        = &launcher->run->buses[index];
    if ((launcher->options.bus == LAUNCH_BUS_CAN) && (bus->flight[0] == '\0')) {
        return true;
    }
    // If the devices are real, no simulator counts the frames: the bus has no shared memory for counts.
    if (!launch_has_simulator(&launcher->options)) {
        write_address(address->flight, bus->flight, "");
        return true;
    }
    char shared[RUN_NAME_MAX];
    const char* const name = launcher->mission.buses[index].name;
    const bool is_whole =
        text_join(shared, sizeof shared, (const char* const[]){launcher->run->identity, ".can.", name, NULL});
    write_address(address->flight, bus->flight, shared);
    write_address(address->simulator, (bus->simulator[0] != '\0') ? bus->simulator : bus->flight, shared);
    if (bus->published[0] != '\0') {
        write_address(address->published, bus->published, "");
    }
    const status_t status = is_whole ? osal_can_create(address->simulator) : STATUS_INVALID;
    return (status == STATUS_OK) ||
           refuse(launcher, "cannot create the bus ", address->simulator, ": ", status_text(status));
}

bool launcher_create_buses(launcher_t* const launcher)
{
    bool is_created = true;
    for (uint16_t i = 0U; is_created && (i < launcher->mission.bus_count); i++) {
        is_created = create_bus(launcher, i);
    }
    return is_created;
}

/// Print the counts of a bus if frames were late, lost or from outside the run, or if calls failed.
static void print_hand_over(launcher_t* const launcher, const char* const bus, const char* const address)
{
    osal_can_hand_over_t counts;
    if (osal_can_hand_over(address, &counts) != STATUS_OK) {
        return;
    }
    launcher->late_frames += counts.late;
    launcher->lost_frames += counts.lost;
    launcher->external_frames += counts.external;
    launcher->bus_cuts += counts.cuts;
    if ((counts.late + counts.lost + counts.external + counts.cuts) == 0U) {
        return;
    }
    char line[224];
    text_t text = text_in(line, sizeof line);
    text_add(&text, "bus ");
    text_add(&text, bus);
    text_add(&text, ": ");
    text_add_unsigned(&text, counts.frames);
    text_add(&text, " frames transferred, ");
    text_add_unsigned(&text, counts.late);
    text_add(&text, " of them late; ");
    text_add_unsigned(&text, counts.lost);
    text_add(&text, " frames lost; ");
    text_add_unsigned(&text, counts.external);
    text_add(&text, " frames from outside the run; ");
    text_add_unsigned(&text, counts.cuts);
    text_add(&text, " calls failed: interface down or removed");
    osal_console_print_line(line);
}

void launcher_remove_buses(launcher_t* const launcher)
{
    for (uint16_t i = 0U; i < launcher->mission.bus_count; i++) {
        launcher_bus_t* const bus = &launcher->buses[i];
        if (launcher->run != NULL) {
            const run_bus_t* const address = &launcher->run->buses[i];
            print_hand_over(launcher, launcher->mission.buses[i].name, address->simulator);
            (void)osal_can_destroy(address->simulator);
        }
        if (bus->is_flight_made) {
            (void)osal_can_interface_remove(bus->flight);
        }
        if (bus->is_published_made) {
            (void)osal_can_interface_remove(bus->published);
        }
        osal_can_interface_release(&bus->claim);
        bus->is_flight_made    = false;
        bus->is_published_made = false;
    }
}

/// True if a killed launcher has created this interface and not removed it.
static bool is_left_behind(const char* const name)
{
    osal_can_interface_t seen;
    return (osal_can_interface_look(name, &seen) == STATUS_OK) && (strcmp(seen.label, LABEL) == 0);
}

void launcher_adopt_interfaces(launcher_t* const launcher)
{
    const bool are_made = (launcher->options.bus == LAUNCH_BUS_VCAN);
    for (uint16_t i = 0U; are_made && (i < launcher->mission.bus_count); i++) {
        launcher_bus_t* const bus = &launcher->buses[i];
        // If another run has claimed the interfaces since the launcher was killed, that run removes them.
        if (name_virtual(bus, &launcher->mission.buses[i]) &&
            (osal_can_interface_claim(bus->published, &bus->claim) == STATUS_OK)) {
            bus->is_published_made = is_left_behind(bus->published);
            bus->is_flight_made    = is_left_behind(bus->flight);
        }
    }
}
