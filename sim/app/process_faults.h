// SPDX-License-Identifier: Apache-2.0
/// Faults of the processes of a run at an instant of simulated time: `fault kill`, `fault hang` and
/// `fault resume` of a scenario.
///
/// If the process is a participant of the scheduler, the simulator, which holds the grant, ends, suspends or
/// resumes the participant in the scheduler; its process ends, waits or continues later, in wall-clock time.
/// Other processes (launcher, operator, archive), and all processes if there is no scheduler, get a signal
/// (sim/app/fault_kill.h).
#ifndef SIM_APP_PROCESS_FAULTS_H
#define SIM_APP_PROCESS_FAULTS_H

#include "osal/include/osal/lockstep_scheduler.h"
#include "sim/app/faults.h"

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>

/// Processes of a run that are no participants: launcher, simulator or image, relay, operator, archive.
#define PROCESS_FAULTS_OTHERS_MAX 5U
/// Most names in the table: a participant may have two.
#define PROCESS_FAULTS_NAMES_MAX (((size_t)2U * OSAL_LOCKSTEP_PARTICIPANTS_MAX) + PROCESS_FAULTS_OTHERS_MAX)
/// Instead of the number of a participant: the process is not a participant.
#define PROCESS_FAULTS_OTHER UINT_MAX

typedef struct { // Private, except `scheduler`: null if there is none.
    osal_lockstep_t* scheduler;
    size_t count; ///< 0: the processes of the run are not known.
    struct {
        const char* name;
        unsigned participant;
    } process[PROCESS_FAULTS_NAMES_MAX];
} process_faults_t;

/// Add a name of a process; `name` must outlive the table. The first name of a participant is that of its
/// program. `participant` is PROCESS_FAULTS_OTHER for a process that is not a participant. False if the table
/// is full.
bool process_faults_name(process_faults_t* faults, const char* name, unsigned participant);
/// Check that a word of a scenario line names one process of the table. Used as fault_world_t.check_process.
/// Returns STATUS_OK (also if the table is empty), STATUS_INVALID (no process or several have this name;
/// `error` lists the names).
status_t process_faults_check(void* context, const scenario_line_t* line, size_t index,
                              char error[SCENARIO_ERROR_MAX]);
/// Apply a fault to a process; used as fault_world_t.process. `context` is a process_faults_t. If the process
/// is not running, a message on the console says so.
void process_faults_act(void* context, fault_kind_t kind, const char* process);

#endif // SIM_APP_PROCESS_FAULTS_H
