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

/// Number of participants that have this name. *out_index is the last of their entries.
static size_t find(const process_faults_t* const faults, const char* const name, size_t* const out_index)
{
    size_t found = 0U;
    for (size_t i = 0U; i < faults->count; i++) {
        if (strcmp(faults->process[i].name, name) == 0) {
            *out_index = i;
            found++;
        }
    }
    return found;
}

/// The program of a process: the first name of a participant, or the name of another process.
static const char* program_of(const process_faults_t* const faults, const size_t index)
{
    size_t first = (faults->process[index].participant == PROCESS_FAULTS_OTHER) ? index : 0U;
    while (faults->process[first].participant != faults->process[index].participant) {
        first++;
    }
    return faults->process[first].name;
}

static status_t refuse_unknown(const process_faults_t* const faults, const scenario_line_t* const line,
                               const size_t index, char error[SCENARIO_ERROR_MAX])
{
    char words[SCENARIO_LIST_MAX] = "a process of this run:";
    for (size_t i = 0U; i < faults->count; i++) {
        scenario_list(words, faults->process[i].name);
    }
    return scenario_error(line, line->word[index], words, error);
}

/// Refuse a program that several subsystems run, with their names.
static status_t refuse_shared(const process_faults_t* const faults, const scenario_line_t* const line,
                              const size_t index, char error[SCENARIO_ERROR_MAX])
{
    char words[SCENARIO_LIST_MAX] = "one of the subsystems that run this program:";
    for (size_t i = 0U; i < faults->count; i++) {
        const char* const name = faults->process[i].name;
        if ((strcmp(program_of(faults, i), line->word[index]) == 0) &&
            (strcmp(name, line->word[index]) != 0)) {
            scenario_list(words, name);
        }
    }
    return scenario_error(line, line->word[index], words, error);
}

status_t process_faults_check(void* const context, const scenario_line_t* const line, const size_t index,
                              char error[SCENARIO_ERROR_MAX])
{
    const process_faults_t* faults = context;
    size_t entry                   = 0U;
    const size_t found             = find(faults, line->word[index], &entry);
    if (found == 0U) {
        return (faults->count == 0U) ? STATUS_OK : refuse_unknown(faults, line, index, error);
    }
    if (found > 1U) {
        return refuse_shared(faults, line, index, error);
    }
    // A signal finds a process by its program.
    if ((faults->scheduler == NULL) && (find(faults, program_of(faults, entry), &entry) > 1U)) {
        return scenario_error(line, line->word[index],
                              "a subsystem with a program of its own, because this run has no scheduler",
                              error);
    }
    return STATUS_OK;
}

void process_faults_act(void* const context, const fault_kind_t kind, const char* const process)
{
    const process_faults_t* faults = context;
    size_t entry                   = 0U;
    const bool is_known            = find(faults, process, &entry) > 0U;
    const bool is_participant      = is_known && (faults->process[entry].participant != PROCESS_FAULTS_OTHER);
    // In stepped time the scheduler performs the fault, so that it takes effect at this instant of simulated
    // time; a signal would arrive at an unknown one.
    if (is_participant && (faults->scheduler != NULL)) {
        act_in_scheduler(faults->scheduler, faults->process[entry].participant, kind);
        return;
    }
    const char* const program = is_participant ? program_of(faults, entry) : process;
    if (kind == FAULT_KILL) {
        fault_kill(program);
    } else if (kind == FAULT_HANG) {
        fault_suspend(program);
    } else {
        fault_resume(program);
    }
}
