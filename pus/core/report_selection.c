// SPDX-License-Identifier: Apache-2.0
#include "pus/core/report_selection.h"

#include "base/assertion.h"

#include <string.h>

// A key consists of list (2 bits), process (11), flag "has an identifier" (1) and identifier (16; for types:
// service << 8 | subtype). A key without identifier means the whole process, a key with subtype 0 the whole
// service; such a key is less than all keys that it includes.

#define LIST_SHIFT 28U
#define APID_SHIFT 17U
#define HAS_ID 0x10000U
#define PROCESS_SPAN 0x1FFFFU ///< Last key of a process minus the key of the whole process.
#define SERVICE_SPAN 0xFFU
#define APID_OF(key) ((uint16_t)(((key) >> APID_SHIFT) & 0x7FFU))
#define ID_OF(key) ((uint16_t)((key)&0xFFFFU))
#define SERVICE_SHIFT 8U
#define SUBTYPE_MASK 0xFFU
#define DETAIL_SHIFT 16U

#define HOUSEKEEPING_REPORT 25U
#define DIAGNOSTIC_REPORT 26U
#define EVENT_REPORTS 4U // TM[5,1] to TM[5,4] are event reports.

#define ENTRY_SIZE 6U // Size of an entry in a persistent record [octets].
#define GROUP_ROOM 8U // Largest size of an entry in a report [octets].
#define NO_KEY UINT32_MAX

void pus_selection_init(pus_selection_t* const selection, pus_selection_entry_t* const entries,
                        const uint16_t capacity)
{
    FSW_ASSERT((selection != NULL) && (entries != NULL) && (capacity > 0U) &&
               (capacity <= PUS_SELECTION_ENTRIES_MAX));
    *selection = (pus_selection_t){.entries = entries, .capacity = capacity};
}

static uint32_t key_of_process(const pus_selection_list_t list, const uint16_t apid)
{
    return ((uint32_t)list << LIST_SHIFT) | ((uint32_t)apid << APID_SHIFT);
}

static uint32_t key_of(const pus_selection_list_t list, const uint16_t apid, const uint16_t id)
{
    return key_of_process(list, apid) | HAS_ID | id;
}

static uint32_t last_key_of(const pus_selection_list_t list)
{
    return key_of(list, PUS_APID_MAX, UINT16_MAX);
}

/// Returns the index of the first entry whose key is at least `key`; `count` if there is none.
static uint16_t index_of(const pus_selection_t* const selection, const uint32_t key)
{
    uint16_t low  = 0U;
    uint16_t high = selection->count;
    while (low < high) {
        const uint16_t middle = (uint16_t)((low + high) / 2U);
        if (selection->entries[middle].key < key) {
            low = (uint16_t)(middle + 1U);
        } else {
            high = middle;
        }
    }
    return low;
}

static pus_selection_entry_t* entry_of(const pus_selection_t* const selection, const uint32_t key)
{
    const uint16_t index = index_of(selection, key);
    const bool is_there  = (index < selection->count) && (selection->entries[index].key == key);
    return is_there ? &selection->entries[index] : NULL;
}

static bool has(const pus_selection_t* const selection, const uint32_t key)
{
    return entry_of(selection, key) != NULL;
}

/// Remove the entries from index `index` on whose keys are at most `last`. Returns their number.
static uint16_t remove_range(pus_selection_t* const selection, const uint16_t index, const uint32_t last)
{
    uint16_t end = index;
    while ((end < selection->count) && (selection->entries[end].key <= last)) {
        end++;
    }
    const uint16_t removed = (uint16_t)(end - index);
    (void)memmove(&selection->entries[index], &selection->entries[end],
                  (size_t)(selection->count - end) * sizeof(pus_selection_entry_t));
    selection->count = (uint16_t)(selection->count - removed);
    return removed;
}

/// Replace all entries from `key` to `last` by one entry. False: there is no room.
static bool insert(pus_selection_t* const selection, const uint32_t key, const uint32_t last,
                   const uint16_t rate)
{
    const uint16_t index   = index_of(selection, key);
    const uint16_t removed = remove_range(selection, index, last);
    if (selection->count >= selection->capacity) {
        FSW_ASSERT(removed == 0U); // An insertion that has removed an entry has room.
        return false;
    }
    (void)memmove(&selection->entries[index + 1U], &selection->entries[index],
                  (size_t)(selection->count - index) * sizeof(pus_selection_entry_t));
    selection->entries[index] = (pus_selection_entry_t){.key = key, .rate = rate};
    selection->count++;
    return true;
}

