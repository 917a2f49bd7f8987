// SPDX-License-Identifier: Apache-2.0
// Compiles the descriptors of a program for a target that cannot read files. For each mission with a
// subsystem of this program, it writes the constants that the reader of descriptors would create from the
// files, the table of the device classes that they name, and a header with the sizes that the storage of the
// program needs for them. A run whose mission has another hash refuses the compiled program
// (fsw/programs/compiled_descriptors.h).
#include "launcher/descriptor_capacities.h"
#include "launcher/descriptor_classes.h"
#include "launcher/descriptor_writer.h"
#include "base/assertion.h"
#include "base/text.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define ENTRIES_MAX 32U
#define LINE_MAX 512U
#define HEADER_MAX 2048U

typedef struct { // A subsystem of the program in one mission.
    uint64_t mission_hash;
    uint16_t apid;
    unsigned subsystem; ///< Number of the model of its descriptor in the generated source.
} entry_t;

typedef struct { // All storage of the program.
    descriptor_loader_t loader;
    mission_descriptor_t whole;
    mission_descriptor_t mission;
    subsystem_descriptor_t own;
    const char* executable;
    entry_t entries[ENTRIES_MAX];
    unsigned count;
    /// Path of the descriptor of each model in the generated source.
    char paths[ENTRIES_MAX][DESCRIPTOR_PATH_CHARACTERS];
    unsigned path_count;
    osal_file_t file;
    descriptor_writer_t writer;
    descriptor_capacities_t capacities;
    descriptor_classes_t classes;
} compiler_t;

static compiler_t storage;

static int report_error(const char* const first, const char* const second)
{
    char line[LINE_MAX];
    (void)text_join(line, sizeof line, (const char* const[]){"descriptor-compiler: ", first, second, NULL});
    osal_console_print_error(line);
    return 1;
}

/// Returns the number of the model that the loader has read from its last path. A new model is written first.
static unsigned number_of_model(compiler_t* const self)
{
    for (unsigned i = 0U; i < self->path_count; i++) {
        if (strcmp(self->paths[i], self->loader.path) == 0) {
            return i;
        }
    }
    const unsigned number = self->path_count;
    (void)text_join(self->paths[number], sizeof self->paths[number],
                    (const char* const[]){self->loader.path, NULL});
    self->path_count++;
    descriptor_writer_subsystem(&self->writer, number, &self->own);
    return number;
}

/// Compile one subsystem. Its mission is read as the program of the subsystem would read it. Returns null, or
/// the error text.
static const char* compile(compiler_t* const self, const char* const path, const uint16_t apid)
{
    if (self->count == ENTRIES_MAX) {
        return "too many missions with this program; raise ENTRIES_MAX in "
               "launcher/descriptor_compiler_main.c";
    }
    if (descriptor_load_mission(&self->loader, path, apid, NULL, &self->mission, &self->own) != STATUS_OK) {
        return descriptor_error(&self->loader);
    }
    self->entries[self->count] = (entry_t){self->whole.configuration_hash, apid, number_of_model(self)};
    descriptor_writer_mission(&self->writer, self->count, &self->mission);
    descriptor_capacities_add(&self->capacities, &self->own, &self->whole);
    descriptor_classes_add(&self->classes, &self->own);
    self->count++;
    return NULL;
}

static const char* compile_mission(compiler_t* const self, const char* const path)
{
    if (descriptor_load_mission(&self->loader, path, MISSION_ANY_TARGET, &descriptor_mission_whole,
                                &self->whole, &self->own) != STATUS_OK) {
        return descriptor_error(&self->loader);
    }
    const char* error = NULL;
    for (uint16_t i = 0U; (i < self->whole.subsystem_count) && (error == NULL); i++) {
        const mission_subsystem_t* const subsystem = &self->whole.subsystems[i];
        if (strcmp(subsystem->executable, self->executable) == 0) {
            error = compile(self, path, subsystem->apid);
        }
    }
    return error;
}

static void write_entries(compiler_t* const self)
{
    descriptor_writer_add(
        &self->writer, (const char* const[]){"\nstatic const compiled_descriptor_t entries[] = {\n", NULL});
    for (unsigned i = 0U; i < self->count; i++) {
        char line[LINE_MAX];
        text_t text = text_in(line, sizeof line);
        text_add(&text, "    {");
        text_add_hex(&text, self->entries[i].mission_hash, 16U);
        text_add_pattern(&text, "ULL, #U, ", NULL, NULL, self->entries[i].apid);
        text_add_pattern(&text, "&mission_#, ", NULL, NULL, i);
        text_add_pattern(&text, "&subsystem_#},\n", NULL, NULL, self->entries[i].subsystem);
        descriptor_writer_add(&self->writer, (const char* const[]){line, NULL});
    }
    descriptor_writer_add(
        &self->writer,
        (const char* const[]){
            "};\nstatic compiled_descriptors_t compiled = {entries, sizeof entries / sizeof entries[0], "
            "\"\"};\n\n"
            "compiled_descriptors_t* compiled_descriptors_of_program(void)\n{\n    return &compiled;\n}\n",
            NULL});
}

