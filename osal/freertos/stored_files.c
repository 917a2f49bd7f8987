// SPDX-License-Identifier: Apache-2.0
// Files on the EEPROM, by the file system littlefs, which survives a power cut at any write. Each write to a
// file ends with a sync of the file system, so that the octets are stored even if the program ends.
#include "osal/freertos/file_system.h"

#include "base/assertion.h"
#include "osal/freertos/eeprom.h"
#include "osal/freertos/i2c.h"
#include "osal/include/osal/mutex.h"

#include <FreeRTOS.h>
#include <lfs.h>
#include <string.h>
#include <task.h>

#define BLOCK EEPROM_PAGE
#define GRAIN 16U   ///< Smallest read and write of the file system [octets].
#define BLOCKS 511U ///< The last page of the EEPROM is not a block of the file system: it contains the mark.
#define MARK_ADDRESS (BLOCKS * BLOCK)
#define LOOKAHEAD 64U ///< One bit for each block.
#define NAME_OCTETS 64U
#define CYCLES 500 ///< Writes of a block for metadata, after which another block is used.
#define BLANK 0xFFU

typedef struct { // An open file: one entry, even if it is opened several times.
    unsigned users;
    bool is_good; ///< False: it was removed, or an error has lost it.
    lfs_file_t file;
    struct lfs_file_config configuration;
    uint8_t cache[BLOCK];
    char name[NAME_OCTETS];
} stored_t;

static uint8_t read_cache[BLOCK];
static uint8_t write_cache[BLOCK];
static uint32_t lookahead[LOOKAHEAD / sizeof(uint32_t)];
static lfs_t store;
static bool is_mounted;
static osal_mutex_t mutex; ///< Guards everything here, and the EEPROM.
static bool has_mutex;
static stored_t stored[FILE_SYSTEM_FILES];
static stored_t* opened[FILE_SYSTEM_FILES]; ///< By the number of the file.

static int read_block(const struct lfs_config* const used, const lfs_block_t block, const lfs_off_t offset,
                      void* const octets, const lfs_size_t size)
{
    (void)used;
    return (eeprom_read((block * BLOCK) + offset, octets, size) == STATUS_OK) ? 0 : LFS_ERR_IO;
}

static int write_block(const struct lfs_config* const used, const lfs_block_t block, const lfs_off_t offset,
                       const void* const octets, const lfs_size_t size)
{
    (void)used;
    return (eeprom_write((block * BLOCK) + offset, octets, size) == STATUS_OK) ? 0 : LFS_ERR_IO;
}

/// An EEPROM needs no erasure before a write.
static int erase_block(const struct lfs_config* const used, const lfs_block_t block)
{
    (void)used;
    (void)block;
    return 0;
}

/// eeprom_write returns when the octets are stored.
static int sync_blocks(const struct lfs_config* const used)
{
    (void)used;
    return 0;
}

static const struct lfs_config configuration = {.read             = read_block,
                                                .prog             = write_block,
                                                .erase            = erase_block,
                                                .sync             = sync_blocks,
                                                .read_size        = GRAIN,
                                                .prog_size        = GRAIN,
                                                .block_size       = BLOCK,
                                                .block_count      = BLOCKS,
                                                .block_cycles     = CYCLES,
                                                .cache_size       = BLOCK,
                                                .lookahead_size   = LOOKAHEAD,
                                                .read_buffer      = read_cache,
                                                .prog_buffer      = write_cache,
                                                .lookahead_buffer = lookahead,
                                                .name_max         = NAME_OCTETS - 1U};

static status_t status_of(const int result)
{
    switch ((result < 0) ? result : 0) {
    case 0:
        return STATUS_OK;
    case LFS_ERR_NOENT:
        return STATUS_NOT_FOUND;
    case LFS_ERR_NOSPC:
    case LFS_ERR_FBIG:
        return STATUS_FULL;
    default:
        return STATUS_IO;
    }
}