status_t pus_selection_add_process(pus_selection_t* const selection, const uint16_t apid)
{
    FSW_ASSERT((selection != NULL) && (apid <= PUS_APID_MAX));
    // The lists before PUS_BLOCKED_EVENTS, those of types and structures, get one entry each.
    const uint16_t lists = (uint16_t)PUS_BLOCKED_EVENTS;
    if (((uint32_t)selection->count + lists) > selection->capacity) {
        return STATUS_EXHAUSTED;
    }
    for (uint16_t list = 0U; list < lists; list++) {
        const uint32_t key = key_of_process((pus_selection_list_t)list, apid);
        if (!has(selection, key)) {
            // Each list adds one entry at most, and there is room for that many.
            (void)insert(selection, key, key + PROCESS_SPAN, 1U);
        }
    }
    return STATUS_OK;
}

// ---- Decision ----

static bool takes_type(const pus_selection_t* const selection, const pus_tm_t* const tm)
{
    const uint16_t service = (uint16_t)((uint16_t)tm->service << SERVICE_SHIFT);
    return has(selection, key_of_process(PUS_SELECTED_TYPES, tm->apid)) ||
           has(selection, key_of(PUS_SELECTED_TYPES, tm->apid, service)) ||
           has(selection, key_of(PUS_SELECTED_TYPES, tm->apid, (uint16_t)(service | tm->subtype)));
}

static bool takes_structure(const pus_selection_t* const selection, const pus_selection_list_t list,
                            const uint16_t apid, const uint16_t id)
{
    if (has(selection, key_of_process(list, apid))) {
        return true;
    }
    pus_selection_entry_t* const entry = entry_of(selection, key_of(list, apid, id));
    if (entry == NULL) {
        return false;
    }
    const bool is_taken = entry->phase == 0U;
    entry->phase        = (uint16_t)((entry->phase + 1U) % entry->rate);
    return is_taken;
}

bool pus_selection_takes(pus_selection_t* const selection, const pus_tm_t* const tm)
{
    FSW_ASSERT((selection != NULL) && (tm != NULL));
    if (!takes_type(selection, tm)) {
        return false;
    }
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    const uint16_t id     = octet_read_u16(&reader); // 0 if the report is too short for an identifier.
    if ((tm->service == PUS_SERVICE_HOUSEKEEPING) && (tm->subtype == HOUSEKEEPING_REPORT)) {
        return takes_structure(selection, PUS_SELECTED_HOUSEKEEPING, tm->apid, id);
    }
    if ((tm->service == PUS_SERVICE_HOUSEKEEPING) && (tm->subtype == DIAGNOSTIC_REPORT)) {
        return takes_structure(selection, PUS_SELECTED_DIAGNOSTIC, tm->apid, id);
    }
    if ((tm->service == PUS_SERVICE_EVENTS) && (tm->subtype <= EVENT_REPORTS)) {
        return !has(selection, key_of_process(PUS_BLOCKED_EVENTS, tm->apid)) &&
               !has(selection, key_of(PUS_BLOCKED_EVENTS, tm->apid, id));
    }
    return true;
}

// ---- Changes ----

/// A request that is being performed on a copy of the selection.
typedef struct {
    const pus_selection_editor_t* editor;
    pus_selection_t selection;
    pus_selection_list_t list;
    pus_request_t* request;
    uint16_t instruction; ///< Number of the last instruction.
    bool is_addition;
    bool is_changed;
} edit_t;

/// The entry that an instruction adds or deletes.
typedef struct {
    uint32_t key;
    uint32_t last; ///< Last key that the entry includes.
    /// Key of the whole service to which it belongs; NO_KEY if there is none, or if it is `key` itself.
    uint32_t service;
    uint16_t rate;
    bool is_valid;
} selection_target_t;

static bool is_controlled(const pus_selection_editor_t* const editor, const uint16_t apid)
{
    for (uint16_t i = 0U; i < editor->apid_count; i++) {
        if (editor->apids[i] == apid) {
            return true;
        }
    }
    return false;
}

