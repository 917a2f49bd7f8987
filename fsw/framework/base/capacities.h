// SPDX-License-Identifier: Apache-2.0
/// How many of each kind one spacecraft can have: one set for flight software, launcher and operating system
/// layer. A table that must hold one entry for each of them takes its size from here; where two tables depend
/// on each other, the source that needs both checks the inequality when it is compiled. What a mission
/// descriptor asks for beyond these is refused when it is loaded, with file, line and the limit.
#ifndef FSW_FRAMEWORK_BASE_CAPACITIES_H
#define FSW_FRAMEWORK_BASE_CAPACITIES_H

#define CAPACITY_SUBSYSTEMS 16U      ///< Of a mission, the supervisor and communication included.
#define CAPACITY_LINKS 32U           ///< Real-time links of a mission.
#define CAPACITY_SUBSYSTEM_LINKS 8U  ///< Real-time links that one subsystem has a part in.
#define CAPACITY_PORT_LINKS 4U       ///< Real-time links that begin at one port: its readers.
#define CAPACITY_BUSES 8U            ///< CAN buses of a mission.
#define CAPACITY_NODES 2U            ///< On-board computers.
#define CAPACITY_RING_RECORDS 15000U ///< Of the packet log in memory.
/// Reports of all HIGH events of a subsystem, each once: room that is never lent to others [octets].
#define CAPACITY_HIGH_EVENTS 2048U
#define CAPACITY_HIGH_EVENT_HEAD 27U ///< Of each, beside its auxiliary data [octets].
/// Who takes part in stepped time: every subsystem, the simulator, the operator, and a reserve of six.
#define CAPACITY_PARTICIPANTS (CAPACITY_SUBSYSTEMS + 8U)

/// Fails to compile where the condition does not hold; `name` says what must hold.
#define CAPACITY_CHECK(name, condition)                                                                      \
    typedef char name[(condition) ? 1 : -1] // NOLINT(bugprone-macro-parentheses): declares the name

#endif // FSW_FRAMEWORK_BASE_CAPACITIES_H
