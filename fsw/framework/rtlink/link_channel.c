// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/rtlink/link_channel.h"

#include "base/assertion.h"

#include <string.h>

#define NAME_MAX_OCTETS 64U

#define WORDS_OF(octets) (((octets) + 7U) / 8U)
#define LINE_WORDS 8U
#define HEADER_WORDS LINK_FRAME_HEADER_WORDS

/// Content of the shared memory. `sequence_counter` is odd while the writer writes. The frame is written and
/// read word by word with relaxed atomics between fences, so that a torn read is detected and is not
/// undefined behaviour.
typedef struct link_slot {
    uint32_t sequence_counter;
    uint64_t words[HEADER_WORDS + WORDS_OF(RTLINK_PAYLOAD_MAX)];
} link_slot_t;

/// True if a link uses this method; agreed terms contain exactly one.
static bool uses(const rtlink_terms_t* const terms, const rtlink_method_t method)
{
    return terms->methods == (uint8_t)(1U << (unsigned)method);
}

static bool comes_by_datagram(const rtlink_terms_t* const terms)
{
    return uses(terms, RTLINK_METHOD_UDP) || uses(terms, RTLINK_METHOD_TIPC);
}

static status_t create_slot(rtlink_producer_t* const producer)
{
    char name[NAME_MAX_OCTETS];
    if (!producer->resolver->shm_name(producer->resolver->context, producer->link, name, sizeof name)) {
        return STATUS_NOT_FOUND;
    }
    // Consumers of an earlier opening keep their mapping; their samples become stale.
    (void)osal_shm_remove(name);
    const status_t status = osal_shm_create(&producer->shm, name, sizeof(link_slot_t));
    producer->slot        = (status == STATUS_OK) ? osal_shm_address(&producer->shm) : NULL;
    return ((status == STATUS_INVALID) || (status == STATUS_EXISTS)) ? STATUS_IO : status;
}

static bool find_route(rtlink_producer_t* const producer)
{
    const rtlink_resolver_t* const resolver = producer->resolver;
    if (uses(&producer->terms, RTLINK_METHOD_UDP)) {
        return resolver->udp_route(resolver->context, producer->link, &producer->socket, &producer->consumer);
    }
    return uses(&producer->terms, RTLINK_METHOD_TIPC) && (resolver->tipc_route != NULL) &&
           resolver->tipc_route(resolver->context, producer->link, &producer->socket,
                                &producer->consumer_name);
}

status_t rtlink_producer_open(rtlink_producer_t* const producer, const rtlink_resolver_t* const resolver,
                              const uint16_t link, const rtlink_terms_t* const agreed, const uint32_t epoch)
{
    FSW_ASSERT((producer != NULL) && (resolver != NULL) && (agreed != NULL));
    *producer = (rtlink_producer_t){.terms = *agreed, .link = link, .epoch = epoch, .resolver = resolver};
    if (uses(agreed, RTLINK_METHOD_SHARED_MEMORY)) {
        const status_t status = create_slot(producer);
        producer->is_open     = (status == STATUS_OK);
        return status;
    }
    producer->is_open = find_route(producer);
    return producer->is_open ? STATUS_OK : STATUS_NOT_FOUND;
}

static void store_words(uint64_t* const words, const uint8_t* const octets, const size_t size)
{
    const size_t whole = size / 8U;
    for (size_t i = 0U; i < whole; i++) {
        uint64_t word = 0U;
        (void)memcpy(&word, &octets[8U * i], sizeof word);
        __atomic_store_n(&words[i], word, __ATOMIC_RELAXED);
    }
    if ((size % 8U) != 0U) {
        uint64_t word = 0U;
        (void)memcpy(&word, &octets[8U * whole], size % 8U);
        __atomic_store_n(&words[whole], word, __ATOMIC_RELAXED);
    }
}

