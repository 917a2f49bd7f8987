// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "base/assertion.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/process.h"

#include <link.h>
#include <string.h>

#define HEADERS_MAX 64U ///< Largest number of segments of one executable.

typedef ElfW(Ehdr) program_header_t;

static bool is_of_this_machine(const program_header_t* const header)
{
    const unsigned char word = (sizeof(void*) == 8U) ? ELFCLASS64 : ELFCLASS32;
    return (memcmp(header->e_ident, ELFMAG, SELFMAG) == 0) && (header->e_ident[EI_CLASS] == word) &&
           (header->e_phentsize == sizeof(ElfW(Phdr))) && (header->e_phnum <= HEADERS_MAX);
}

static status_t add_segments(osal_file_t* const file, uint64_t* const out_octets)
{
    program_header_t header;
    ElfW(Phdr) segments[HEADERS_MAX];
    status_t status = osal_file_read_at(file, 0U, &header, sizeof header);
    if ((status == STATUS_OK) && !is_of_this_machine(&header)) {
        status = STATUS_INVALID;
    }
    if (status == STATUS_OK) {
        status =
            osal_file_read_at(file, header.e_phoff, segments, (size_t)header.e_phnum * sizeof segments[0]);
    }
    for (size_t i = 0U; (status == STATUS_OK) && (i < header.e_phnum); i++) {
        *out_octets += (segments[i].p_type == PT_LOAD) ? segments[i].p_memsz : 0U;
    }
    return (status == STATUS_TRUNCATED) ? STATUS_INVALID : status;
}

status_t osal_process_loaded_size(const char* const path, uint64_t* const out_octets)
{
    FSW_ASSERT((path != NULL) && (out_octets != NULL));
    osal_file_t file;
    *out_octets     = 0U;
    status_t status = osal_file_open_read(&file, path);
    if (status == STATUS_OK) {
        status = add_segments(&file, out_octets);
        osal_file_close(&file);
    }
    return status;
}
