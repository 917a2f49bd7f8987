// SPDX-License-Identifier: Apache-2.0
// A power cut in the storage of a flight, the directory POWER_CUT_STORAGE. Loaded before the C library
// (LD_PRELOAD), it counts the changes and syncs that the program makes there. At number POWER_CUT_AFTER it
// undoes changes that a disk may lose, and kills the program. POWER_CUT_SEED selects the changes that are
// lost: any writes and changes of size since the last sync of their file (the last write may be torn), and
// any number of the latest changes of names since the last sync of their directory. A call that reserves
// space (fallocate) is not counted.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define CHANGES 256     // Beyond this number, the oldest changes count as written to the disk.
#define DESCRIPTORS 512 // File descriptors of this library begin here.

typedef enum {
    WRITTEN,
    RESIZED,
    MADE,
    REMOVED,
    RENAMED
} kind_t;

typedef struct {
    kind_t kind;
    int place; // The changed file, or the directory of the name.
    int other; // The directory of the new name.
    bool is_directory;
    char name[NAME_MAX + 1];
    char new_name[NAME_MAX + 1];
    off_t old_size;
    off_t offset; // Offset of a write, or new size.
    char *old_octets, *octets;
    size_t old_count, count;
} change_t;

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static change_t changes[CHANGES];
static unsigned change_count;
static long rest = -1; // Number of changes and syncs until the cut.
static char storage[PATH_MAX];
static int removed_files = -1; // A directory that keeps removed files until their removal is synced.

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

__attribute__((constructor)) static void begin(void)
{
    const char* const after     = getenv("POWER_CUT_AFTER");
    const char* const seed      = getenv("POWER_CUT_SEED");
    const char* const directory = getenv("POWER_CUT_STORAGE");
    if ((after != NULL) && (seed != NULL) && (directory != NULL)) {
        rest = atol(after);
        srandom((unsigned)atol(seed));
        (void)snprintf(storage, sizeof storage, "%s", directory);
        char path[PATH_MAX + 16];
        (void)snprintf(path, sizeof path, "%s.removed", directory);
        (void)mkdir(path, 0755);
        removed_files = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    }
}

static bool is_stored(int descriptor)
{
    char link[64];
    char path[PATH_MAX];
    if (rest < 0) {
        return false;
    }
    (void)snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t size  = readlink(link, path, sizeof path - 1U);
    const size_t length = strlen(storage);
    return (size >= (ssize_t)length) && (memcmp(path, storage, length) == 0);
}

static int keep(int descriptor)
{
    return fcntl(descriptor, F_DUPFD_CLOEXEC, DESCRIPTORS);
}

static bool is_name(const change_t* change)
{
    return change->kind >= MADE;
}

static void forget(unsigned index)
{
    change_t* const change = &changes[index];
    (void)close(change->place);
    if (change->other >= 0) {
        (void)close(change->other);
    }
    free(change->old_octets);
    free(change->octets);
    change_count--;
    memmove(change, change + 1, (change_count - index) * sizeof *change);
}

static change_t* remember(kind_t kind, int place)
{
    if (change_count == CHANGES) {
        forget(0U);
    }
    change_t* const change = &changes[change_count++];
    *change                = (change_t){.kind = kind, .place = keep(place), .other = -1};
    return change;
}

static void set_name(char* to, const char* name)
{
    (void)snprintf(to, NAME_MAX + 1, "%s", name);
}

/// Restore the state before a change.
static void undo_change(const change_t* change)
{
    switch (change->kind) {
    case WRITTEN:
        (void)!REAL(pwrite)(change->place, change->old_octets, change->old_count, change->offset);
        (void)!REAL(ftruncate)(change->place, change->old_size);
        break;
    case RESIZED:
        (void)!REAL(ftruncate)(change->place, change->old_size);
        (void)!REAL(pwrite)(change->place, change->old_octets, change->old_count, change->offset);
        break;
    case MADE:
        (void)REAL(unlinkat)(change->place, change->name, change->is_directory ? AT_REMOVEDIR : 0);
        break;
    case REMOVED:
        if (change->is_directory) {
            (void)REAL(mkdirat)(change->place, change->name, 0755);
        } else {
            (void)linkat(change->other, change->new_name, change->place, change->name, 0);
        }
        break;
    case RENAMED:
        (void)REAL(renameat)(change->other, change->new_name, change->place, change->name);
        break;
    }
}

/// Repeat a change that was undone.
static void redo_change(const change_t* change)
{
    if (change->kind == WRITTEN) {
        (void)!REAL(pwrite)(change->place, change->octets, change->count, change->offset);
    } else {
        (void)!REAL(ftruncate)(change->place, change->offset);
    }
}

static void cut(void)
{
    unsigned names = 0U;
    for (unsigned i = 0U; i < change_count; i++) {
        names += is_name(&changes[i]) ? 1U : 0U;
    }
    const unsigned lasting = (unsigned)random() % (names + 1U);
    for (unsigned i = change_count; i-- > 0U;) {
        if (!is_name(&changes[i]) || (names-- > lasting)) {
            undo_change(&changes[i]);
        }
    }
    for (unsigned i = 0U; i < change_count; i++) {
        if (!is_name(&changes[i]) && ((random() & 1) != 0)) {
            redo_change(&changes[i]);
        }
    }
    (void)kill(getpid(), SIGKILL);
    (void)pause();
}

