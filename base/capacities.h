// SPDX-License-Identifier: Apache-2.0
/// Capacities of one spacecraft: one set for flight software, launcher and operating system layer. Tables of
/// subsystems, links, buses and so on take their sizes from here. If two tables depend on each other, the
/// source that uses both checks the relation at compile time. A mission descriptor that exceeds a capacity is
/// refused when it is loaded, with file, line and the limit.
#ifndef BASE_CAPACITIES_H
#define BASE_CAPACITIES_H

#define CAPACITY_SUBSYSTEMS 16U      ///< Subsystems of a mission, including supervisor and communication.
#define CAPACITY_LINKS 32U           ///< Real-time links of a mission.
#define CAPACITY_SUBSYSTEM_LINKS 8U  ///< Real-time links that begin or end at one subsystem.
#define CAPACITY_PORT_LINKS 4U       ///< Real-time links that begin at one port, one for each reader.
#define CAPACITY_BUSES 8U            ///< CAN buses of a mission.
#define CAPACITY_COMPUTERS 2U        ///< On-board computers.
#define CAPACITY_RING_RECORDS 15000U ///< Records in the ring of the packet log, which is in memory.
/// Room reserved for one report of each HIGH event of a subsystem [octets].
#define CAPACITY_HIGH_EVENTS 2048U
#define CAPACITY_HIGH_EVENT_HEAD 27U ///< Size of each report without its auxiliary data [octets].
/// Participants of stepped time: every subsystem, the simulator, the operator, and a reserve of six.
#define CAPACITY_PARTICIPANTS (CAPACITY_SUBSYSTEMS + 8U)

/// Length of an array of the model into which a descriptor is read; a descriptor may have `most` items. A
/// build for a target whose descriptors are compiled into its programs replaces this macro: it reads no
/// descriptor, so the arrays are not used.
#ifndef CAPACITY_OF_STORAGE
#define CAPACITY_OF_STORAGE(most) (most)
#endif

/// Does not compile if the condition is false; `name` is the condition in words.
#define CAPACITY_CHECK(name, condition)                                                                      \
    typedef char name[(condition) ? 1 : -1] // NOLINT(bugprone-macro-parentheses): declares the name

#endif // BASE_CAPACITIES_H
