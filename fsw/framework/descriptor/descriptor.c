// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/descriptor.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/text.h"
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

/// What the parser itself found goes into the error text; what a handler found is there already.
static status_t tell(source_t* const source, const xml_parser_t* const parser, const status_t status)
{
    if (source->status != STATUS_OK) {
        return source->status;
    }
    if (status != STATUS_OK) {
        (void)source_fail(source, parser->error.line, status, parser->error.message);
    }
    return status;
}

static status_t parse_octets(descriptor_loader_t* const loader, source_t* const source,
                             const void* const octets, const size_t size)
{
    const xml_handler_t handler = source_handler(source);
    status_t status             = xml_begin(&loader->parser, &handler);
    if (status == STATUS_OK) {
        status = xml_feed(&loader->parser, octets, size);
    }
    if (status == STATUS_OK) {
        status = xml_finish(&loader->parser);
    }
    return tell(source, &loader->parser, status);
}

static status_t parse_file(descriptor_loader_t* const loader, source_t* const source, const char* const path)
{
    const xml_handler_t handler = source_handler(source);
    osal_file_t file;
    uint8_t piece[PIECE_OCTETS];
    size_t size     = 1U;
    status_t status = osal_file_open_read(&file, path);
    if (status != STATUS_OK) {
        if (source_fail(source, 0U, status, "cannot read: ")) {
            text_add(source->error, status_text(status));
        }
        return status;
    }
    status = xml_begin(&loader->parser, &handler);
    while ((status == STATUS_OK) && (size > 0U)) {
        const status_t read = osal_file_read(&file, piece, sizeof piece, &size);
        if (read != STATUS_OK) {
            (void)source_fail(source, 0U, read, "cannot read on");
            status = read;
        } else {
            status = xml_feed(&loader->parser, piece, size);
        }
    }
    osal_file_close(&file);
    if (status == STATUS_OK) {
        status = xml_finish(&loader->parser);
    }
    return tell(source, &loader->parser, status);
}

/// Leave nothing half-read behind.
static void empty_subsystem(subsystem_descriptor_t* const descriptor)
{
    (void)memset(descriptor, 0, sizeof *descriptor);
    descriptor->name = "";
}

status_t descriptor_load_subsystem(descriptor_loader_t* const loader, const char* const path,
                                   subsystem_descriptor_t* const out_descriptor)
{
    FSW_ASSERT((loader != NULL) && (path != NULL) && (out_descriptor != NULL));
    text_t error = text_in(loader->error, sizeof loader->error);
    subsystem_builder_t builder;
    subsystem_builder_begin(&builder, out_descriptor, path, &error);
    const status_t status = parse_file(loader, &builder.source, path);
    if (status != STATUS_OK) {
        empty_subsystem(out_descriptor);
    }
    return status;
}

status_t descriptor_parse_subsystem(descriptor_loader_t* const loader, const char* const name,
                                    const void* const octets, const size_t size,
                                    subsystem_descriptor_t* const out_descriptor)
{
    FSW_ASSERT((loader != NULL) && (name != NULL) && (out_descriptor != NULL));
    text_t error = text_in(loader->error, sizeof loader->error);
    subsystem_builder_t builder;
    subsystem_builder_begin(&builder, out_descriptor, name, &error);
    const status_t status = parse_octets(loader, &builder.source, octets, size);
    if (status != STATUS_OK) {
        empty_subsystem(out_descriptor);
    }
    return status;
}

/// Path of a file named relative to the folder of another one. False if it is too long.
static bool join(char* const out_path, const size_t capacity, const char* const neighbour,
                 const char* const name)
{
    text_t path             = text_in(out_path, capacity);
    const char* const slash = strrchr(neighbour, '/');
    if ((slash != NULL) && (name[0] != '/')) {
        for (const char* at = neighbour; at <= slash; at++) {
            text_add_character(&path, *at);
        }
    }
    text_add(&path, name);
    return !path.cut;
}

static status_t load_listed(descriptor_loader_t* const loader, mission_builder_t* const builder,
                            const char* const mission_path, subsystem_descriptor_t* const scratch)
{
    const mission_descriptor_t* const mission = builder->mission;
    for (uint16_t i = 0U; i < mission->subsystem_count; i++) {
        const mission_subsystem_t* const subsystem = &mission->subsystems[i];
        if (!join(loader->path, sizeof loader->path, mission_path, subsystem->descriptor)) {
            (void)source_fail(&builder->source, subsystem->line, STATUS_INVALID,
                              "the path of the descriptor is too long");
            return STATUS_INVALID;
        }
        status_t status = descriptor_load_subsystem(loader, loader->path, scratch);
        if (status == STATUS_OK) {
            status = mission_builder_take(builder, i, loader->path, scratch);
        }
        if (status != STATUS_OK) {
            return status;
        }
    }
    return mission_builder_resolve(builder);
}

status_t descriptor_load_mission(descriptor_loader_t* const loader, const char* const path,
                                 mission_descriptor_t* const out_mission,
                                 subsystem_descriptor_t* const scratch)
{
    FSW_ASSERT((loader != NULL) && (path != NULL) && (out_mission != NULL) && (scratch != NULL));
    text_t error = text_in(loader->error, sizeof loader->error);
    mission_builder_t builder;
    mission_builder_begin(&builder, out_mission, path, &error);
    status_t status = parse_file(loader, &builder.source, path);
    if (status == STATUS_OK) {
        status = load_listed(loader, &builder, path, scratch);
    }
    if (status != STATUS_OK) {
        (void)memset(out_mission, 0, sizeof *out_mission);
        out_mission->name           = "";
        out_mission->ground_address = "";
    }
    return status;
}

status_t descriptor_check_interface(descriptor_loader_t* const loader, const char* const path,
                                    const subsystem_descriptor_t* const descriptor,
                                    const uint64_t compiled_hash)
{
    FSW_ASSERT((loader != NULL) && (path != NULL) && (descriptor != NULL));
    text_t error = text_in(loader->error, sizeof loader->error);
    if (descriptor->interface_hash == compiled_hash) {
        return STATUS_OK;
    }
    text_add(&error, path);
    text_add(&error, ":1: interface compiled ");
    text_add_hex(&error, compiled_hash, 16U);
    text_add(&error, ", found ");
    text_add_hex(&error, descriptor->interface_hash, 16U);
    text_add(&error, ": run make");
    return STATUS_CHECKSUM;
}

const char* descriptor_error(const descriptor_loader_t* const loader)
{
    FSW_ASSERT(loader != NULL);
    return loader->error;
}
