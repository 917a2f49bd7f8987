// SPDX-License-Identifier: Apache-2.0
/// Task of the simulator process that serves the co-simulation port (sim/clock/cosimulation_port.h).
#ifndef SIM_APP_COSIMULATION_SERVER_H
#define SIM_APP_COSIMULATION_SERVER_H

#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/task.h"
#include "sim/clock/cosimulation_port.h"

#include <stdbool.h>

typedef struct {
    const char* path;     ///< Null: there is no port.
    const char* name;     ///< Name of the client.
    unsigned participant; ///< Number of the client as a participant of the scheduler.
    unsigned receiver;    ///< Number of the participant that gets the client's messages.
} cosimulation_config_t;

typedef struct { // Private.
    cosimulation_port_t port;
    osal_lockstep_t* scheduler;
    cosimulation_config_t config;
    osal_task_t task;
    bool is_running;
} cosimulation_server_t;

/// Open the port and start the task. False: a line on the standard error stream says why.
bool cosimulation_server_open(cosimulation_server_t* server, const cosimulation_config_t* config,
                              osal_lockstep_t* scheduler);
/// Close the scheduler, and end the task.
void cosimulation_server_close(cosimulation_server_t* server);

#endif // SIM_APP_COSIMULATION_SERVER_H
