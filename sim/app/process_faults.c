// SPDX-License-Identifier: Apache-2.0
#include "sim/app/process_faults.h"

#include "sim/app/fault_kill.h"

#include <string.h>

bool process_faults_name(process_faults_t* const faults, const char* const name, const unsigned participant)
{
    if (faults->count == PROCESS_FAULTS_NAMES_MAX) {
        return false;
    }
    faults->process[faults->count].name        = name;
    faults->process[faults->count].participant = participant;
    faults->count++;
    return true;
}

static void act_in_scheduler(osal_lockstep_t* const scheduler, const unsigned participant,
                             const fault_kind_t kind)
{
    if (kind == FAULT_KILL) {
        osal_lockstep_kill(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE);
    } else if (kind == FAULT_HANG) {
        osal_lockstep_suspend(scheduler, participant);
    } else {
        osal_lockstep_resume(scheduler, participant);
    }
}

void process_faults_act(void* const context, const fault_kind_t kind, const char* const process)
{
    const process_faults_t* faults = context;
    // In stepped time the scheduler performs the fault, so that it takes effect at this instant of simulated
    // time; a signal would arrive at an unknown one.
    for (size_t i = 0U; (faults->scheduler != NULL) && (i < faults->count); i++) {
        if (strcmp(faults->process[i].name, process) == 0) {
            act_in_scheduler(faults->scheduler, faults->process[i].participant, kind);
            return;
        }
    }
    if (kind == FAULT_KILL) {
        fault_kill(process);
    } else if (kind == FAULT_HANG) {
        fault_suspend(process);
    } else {
        fault_resume(process);
    }
}
