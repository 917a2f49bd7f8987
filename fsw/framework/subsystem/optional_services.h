// SPDX-License-Identifier: Apache-2.0
/// Services that a subsystem has in addition to the standard ones (3, 5, 8, 17, 20, 129, 130), because its
/// descriptor lists them: `<Services><Service type="6" capacity="4"/></Services>`. How to add one:
/// docs/framework.md, "Optional services".
///
/// The generator makes build/generated/<subsystem>_services.h of these lines. The program of the subsystem
/// places the structure in it. A service that no descriptor of a program lists is not linked.
///
/// The `step` of a service is called once per cycle of the component's own loop, after control, housekeeping
/// and links, also in OFFLINE (idle cycle). Its cycle number counts these steps from 1 and never restarts.
///
/// Context    The component's own loop.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H
#define FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H

#include "fsw/framework/subsystem/subsystem_core.h"

/// Put a service into the component's list, during subsystem_init. `restore` restores one record that the
/// service has put (table = its type); null: the service keeps no records. At most
/// SUBSYSTEM_OPTIONAL_SERVICES.
void subsystem_add_service(subsystem_t* subsystem, const pus_service_t* service, subsystem_restore_t restore);
/// The port to the component's parameters; a parameter is known from SOFTWARE_INIT to SOFTWARE_DEINIT.
pus_parameter_port_t subsystem_parameter_port(subsystem_t* subsystem);
/// Where records are kept, or null.
const pus_persistence_t* subsystem_persistence(const subsystem_t* subsystem);

#endif // FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H
