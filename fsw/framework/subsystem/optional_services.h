// SPDX-License-Identifier: Apache-2.0
/// Services that a subsystem has beside the standard ones (3, 5, 8, 17, 20, 129, 130), because its descriptor
/// lists them: `<Services><Service type="6" capacity="4"/></Services>`.
///
/// The generator makes build/generated/<subsystem>_services.h of these lines: a structure with the storage of
/// exactly those services and `<subsystem>_add_services`, which puts them into the component. The program of
/// the subsystem places that structure and names both to member_begin. What no descriptor of a program lists
/// is not linked to it.
///
/// To offer a further service: write fsw/framework/subsystem/<name>_service.{h,c} with a type
/// <name>_service_t and a function <name>_service_add(component, service, entries, count, ..) that sets the
/// service up with what the functions below give and ends with component_add_service; then list it in
/// gse/generator/services.py, in fsw/framework/descriptor/subsystem_builder.c, in subsystem.xsd and in
/// docs/descriptors.md.
///
/// A service's `step` is called once per cycle of the component's own loop, behind the control, housekeeping
/// and links of that cycle; in OFFLINE too, where a cycle is the idle one. Its cycle number counts these
/// steps from 1 and never begins anew.
///
/// Context  The component's own loop.
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
/// The component's application process is component_process (component.h); events of the descriptor are
/// raised by subsystem_raise (subsystem.h), device callbacks see subsystem_callbacks_t.

#endif // FSW_FRAMEWORK_SUBSYSTEM_OPTIONAL_SERVICES_H
