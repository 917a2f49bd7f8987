# SPDX-License-Identifier: Apache-2.0
"""C header of one subsystem: ids, structures and definition tables of its interface part."""

from source import TYPES

KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "bool true false".split()
)


def header(subsystem, source):
    """Text of the header. `source` is the name of the descriptor in its first lines."""
    return _Writer(subsystem).text(source)


class _Writer:
    def __init__(self, subsystem):
        self.subsystem = subsystem
        self.upper = subsystem.name
        self.lower = subsystem.name.lower()
        self.lines = []

    def add(self, *lines):
        self.lines.extend(lines)

    def text(self, source):
        guard = f"GENERATED_{self.upper}_DESCRIPTOR_H"
        self.add(
            "// SPDX-License-Identifier: Apache-2.0",
            f"/// Interface of {self.upper}, generated from {source}: do not edit, run make.",
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            '#include "fsw/framework/parameter/parameter.h"',
            "",
            "#include <stdbool.h>",
            "#include <stddef.h>",
            "#include <stdint.h>",
            "",
            f"#define {self.upper}_NAME \"{self.upper}\"",
            f"#define {self.upper}_APID {self.subsystem.apid}U",
            f"#define {self.upper}_INTERFACE_HASH 0x{self.subsystem.interface_hash:016X}ULL",
            "",
        )
        self.ids()
        self.structures()
        self.definitions()
        self.add(f"#endif // {guard}")
        return "\n".join(self.lines) + "\n"

    def ids(self):
        for parameter in self.subsystem.parameters:
            self.add(f"#define {self.upper}_PARAMETER_{parameter.name} 0x{parameter.id:08X}U")
        self.add("")
        for kind, items in (
            ("EVENT", self.subsystem.events),
            ("FUNCTION", self.subsystem.functions),
            ("CONFIGURATION", self.subsystem.configurations),
            ("PORT", self.subsystem.ports()),
        ):
            if items:
                self.add("enum {")
                self.add(*(f"    {self.upper}_{kind}_{item.name} = {item.id}," for item in items))
                self.add("};", "")
        self.enumerations()
        for event in self.subsystem.events:
            size = sum(item.size for item in event.fields + event.references)
            if size:
                layout = ", ".join(_brief(item) for item in event.fields) or "sampled: " + ", ".join(
                    item.name for item in event.references
                )
                self.add(f"#define {self.upper}_EVENT_{event.name}_OCTETS {size}U ///< {layout}")
        if any(event.fields or event.references for event in self.subsystem.events):
            self.add("")

    def enumerations(self):
        """Constants of failure codes and of the numbers of enumerations."""
        if self.subsystem.failures:
            self.add(f"enum {{ ///< Failure codes of {self.upper}.")
            self.add(*(f"    {self.upper}_FAILURE_{failure.name} = 0x{failure.code:04X}," for failure in self.subsystem.failures))
            self.add("};", "")
        taken = {}
        for enumeration in self.subsystem.enumerations:
            self.add(f"enum {{ ///< {enumeration.name}.")
            for name, number in enumeration.numbers.items():
                constant = f"{self.upper}_VALUE_{enumeration.name}_{name}"
                if constant in taken:
                    enumeration.element.fail(f"the constant {constant} is that of <Enumeration> {taken[constant]}, expected another name")
                taken[constant] = enumeration.name
                self.add(f"    {constant} = {number},")
            self.add("};", "")

    def structure(self, name, fields, meaning):
        self.add(f"typedef struct {{ ///< {meaning}")
        groups = []
        for item in fields:
            *around, _ = item.name.split(".")
            self.close_groups(groups, next((i for i, (a, b) in enumerate(zip(groups, around)) if a != b), min(len(groups), len(around))))
            while len(groups) < len(around):
                groups.append(around[len(groups)])
                self.add(f"{'    ' * len(groups)}struct {{")
            unit = f" ///< [{item.unit}]" if item.unit else ""
            self.add(f"{'    ' * (len(groups) + 1)}{TYPES[item.type][3]} {self.member(item)}{_count(item)};{unit}")
        self.close_groups(groups, 0)
        self.add(f"}} {name};", "")

    def close_groups(self, groups, kept):
        """Close nested structures until `kept` of them are open."""
        while len(groups) > kept:
            self.add(f"{'    ' * len(groups)}}} {groups.pop().lower()};")

    def member(self, item):
        for name in item.name.split("."):
            if name.lower() in KEYWORDS:
                item.element.fail(f"name=\"{name}\": expected a name that is no keyword of C in lower case")
        return item.name.lower().rpartition(".")[2]

    def structures(self):
        for parameter in self.subsystem.parameters:
            if parameter.is_struct:
                self.structure(f"{self.lower}_{parameter.name.lower()}_t", parameter.fields, "Structured parameter.")
        if self.subsystem.parameters:
            self.add("typedef struct { ///< Storage of all parameters.")
            for parameter in self.subsystem.parameters:
                if parameter.is_struct:
                    self.member(parameter)
                    self.add(f"    {self.lower}_{parameter.name.lower()}_t {parameter.name.lower()};")
                else:
                    item = parameter.fields[0]
                    self.add(f"    {TYPES[item.type][3]} {self.member(item)}{_count(item)};")
            self.add(f"}} {self.lower}_parameters_t;", "")
        for function in self.subsystem.functions:
            if function.arguments:
                name = f"{self.lower}_{function.name.lower()}_arguments_t"
                self.structure(name, function.arguments, f"Arguments of {function.name}.")
        for port in self.subsystem.ports():
            self.structure(f"{self.lower}_{port.name.lower()}_payload_t", port.fields, f"Sample of port {port.name}.")

    def definitions(self):
        parameters = self.subsystem.parameters
        fields = sum(len(parameter.fields) for parameter in parameters)
        self.add(
            f"#define {self.upper}_PARAMETER_COUNT {len(parameters)}U",
            f"#define {self.upper}_FIELD_COUNT {fields}U",
            "",
        )
        if not parameters:
            return
        self.add(f"enum {{ ///< Index in {self.lower}_definitions.")
        self.add(*(f"    {self.upper}_INDEX_{parameter.name}," for parameter in parameters))
        self.add("};", "")
        self.add(f"static const parameter_field_t {self.lower}_fields[] = {{")
        for parameter in parameters:
            for item in parameter.fields:
                place = f"offsetof({self.lower}_{parameter.name.lower()}_t, {item.name.lower()})"
                offset = f"(uint32_t){place}" if parameter.is_struct else "0U"
                self.add(f'    {{"{item.name}", VALUE_{item.type}, {item.count}U, {offset}}},')
        self.add("};", "")
        self.add(f"static const parameter_definition_t {self.lower}_definitions[] = {{")
        first = 0
        for parameter in parameters:
            memory = f"(uint32_t)sizeof(((const {self.lower}_parameters_t*)0)->{parameter.name.lower()})"
            self.add(
                f'    {{"{parameter.name}", {self.upper}_PARAMETER_{parameter.name}, &{self.lower}_fields[{first}], '
                f"{len(parameter.fields)}U,",
                f"     {memory}, {parameter.size}U}},",
            )
            first += len(parameter.fields)
        self.add("};", "")
        self.add(f"/// Offset of each parameter in {self.lower}_parameters_t, in the order of the definitions.")
        self.add(f"static const size_t {self.lower}_offsets[] = {{")
        self.add(*(f"    offsetof({self.lower}_parameters_t, {parameter.name.lower()})," for parameter in parameters))
        self.add("};", "")


def _count(item):
    return f"[{item.count}]" if item.count > 1 else ""


def _brief(item):
    return f"{item.name} {item.type}" + (f"[{item.count}]" if item.count > 1 else "")
