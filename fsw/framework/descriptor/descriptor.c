// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/descriptor.h"

#include "base/assertion.h"
#include "base/text.h"
#include "fsw/framework/descriptor/mission_builder.h"
#include "fsw/framework/descriptor/subsystem_builder.h"
#include "osal/include/osal/file.h"

#include <string.h>

#define PIECE_OCTETS 2048U

void descriptor_loader_init(descriptor_loader_t* const loader)
{
    FSW_ASSERT(loader != NULL);
    xml_init(&loader->parser, loader->arena, XML_ARENA_WORDS);
    loader->error[0] = '\0';
    loader->path[0]  = '\0';
}

/// Pass the octets of a file to the parser.
static status_t feed_file(descriptor_loader_t* const loader, source_t* const source)
{
    osal_file_t file;
    uint8_t piece[PIECE_OCTETS];
    size_t size   = 1U;
    status_t fed  = STATUS_OK;
    status_t read = osal_file_open_read(&file, source->path);
    if (read == STATUS_OK) {
        while ((read == STATUS_OK) && (fed == STATUS_OK) && (size > 0U)) {
            read = osal_file_read(&file, piece, sizeof piece, &size);
            fed  = (read == STATUS_OK) ? xml_feed(&loader->parser, piece, size) : fed;
        }
        osal_file_close(&file);
    }
    if (read != STATUS_OK) {
        descriptor_source_fail_as(source, 0U, read, "cannot read: ");
        descriptor_source_append(source, "%", status_text(read), NULL, 0U);
    }
    return (read != STATUS_OK) ? read : fed;
}

/// Parse `octets`; if null, parse the file that the source names.
static status_t parse(descriptor_loader_t* const loader, source_t* const source, const void* const octets,
                      const size_t size)
{
    const xml_handler_t handler = descriptor_source_handler(source);
    status_t status             = xml_begin(&loader->parser, &handler);
    if (status == STATUS_OK) {
        status = (octets != NULL) ? xml_feed(&loader->parser, octets, size) : feed_file(loader, source);
    }
    if (status == STATUS_OK) {
        status = xml_finish(&loader->parser);
    }
    if (status != STATUS_OK) { // Report an error of the parser; the handlers have already reported theirs.
        descriptor_source_fail_as(source, loader->parser.error.line, status, loader->parser.error.message);
    }
    return status;
}

static status_t read_subsystem(descriptor_loader_t* const loader, const char* const path,
                               const void* const octets, const size_t size,
                               subsystem_descriptor_t* const out_descriptor)
{
    FSW_ASSERT((loader != NULL) && (path != NULL) && (out_descriptor != NULL));
    text_t error = text_in(loader->error, sizeof loader->error);
    subsystem_builder_t builder;
    descriptor_subsystem_builder_begin(&builder, out_descriptor, path, &error);
    const status_t status = parse(loader, &builder.source, octets, size);
    if (status != STATUS_OK) { // Clear a model that is incomplete.
        descriptor_subsystem_clear(out_descriptor);
    }
    return status;
}

status_t descriptor_load_subsystem(descriptor_loader_t* const loader, const char* const path,
                                   subsystem_descriptor_t* const out_descriptor)
{
    return read_subsystem(loader, path, NULL, 0U, out_descriptor);
}

status_t descriptor_parse_subsystem(descriptor_loader_t* const loader, const char* const name,
                                    const void* const octets, const size_t size,
                                    subsystem_descriptor_t* const out_descriptor)
{
    return read_subsystem(loader, name, (size > 0U) ? octets : "", size, out_descriptor);
}

static status_t load_listed(descriptor_loader_t* const loader, mission_builder_t* const builder,
                            const uint16_t index, subsystem_descriptor_t* const out_descriptor)
{
    const mission_subsystem_t* const subsystem = &builder->mission->subsystems[index];
    text_t refusal                             = text_in(loader->error, sizeof loader->error);
    if (descriptor_path_of(&refusal, builder->source.path, subsystem, loader->path, sizeof loader->path) !=
        STATUS_OK) {
        return STATUS_INVALID;
    }
    const status_t status = descriptor_load_subsystem(loader, loader->path, out_descriptor);
    if (status == STATUS_NOT_FOUND) { // Report it at the line of the mission that names the descriptor.
        descriptor_source_fail_as(&builder->source, subsystem->line, status, "descriptor=\"");
        descriptor_source_append(&builder->source, "%\" of <Subsystem>: expected a file, found none",
                                 subsystem->descriptor, NULL, 0U);
    }
    return (status == STATUS_OK)
               ? descriptor_mission_builder_take(builder, index, loader->path, out_descriptor)
               : status;
}

/// Load the descriptors one after the other, and that of subsystem `own` last, so that its model remains in
/// *out_own.
static status_t load_all(descriptor_loader_t* const loader, mission_builder_t* const builder,
                         const uint16_t own, subsystem_descriptor_t* const out_own)
{
    const mission_descriptor_t* const mission = builder->mission;
    uint16_t last                             = mission->subsystem_count;
    status_t status                           = STATUS_OK;
    for (uint16_t i = 0U; (i < mission->subsystem_count) && (status == STATUS_OK); i++) {
        if (mission->subsystems[i].apid == own) {
            last = i;
        } else if (builder->scope != NULL) {
            status = load_listed(loader, builder, i, out_own);
        } else {
            // Without a scope, only the descriptor of subsystem `own` is read.
        }
    }
    if ((status == STATUS_OK) && (last < mission->subsystem_count)) {
        status = load_listed(loader, builder, last, out_own);
    }
    return (status == STATUS_OK) ? descriptor_mission_builder_resolve(builder) : status;
}

status_t descriptor_load_mission(descriptor_loader_t* const loader, const char* const path,
                                 const uint16_t apid, const mission_scope_t* const scope,
                                 mission_descriptor_t* const out_mission,
                                 subsystem_descriptor_t* const out_own)
{
    FSW_ASSERT((loader != NULL) && (path != NULL) && (out_mission != NULL) && (out_own != NULL));
    FSW_ASSERT((scope != NULL) || (apid != MISSION_ANY_TARGET));
    text_t error = text_in(loader->error, sizeof loader->error);
    mission_builder_t builder;
    descriptor_mission_builder_begin(&builder, out_mission, path, apid, scope, &error);
    status_t status = parse(loader, &builder.source, NULL, 0U);
    if ((status == STATUS_OK) && (apid != MISSION_ANY_TARGET) &&
        (descriptor_mission_find_subsystem(out_mission, apid) == NULL)) {
        descriptor_source_refuse(&builder.source, 1U, "no subsystem has id #", NULL, NULL, apid);
        status = builder.source.status;
    }
    if (status == STATUS_OK) {
        status = load_all(loader, &builder, apid, out_own);
    }
    if (status != STATUS_OK) {
        descriptor_mission_clear(out_mission);
    }
    return status;
}

const char* descriptor_error(const descriptor_loader_t* const loader)
{
    FSW_ASSERT(loader != NULL);
    return loader->error;
}
