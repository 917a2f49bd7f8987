// SPDX-License-Identifier: Apache-2.0
/// Storage of the on-board control procedures of ST[18], with the engine that runs them. All of it is static.
/// It has room for the largest capacity that a descriptor may grant.
///
/// A cycle of procedures is SPACECRAFT_PROCEDURE_CYCLE_NS, independent of the supervisor's wake times. In
/// each cycle every running procedure has a budget of units (procedure_cost.h) and of calls with external
/// effects. Therefore a procedure that never ends uses only a limited share of the supervisor's time, of
/// the downlink and of the packet log. If a procedure exceeds its budget, the following ones have less: all
/// of them together use at most 16 384 units a cycle, less than 1 ms even for the most expensive programs
/// known (`make bench ONLY=procedures`).
///
/// A request of a procedure is released, and then checked and routed like a request from the ground. A
/// procedure may raise those events of the supervisor's descriptor whose data are exactly the id and the
/// step of the procedure, so it cannot raise the events with which the supervisor reports failures.
#ifndef FSW_SUPERVISOR_SERVICES_PROCEDURES_H
#define FSW_SUPERVISOR_SERVICES_PROCEDURES_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/procedures/procedure_engine.h"
#include "pus/st18/st18_procedures.h"

#define SPACECRAFT_PROCEDURES DESCRIPTOR_PROCEDURES_MAX ///< Procedures that can be loaded.
#define SPACECRAFT_PROCEDURE_SLOTS 8U                   ///< Procedures that can run at the same time.
/// Memory of a running procedure and its interpreter.
#define SPACECRAFT_PROCEDURE_OCTETS 262144U
#define SPACECRAFT_PROCEDURE_BUDGET 2048U ///< Units of each procedure in a cycle.
/// Steps, events and requests of each procedure in a cycle.
#define SPACECRAFT_PROCEDURE_CALLS 8U
#define SPACECRAFT_PROCEDURE_CYCLE_NS 10000000ULL
/// Time limit of a request for whose end a procedure waits; longer than any function of a subsystem.
#define SPACECRAFT_PROCEDURE_TIMEOUT_NS 900000000000ULL

typedef struct { // Private to fsw/supervisor.
    pus_procedures_t service;
    pus_requester_t requester;
    uint64_t next_cycle_ns;
    pus_procedure_t procedures[SPACECRAFT_PROCEDURES];
    pus_procedure_run_t runs[SPACECRAFT_PROCEDURE_SLOTS];
    procedure_engine_t engine;
    procedure_slot_t slots[SPACECRAFT_PROCEDURE_SLOTS];
    uint64_t memory[SPACECRAFT_PROCEDURE_SLOTS * (SPACECRAFT_PROCEDURE_OCTETS / sizeof(uint64_t))];
    uint8_t map[SPACECRAFT_PROCEDURE_SLOTS * PROCEDURE_BLOCKS(SPACECRAFT_PROCEDURE_OCTETS)];
} spacecraft_procedures_t;

#endif // FSW_SUPERVISOR_SERVICES_PROCEDURES_H
