// SPDX-License-Identifier: Apache-2.0
/// Services that a subsystem has in addition to the standard ones (3, 5, 8, 17, 20, 129, 130), because its
/// descriptor lists them: `<Services><Service type="6" capacity="4"/></Services>`. How to add one:
/// docs/framework.md, "Optional services".
///
/// From these lines the generator makes build/generated/<subsystem>_services.h with a structure that the
/// program of the subsystem places in memory. A service that the descriptor does not list is not linked
/// into the program.
///
/// The `step` of a service is called once per cycle of the component's main loop, after control,
/// housekeeping and links, also in OFFLINE (idle cycle). Its cycle number counts these steps from 1 and
/// never restarts.
///
/// Context    The main loop of the component.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H
#define FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H

#include "fsw/framework/subsystem/subsystem_core.h"

/// Add a service to the component's list; to be called during subsystem_init. `restore` restores one record
/// that the service has stored (table = service type); null: the service stores no records. At most
/// SUBSYSTEM_OPTIONAL_SERVICES.
void subsystem_add_service(subsystem_t* subsystem, const pus_service_t* service, subsystem_restore_t restore);
/// Returns the port to the component's parameters; they exist from SOFTWARE_INIT to SOFTWARE_DEINIT.
pus_parameter_port_t subsystem_parameter_port(subsystem_t* subsystem);
/// Returns the port to the store of records, or null.
const pus_persistence_t* subsystem_persistence(const subsystem_t* subsystem);

#endif // FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H
