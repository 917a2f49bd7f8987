// SPDX-License-Identifier: Apache-2.0
/// Three memories and a file under ST[06], whose hardware fails as it is told, and a writer of requests.
#ifndef TEST_UNIT_PUS_MEMORIES_H
#define TEST_UNIT_PUS_MEMORIES_H

#include "pus/st06_memory.h"

#define RAM 1U   ///< 4 KiB at RAM_BASE, octet by octet; objects 7 (0x1100, 256 octets) and 8 (empty).
#define WORDS 2U ///< 64 octets at 0xFFFFFFC0, four at a time; no objects, no scrubbing.
#define ROM 3U   ///< 64 octets at 0, read-only.
#define RAM_BASE 0x1000U
#define MEMORY_OPERATIONS 2U
#define FILE_OCTETS 4000U

typedef struct {
    uint32_t broken_at;  ///< Reading this address of RAM fails; 0 none.
    uint32_t stuck_at;   ///< Writing this address of RAM has no effect.
    bool refuses_writes; ///< Writing WORDS fails.
    unsigned scrubs;
    uint32_t scrubbed; ///< Octets.
    uint32_t scrubbed_at;
} memory_hardware_t;

typedef struct {
    uint8_t octets[FILE_OCTETS];
    uint32_t size;
    status_t open; ///< What opening and creating says.
    status_t read;
    status_t write;
    status_t close;
    bool is_open;
    unsigned closes;
    char name[32]; ///< Path/name.
} memory_file_t;

extern pus_memory_service_t memory_service;
extern pus_memory_state_t memory_states[3];
extern pus_memory_operation_t memory_operations[MEMORY_OPERATIONS];
extern uint8_t memory_ram[4096];
extern uint8_t memory_words[64];
extern uint8_t memory_rom[64];
extern memory_hardware_t memory_hardware;
extern memory_file_t memory_file;
extern const pus_file_port_t memory_files;
extern uint8_t memory_data[PUS_TC_DATA_MAX]; ///< Of the request being written,
extern octet_writer_t memory_writer;         ///< and where its next octet goes.

/// Everything as at first, with an empty store of records; and the service anew, the records as they are.
void memories_start(void);
void memory_start_with(const pus_file_port_t* port);
/// The three memories.
const pus_memory_t* memory_list(void);

/// Begin a request; add what it is made of; send it; step the service.
void memory_begin(uint8_t memory);
void memory_begin_object(uint8_t memory, uint32_t base_id);
void memory_name_file(void);
void memory_add_area(uint32_t address, uint32_t length);
/// `damage` is or-ed exclusively to the checksum.
void memory_add_data(uint32_t address, const void* octets, uint16_t size, uint16_t damage);
void memory_add_file_area(uint32_t address, uint32_t offset, uint32_t length, uint16_t damage);
void memory_request(uint8_t subtype);
void memory_step(unsigned count);

#endif // TEST_UNIT_PUS_MEMORIES_H