static void write_slot(link_slot_t* const slot, const rtlink_frame_header_t* const header,
                       const uint8_t* const payload, const size_t size)
{
    uint64_t words[HEADER_WORDS];
    for (size_t i = 0U; i < (HEADER_WORDS + WORDS_OF(size)); i += LINE_WORDS) {
        // Request all cache lines at once from the reader's processor: each would otherwise be fetched in
        // turn.
        __builtin_prefetch(&slot->words[i], 1);
    }
    rtlink_frame_pack(header, words);
    const uint32_t counter = __atomic_load_n(&slot->sequence_counter, __ATOMIC_RELAXED);
    __atomic_store_n(&slot->sequence_counter, counter + 1U, __ATOMIC_RELAXED);
    // A reader that sees a changed word must also see the odd counter.
    __atomic_thread_fence(__ATOMIC_RELEASE);
    for (size_t i = 0U; i < HEADER_WORDS; i++) {
        __atomic_store_n(&slot->words[i], words[i], __ATOMIC_RELAXED);
    }
    store_words(&slot->words[HEADER_WORDS], payload, size);
    __atomic_store_n(&slot->sequence_counter, counter + 2U, __ATOMIC_RELEASE);
}

static status_t send_datagram(rtlink_producer_t* const producer, const rtlink_frame_header_t* const header,
                              const uint8_t* const payload)
{
    uint8_t frame[LINK_FRAME_MAX];
    const size_t size     = rtlink_frame_encode(header, payload, producer->terms.layout_octets, true, frame);
    const status_t status = uses(&producer->terms, RTLINK_METHOD_TIPC)
                                ? osal_tipc_send(producer->socket, producer->consumer_name, frame, size)
                                : osal_udp_send(producer->socket, producer->consumer, frame, size);
    if ((status == STATUS_OK) && (producer->resolver->delivered != NULL)) {
        producer->resolver->delivered(producer->resolver->context, producer->link, producer->epoch);
    }
    return status;
}

status_t rtlink_producer_write(rtlink_producer_t* const producer, const uint8_t state, const uint64_t now_ns,
                               const uint8_t* const payload)
{
    FSW_ASSERT((producer != NULL) && (payload != NULL));
    if (!producer->is_open) {
        return STATUS_CLOSED;
    }
    const rtlink_frame_header_t header = {.producer_state = state,
                                          .link           = producer->link,
                                          .epoch          = producer->epoch,
                                          .sequence       = producer->sequence,
                                          .time_ns        = now_ns};
    status_t status                    = STATUS_OK;
    if (producer->slot != NULL) {
        write_slot(producer->slot, &header, payload, producer->terms.layout_octets);
    } else {
        status = send_datagram(producer, &header, payload);
    }
    producer->counters.last_sequence = producer->sequence;
    producer->sequence++;
    if (status == STATUS_OK) {
        producer->counters.frames++;
        return STATUS_OK;
    }
    producer->counters.lost++;
    return (status == STATUS_FULL) ? STATUS_FULL : STATUS_IO;
}

void rtlink_producer_close(rtlink_producer_t* const producer)
{
    FSW_ASSERT(producer != NULL);
    if (producer->slot != NULL) {
        char name[NAME_MAX_OCTETS];
        if (producer->resolver->shm_name(producer->resolver->context, producer->link, name, sizeof name)) {
            (void)osal_shm_remove(name);
        }
        osal_shm_close(&producer->shm);
        producer->slot = NULL;
    }
    producer->is_open = false;
}

