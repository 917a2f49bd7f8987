// SPDX-License-Identifier: Apache-2.0
/// Memory functions that expat calls; they allocate from one arena. Internal to xml/.
///
/// These functions have no context argument, so each call of expat is enclosed by xml_arena_enter, which
/// selects the arena, and xml_arena_leave. MISRA deviation D-1.4: the pointer to the selected arena is the
/// only writable object of static storage in the framework; each thread has its own, which is null outside
/// these calls.
#ifndef FSW_FRAMEWORK_XML_XML_ARENA_H
#define FSW_FRAMEWORK_XML_XML_ARENA_H

#include "fsw/framework/xml/xml.h"

void xml_arena_enter(xml_arena_t* arena);
void xml_arena_leave(void);

/// Free all blocks of the arena.
void xml_arena_reset(xml_arena_t* arena);

/// The three functions of XML_Memory_Handling_Suite. They return null if the arena has no room.
void* xml_arena_take(size_t octets);
void* xml_arena_resize(void* block, size_t octets);
void xml_arena_give(void* block);

#endif // FSW_FRAMEWORK_XML_XML_ARENA_H
