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

#include "fsw/framework/subsystem/component.h"

/// Put a service into the component's list, during component_init. `restore` takes back one record that the
/// service has put (table = its type); null: it keeps none. At most COMPONENT_OPTIONAL_SERVICES.
void component_add_service(component_t* component, const pus_service_t* service, component_restore_t restore);
/// The port to the component's parameters; a parameter is known from SOFTWARE_INIT to SOFTWARE_DEINIT.
pus_parameter_port_t component_parameter_port(component_t* component);
/// Where records are kept, or null.
const pus_persistence_t* component_persistence(const component_t* component);

#endif // FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H