status_t rtlink_consumer_open(rtlink_consumer_t* const consumer, const rtlink_resolver_t* const resolver,
                              const uint16_t link, const rtlink_terms_t* const agreed, const uint32_t epoch)
{
    FSW_ASSERT((consumer != NULL) && (resolver != NULL) && (agreed != NULL));
    (void)memset(consumer, 0, sizeof *consumer);
    consumer->terms = *agreed;
    consumer->link  = link;
    consumer->epoch = epoch;
    if (uses(agreed, RTLINK_METHOD_SHARED_MEMORY)) {
        char name[NAME_MAX_OCTETS];
        if (!resolver->shm_name(resolver->context, link, name, sizeof name)) {
            return STATUS_NOT_FOUND;
        }
        const status_t status = osal_shm_open(&consumer->shm, name);
        if ((status == STATUS_OK) && (osal_shm_size(&consumer->shm) < sizeof(link_slot_t))) {
            osal_shm_close(&consumer->shm);
            return STATUS_IO;
        }
        consumer->is_open = (status == STATUS_OK);
        consumer->slot    = consumer->is_open ? osal_shm_address(&consumer->shm) : NULL;
        return (status == STATUS_INVALID) ? STATUS_NOT_FOUND : status;
    }
    if (!comes_by_datagram(agreed)) {
        return STATUS_NOT_FOUND;
    }
    const status_t status = (resolver->play_out != NULL)
                                ? resolver->play_out(resolver->context, link, &consumer->play_out)
                                : STATUS_OK;
    if (consumer->play_out != NULL) {
        rtlink_play_out_clear(consumer->play_out, agreed->layout_octets);
    }
    consumer->is_open = (status == STATUS_OK);
    return status;
}

/// Returns the number of samples missed when the sequence number advances by `ahead`. Only samples that the
/// decimation selects count, so that a reader which is slightly early or late misses none.
static uint32_t missed_samples(const uint32_t ahead, const uint32_t decimation)
{
    const uint32_t passed = (decimation > 1U) ? (ahead / decimation) : ahead;
    return (passed > 0U) ? (passed - 1U) : 0U;
}

/// True for a repeated sample, or one that a newer sample has overtaken.
static bool is_old(const rtlink_consumer_t* const consumer, const uint32_t sequence)
{
    const uint32_t ahead = sequence - consumer->sequence;
    return consumer->has_sample && ((ahead == 0U) || (ahead > (UINT32_MAX / 2U)));
}

/// Make a received sample the newest of the consumer.
static void take_sample(rtlink_consumer_t* const consumer, const rtlink_frame_header_t* const header,
                        const uint8_t* const payload)
{
    if (consumer->has_sample) {
        consumer->counters.lost +=
            missed_samples(header->sequence - consumer->sequence, consumer->terms.decimation);
    }
    (void)memcpy(consumer->payload, payload, consumer->terms.layout_octets);
    consumer->has_sample             = true;
    consumer->sequence               = header->sequence;
    consumer->peer_state             = header->producer_state;
    consumer->sample_time_ns         = header->time_ns;
    consumer->counters.last_sequence = header->sequence;
    consumer->counters.frames++;
}

/// Accept a sample if it belongs to this opening of the link and is newer than the last one; an older sample
/// is dropped, which is no error. `decoded`: whether its header and checksum were correct.
static status_t accept(rtlink_consumer_t* const consumer, const status_t decoded,
                       const rtlink_frame_header_t* const header, const uint8_t* const payload)
{
    const bool is_ours =
        (decoded == STATUS_OK) && (header->link == consumer->link) && (header->epoch == consumer->epoch);
    if (!is_ours) {
        consumer->counters.refused++;
        return STATUS_INVALID;
    }
    if (is_old(consumer, header->sequence)) {
        return STATUS_OK;
    }
    if (consumer->play_out != NULL) {
        rtlink_play_out_put(consumer->play_out, header, payload);
    } else {
        take_sample(consumer, header, payload);
    }
    return STATUS_OK;
}

/// Play the samples that are due, in the order of their sequence numbers, so that each missing sample is
/// counted once. The time stamps of a faulty producer may contradict its sequence: a sample older than one
/// that was played is dropped.
static void take_played_out(rtlink_consumer_t* const consumer, const uint64_t now_ns)
{
    rtlink_frame_header_t header = {0};
    const uint8_t* payload       = NULL;
    while (rtlink_play_out_take(consumer->play_out, now_ns, &header, &payload)) {
        if (!is_old(consumer, header.sequence)) {
            take_sample(consumer, &header, payload);
        }
    }
}

