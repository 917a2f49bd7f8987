// SPDX-License-Identifier: Apache-2.0
/// ST[08] function management: TC[8,1] {function name 8 octets, N u8 x {argument id u16, value}}.
///
/// A request must contain every declared argument exactly once, in any order, and no others. Values are
/// decoded to the argument area, each at the offset of its argument, so that the port gets a pointer to a C
/// struct. The function is performed only if all arguments are valid; the failure of an argument has the
/// position of the argument as instruction number. Floating-point values that are not finite are refused. The
/// port checks bounds.
///
/// Ownership  The caller provides definitions and area.
#ifndef PUS_ST08_ST08_FUNCTIONS_H
#define PUS_ST08_ST08_FUNCTIONS_H

#include "base/value.h"
#include "pus/core/service.h"

#define PUS_ARGUMENTS_MAX 32U ///< Largest number of arguments of one function.

/// One argument of a function.
typedef struct {
    uint16_t id;
    value_type_t type;
    uint16_t count;  ///< Elements, >= 1.
    uint16_t offset; ///< Position in the argument area [octets], aligned for the type.
} pus_argument_t;

/// One function.
typedef struct {
    char name[PUS_NAME_SIZE + 1U]; ///< 1..8 characters, NUL padded.
    uint8_t argument_count;        ///< <= PUS_ARGUMENTS_MAX.
    const pus_argument_t* arguments;
} pus_function_t;

typedef struct {
    void* context;
    /// Perform function `index` of the table. `arguments` is the area, valid during the call only. If it
    /// returns PUS_LATER, it has copied the token and later calls pus_verify_completed or pus_verify_failed.
    pus_reply_t (*perform)(void* context, uint16_t index, const void* arguments, const pus_token_t* token,
                           uint64_t now_ns);
} pus_function_port_t;

typedef struct { // Private.
    const pus_function_t* functions;
    uint16_t count;
    pus_function_port_t port;
    uint8_t* area;
    size_t area_size;
} pus_functions_t;

/// `table` has `count` functions. `area` has room for the arguments of every function.
void pus_functions_init(pus_functions_t* functions, const pus_function_t* table, uint16_t count,
                        const pus_function_port_t* port, uint64_t* area, size_t area_size);
pus_service_t pus_functions_service(pus_functions_t* functions);

#endif // PUS_ST08_ST08_FUNCTIONS_H
