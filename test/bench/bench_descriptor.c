// SPDX-License-Identifier: Apache-2.0
/// Loading the manipulator's descriptor. Baseline: expat alone on the same octets, with the heap and an equal
/// number of handlers. The value of parsing alone is per octet.
#include "fsw/framework/descriptor/descriptor.h"
#include "fsw/framework/xml/xml.h"
#include "test/bench/measure.h"

#include <expat.h>
#include <stdio.h>
#include <stdlib.h>

#define PATH "descriptors/subsystems/manipulator.xml"

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static char document[256U * 1024U];
static size_t document_size;
static xml_parser_t parser;
static uint64_t arena[XML_ARENA_WORDS];

static void load(void)
{
    if (descriptor_parse_subsystem(&loader, PATH, document, document_size, &descriptor) != STATUS_OK) {
        (void)fprintf(stderr, "%s\n", descriptor_error(&loader));
        exit(1);
    }
}

static status_t on_start(void* context, const xml_element_t* element)
{
    (void)context;
    (void)element;
    return STATUS_OK;
}

static status_t on_end(void* context, const char* name, uint32_t line)
{
    (void)context;
    (void)name;
    (void)line;
    return STATUS_OK;
}

static void parse(void)
{
    const xml_handler_t handler = {.start = on_start, .end = on_end};
    if ((xml_begin(&parser, &handler) != STATUS_OK) ||
        (xml_feed(&parser, document, document_size) != STATUS_OK) || (xml_finish(&parser) != STATUS_OK)) {
        exit(1);
    }
}

static void XMLCALL on_bare_start(void* context, const XML_Char* name, const XML_Char** attributes)
{
    (void)context;
    (void)name;
    (void)attributes;
}

static void XMLCALL on_bare_end(void* context, const XML_Char* name)
{
    (void)context;
    (void)name;
}

static void XMLCALL on_bare_text(void* context, const XML_Char* octets, int length)
{
    (void)context;
    (void)octets;
    (void)length;
}

static void expat_alone(void)
{
    const XML_Parser bare = XML_ParserCreate(NULL);
    XML_SetElementHandler(bare, on_bare_start, on_bare_end);
    XML_SetCharacterDataHandler(bare, on_bare_text);
    if (XML_Parse(bare, document, (int)document_size, 1) != XML_STATUS_OK) {
        exit(1);
    }
    XML_ParserFree(bare);
}

int main(void)
{
    FILE* const file = fopen(PATH, "rb");
    if (file == NULL) {
        (void)fprintf(stderr, "cannot read %s\n", PATH);
        return 1;
    }
    document_size = fread(document, 1U, sizeof document, file);
    (void)fclose(file);
    descriptor_loader_init(&loader);
    xml_init(&parser, arena, XML_ARENA_WORDS);
    measure_compare("descriptor_load", load, expat_alone, 1.0, "us", 1000.0);
    measure_compare("xml_parse", parse, expat_alone, (double)document_size, "ns/octet", 1.0);
    return 0;
}