/// Make one attempt to copy the whole slot. *counter is the sequence counter at the previous copy; a slot
/// that has not changed since is not copied. False if the writer was writing.
static bool copy_slot(const link_slot_t* const slot, const size_t words, uint32_t* const counter,
                      uint64_t* const out_words)
{
    const uint32_t before = __atomic_load_n(&slot->sequence_counter, __ATOMIC_ACQUIRE);
    if (before == *counter) {
        return true;
    }
    if ((before & 1U) != 0U) {
        return false;
    }
    for (size_t i = 0U; i < words; i++) {
        out_words[i] = __atomic_load_n(&slot->words[i], __ATOMIC_RELAXED);
    }
    // Read all words before the sequence counter is read again.
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    if (__atomic_load_n(&slot->sequence_counter, __ATOMIC_RELAXED) != before) {
        return false;
    }
    *counter = before;
    return true;
}

static void take_from_slot(rtlink_consumer_t* const consumer)
{
    const size_t count   = HEADER_WORDS + WORDS_OF(consumer->terms.layout_octets);
    const uint32_t taken = consumer->sequence_counter;
    uint64_t words[HEADER_WORDS + WORDS_OF(RTLINK_PAYLOAD_MAX)];
    for (unsigned attempt = 0U; attempt < LINK_READ_ATTEMPTS; attempt++) {
        if (copy_slot(consumer->slot, count, &consumer->sequence_counter, words)) {
            if (consumer->sequence_counter != taken) {
                rtlink_frame_header_t header;
                const status_t status = rtlink_frame_unpack(words, &header);
                (void)accept(consumer, status, &header, (const uint8_t*)&words[HEADER_WORDS]);
            }
            return;
        }
    }
    consumer->counters.torn++;
}

status_t rtlink_consumer_read(rtlink_consumer_t* const consumer, const uint64_t now_ns)
{
    FSW_ASSERT(consumer != NULL);
    if (!consumer->is_open) {
        return STATUS_CLOSED;
    }
    if (consumer->slot != NULL) {
        take_from_slot(consumer);
    }
    if (consumer->play_out != NULL) {
        take_played_out(consumer, now_ns);
    }
    if (!consumer->has_sample) {
        return STATUS_EMPTY;
    }
    const uint64_t age_ns = (now_ns > consumer->sample_time_ns) ? (now_ns - consumer->sample_time_ns) : 0U;
    if (age_ns > (rtlink_consumer_max_age_us(consumer) * 1000U)) {
        consumer->counters.late++;
        return STATUS_STALE;
    }
    return STATUS_OK;
}

status_t rtlink_consumer_deliver(rtlink_consumer_t* const consumer, const uint8_t* const frame,
                                 const size_t size)
{
    FSW_ASSERT((consumer != NULL) && (frame != NULL));
    if (!consumer->is_open) {
        return STATUS_CLOSED;
    }
    if (!comes_by_datagram(&consumer->terms)) { // Samples of this link do not arrive as datagrams.
        consumer->counters.refused++;
        return STATUS_INVALID;
    }
    rtlink_frame_header_t header = {0};
    const uint8_t* payload       = NULL;
    const status_t status =
        rtlink_frame_decode(frame, size, consumer->terms.layout_octets, true, &header, &payload);
    return accept(consumer, status, &header, payload);
}

uint64_t rtlink_consumer_max_age_us(const rtlink_consumer_t* const consumer)
{
    FSW_ASSERT(consumer != NULL);
    const rtlink_play_out_t* const play_out = consumer->play_out;
    if (play_out == NULL) {
        return consumer->terms.max_age_us;
    }
    // A sample is played at the age delay_us + budget_us, or later if its jitter exceeds the budget. Beyond
    // that age it may be older by agreed_us or by budgets_us, whichever is larger.
    const uint64_t budgets_us = (uint64_t)RTLINK_PLAY_OUT_BUDGETS * play_out->budget_us;
    const uint64_t agreed_us  = consumer->terms.max_age_us;
    return (uint64_t)play_out->delay_us + play_out->budget_us +
           ((budgets_us > agreed_us) ? budgets_us : agreed_us);
}

void rtlink_consumer_close(rtlink_consumer_t* const consumer)
{
    FSW_ASSERT(consumer != NULL);
    if (consumer->slot != NULL) {
        osal_shm_close(&consumer->shm);
        consumer->slot = NULL;
    }
    consumer->is_open = false;
}
