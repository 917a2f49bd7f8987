// SPDX-License-Identifier: Apache-2.0
// Files on an EEPROM that the test simulates in memory. The power is cut at each write to a page of a script:
// the page then has none, half or all of the octets. After the restart, each operation that had ended is
// complete, and the one under way is complete or has changed nothing.
#include "osal/freertos/eeprom.h"
#include "osal/freertos/file_system.h"
#include "osal/include/osal/file.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>

#define PATH "/eeprom/a"
#define OTHER "/eeprom/b"
#define STEPS 24U
#define PIECE 100U
#define CONTENT_MAX 4000U
#define CUTS_MAX 2000U
#define SCRIPT_FILES 3U

typedef enum {
    CUT_BEFORE,
    CUT_INSIDE,
    CUT_BEHIND,
    CUTS
} cut_t;

typedef struct { // Content of the files that the script uses.
    bool exists[SCRIPT_FILES];
    size_t size[SCRIPT_FILES];
    uint8_t octets[SCRIPT_FILES][CONTENT_MAX];
} content_t;

static const char* const names[SCRIPT_FILES] = {"/eeprom/script", "/eeprom/script.new", "/eeprom/log"};
static uint8_t memory[EEPROM_OCTETS];
static unsigned writes;
static unsigned cut_at; ///< Number of the write at which the power is cut; 0: none.
static cut_t kind;
static bool is_off;
static bool is_jammed;   ///< The bus cannot be freed.
static bool is_clear;    ///< The bus has been freed since the restart.
static content_t before; ///< After the last step that has ended.
static content_t behind; ///< After the step under way.
static content_t found;

status_t __wrap_i2c_clear(void);
status_t __wrap_eeprom_read(uint32_t address, void* octets, size_t size);
status_t __wrap_eeprom_write(uint32_t address, const void* octets, size_t size);

status_t __wrap_i2c_clear(void)
{
    is_clear = is_clear || !is_jammed;
    return is_jammed ? STATUS_IO : STATUS_OK;
}

status_t __wrap_eeprom_read(const uint32_t address, void* const octets, const size_t size)
{
    TEST_ASSERT_TRUE(is_clear);
    (void)memcpy(octets, &memory[address], size);
    return is_off ? STATUS_IO : STATUS_OK;
}

status_t __wrap_eeprom_write(const uint32_t address, const void* const octets, const size_t size)
{
    size_t stored = is_off ? 0U : size;
    TEST_ASSERT_EQUAL_UINT32(address / EEPROM_PAGE, (address + size - 1U) / EEPROM_PAGE); // One page.
    if (!is_off) {
        writes++;
        is_off = (writes == cut_at);
    }
    if (is_off && (writes == cut_at) && (stored > 0U)) {
        stored = (kind == CUT_BEFORE) ? 0U : ((kind == CUT_INSIDE) ? (size / 2U) : size);
    }
    (void)memcpy(&memory[address], octets, stored);
    return is_off ? STATUS_IO : STATUS_OK;
}

static void restart(void)
{
    is_off   = false;
    is_clear = false;
    cut_at   = 0U;
    stored_files_restart();
}

static void begin_blank(void)
{
    (void)memset(memory, 0xFF, sizeof memory);
    restart();
}

void setUp(void)
{
    begin_blank();
}

void tearDown(void)
{
}

static void put(const char* const path, const char* const text)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, text, strlen(text)));
    osal_file_close(&file);
}

static void expect(const char* const path, const char* const text)
{
    char content[64];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(strlen(text), size);
    TEST_ASSERT_EQUAL_MEMORY(text, content, size);
}

static void written_files_exist_after_a_restart(void)
{
    osal_file_t file;
    put(PATH, "content");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, OTHER));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, "without sync", 12U)); // Neither synced nor closed.
    osal_file_close(&file);
    restart();
    expect(PATH, "content");
    expect(OTHER, "without sync");
}

/// A reset within a read can leave the bus in use.
static void the_bus_is_freed_before_the_first_read(void)
{
    osal_file_t file;
    put(PATH, "content");
    restart();
    is_jammed = true;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_update(&file, PATH));
    TEST_ASSERT_FALSE(is_clear);
    is_jammed = false;
    expect(PATH, "content"); // The next user tries again.
    TEST_ASSERT_TRUE(is_clear);
}