/// Add an entry. Returns PUS_FAILURE_NONE, or the failure code.
static uint16_t add(edit_t* const edit, const selection_target_t* const target, const uint16_t apid)
{
    pus_selection_t* const selection   = &edit->selection;
    const uint32_t process             = key_of_process(edit->list, apid);
    pus_selection_entry_t* const entry = entry_of(selection, target->key);
    const bool is_comprised            = ((target->key != process) && has(selection, process)) ||
                              ((target->service != NO_KEY) && has(selection, target->service));
    if (!is_controlled(edit->editor, apid)) {
        return PUS_FAILURE_UNKNOWN_ID;
    }
    if (is_comprised || ((entry != NULL) && (entry->rate == target->rate))) {
        return PUS_FAILURE_EXISTS;
    }
    if (entry != NULL) {
        entry->rate  = target->rate;
        entry->phase = 0U;
        return PUS_FAILURE_NONE;
    }
    return insert(selection, target->key, target->last, target->rate) ? PUS_FAILURE_NONE
                                                                      : PUS_FAILURE_TABLE_FULL;
}

static uint16_t erase(edit_t* const edit, const selection_target_t* const target)
{
    const uint16_t removed =
        remove_range(&edit->selection, index_of(&edit->selection, target->key), target->last);
    return (removed > 0U) ? PUS_FAILURE_NONE : PUS_FAILURE_UNKNOWN_ID;
}

static uint32_t detail_of(const edit_t* const edit, const uint16_t code, const uint32_t key)
{
    switch (code) {
    case PUS_FAILURE_TABLE_FULL:
        return edit->selection.capacity;
    case PUS_FAILURE_OUT_OF_RANGE:
        return (uint32_t)edit->request->reader.position;
    default:
        return ((uint32_t)APID_OF(key) << DETAIL_SHIFT) | ID_OF(key);
    }
}

/// Perform or refuse one instruction.
static void instruct(edit_t* const edit, const selection_target_t* const target)
{
    uint16_t code = PUS_FAILURE_OUT_OF_RANGE;
    edit->instruction++;
    if (target->is_valid) {
        code = edit->is_addition ? add(edit, target, APID_OF(target->key)) : erase(edit, target);
    }
    if (code == PUS_FAILURE_NONE) {
        edit->is_changed = true;
        pus_request_perform(edit->request);
    } else {
        pus_request_refuse(edit->request, edit->instruction, code, detail_of(edit, code, target->key));
    }
}

/// Perform the instructions about the services of a process and their subtypes.
static void edit_services(edit_t* const edit, const uint16_t apid, const uint8_t count)
{
    octet_reader_t* const reader = &edit->request->reader;
    for (uint8_t i = 0U; i < count; i++) {
        const uint8_t service  = octet_read_u8(reader);
        const uint8_t subtypes = octet_read_u8(reader);
        const uint32_t all     = key_of(edit->list, apid, (uint16_t)((uint16_t)service << SERVICE_SHIFT));
        if (subtypes == 0U) {
            const selection_target_t target = {.key      = all,
                                               .last     = all + SERVICE_SPAN,
                                               .service  = NO_KEY,
                                               .rate     = 1U,
                                               .is_valid = service != 0U};
            instruct(edit, &target);
        }
        for (uint8_t k = 0U; k < subtypes; k++) {
            const uint8_t subtype           = octet_read_u8(reader);
            const selection_target_t target = {.key      = all | subtype,
                                               .last     = all | subtype,
                                               .service  = all,
                                               .rate     = 1U,
                                               .is_valid = (service != 0U) && (subtype != 0U)};
            instruct(edit, &target);
        }
    }
}

/// Perform the instructions about the structures or events of a process.
static void edit_ids(edit_t* const edit, const uint16_t apid, const uint8_t count)
{
    octet_reader_t* const reader = &edit->request->reader;
    const bool has_rate          = edit->is_addition && (edit->list != PUS_BLOCKED_EVENTS);
    for (uint8_t i = 0U; i < count; i++) {
        const uint32_t key              = key_of(edit->list, apid, octet_read_u16(reader));
        const uint16_t rate             = has_rate ? octet_read_u16(reader) : 1U;
        const selection_target_t target = {
            .key = key, .last = key, .service = NO_KEY, .rate = rate, .is_valid = rate != 0U};
        instruct(edit, &target);
    }
}

