// SPDX-License-Identifier: Apache-2.0
#include "sim/app/process_faults.h"

#include "sim/app/death.h"

#include <string.h>

bool process_faults_name(process_faults_t* faults, const char* name, unsigned participant)
{
    if (faults->count == PROCESS_FAULTS_NAMES_MAX) {
        return false;
    }
    faults->process[faults->count].name        = name;
    faults->process[faults->count].participant = participant;
    faults->count++;
    return true;
}

static void act_in_calendar(osal_calendar_t* calendar, unsigned participant, fault_kind_t kind)
{
    if (kind == FAULT_KILL) {
        osal_calendar_kill(calendar, participant, OSAL_CALENDAR_ANY_LIFE);
    } else if (kind == FAULT_HANG) {
        osal_calendar_suspend(calendar, participant);
    } else {
        osal_calendar_resume(calendar, participant);
    }
}

void process_faults_act(void* context, fault_kind_t kind, const char* process)
{
    const process_faults_t* faults = context;
    for (size_t i = 0U; (faults->calendar != NULL) && (i < faults->count); i++) {
        if (strcmp(faults->process[i].name, process) == 0) {
            act_in_calendar(faults->calendar, faults->process[i].participant, kind);
            return;
        }
    }
    if (kind == FAULT_KILL) {
        death_of(process);
    } else if (kind == FAULT_HANG) {
        suspend_process(process);
    } else {
        resume_process(process);
    }
}
