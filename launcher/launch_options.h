// SPDX-License-Identifier: Apache-2.0
/// Command line of the launcher: the options of `hirosco run`, and the check of their combinations.
#ifndef LAUNCHER_LAUNCH_OPTIONS_H
#define LAUNCHER_LAUNCH_OPTIONS_H

#include "fsw/framework/descriptor/mission_descriptor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LAUNCH_PATH_MAX 256U
#define LAUNCH_ERROR_MAX 384U
#define LAUNCH_SCENARIO "telepresence" ///< Flown if no scenario has the name of the mission.

#define LAUNCH_INTERFACES_MAX MISSION_BUSES_MAX

typedef enum {
    LAUNCH_BUS_SHM,  ///< Rings in shared memory.
    LAUNCH_BUS_VCAN, ///< SocketCAN over virtual interfaces, with the simulator as gateway.
    LAUNCH_BUS_CAN   ///< SocketCAN over the interfaces that the command line names: real controllers.
} launch_bus_t;

typedef struct {
    const char* mission; ///< Name; the descriptor is descriptors/missions/<name>.xml.
    /// Name (the file is sim/scenarios/<name>.scn), or path (with a slash or the ending .scn). "none": no
    /// operator, no hand, no faults. Empty: the mission's name, or LAUNCH_SCENARIO if there is no such file.
    const char* scenario;
    /// Name (the file is descriptors/worlds/<name>.xml), or path (with a slash or the ending .xml).
    const char* world;
    uint64_t seed;
    bool is_image;
    bool is_stepped; ///< Discrete time; the default with a simulator.
    bool is_free;    ///< Every process, including the simulator, has its own clock; there is no scheduler.
    launch_bus_t bus;
    const char* interfaces[LAUNCH_INTERFACES_MAX]; ///< "BUS=INTERFACE": controllers of flight.
    size_t interface_count;
    /// "BUS=INTERFACE": controllers of the simulator on the same wires.
    const char* sim_interfaces[LAUNCH_INTERFACES_MAX];
    size_t sim_interface_count;
    const char* transport; ///< "udp" or "tipc"; "": that of the mission.
    const char* links;     ///< "shm", "udp" or "tipc"; "": that of the mission.
    uint8_t computers;     ///< On-board computers, 1 or 2.
    uint16_t port;         ///< Ground port; 0: the first free port, beginning with that of the mission.
    uint16_t delay_ms;     ///< Round-trip delay of the links, through a relay; 0: no delay.
    uint16_t tools;        ///< Port of the simulator's socketcand server for bus tools; 0: none.
    const char* output;    ///< Output directory; empty: a new one under runs/.
    const char* storage; ///< Directory of persistent records, stores and files; empty: "storage" in `output`.
    const char* key;     ///< File with the key of telecommands; empty: the mission's.
    const char* remote_endian; ///< Subsystem with a program of another byte order and a proxy; "": none.
    /// Subsystems whose programs run on FreeRTOS on an emulated board, separated by commas; "": none.
    const char* rtos;
    uint64_t duration_ns; ///< Shut the mission down after this simulated time; 0: never.
    bool has_report;
} launch_options_t;

/// Parse the command line. Options that were given as empty text count as not given (a Makefile passes all of
/// them). False with a line in `error`: unknown option, invalid value, or an impossible combination with the
/// reason.
bool launch_options_parse(int argument_count, char* const arguments[], launch_options_t* out_options,
                          char error[LAUNCH_ERROR_MAX]);
/// True if a text is the path of a file, not a name: it contains a slash or ends with `ending`.
bool launch_is_path(const char* text, const char* ending);
/// True if the simulator takes part: it simulates all buses, except buses with real devices.
bool launch_has_simulator(const launch_options_t* options);
/// True if a scheduler controls simulated time: with a simulator, unless every process has its own clock.
bool launch_has_scheduler(const launch_options_t* options);
/// Returns the kind of time in the words of the command line: "stepped", "real" or "free".
const char* launch_time_text(const launch_options_t* options);
/// Returns the carrier of buses in the words of the command line: "shm", "vcan" or "can".
const char* launch_bus_text(launch_bus_t bus);
/// Returns the help text of `hirosco run`.
const char* launch_options_help(void);

#endif // LAUNCHER_LAUNCH_OPTIONS_H