static void edit_entries(edit_t* const edit)
{
    octet_reader_t* const reader = &edit->request->reader;
    const uint8_t processes      = octet_read_u8(reader);
    if (processes == 0U) { // Only a request to delete may name no process: then it deletes the whole list.
        const uint32_t first = key_of_process(edit->list, 0U);
        const uint16_t removed =
            remove_range(&edit->selection, index_of(&edit->selection, first), last_key_of(edit->list));
        edit->is_changed = removed > 0U;
    }
    for (uint8_t i = 0U; i < processes; i++) {
        const uint16_t apid = octet_read_u16(reader);
        const uint8_t count = octet_read_u8(reader);
        const uint32_t key  = key_of_process(edit->list, apid);
        if (count == 0U) {
            const selection_target_t target = {.key      = key,
                                               .last     = key + PROCESS_SPAN,
                                               .service  = NO_KEY,
                                               .rate     = 1U,
                                               .is_valid = apid <= PUS_APID_MAX};
            instruct(edit, &target);
        } else if (edit->list == PUS_SELECTED_TYPES) {
            edit_services(edit, apid, count);
        } else {
            edit_ids(edit, apid, count);
        }
    }
}

static void copy_entries(pus_selection_t* const to, const pus_selection_t* const from)
{
    (void)memcpy(to->entries, from->entries, (size_t)from->count * sizeof(pus_selection_entry_t));
    to->count = from->count;
}

