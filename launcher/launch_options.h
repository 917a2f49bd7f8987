// SPDX-License-Identifier: Apache-2.0
/// Command line of the launcher: `hirosco run` with its options, and which combinations make sense.
#ifndef LAUNCHER_LAUNCH_OPTIONS_H
#define LAUNCHER_LAUNCH_OPTIONS_H

#include "fsw/framework/descriptor/mission_descriptor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LAUNCH_PATH_MAX 256U
#define LAUNCH_ERROR_MAX 384U

#define LAUNCH_INTERFACES_MAX MISSION_BUSES_MAX

typedef enum {
    LAUNCH_BUS_SHM,  ///< Shared memory.
    LAUNCH_BUS_VCAN, ///< SocketCAN over virtual interfaces, with the simulator as gateway.
    LAUNCH_BUS_CAN   ///< SocketCAN over the interfaces named: real controllers.
} launch_bus_t;

typedef struct {
    const char* mission;  ///< Name; the descriptor is descriptors/missions/<name>.xml.
    const char* scenario; ///< Name; the file is sim/scenarios/<name>.scn. Or its path, known by a slash or
                          ///< the ending .scn. "none": no operator, no hand, no faults.
    const char* world; ///< Name; the file is descriptors/worlds/<name>.xml. Or its path, known by a slash or
                       ///< the ending .xml.
    uint64_t seed;
    bool is_image;
    bool is_stepped; ///< Discrete time; the default with a simulator.
    bool is_free;    ///< Every process has its own clock, also the simulator; there is no scheduler.
    launch_bus_t bus;
    const char* interfaces[LAUNCH_INTERFACES_MAX]; ///< "BUS=INTERFACE": flight's controllers.
    size_t interface_count;
    const char*
        sim_interfaces[LAUNCH_INTERFACES_MAX]; ///< "BUS=INTERFACE": the simulator's, on the same wires.
    size_t sim_interface_count;
    const char* transport; ///< "udp" or "tipc"; "": that of the mission.
    const char* links;     ///< "shm", "udp" or "tipc"; "": that of the mission.
    uint8_t computers;     ///< On-board computers, 1 or 2.
    uint16_t port;         ///< Ground port; 0: the first free from the mission's.
    uint16_t delay_ms;     ///< Round trip of the links, through a relay; 0: they have none.
    uint16_t tools;        ///< Port of the simulator's socketcand server for bus tools; 0: none.
    const char* output;    ///< Output folder; empty: a new one under runs/.
    const char*
        storage; ///< Folder of persistent records, stores and files; empty: "storage" in the output folder.
    const char* key;           ///< File with the key of telecommands; empty: the mission's.
    const char* remote_endian; ///< Subsystem with a program of another byte order and a proxy; "": none.
    uint64_t duration_ns;      ///< Shut the mission down after this simulated time; 0: never.
    bool has_report;
} launch_options_t;

/// Parse the command line. Options that were given as empty text count as not given (a Makefile passes all of
/// them). False with a line in `error`: unknown option, bad value, or a combination that is not possible,
/// with the reason.
bool launch_options_parse(int argument_count, char* const arguments[], launch_options_t* out_options,
                          char error[LAUNCH_ERROR_MAX]);
/// A file is given by its path: it has a slash or the ending.
bool launch_is_path(const char* text, const char* ending);
/// True if the simulator takes part: on all buses but those of real devices.
bool launch_has_simulator(const launch_options_t* options);
/// True if a scheduler keeps simulated time: with a simulator, unless every process has its own clock.
bool launch_has_scheduler(const launch_options_t* options);
/// How time passes, in the words of the command line: "stepped", "real" or "free".
const char* launch_time_text(const launch_options_t* options);
/// The carrier of buses in words of the command line: "shm", "vcan" or "can".
const char* launch_bus_text(launch_bus_t bus);
const char* launch_options_help(void);

#endif // LAUNCHER_LAUNCH_OPTIONS_H