/// Count a change or a sync. Returns true if it is the last one.
static bool is_last(void)
{
    rest--;
    return rest == 0;
}

static char* octets_of(int descriptor, off_t offset, size_t size, size_t* out_count)
{
    char* const octets = malloc(size + 1U);
    char link[64];
    // The file may be open only for writing, so open it again for reading.
    (void)snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const int reader  = open(link, O_RDONLY | O_CLOEXEC);
    const ssize_t got = (octets != NULL) ? pread(reader, octets, size, offset) : 0;
    (void)close(reader);
    *out_count = (got > 0) ? (size_t)got : 0U;
    return octets;
}

static off_t size_of(int descriptor)
{
    struct stat about;
    return (fstat(descriptor, &about) == 0) ? about.st_size : 0;
}

ssize_t pwrite(int descriptor, const void* octets, size_t size, off_t offset)
{
    if (!is_stored(descriptor)) {
        return REAL(pwrite)(descriptor, octets, size, offset);
    }
    (void)pthread_mutex_lock(&mutex);
    change_t* const change = remember(WRITTEN, descriptor);
    const bool is_end      = is_last();
    change->offset         = offset;
    change->old_size       = size_of(descriptor);
    change->old_octets     = octets_of(descriptor, offset, size, &change->old_count);
    change->octets         = malloc(size + 1U);
    change->count          = is_end ? ((size_t)random() % (size + 1U)) : size;
    memcpy(change->octets, octets, size);
    const ssize_t written = REAL(pwrite)(descriptor, octets, change->count, offset);
    if (is_end) {
        cut();
    }
    (void)pthread_mutex_unlock(&mutex);
    return written;
}

int ftruncate(int descriptor, off_t size)
{
    if (!is_stored(descriptor)) {
        return REAL(ftruncate)(descriptor, size);
    }
    (void)pthread_mutex_lock(&mutex);
    change_t* const change = remember(RESIZED, descriptor);
    change->offset         = size;
    change->old_size       = size_of(descriptor);
    const off_t lost       = (change->old_size > size) ? (change->old_size - size) : 0;
    change->old_octets     = octets_of(descriptor, size, (size_t)lost, &change->old_count);
    const int result       = REAL(ftruncate)(descriptor, size);
    if (is_last()) {
        cut();
    }
    (void)pthread_mutex_unlock(&mutex);
    return result;
}

/// Forget the changes of this file or directory, because they are synced.
static void settle(int descriptor)
{
    struct stat synced;
    struct stat about;
    (void)fstat(descriptor, &synced);
    for (unsigned i = change_count; i-- > 0U;) {
        const bool is_known = fstat(changes[i].place, &about) == 0;
        if (is_known && (about.st_ino == synced.st_ino) && (about.st_dev == synced.st_dev)) {
            forget(i);
        }
    }
}

int fsync(int descriptor)
{
    if (is_stored(descriptor)) {
        (void)pthread_mutex_lock(&mutex);
        if (is_last()) {
            cut();
        }
        settle(descriptor);
        (void)pthread_mutex_unlock(&mutex);
    }
    return REAL(fsync)(descriptor);
}

/// Record a change of names.
static int moved(kind_t kind, int directory, const char* name, int new_directory, const char* new_name,
                 bool is_directory)
{
    (void)pthread_mutex_lock(&mutex);
    change_t* const change = remember(kind, directory);
    change->other          = (new_directory >= 0) ? keep(new_directory) : -1;
    change->is_directory   = is_directory;
    set_name(change->name, name);
    set_name(change->new_name, new_name);
    if (is_last()) {
        cut();
    }
    (void)pthread_mutex_unlock(&mutex);
    return 0;
}

int mkdirat(int directory, const char* name, mode_t mode)
{
    const int result = REAL(mkdirat)(directory, name, mode);
    return ((result == 0) && is_stored(directory)) ? moved(MADE, directory, name, -1, "", true) : result;
}

int openat(int directory, const char* name, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = ((flags & O_CREAT) != 0) ? va_arg(arguments, mode_t) : 0U;
    va_end(arguments);
    const bool is_new =
        ((flags & O_CREAT) != 0) && is_stored(directory) && (faccessat(directory, name, F_OK, 0) != 0);
    const int result = REAL(openat)(directory, name, flags, mode);
    if (is_new && (result >= 0)) {
        (void)moved(MADE, directory, name, -1, "", false);
    }
    return result;
}

int unlinkat(int directory, const char* name, int flags)
{
    static unsigned number;
    if (!is_stored(directory)) {
        return REAL(unlinkat)(directory, name, flags);
    }
    char hidden[16];
    (void)snprintf(hidden, sizeof hidden, "%u", number++);
    if (flags == 0) {
        (void)REAL(unlinkat)(removed_files, hidden, 0);
        (void)linkat(directory, name, removed_files, hidden, 0);
    }
    const int result = REAL(unlinkat)(directory, name, flags);
    return (result == 0) ? moved(REMOVED, directory, name, removed_files, hidden, flags == AT_REMOVEDIR)
                         : result;
}

int renameat2(int from, const char* name, int to, const char* new_name, unsigned flags)
{
    const int result = REAL(renameat2)(from, name, to, new_name, flags);
    return ((result == 0) && is_stored(from)) ? moved(RENAMED, from, name, to, new_name, false) : result;
}