/// Create the file system on an EEPROM that has never had one. The mark is written last. A power cut before
/// that leaves an EEPROM that is still to be formatted. After the first octet of the mark, the EEPROM is
/// never formatted again, whatever happens to its content.
static int format_blank(void)
{
    static const uint8_t mark[GRAIN] = "littlefs";
    uint8_t found[GRAIN];
    bool is_blank = (eeprom_read(MARK_ADDRESS, found, sizeof found) == STATUS_OK);
    if (!is_blank) {
        return LFS_ERR_IO;
    }
    for (size_t i = 0U; i < sizeof found; i++) {
        is_blank = is_blank && (found[i] == BLANK);
    }
    int result = is_blank ? lfs_format(&store, &configuration) : 0;
    if (is_blank && (result == 0) && (eeprom_write(MARK_ADDRESS, mark, sizeof mark) != STATUS_OK)) {
        result = LFS_ERR_IO;
    }
    return result;
}

/// Lock the store, and mount it if it is not mounted. STATUS_OK; STATUS_IO: it cannot be used. The caller
/// releases it with leave(), whatever the status.
static status_t enter(void)
{
    taskENTER_CRITICAL(); // Two tasks may find that the mutex does not exist yet.
    if (!has_mutex) {
        has_mutex = (osal_mutex_create(&mutex, false) == STATUS_OK);
    }
    taskEXIT_CRITICAL();
    const status_t locked = osal_mutex_lock(&mutex);
    FSW_ASSERT(has_mutex && (locked == STATUS_OK));
    if (!is_mounted) {
        is_mounted =
            (i2c_clear() == STATUS_OK) && (format_blank() == 0) && (lfs_mount(&store, &configuration) == 0);
    }
    return is_mounted ? STATUS_OK : STATUS_IO;
}

static status_t leave(const status_t status)
{
    osal_mutex_unlock(&mutex);
    return status;
}

static const char* name_of(const char* const path)
{
    return &path[strlen(STORED_FILES)];
}

static stored_t* find(const char* const name)
{
    for (unsigned i = 0U; i < FILE_SYSTEM_FILES; i++) {
        if ((stored[i].users > 0U) && stored[i].is_good && (strcmp(stored[i].name, name) == 0)) {
            return &stored[i];
        }
    }
    return NULL;
}

/// Close the file of that name for all its users: it was removed, renamed or replaced.
static void forget(const char* const name)
{
    stored_t* const one = find(name);
    if (one != NULL) {
        (void)lfs_file_close(&store, &one->file);
        one->is_good = false;
    }
}

static int open_stored(stored_t* const one, const int flags)
{
    one->configuration = (struct lfs_file_config){.buffer = one->cache};
    const int result   = lfs_file_opencfg(&store, &one->file, one->name, flags, &one->configuration);
    one->is_good       = (result == 0);
    return result;
}

/// After an error of a write, littlefs refuses the file until it is opened again; it then has the content
/// that it had before this write.
static status_t settle(stored_t* const one, const int result)
{
    const int synced = (result < 0) ? result : lfs_file_sync(&store, &one->file);
    if (synced < 0) {
        (void)lfs_file_close(&store, &one->file);
        (void)open_stored(one, LFS_O_RDWR);
    }
    return status_of(synced);
}

static stored_t* free_entry(void)
{
    unsigned i = 0U;
    while ((i < FILE_SYSTEM_FILES) && (stored[i].users > 0U)) {
        i++;
    }
    FSW_ASSERT(i < FILE_SYSTEM_FILES); // There are as many entries as file numbers.
    return &stored[i];
}

static status_t open_file(const unsigned file, const char* const path, const file_system_mode_t mode)
{
    const char* const name = name_of(path);
    status_t status        = enter();
    if ((status == STATUS_OK) && (strlen(name) >= NAME_OCTETS)) {
        status = STATUS_IO;
    }
    stored_t* one = (status == STATUS_OK) ? find(name) : NULL;
    if ((status == STATUS_OK) && (one == NULL)) {
        one = free_entry();
        (void)memcpy(one->name, name, strlen(name) + 1U);
        status = status_of(open_stored(one, LFS_O_RDWR | ((mode == FILE_SYSTEM_READ) ? 0 : LFS_O_CREAT)));
        status = ((status == STATUS_OK) && (mode != FILE_SYSTEM_READ)) ? settle(one, 0) : status;
    }
    if ((status == STATUS_OK) && (mode == FILE_SYSTEM_CREATE)) {
        status = settle(one, lfs_file_truncate(&store, &one->file, 0U));
    }
    if (status == STATUS_OK) {
        one->users++;
        opened[file] = one;
    } else if ((one != NULL) && (one->users == 0U) && one->is_good) {
        (void)lfs_file_close(&store, &one->file);
    }
    return leave(status);
}

