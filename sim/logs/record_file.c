// SPDX-License-Identifier: Apache-2.0
#include "sim/logs/record_file.h"

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

bool record_file_open(record_file_t* const file, const char* const path)
{
    file->is_broken  = false;
    file->size       = 0U;
    file->used       = 0U;
    file->descriptor = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    return file->descriptor >= 0;
}

void record_file_flush(record_file_t* const file)
{
    size_t done = 0U;
    while ((done < file->used) && !file->is_broken) {
        const ssize_t written = write(file->descriptor, &file->octets[done], file->used - done);
        if (written > 0) {
            done += (size_t)written;
        } else if (errno != EINTR) {
            file->is_broken = true;
        }
    }
    if (!file->is_broken) {
        file->size += done;
    } else if (ftruncate(file->descriptor, (off_t)file->size) != 0) {
        // The file ends within a record: close reports an incomplete file.
    } else {
        // The file ends with a whole record.
    }
    file->used = 0U;
}

uint8_t* record_file_room(record_file_t* const file, const size_t octets)
{
    if ((file->used + octets) > RECORD_FILE_BUFFER) {
        record_file_flush(file);
    }
    return &file->octets[file->used];
}

void record_file_add(record_file_t* const file, const size_t octets)
{
    file->used += octets;
}

bool record_file_close(record_file_t* const file)
{
    if (file->descriptor < 0) {
        return true;
    }
    record_file_flush(file);
    return (close(file->descriptor) == 0) && !file->is_broken;
}