static pus_reply_t change(const pus_selection_editor_t* const editor, pus_selection_t* const selection,
                          const pus_selection_list_t list, const uint32_t key, pus_request_t* const request,
                          const bool is_addition)
{
    FSW_ASSERT((editor != NULL) && (selection != NULL) && (list < PUS_SELECTION_LISTS) && (request != NULL));
    edit_t edit            = {.editor      = editor,
                              .selection   = *selection,
                              .list        = list,
                              .request     = request,
                              .is_addition = is_addition};
    edit.selection.entries = editor->candidate;
    copy_entries(&edit.selection, selection);
    edit_entries(&edit);
    const status_t status = edit.is_changed ? pus_selection_put(editor, &edit.selection, key) : STATUS_OK;
    if (status != STATUS_OK) {
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    copy_entries(selection, &edit.selection);
    return pus_done();
}

pus_reply_t pus_selection_add(const pus_selection_editor_t* const editor, pus_selection_t* const selection,
                              const pus_selection_list_t list, const uint32_t key,
                              pus_request_t* const request)
{
    return change(editor, selection, list, key, request, true);
}

pus_reply_t pus_selection_delete(const pus_selection_editor_t* const editor, pus_selection_t* const selection,
                                 const pus_selection_list_t list, const uint32_t key,
                                 pus_request_t* const request)
{
    return change(editor, selection, list, key, request, false);
}

// ---- Persistent records ----

status_t pus_selection_put(const pus_selection_editor_t* const editor, const pus_selection_t* const selection,
                           const uint32_t key)
{
    FSW_ASSERT((editor != NULL) && (selection != NULL));
    const pus_persistence_t* const persistence = editor->persistence;
    if (persistence == NULL) {
        return STATUS_OK;
    }
    uint8_t record[PUS_RECORD_MAX];
    octet_writer_t writer = octet_writer(record, sizeof record);
    octet_write_u16(&writer, selection->count);
    for (uint16_t i = 0U; i < selection->count; i++) {
        octet_write_u32(&writer, selection->entries[i].key);
        octet_write_u16(&writer, selection->entries[i].rate);
    }
    FSW_ASSERT(!writer.failed); // A record has room for PUS_SELECTION_ENTRIES_MAX entries, so all fit.
    return persistence->put(persistence->context, editor->table, key, record, writer.position);
}

/// True if the entries of a record can be used: the keys ascend, list and rate of each entry are valid, and a
/// key without the flag "has an identifier" has the identifier 0.
static bool is_sound(octet_reader_t reader, const uint16_t count)
{
    uint32_t least = 0U;
    bool is_good   = octet_reader_left(&reader) == ((size_t)count * ENTRY_SIZE);
    for (uint16_t i = 0U; is_good && (i < count); i++) {
        const uint32_t key  = octet_read_u32(&reader);
        const uint16_t rate = octet_read_u16(&reader);
        const bool is_key   = ((key & HAS_ID) != 0U) || (ID_OF(key) == 0U);
        is_good =
            (key >= least) && ((key >> LIST_SHIFT) < (uint32_t)PUS_SELECTION_LISTS) && is_key && (rate != 0U);
        least = key + 1U;
    }
    return is_good;
}

status_t pus_selection_restore(pus_selection_t* const selection, const uint8_t* const octets,
                               const size_t size)
{
    FSW_ASSERT((selection != NULL) && ((octets != NULL) || (size == 0U)));
    octet_reader_t reader = octet_reader(octets, size);
    const uint16_t count  = octet_read_u16(&reader);
    if (reader.failed || !is_sound(reader, count)) {
        return STATUS_INVALID;
    }
    if (count > selection->capacity) {
        return STATUS_EXHAUSTED;
    }
    for (uint16_t i = 0U; i < count; i++) {
        const uint32_t key    = octet_read_u32(&reader);
        selection->entries[i] = (pus_selection_entry_t){.key = key, .rate = octet_read_u16(&reader)};
    }
    selection->count = count;
    return STATUS_OK;
}

// ---- Reports ----

/// A report that is being written. The next entry is appended to the present process and service.
typedef struct {
    octet_writer_t writer;
    size_t processes_at; ///< Position of the count of processes.
    size_t ids_at;       ///< Position of the count of services, structures or events.
    size_t subtypes_at;
    uint32_t process; ///< Key of the present process; NO_KEY: none.
    uint32_t service;
} page_t;

static size_t begin_count(octet_writer_t* const writer)
{
    const size_t position = writer->position;
    octet_write_u16(writer, 0U);
    return position;
}

static void count_one(const octet_writer_t* const writer, const size_t position)
{
    octets_put_u16(&writer->octets[position], (uint16_t)(octets_u16_at(&writer->octets[position]) + 1U));
}

static page_t begin_page(const pus_request_t* const request, const uint8_t subtype, const uint8_t* const name)
{
    page_t page = {.writer = pus_answer_begin(request, subtype), .process = NO_KEY, .service = NO_KEY};
    if (name != NULL) {
        octet_write_octets(&page.writer, name, PUS_NAME_SIZE);
    }
    page.processes_at = begin_count(&page.writer);
    return page;
}

static void write_type(page_t* const page, const uint32_t key)
{
    octet_writer_t* const writer = &page->writer;
    const uint32_t service       = key & ~(uint32_t)SUBTYPE_MASK;
    if (page->service != service) {
        page->service = service;
        count_one(writer, page->ids_at);
        octet_write_u8(writer, (uint8_t)(ID_OF(key) >> SERVICE_SHIFT));
        page->subtypes_at = begin_count(writer);
    }
    if (key != service) {
        count_one(writer, page->subtypes_at);
        octet_write_u8(writer, (uint8_t)(key & SUBTYPE_MASK));
    }
}

static void write_entry(page_t* const page, const pus_selection_list_t list,
                        const pus_selection_entry_t* const entry)
{
    octet_writer_t* const writer = &page->writer;
    const uint32_t process       = key_of_process(list, APID_OF(entry->key));
    if (page->process != process) {
        page->process = process;
        count_one(writer, page->processes_at);
        octet_write_u16(writer, APID_OF(entry->key));
        page->ids_at = begin_count(writer);
    }
    if (entry->key == process) {
        return; // The entry of a whole process has no identifiers.
    }
    if (list == PUS_SELECTED_TYPES) {
        write_type(page, entry->key);
        return;
    }
    count_one(writer, page->ids_at);
    octet_write_u16(writer, ID_OF(entry->key));
    if (list != PUS_BLOCKED_EVENTS) {
        octet_write_u16(writer, entry->rate);
    }
}

void pus_selection_report(const pus_selection_t* const selection, const pus_selection_list_t list,
                          pus_request_t* const request, const uint8_t subtype, const uint8_t* const name)
{
    FSW_ASSERT((selection != NULL) && (list < PUS_SELECTION_LISTS) && (request != NULL));
    const uint32_t last = last_key_of(list);
    page_t page         = begin_page(request, subtype, name);
    for (uint16_t i = index_of(selection, key_of_process(list, 0U));
         (i < selection->count) && (selection->entries[i].key <= last); i++) {
        if ((page.writer.capacity - page.writer.position) < GROUP_ROOM) {
            pus_answer_send(request, &page.writer);
            page = begin_page(request, subtype, name);
        }
        write_entry(&page, list, &selection->entries[i]);
    }
    pus_answer_send(request, &page.writer);
}
