// SPDX-License-Identifier: Apache-2.0
/// Runs a fuzz target once for each file that its command line names, in order, without a fuzzing engine.
/// Exit code 0 if all inputs passed, 2 if a file cannot be read. A target that fails ends the program.
#include "test/fuzz/fuzz.h"

#include <stdio.h>
#include <stdlib.h>

/// Weak: a target without this function starts with its first input.
__attribute__((weak)) int LLVMFuzzerInitialize(int* argc, char*** argv);

/// The mutators of the targets call this function of the engine. No mutator runs here.
size_t LLVMFuzzerMutate(uint8_t* const data, const size_t size, const size_t max_size)
{
    (void)data;
    (void)max_size;
    return size;
}

/// Returns the octets of an open file in a block of exactly their number, so that a read past its end is
/// detected; NULL if the file cannot be read.
static uint8_t* octets_of(FILE* const file, size_t* const out_size)
{
    if (fseek(file, 0, SEEK_END) != 0) {
        return NULL;
    }
    const long size = ftell(file);
    if ((size < 0) || (fseek(file, 0, SEEK_SET) != 0)) {
        return NULL;
    }
    uint8_t* const octets = malloc((size_t)size);
    *out_size             = (size_t)size;
    if ((octets != NULL) && (fread(octets, 1U, (size_t)size, file) != (size_t)size)) {
        free(octets);
        return NULL;
    }
    return octets;
}

int main(int argc, char** argv)
{
    if (LLVMFuzzerInitialize != NULL) {
        (void)LLVMFuzzerInitialize(&argc, &argv);
    }
    for (int i = 1; i < argc; i++) {
        FILE* const file      = fopen(argv[i], "rb");
        size_t size           = 0U;
        uint8_t* const octets = (file != NULL) ? octets_of(file, &size) : NULL;
        if (octets == NULL) {
            (void)fprintf(stderr, "%s: cannot be read\n", argv[i]);
            return 2;
        }
        (void)fclose(file);
        (void)fprintf(stderr, "%s\n", argv[i]); // The last line before a failure names its input.
        (void)LLVMFuzzerTestOneInput(octets, size);
        free(octets);
    }
    return 0;
}