static void all_users_of_an_open_file_have_the_same_content(void)
{
    osal_file_t first;
    osal_file_t second;
    uint64_t size = 0U;
    char content[4];
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&first, PATH));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_append(&second, PATH));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&first, 0U, "ab", 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&second, "cd", 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&first, 0U, content, 4U));
    TEST_ASSERT_EQUAL_MEMORY("abcd", content, 4U);
    osal_file_close(&second);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&first, &size));
    TEST_ASSERT_EQUAL_UINT64(4U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_remove(PATH));
    TEST_ASSERT_EQUAL(STATUS_IO,
                      osal_file_read_at(&first, 0U, content, 4U)); // An open file loses its content, too.
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_sync(&first));
    TEST_ASSERT_FALSE(osal_file_is_named(&first));
    osal_file_close(&first);
}

static void a_file_stays_open_if_it_could_not_be_replaced(void)
{
    osal_file_t file;
    char content[2];
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_update(&file, PATH));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_file_rename(OTHER, PATH)); // There is no such file.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write_at(&file, 0U, "ab", 2U));
    put(OTHER, "new");
    is_off = true;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_rename(OTHER, PATH));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_remove(PATH));
    is_off = false;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_read_at(&file, 0U, content, 2U));
    TEST_ASSERT_EQUAL_MEMORY("ab", content, 2U);
    osal_file_close(&file);
}

static void a_full_store_keeps_what_it_has(void)
{
    static const uint8_t piece[1000];
    osal_file_t file;
    uint64_t size    = 0U;
    status_t status  = STATUS_OK;
    unsigned written = 0U;
    put(PATH, "kept");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, OTHER));
    while ((status == STATUS_OK) && (written <= (EEPROM_OCTETS / sizeof piece))) {
        status = osal_file_write(&file, piece, sizeof piece);
        written += (status == STATUS_OK) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, status);
    TEST_ASSERT_GREATER_THAN_UINT(100U, written); // Two record stores of 32 KiB and a copy of one fit.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_size(&file, &size));
    TEST_ASSERT_EQUAL_UINT64(written * sizeof piece, size); // The write that failed has changed nothing.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_resize(&file, 1000U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, piece, 1U));
    osal_file_close(&file);
    expect(PATH, "kept");
    put(PATH, "changed");
    expect(PATH, "changed");
}

static void long_names_directories_other_media_and_too_many_files_are_refused(void)
{
    char path[128] = "/eeprom/";
    osal_file_t file;
    osal_file_t files[FILE_SYSTEM_FILES];
    (void)memset(&path[8], 'n', 64U);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create(&file, path)); // The name has 64 characters.
    path[71] = '\0';
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path));
    osal_file_close(&file);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND,
                      osal_file_create(&file, "/eeprom/directory/a")); // There are no directories.
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_rename(path, "./a"));       // Another medium.
    for (unsigned i = 0U; i < FILE_SYSTEM_FILES; i++) {
        (void)snprintf(path, sizeof path, "/eeprom/%u", i);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&files[i], path));
    }
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_create(&file, PATH)); // Too many are open.
    for (unsigned i = 0U; i < FILE_SYSTEM_FILES; i++) {
        osal_file_close(&files[i]);
    }
}

static void without_an_eeprom_there_are_no_files(void)
{
    osal_file_t file;
    is_off = true;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_update(&file, PATH));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_remove(PATH));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_sync_names(PATH));
    TEST_ASSERT_FALSE(osal_file_exists(PATH));
}

static void a_store_that_is_damaged_is_not_formatted_again(void)
{
    static uint8_t damaged[EEPROM_OCTETS];
    osal_file_t file;
    put(PATH, "content");
    (void)memset(memory, 0, 2U * EEPROM_PAGE); // Both blocks of the root.
    (void)memcpy(damaged, memory, sizeof memory);
    restart();
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_open_read(&file, PATH));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_update(&file, PATH));
    TEST_ASSERT_EQUAL_MEMORY(damaged, memory, sizeof memory);
}

// ---- Power cuts ----

static status_t write_all(const char* const name, status_t (*const open)(osal_file_t* file, const char* path),
                          const void* const octets, const size_t size)
{
    osal_file_t file;
    status_t status = open(&file, name);
    if (status == STATUS_OK) {
        status = osal_file_write(&file, octets, size);
        osal_file_close(&file);
    }
    return status;
}

