// SPDX-License-Identifier: Apache-2.0
/// Faults of the processes of a run at an instant of simulated time: kill, hang and resume of a scenario.
///
/// A participant of the scheduler is ended, suspended or resumed in the scheduler, by the holder of the
/// grant; its process follows in wall-clock time. Other processes (launcher, operator, archive), and all
/// processes if there is no scheduler, get a signal (sim/app/fault_kill.h).
#ifndef SIM_APP_PROCESS_FAULTS_H
#define SIM_APP_PROCESS_FAULTS_H

#include "osal/include/osal/lockstep_scheduler.h"
#include "sim/app/faults.h"

#include <stdbool.h>
#include <stddef.h>

#define PROCESS_FAULTS_NAMES_MAX                                                                             \
    ((size_t)2U * OSAL_LOCKSTEP_PARTICIPANTS_MAX) ///< Each process may have two names.

typedef struct { // Private, except `scheduler`: null if there is none.
    osal_lockstep_t* scheduler;
    size_t count;
    struct {
        const char* name;
        unsigned participant;
    } process[PROCESS_FAULTS_NAMES_MAX];
} process_faults_t;

/// Name the process of a participant; `name` outlives the table. False if the table is full.
bool process_faults_name(process_faults_t* faults, const char* name, unsigned participant);
/// As fault_world_t.process; the context is a process_faults_t. An unknown name is reported on the console.
void process_faults_act(void* context, fault_kind_t kind, const char* process);

#endif // SIM_APP_PROCESS_FAULTS_H
