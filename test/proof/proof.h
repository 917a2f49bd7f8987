// SPDX-License-Identifier: Apache-2.0
/// What the proofs share. Each `proof_*.c` begins with its statement, which run_proofs.py reads: what it
/// proves, for which bounds, what it replaces, the sources it needs, options of CBMC, and faults that it
/// must find. CBMC begins with the function `proof`; what a proof does not set has any value. A state is
/// sound if the conditions hold that every call of the code must preserve; the proof defines them.
#ifndef TEST_PROOF_PROOF_H
#define TEST_PROOF_PROOF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// PROVE: the statement is true whenever it is reached. IMPLIES, only within PROVE: if the condition is true,
/// the consequence is true. NEVER: this line is not reached.
///
/// With PROOF_REACHED each assertion claims instead that the statement is never reached with all of its
/// conditions true; run_proofs.py expects each to fail, because a statement that is never reached proves
/// nothing.
#define ASSUME(condition) __CPROVER_assume(condition)
#ifdef PROOF_REACHED
static bool proof_is_idle; // A condition of the statement is false, so its consequence was not examined.
static inline bool proof_idle(void)
{
    proof_is_idle = true;
    return true;
}
#define PROVE(statement, text)                                                                               \
    do {                                                                                                     \
        proof_is_idle          = false;                                                                      \
        const bool proof_holds = (statement);                                                                \
        __CPROVER_assert(!proof_holds || proof_is_idle, text);                                               \
    } while (false)
#define IMPLIES(condition, consequence) ((condition) ? (consequence) : proof_idle())
#define NEVER(text) (void)0
#else
#define PROVE(statement, text) __CPROVER_assert((statement), text)
#define IMPLIES(condition, consequence) (!(condition) || (consequence))
#define NEVER(text) __CPROVER_assert(false, text)
#endif

// Functions that return any value: CBMC recognizes them by the beginning of their names.
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
