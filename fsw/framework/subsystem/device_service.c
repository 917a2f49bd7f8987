// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/device_service.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/optional_services.h"

void subsystem_device_service_add(subsystem_t* const subsystem, device_service_t* const service,
                                  pus_device_operation_t* const operations, const uint8_t count)
{
    FSW_ASSERT((subsystem != NULL) && (service != NULL) && (operations != NULL));
    const subsystem_callbacks_t* const callbacks = subsystem->config.callbacks;
    // subsystem_fits has checked that the subsystem has this callback.
    FSW_ASSERT(callbacks->device_port != NULL);
    const pus_device_config_t config = {.process         = subsystem_process(subsystem),
                                        .port            = callbacks->device_port(subsystem->config.self),
                                        .operations      = operations,
                                        .operation_count = count,
                                        .timeout_ns      = DEVICE_SERVICE_TIMEOUT_NS};
    pus_device_access_init(&service->access, &config);
    const pus_service_t entry = pus_device_access_service(&service->access);
    subsystem_add_service(subsystem, &entry, NULL);
}