static void close_file(const unsigned file)
{
    (void)enter();
    stored_t* const one = opened[file];
    one->users--;
    if ((one->users == 0U) && one->is_good) {
        (void)lfs_file_close(&store, &one->file);
    }
    (void)leave(STATUS_OK);
}

/// Lock the store for an operation on an open file. STATUS_OK, STATUS_IO: the file cannot be used any more.
static status_t enter_file(const unsigned file)
{
    const status_t status = enter();
    return ((status == STATUS_OK) && opened[file]->is_good) ? STATUS_OK : STATUS_IO;
}

static int seek(stored_t* const one, const uint32_t offset)
{
    return (int)lfs_file_seek(&store, &one->file, (lfs_soff_t)offset, LFS_SEEK_SET);
}

static status_t read_file(const unsigned file, const uint32_t offset, void* const octets,
                          const size_t capacity, size_t* const out_size)
{
    stored_t* const one = opened[file];
    *out_size           = 0U;
    if (enter_file(file) != STATUS_OK) {
        return leave(STATUS_IO);
    }
    int result = seek(one, offset);
    result     = (result >= 0) ? (int)lfs_file_read(&store, &one->file, octets, capacity) : result;
    *out_size  = (result > 0) ? (size_t)result : 0U;
    return leave(status_of(result));
}

static status_t write_file(const unsigned file, const uint32_t offset, const void* const octets,
                           const size_t size)
{
    stored_t* const one = opened[file];
    if (enter_file(file) != STATUS_OK) {
        return leave(STATUS_IO);
    }
    int result = seek(one, offset);
    result     = (result >= 0) ? (int)lfs_file_write(&store, &one->file, octets, size) : result;
    return leave(settle(one, result));
}

static status_t size_of_file(const unsigned file, uint32_t* const out_size)
{
    *out_size = 0U;
    if (enter_file(file) != STATUS_OK) {
        return leave(STATUS_IO);
    }
    const int size = (int)lfs_file_size(&store, &opened[file]->file);
    *out_size      = (size > 0) ? (uint32_t)size : 0U;
    return leave(status_of(size));
}

static status_t resize_file(const unsigned file, const uint32_t size)
{
    stored_t* const one = opened[file];
    if (enter_file(file) != STATUS_OK) {
        return leave(STATUS_IO);
    }
    return leave(settle(one, lfs_file_truncate(&store, &one->file, size)));
}

/// Each write has stored its octets already.
static status_t sync_file(const unsigned file)
{
    return leave(enter_file(file));
}

/// The name of a file is on the EEPROM as soon as it was opened. There are no directories.
static status_t sync_names(const char* const path)
{
    const status_t status = enter();
    return leave((strchr(name_of(path), '/') == NULL) ? status : STATUS_IO);
}

static status_t remove_file(const char* const path)
{
    status_t status = enter();
    if (status == STATUS_OK) {
        status = status_of(lfs_remove(&store, name_of(path)));
    }
    if (status == STATUS_OK) {
        forget(name_of(path));
    }
    return leave(status);
}

static status_t rename_file(const char* const path, const char* const new_path)
{
    status_t status = enter();
    if (status == STATUS_OK) {
        status = status_of(lfs_rename(&store, name_of(path), name_of(new_path)));
    }
    if (status == STATUS_OK) {
        forget(name_of(path));
        forget(name_of(new_path));
    }
    return leave(status);
}

static bool file_exists(const char* const path)
{
    struct lfs_info about;
    const status_t status = enter();
    return leave((status == STATUS_OK) ? status_of(lfs_stat(&store, name_of(path), &about)) : status) ==
           STATUS_OK;
}

void stored_files_restart(void)
{
    is_mounted = false;
    (void)memset(stored, 0, sizeof stored);
}

const file_system_t stored_files = {.open       = open_file,
                                    .close      = close_file,
                                    .read       = read_file,
                                    .write      = write_file,
                                    .size       = size_of_file,
                                    .resize     = resize_file,
                                    .sync       = sync_file,
                                    .sync_names = sync_names,
                                    .remove     = remove_file,
                                    .rename     = rename_file,
                                    .exists     = file_exists};
