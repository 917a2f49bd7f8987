// SPDX-License-Identifier: Apache-2.0
#include "test/support/recorded_media.h"

#include "unity.h"

#include <string.h>

recorded_t recorded;

static size_t medium_of(const void* const context)
{
    return (context == &recorded.image[0]) ? 0U : 1U;
}

static bool fails(const void* const context)
{
    recorded.calls++;
    return ((recorded.failing == NULL) || (recorded.failing == context)) && (recorded.fail_from != 0U) &&
           (recorded.calls >= recorded.fail_from) &&
           (recorded.calls < (recorded.fail_from + recorded.fail_count));
}

static void resize_image(image_t* const image, const size_t size)
{
    TEST_ASSERT_TRUE(size <= MEDIUM_MAX);
    if (size > image->size) {
        memset(&image->octets[image->size], 0, size - image->size);
    }
    image->size = size;
}

void recorded_apply(const operation_t* const operation, const size_t size, image_t images[2])
{
    image_t* const image = &images[operation->medium];
    const size_t end     = operation->offset + size;
    if (operation->kind == OPERATION_RESIZE) {
        resize_image(image, operation->offset);
    } else if ((operation->kind == OPERATION_WRITE) && (size > 0U)) {
        if (end > image->size) {
            resize_image(image, end);
        }
        memcpy(&image->octets[operation->offset], &recorded.data[operation->data], size);
    }
}

static void record(const operation_t* const wanted, const uint8_t* const octets)
{
    TEST_ASSERT_TRUE(recorded.count < OPERATIONS_MAX);
    TEST_ASSERT_TRUE((recorded.data_size + wanted->size) <= sizeof recorded.data);
    operation_t* const operation = &recorded.operations[recorded.count];
    *operation                   = *wanted;
    operation->data              = recorded.data_size;
    operation->mark              = recorded.mark;
    if (wanted->size > 0U) {
        memcpy(&recorded.data[recorded.data_size], octets, wanted->size);
    }
    recorded.data_size += wanted->size;
    recorded.count++;
    recorded_apply(operation, operation->size, recorded.image);
}

static status_t read_image(void* const context, const uint64_t offset, uint8_t* const octets,
                           const size_t size)
{
    const image_t* const image = context;
    if (fails(context)) {
        return recorded.failure;
    }
    if ((offset > image->size) || (size > (image->size - offset))) {
        return STATUS_TRUNCATED;
    }
    memcpy(octets, &image->octets[offset], size);
    return STATUS_OK;
}

static status_t write_image(void* const context, const uint64_t offset, const uint8_t* const octets,
                            const size_t size)
{
    const bool is_failing = fails(context);
    const size_t written  = (is_failing && (recorded.torn < size)) ? recorded.torn : size;
    if (written > 0U) {
        record(&(operation_t){.kind   = OPERATION_WRITE,
                              .medium = medium_of(context),
                              .offset = (size_t)offset,
                              .size   = written},
               octets);
    }
    return is_failing ? recorded.failure : STATUS_OK;
}

static status_t sync_image(void* const context)
{
    const bool is_failing = fails(context);
    record(&(operation_t){.kind = is_failing ? OPERATION_LOST : OPERATION_SYNC, .medium = medium_of(context)},
           NULL);
    return is_failing ? recorded.failure : STATUS_OK;
}

static status_t size_image(void* const context, uint64_t* const out_size)
{
    const image_t* const image = context;
    *out_size                  = image->size;
    return fails(context) ? recorded.failure : STATUS_OK;
}

static status_t resize_it(void* const context, const uint64_t size)
{
    if (fails(context)) {
        return recorded.failure;
    }
    record(&(operation_t){.kind = OPERATION_RESIZE, .medium = medium_of(context), .offset = (size_t)size},
           NULL);
    return STATUS_OK;
}

medium_t recorded_medium(const size_t index)
{
    return (medium_t){.context = &recorded.image[index],
                      .read    = read_image,
                      .write   = write_image,
                      .sync    = sync_image,
                      .size    = size_image,
                      .resize  = resize_it};
}

void recorded_copy(image_t to[2], const image_t from[2])
{
    for (size_t i = 0U; i < 2U; i++) {
        to[i].size = from[i].size;
        memcpy(to[i].octets, from[i].octets, from[i].size);
    }
}

void recorded_durable(image_t images[2])
{
    recorded_copy(images, recorded.durable);
    size_t settled[2] = {0U, 0U}; // Operations on each medium that were synced or lost.
    for (size_t i = 0U; i < recorded.count; i++) {
        const operation_t* const operation = &recorded.operations[i];
        const size_t medium                = operation->medium;
        const bool is_end = (operation->kind == OPERATION_SYNC) || (operation->kind == OPERATION_LOST);
        for (size_t k = settled[medium]; is_end && (k < i); k++) {
            if ((recorded.operations[k].medium == medium) && (operation->kind == OPERATION_SYNC)) {
                recorded_apply(&recorded.operations[k], recorded.operations[k].size, images);
            }
        }
        settled[medium] = is_end ? i : settled[medium];
    }
}

void recorded_clear(const image_t images[2])
{
    recorded_copy(recorded.image, images);
    recorded_copy(recorded.durable, images);
    recorded.count      = 0U;
    recorded.data_size  = 0U;
    recorded.mark       = 0U;
    recorded.calls      = 0U;
    recorded.fail_from  = 0U;
    recorded.fail_count = 1U;
    recorded.failing    = NULL;
    recorded.failure    = STATUS_IO;
    recorded.torn       = 0U;
}
