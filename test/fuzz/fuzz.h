// SPDX-License-Identifier: Apache-2.0
/// Common parts of the fuzz targets: checks that end the program, inputs that are a sequence of records,
/// mutators that keep lengths, checksums and nesting correct, and files in memory.
///
/// A target is `fuzz_<name>.c` with LLVMFuzzerTestOneInput and, if a protocol has lengths or checksums,
/// LLVMFuzzerCustomMutator. Every input starts from the same state, so that a failure can be repeated.
#ifndef TEST_FUZZ_FUZZ_H
#define TEST_FUZZ_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// End the program with file, line and condition if an invariant does not hold.
#define FUZZ_CHECK(condition)                                                                                \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fuzz_fail(__FILE__, __LINE__, #condition);                                                       \
        }                                                                                                    \
    } while (0)
void fuzz_fail(const char* file, int line, const char* condition) __attribute__((noreturn));

/// The interface of the fuzzing engine.
int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
int LLVMFuzzerInitialize(int* argc, char*** argv);
size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

/// Returns the next number of a sequence, 0 to 2^24 - 1; advances `state`.
uint32_t fuzz_random(uint32_t* state);

// ---- Inputs that are a sequence of records: kind u8 | argument u8 | size u16 | octets ----

#define FUZZ_RECORD_HEADER 4U

typedef struct {
    uint8_t kind;
    uint8_t argument;
    size_t size;
    /// A separate copy, so that a read past its end is detected. Valid until the next record.
    const uint8_t* octets;
} fuzz_record_t;

typedef struct { // Private.
    const uint8_t* data;
    size_t size;
    size_t position;
    uint8_t* copy;
} fuzz_input_t;

fuzz_input_t fuzz_input(const uint8_t* data, size_t size);
/// Read the next record. Returns false at the end, when the last copy is released. A record that is longer
/// than the rest of the input is truncated.
bool fuzz_next(fuzz_input_t* input, fuzz_record_t* out_record);

/// Repairs the octets of one record in place.
typedef void (*fuzz_repair_t)(uint8_t kind, uint8_t* octets, size_t size, uint32_t* random);

/// Mutate the octets or the header of a record, or copy, remove or add a record. In 7 of 8 inputs
/// the mutated octets are repaired.
size_t fuzz_mutate_records(uint8_t* data, size_t size, size_t max_size, unsigned seed, fuzz_repair_t repair);
/// Mutate an input that consists of one message; in 7 of 8 inputs the message is repaired.
size_t fuzz_mutate_message(uint8_t* data, size_t size, size_t max_size, unsigned seed, fuzz_repair_t repair);
/// Mutate an XML document by elements and attributes; one in 8 by octets.
size_t fuzz_mutate_document(uint8_t* data, size_t size, size_t max_size, unsigned seed);

/// Repair a space packet: versions, flags, length field, CRC, and the time of a report.
void fuzz_repair_packet(uint8_t kind, uint8_t* octets, size_t size, uint32_t* random);

// ---- Files ----

/// Returns the path of a file in memory with these octets; it is always the same path.
const char* fuzz_file(const uint8_t* data, size_t size);
/// Returns a directory for this target under build/fuzz/directory, made if it does not exist.
const char* fuzz_directory(const char* name);
/// Make `link` in the target's directory point to `target`.
void fuzz_link(const char* directory, const char* link, const char* target);

#endif // TEST_FUZZ_FUZZ_H
