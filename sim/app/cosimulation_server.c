// SPDX-License-Identifier: Apache-2.0
#include "sim/app/cosimulation_server.h"

#include "sim/app/argument_values.h"

#define SILENCE_MAX_MS 200000U ///< For the client: longer than the launcher waits for progress of the run.

static void serve(void* const context)
{
    cosimulation_server_t* server = context;
    status_t status               = STATUS_OK;
    while (status == STATUS_OK) {
        status = cosimulation_port_serve(&server->port, server->scheduler, server->config.participant,
                                         server->config.receiver);
    }
}

bool cosimulation_server_open(cosimulation_server_t* const server, const cosimulation_config_t* const config,
                              osal_lockstep_t* const scheduler)
{
    server->config    = *config;
    server->scheduler = scheduler;
    if (config->path == NULL) {
        return true;
    }
    if (cosimulation_port_open(&server->port, config->path, config->name, scheduler, SILENCE_MAX_MS) !=
        STATUS_OK) {
        return argument_refuse("cosimulation", config->path, "a path where a local socket can be made");
    }
    server->is_running = osal_task_start(&server->task, serve, server, 0) == STATUS_OK;
    return server->is_running ||
           argument_refuse("cosimulation", config->path, "that one more thread may start: raise `ulimit -u`");
}

void cosimulation_server_close(cosimulation_server_t* const server)
{
    if (server->is_running) {
        if (!osal_lockstep_is_closed(server->scheduler)) {
            osal_lockstep_close(server->scheduler); // A run cannot continue without the simulator.
        }
        osal_task_join(&server->task);
        cosimulation_port_close(&server->port);
    }
}
