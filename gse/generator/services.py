# SPDX-License-Identifier: Apache-2.0
"""Optional services of a subsystem, and the generated header with the storage of the services that its descriptor lists.

fsw/framework/subsystem/<name>_service.{h,c} implements a service: <name>_service_t is its storage, and
subsystem_<name>_service_add(component, service, entries, number of entries, ..) adds the service to a component.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Offer:
    """Name of a service, and for each attribute: type of the entries, maximum and default number.

    If a service needs several arrays for an attribute, `room` names them: attribute -> (member, type, entries for each),
    and the service receives a <name>_room_t with pointers to the arrays and the number of entries of each attribute."""

    name: str
    capacity: tuple
    functional: tuple = None
    room: dict = None


# Services of the whole spacecraft, which the supervisor always has: maximum capacity, which is also the default.
# Same values as in fsw/framework/descriptor/subsystem_descriptor.h.
OF_SPACECRAFT = {11: 12000, 15: 8, 18: 64, 19: 1000, 21: 64, 22: 1000, 23: 64}
SUPERVISOR = 1
OF_EVERY_SUBSYSTEM = (1, 3, 5, 8, 17, 20, 129, 130)  # fsw/framework/subsystem/subsystem_services.c
OF_SUPERVISOR = (*OF_SPACECRAFT, 9, 13, 14, 131)  # fsw/supervisor/services/spacecraft_services.c
# Same values as in fsw/framework/descriptor/subsystem_builder.c.
OFFERS = {
    2: Offer("device", ("pus_device_operation_t", 16, 4)),
    4: Offer("statistics", (None, 256, 16), None, {
        "capacity": (("statistics", "pus_statistic_t", 1), ("due", "pus_due_t", 1), ("positions", "uint16_t", 1)),
    }),
    6: Offer("memory", ("pus_memory_operation_t", 16, 4)),
    12: Offer("monitoring", (None, 2000, 32), (None, 200, 4), {
        "capacity": (("pmons", "pus_pmon_t", 1), ("order", "uint16_t", 1), ("positions", "uint16_t", 1), ("due", "pus_due_t", 1)),
        "functional": (("fmons", "pus_fmon_t", 1), ("touched", "uint16_t", 1), ("members", "pus_fmon_member_t", 16)),
    }),
}


@dataclass
class Service:
    """A service of a subsystem."""

    type: int
    capacity: int
    functional: int


def flown(services, apid):
    """Types of all services of a subsystem whose descriptor lists `services`."""
    return sorted({*OF_EVERY_SUBSYSTEM, *(service.type for service in services), *(OF_SUPERVISOR if apid == SUPERVISOR else ())})


def compiled(services):
    """Services whose storage the generated header defines, with the number of entries in the descriptor."""
    return [service for service in services if service.type in OFFERS]


def service_of(element, apid):
    """Service that an element describes. `apid` is that of its subsystem."""
    number = int(element.word("type", [str(known) for known in (*OFFERS, *OF_SPACECRAFT)]))
    if number in OF_SPACECRAFT and apid != SUPERVISOR:
        element.fail(f"only the supervisor (id 1) can have service {number}")
    most = OF_SPACECRAFT.get(number)
    offer = OFFERS.get(number) or Offer("", (None, most, most))
    found = {}
    for attribute in ("capacity", "functional"):
        entries = getattr(offer, attribute)
        if entries is None and attribute in element.attributes:
            element.fail(f"service {number} cannot have attribute {attribute}")
        found[attribute] = element.unsigned(attribute, 1, entries[1], entries[2]) if entries else 0
    return Service(number, **found)


def header(subsystem, source):
    """Text of the header with the storage of the services in a descriptor."""
    upper, lower = subsystem.name, subsystem.name.lower()
    offers = [(service, OFFERS[service.type]) for service in compiled(subsystem.services)]
    guard = f"GENERATED_{upper}_SERVICES_H"
    lines = [
        "// SPDX-License-Identifier: Apache-2.0",
        f"/// Optional services of {upper}, generated from {source}: do not edit, run make.",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        '#include "fsw/framework/subsystem/subsystem_core.h"',
    ]
    lines += [f'#include "fsw/framework/subsystem/{offer.name}_service.h"' for _, offer in offers]
    lines += ["", "typedef struct {"]
    calls = []
    for service, offer in offers:
        arguments = ""
        lines.append(f"    {offer.name}_service_t {offer.name};")
        room = []
        for attribute, arrays in (offer.room or {}).items():
            count = getattr(service, attribute)
            for member, kind, each in arrays:
                lines.append(f"    {kind} {offer.name}_{member}[{count * each}];")
                room.append(f".{member} = own->{offer.name}_{member}")
            room.append(f".{attribute} = {count}U")
        if room:
            arguments = f", &(const {offer.name}_room_t){{{', '.join(room)}}}"
        for attribute in () if room else ("capacity", "functional"):
            if getattr(offer, attribute):
                place = f"{offer.name}_{attribute}"
                count = getattr(service, attribute)
                lines.append(f"    {getattr(offer, attribute)[0]} {place}[{count}];")
                arguments += f", own->{place}, {count}U"
        calls.append(f"    subsystem_{offer.name}_service_add(component, &own->{offer.name}{arguments});")
    if not offers:
        lines.append("    uint8_t none; // C has no empty structures.")
    lines += [
        f"}} {lower}_services_t;",
        "",
        f"static inline void {lower}_add_services(void* storage, subsystem_t* component)",
        "{",
        *([f"    {lower}_services_t* const own = ({lower}_services_t*)storage;"] if offers else
          ["    (void)storage;", "    (void)component;"]),
        *calls,
        "}",
        "",
        f"#endif // {guard}",
    ]
    return "\n".join(lines) + "\n"
