// SPDX-License-Identifier: Apache-2.0
/// Loads subsystem and mission descriptors from XML into a model, and checks every value. The first error
/// ends the loading; its text reads "file:line: what was found and what is expected"; the model is then
/// empty.
///
/// Ownership  The caller provides loader and models; a loader can be used for any number of documents in
///            turn.
/// Context    At start and for TC[129,6]; not in the control cycle, because a document takes milliseconds.
/// Errors     Each function lists every status.
///
///     static descriptor_loader_t    loader;
///     static subsystem_descriptor_t descriptor;
///     descriptor_loader_init(&loader);
///     if (descriptor_load_subsystem(&loader, path, &descriptor) != STATUS_OK) {
///         report(descriptor_error(&loader));
///     }
#ifndef FSW_FRAMEWORK_DESCRIPTOR_DESCRIPTOR_H
#define FSW_FRAMEWORK_DESCRIPTOR_DESCRIPTOR_H

#include "base/status.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/xml/xml.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DESCRIPTOR_PATH_CHARACTERS 256U

typedef struct { // Private.
    xml_parser_t parser;
    uint64_t arena[XML_ARENA_WORDS];
    char error[DESCRIPTOR_ERROR_CHARACTERS];
    char path[DESCRIPTOR_PATH_CHARACTERS];
} descriptor_loader_t;

void descriptor_loader_init(descriptor_loader_t* loader);

/// Load the descriptor of a subsystem. STATUS_OK; STATUS_NOT_FOUND, STATUS_DENIED, STATUS_IO (file);
/// STATUS_INVALID, STATUS_TRUNCATED, STATUS_TOO_LARGE, STATUS_EXHAUSTED (content: see descriptor_error).
MUST_USE status_t descriptor_load_subsystem(descriptor_loader_t* loader, const char* path,
                                            subsystem_descriptor_t* out_descriptor);
/// Like descriptor_load_subsystem, but from memory; error texts give `name` as the file. STATUS_OK,
/// STATUS_INVALID, STATUS_TRUNCATED, STATUS_TOO_LARGE, STATUS_EXHAUSTED.
MUST_USE status_t descriptor_parse_subsystem(descriptor_loader_t* loader, const char* name,
                                             const void* octets, size_t size,
                                             subsystem_descriptor_t* out_descriptor);

/// Extent to which a mission is read. The linker leaves out the code for a whole mission if a program does
/// not refer to `descriptor_mission_whole`.
typedef struct mission_scope mission_scope_t;
/// Permissions, recovery plans, hashes, and the descriptors of all subsystems: for supervisor and launcher.
extern const mission_scope_t descriptor_mission_whole;

/// Load a mission, and the descriptors of its subsystems one after the other into `out_own` (their paths are
/// relative to the mission's file). At the end `out_own` contains the descriptor of subsystem `apid`. With
/// scope NULL, as a subsystem needs it, only this descriptor is read: the mission then has no permissions and
/// no recovery plans, its hashes are 0, other subsystems have only what the mission's file defines, and their
/// ends of links have port 0. `apid` is 1..2046; with a scope, MISSION_ANY_TARGET means the last subsystem.
/// Statuses of descriptor_load_subsystem; STATUS_INVALID also: the mission has no such subsystem. After an
/// error *out_mission is empty, and *out_own is not valid.
MUST_USE status_t descriptor_load_mission(descriptor_loader_t* loader, const char* path, uint16_t apid,
                                          const mission_scope_t* scope, mission_descriptor_t* out_mission,
                                          subsystem_descriptor_t* out_own);

/// Returns the text of the last error; "" if there was none. Never null; valid until the loader's next use.
const char* descriptor_error(const descriptor_loader_t* loader);

#endif // FSW_FRAMEWORK_DESCRIPTOR_DESCRIPTOR_H
