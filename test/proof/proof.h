// SPDX-License-Identifier: Apache-2.0
/// What the proofs share. Each `proof_*.c` begins with its statement, which run_proofs.py reads: what it
/// proves, for which bounds, what it replaces, the sources it needs, options of CBMC, and a fault that it
/// must find. CBMC begins with the function `proof`; what a proof does not set has any value.
#ifndef TEST_PROOF_PROOF_H
#define TEST_PROOF_PROOF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PROVE(condition, text) __CPROVER_assert((condition), text)
#define ASSUME(condition) __CPROVER_assume(condition)
#define IMPLIES(condition, consequence) (!(condition) || (consequence))

// Any value: CBMC knows these by the beginning of their names.
bool nondet_bool(void);
uint8_t nondet_u8(void);
uint16_t nondet_u16(void);
uint32_t nondet_u32(void);
uint64_t nondet_u64(void);
int64_t nondet_i64(void);
size_t nondet_size(void);

void proof(void);

/// Any size up to `most`.
static inline size_t any_size(const size_t most)
{
    const size_t size = nondet_size();
    ASSUME(size <= most);
    return size;
}

#endif // TEST_PROOF_PROOF_H