/// Write the table of device classes.
static void write_classes(compiler_t* const self)
{
    char characters[DESCRIPTOR_CLASSES_OCTETS];
    text_t text = text_in(characters, sizeof characters);
    descriptor_classes_write(&self->classes, &text);
    FSW_ASSERT(!text.cut);
    descriptor_writer_add(&self->writer, (const char* const[]){characters, NULL});
}

/// Write the main function of the program, which calls <name>_open.
static void write_main(compiler_t* const self, const char* const name)
{
    descriptor_writer_begin(&self->writer, &self->file);
    descriptor_writer_add(
        &self->writer,
        (const char* const[]){"#include \"fsw/programs/executive.h\"\n\n"
                              "int main(int argument_count, char* arguments[])\n{\n"
                              "    const component_descriptors_t descriptors =\n"
                              "        compiled_descriptors(compiled_descriptors_of_program());\n"
                              "    return executive_run(argument_count, arguments, \"",
                              self->executable, "\", ", name, "_open, &descriptors);\n}\n", NULL});
}

/// Write the header of capacities to the file that was created.
static bool write_capacities(compiler_t* const self)
{
    char characters[HEADER_MAX];
    text_t text = text_in(characters, sizeof characters);
    descriptor_capacities_write(&self->capacities, &text);
    FSW_ASSERT(!text.cut);
    const status_t status = osal_file_write(&self->file, characters, text.length);
    osal_file_close(&self->file);
    if (status != STATUS_OK) {
        (void)report_error("cannot write the capacities: ", status_text(status));
    }
    return status == STATUS_OK;
}

/// Create the file `<directory>/<name><ending>`. False on an error, which is printed.
static bool create(compiler_t* const self, const char* const directory, const char* const name,
                   const char* const ending)
{
    char path[DESCRIPTOR_PATH_CHARACTERS];
    const bool fits = text_join(path, sizeof path, (const char* const[]){directory, "/", name, ending, NULL});
    const status_t status = fits ? osal_file_create(&self->file, path) : STATUS_TOO_LARGE;
    if (status != STATUS_OK) {
        char detail[DESCRIPTOR_PATH_CHARACTERS + 32U];
        (void)text_join(detail, sizeof detail, (const char* const[]){path, ": ", status_text(status), NULL});
        (void)report_error("cannot write ", detail);
    }
    return status == STATUS_OK;
}

/// Finish and close the file that is being written. False on an error, which is printed.
static bool finish(compiler_t* const self)
{
    const status_t status = descriptor_writer_end(&self->writer);
    osal_file_close(&self->file);
    if (status != STATUS_OK) {
        (void)report_error("cannot write the source: ", status_text(status));
    }
    return status == STATUS_OK;
}

int main(const int argument_count, char* arguments[])
{
    static const char usage[] =
        "usage: descriptor-compiler DIRECTORY NAME EXECUTABLE MISSION...: writes "
        "DIRECTORY/NAME_descriptors.c, DIRECTORY/NAME_main.c and DIRECTORY/NAME_capacities.h";
    compiler_t* const self = &storage;
    if (osal_console_introduce(argument_count, arguments, "descriptor-compiler", usage)) {
        return 0;
    }
    if (argument_count < 5) {
        (void)report_error(usage, "");
        return 2;
    }
    descriptor_loader_init(&self->loader);
    self->executable = arguments[3];
    if (!create(self, arguments[1], arguments[2], "_descriptors.c")) {
        return 1;
    }
    descriptor_writer_begin(&self->writer, &self->file);
    for (int i = 4; i < argument_count; i++) {
        const char* const error = compile_mission(self, arguments[i]);
        if (error != NULL) {
            return report_error(error, "");
        }
    }
    if (self->count == 0U) {
        return report_error(self->executable, ": no mission has a subsystem with this executable");
    }
    write_entries(self);
    write_classes(self);
    if (!finish(self) || !create(self, arguments[1], arguments[2], "_main.c")) {
        return 1;
    }
    write_main(self, arguments[2]);
    if (!finish(self) || !create(self, arguments[1], arguments[2], "_capacities.h")) {
        return 1;
    }
    return write_capacities(self) ? 0 : 1;
}