static void model_write(content_t* const content, const unsigned file, const size_t offset,
                        const uint8_t* const octets, const size_t size)
{
    const size_t end = offset + size;
    (void)memcpy(&content->octets[file][offset], octets, size);
    content->size[file]   = (end > content->size[file]) ? end : content->size[file];
    content->exists[file] = true;
}

/// One step of the script, which changes the content by one operation: an append, a write into the middle, a
/// file that is replaced by a rename, a removal.
static status_t step(const unsigned number)
{
    uint8_t piece[PIECE];
    osal_file_t file;
    status_t status = STATUS_OK;
    (void)memset(piece, (int)(number + 1U), sizeof piece);
    behind = before;
    switch (number % 6U) {
    case 0U:
    case 1U:
        model_write(&behind, 2U, behind.size[2], piece, sizeof piece);
        return write_all(names[2], osal_file_append, piece, sizeof piece);
    case 2U:
        status = osal_file_update(&file, names[2]);
        model_write(&behind, 2U, PIECE / 2U, piece, sizeof piece);
        if (status == STATUS_OK) {
            status = osal_file_write_at(&file, PIECE / 2U, piece, sizeof piece);
            osal_file_close(&file);
        }
        return status;
    case 3U:
        model_write(&behind, 1U, behind.size[1], piece, sizeof piece);
        return write_all(names[1], osal_file_append, piece, sizeof piece);
    case 4U:
        behind.exists[0] = true;
        behind.size[0]   = behind.size[1];
        (void)memcpy(behind.octets[0], behind.octets[1], behind.size[1]);
        behind.exists[1] = false;
        behind.size[1]   = 0U;
        return osal_file_rename(names[1], names[0]);
    default:
        behind.exists[0] = false;
        behind.size[0]   = 0U;
        return osal_file_remove(names[0]);
    }
}

static void load(content_t* const content)
{
    for (unsigned i = 0U; i < SCRIPT_FILES; i++) {
        const status_t status = osal_file_load(names[i], content->octets[i], CONTENT_MAX, &content->size[i]);
        TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_NOT_FOUND));
        content->exists[i] = (status == STATUS_OK);
    }
}

/// An append creates a missing file before it writes, so an empty file is the same as none.
static bool is_same(const content_t* const one, const content_t* const other)
{
    bool same = true;
    for (unsigned i = 0U; i < SCRIPT_FILES; i++) {
        same = same && (one->size[i] == other->size[i]) &&
               (memcmp(one->octets[i], other->octets[i], one->size[i]) == 0);
    }
    return same;
}

/// Run the script on a blank EEPROM. Returns true if it has ended without a cut.
static bool run_script(const unsigned at, const cut_t how)
{
    begin_blank();
    (void)memset(&before, 0, sizeof before);
    behind          = before;
    writes          = 0U;
    cut_at          = at;
    kind            = how;
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i < STEPS) && (status == STATUS_OK); i++) {
        status = step(i);
        before = (status == STATUS_OK) ? behind : before;
    }
    return status == STATUS_OK;
}

static void a_power_cut_at_any_write_leaves_the_state_before_or_after_the_step(void)
{
    for (unsigned how = 0U; how < CUTS; how++) {
        unsigned at = 1U;
        while (!run_script(at, (cut_t)how)) {
            restart();
            load(&found);
            TEST_ASSERT_TRUE(is_same(&found, &before) || is_same(&found, &behind));
            before = found;
            TEST_ASSERT_EQUAL(STATUS_OK, step(0U)); // The store can be written to.
            load(&found);
            TEST_ASSERT_TRUE(is_same(&found, &behind));
            at++;
            TEST_ASSERT_LESS_THAN_UINT(CUTS_MAX, at);
        }
        TEST_ASSERT_GREATER_THAN_UINT(STEPS, at); // At least one write in each step.
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(written_files_exist_after_a_restart);
    RUN_TEST(the_bus_is_freed_before_the_first_read);
    RUN_TEST(all_users_of_an_open_file_have_the_same_content);
    RUN_TEST(a_file_stays_open_if_it_could_not_be_replaced);
    RUN_TEST(a_full_store_keeps_what_it_has);
    RUN_TEST(long_names_directories_other_media_and_too_many_files_are_refused);
    RUN_TEST(without_an_eeprom_there_are_no_files);
    RUN_TEST(a_store_that_is_damaged_is_not_formatted_again);
    RUN_TEST(a_power_cut_at_any_write_leaves_the_state_before_or_after_the_step);
    return UNITY_END();
}
