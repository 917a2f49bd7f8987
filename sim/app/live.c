// SPDX-License-Identifier: Apache-2.0
#include "sim/app/live.h"

#include "osal/include/osal/file.h"
#include "osal/include/osal/socket.h"
#include "sim/app/live_rows.h"
#include "sim/logs/frame_log.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ACCEPT_EVERY 20U ///< Calls of live_take between two checks for clients, which cost a system call.
#define PATH_OCTETS 4096U
#define ANSWER_OCTETS (SCENARIO_ERROR_MAX + 32U)
#define NAME_OCTETS 24U
#define NS_PER_S 1.0e9
#define STEP_S_MAX 3600.0
#define SPEED_MIN 0.1
#define WAITING_OCTETS 131072U ///< Octets that wait for a client.
#define CHANNELS_MAX ((size_t)FAULT_BUSES_MAX * NODE_CHANNELS)
#define TRUTH_HZ_MAX 1000.0

typedef struct {
    osal_socket_t socket;
    char name[NAME_OCTETS]; // The comment after each line of this client in live.scn.
    char text[SCENARIO_LINE_MAX];
    size_t size;
    unsigned line;
    bool has_frames[CHANNELS_MAX]; // True for the buses (indices of bus_index) whose frames it gets.
    uint64_t truth_ns;             // Interval of the true state; 0: the client does not get it.
    uint64_t next_truth_ns;
    uint32_t dropped; // Frames and rows dropped, and not yet reported to the client.
    size_t waiting_size;
    char waiting[WAITING_OCTETS];
} client_t;

struct live {
    live_config_t config;
    osal_socket_t listener;
    client_t client[LIVE_CLIENTS_MAX];
    FILE* record;
    bool is_record_broken;
    uint64_t now_ns;
    unsigned calls;
    bool is_paused;
    uint64_t step_until_ns; // While paused: time up to which the command `step` lets the run advance.
    double speed;
    char aiming_client[NAME_OCTETS]; // Name of the client that has sent the last `aim`.
    bool is_aimed;  // The last line of the hand from a client was `aim`, and the hand still holds the stick.
    bool is_silent; // No line has followed the `aim`, and this port has made the hand hold.
    uint64_t aimed_ns;
};

// ---- Record ----

static void record(live_t* const live, const char* const actor, const scenario_line_t* const line,
                   const char* const client_name)
{
    bool is_written = fprintf(live->record, "%" PRIu64 ".%09" PRIu64 " %s", live->now_ns / 1000000000U,
                              live->now_ns % 1000000000U, actor) > 0;
    for (size_t i = 0U; i < line->word_count; i++) {
        is_written = is_written && (fprintf(live->record, " %s", line->word[i]) > 0);
    }
    is_written =
        is_written && (fprintf(live->record, " # %s\n", client_name) > 0) && (fflush(live->record) == 0);
    live->is_record_broken = live->is_record_broken || !is_written;
}

static void print_mark(const live_t* const live, FILE* const out, const scenario_line_t* const line,
                       const char* const client_name)
{
    const double now = (double)live->now_ns / NS_PER_S;
    (void)fprintf(out, "{\"text\": \"[%9.4f s] live", now);
    for (size_t i = 0U; i < line->word_count; i++) {
        (void)fprintf(out, " %s", line->word[i]);
    }
    (void)fprintf(out,
                  " (%s)\", \"time\": %.9f, \"end\": %.9f, \"line\": 0, \"verb\": \"live\", \"words\": [",
                  client_name, now, now);
    for (size_t i = 0U; i < line->word_count; i++) {
        (void)fprintf(out, "%s\"%s\"", (i == 0U) ? "" : ", ", line->word[i]);
    }
    (void)fprintf(out, "], \"outcome\": \"by %s\", \"asked\": []}\n", client_name);
}

/// Append an accepted line to the log of the operator, which the operator's program also appends to. In a
/// flight without an operator the line goes to the standard output.
static void mark(live_t* const live, const scenario_line_t* const line, const char* const client_name)
{
    char path[PATH_OCTETS];
    (void)snprintf(path, sizeof path, "%s/operator.log", live->config.directory);
    FILE* const existing = fopen(path, "r");
    if (existing == NULL) {
        print_mark(live, stdout, line, client_name);
        (void)fflush(stdout);
        return;
    }
    (void)fclose(existing);
    // The buffer holds the whole line, so that one write appends it: lines of both programs do not mix.
    FILE* const log = fopen(path, "a");
    if (log != NULL) {
        print_mark(live, log, line, client_name);
    }
    live->is_record_broken = live->is_record_broken || (log == NULL) || (fclose(log) != 0);
}

// ---- Lines ----

static status_t take_world_line(live_t* const live, scenario_line_t* const line,
                                const char* const client_name, char error[SCENARIO_ERROR_MAX])
{
    const char* const actor = line->word[0];
    const bool is_hand      = strcmp(actor, "hand") == 0;
    scenario_line_t rest    = *line; // The words of the copy still point into line->text.
    if (line->word_count < 2U) {
        return scenario_error(line, "end of line", is_hand ? "a verb of the hand" : "a fault", error);
    }
    rest.word_count = line->word_count - 1U;
    rest.time_ns    = live->now_ns;
    memmove(&rest.word[0], &rest.word[1], rest.word_count * sizeof rest.word[0]);
    if (is_hand && (live->config.hand == NULL)) {
        return scenario_error(line, "hand", "fault: this world has no hand", error);
    }
    const status_t status = is_hand ? hand_add(live->config.hand, &rest, error)
                                    : faults_add(live->config.faults, live->config.targets, &rest, error);
    const bool is_aim     = is_hand && (strcmp(rest.word[0], "aim") == 0);
    if (status == STATUS_OK) {
        record(live, actor, &rest, client_name);
        // Only the first of consecutive `aim` lines of a client gets a mark.
        if (!is_aim || !live->is_aimed || live->is_silent ||
            (strcmp(live->aiming_client, client_name) != 0)) {
            mark(live, line, client_name);
        }
    }
    if ((status == STATUS_OK) && is_hand) {
        live->is_aimed  = is_aim;
        live->is_silent = false;
        live->aimed_ns  = live->now_ns;
        (void)snprintf(live->aiming_client, sizeof live->aiming_client, "%s", client_name);
    }
    return status;
}

static status_t take_pace(live_t* const live, const scenario_line_t* const line,
                          char error[SCENARIO_ERROR_MAX])
{
    double value        = 0.0;
    status_t status     = STATUS_OK;
    const char* const v = line->word[0];
    if (!live->config.is_paced) {
        return scenario_error(line, v, "a run with TIME=real: here each process has its own clock", error);
    }
    if ((strcmp(v, "pause") == 0) || (strcmp(v, "resume") == 0)) {
        status = scenario_arguments(line, 0U, v, error);
        if (status == STATUS_OK) {
            live->is_paused     = v[0] == 'p';
            live->step_until_ns = 0U;
        }
        return status;
    }
    const bool is_speed = strcmp(v, "speed") == 0;
    status              = scenario_arguments(line, 1U, is_speed ? "speed <factor>" : "step <s>", error);
    if (status != STATUS_OK) {
        return status;
    }
    if (!is_speed) {
        status = scenario_number(line, 1U, "time [s]", 1.0e-4, STEP_S_MAX, &value, error);
        if (status == STATUS_OK) {
            live->is_paused     = true;
            live->step_until_ns = live->now_ns + (uint64_t)((value * NS_PER_S) + 0.5);
        }
        return status;
    }
    if (strcmp(line->word[1], "0") != 0) {
        status = scenario_number(line, 1U, "speed (0: as fast as possible), or", SPEED_MIN, LIVE_SPEED_MAX,
                                 &value, error);
    }
    live->speed = (status == STATUS_OK) ? value : live->speed;
    return status;
}

static status_t take_name(client_t* const client, const scenario_line_t* const line,
                          char error[SCENARIO_ERROR_MAX])
{
    const status_t status = scenario_arguments(line, 1U, "name <word>", error);
    if (status != STATUS_OK) {
        return status;
    }
    if (strlen(line->word[1]) >= NAME_OCTETS) {
        return scenario_error(line, line->word[1], "a name of at most 23 characters", error);
    }
    // The name is written into strings of JSON.
    for (const char* next = line->word[1]; *next != '\0'; next++) {
        if ((*next < '!') || (*next > '~') || (*next == '"') || (*next == '\\')) {
            return scenario_error(line, line->word[1],
                                  "a name of ASCII characters without quotation marks and backslashes",
                                  error);
        }
    }
    (void)snprintf(client->name, sizeof client->name, "%s", line->word[1]);
    return STATUS_OK;
}

/// Send as many waiting octets as the client takes now.
static void flush(client_t* const client)
{
    size_t sent = 0U;
    const status_t status =
        osal_stream_send(&client->socket, (const uint8_t*)client->waiting, client->waiting_size, &sent);
    if (status == STATUS_OK) {
        client->waiting_size -= sent;
        memmove(client->waiting, &client->waiting[sent], client->waiting_size);
    } else if (status != STATUS_FULL) {
        osal_socket_close(&client->socket);
    } else {
        // The client reads slowly.
    }
}

/// Queue octets for a client. False: there is no room.
static bool put(client_t* const client, const char* const text, const size_t octets)
{
    if (octets > (sizeof client->waiting - client->waiting_size)) {
        return false;
    }
    memcpy(&client->waiting[client->waiting_size], text, octets);
    client->waiting_size += octets;
    return true;
}

/// Queue a line with a frame or a row. After a line had to be dropped, the next lines are dropped, too, until
/// half of the room is free: so a slow client gets long pieces without a gap. Then the port first queues the
/// number of dropped lines.
static void put_report(client_t* const client, const char* const text, const size_t octets)
{
    char note[32];
    const int size = snprintf(note, sizeof note, "dropped %" PRIu32 "\n", client->dropped);
    if ((client->dropped > 0U) && (client->waiting_size <= (WAITING_OCTETS / 2U)) &&
        put(client, note, (size_t)size)) {
        client->dropped = 0U;
    }
    if ((client->dropped > 0U) || !put(client, text, octets)) {
        client->dropped++;
    }
}

static void answer(client_t* const client, const char* const text)
{
    if (!put(client, text, strlen(text))) {
        osal_socket_close(&client->socket); // Disconnect a client that does not read its answers.
    }
}

/// Returns the index of the bus, or the channel B of a bus, with this name; CHANNELS_MAX if there is none.
static size_t bus_index(const live_t* const live, const char* const name)
{
    size_t index = 0U;
    while (index < CHANNELS_MAX) {
        const char* const known =
            live->config.targets->channel[index / NODE_CHANNELS][index % NODE_CHANNELS].name;
        if ((known != NULL) && (strcmp(known, name) == 0)) {
            break;
        }
        index++;
    }
    return index;
}

static status_t take_frames(const live_t* const live, client_t* const client,
                            const scenario_line_t* const line, char error[SCENARIO_ERROR_MAX])
{
    const status_t status = scenario_arguments(line, 2U, "frames <bus> on|off", error);
    if (status != STATUS_OK) {
        return status;
    }
    const size_t index = bus_index(live, line->word[1]);
    const bool is_on   = strcmp(line->word[2], "on") == 0;
    if (index == CHANNELS_MAX) {
        return scenario_error(line, line->word[1], "a bus of this run, or its channel B", error);
    }
    if (!is_on && (strcmp(line->word[2], "off") != 0)) {
        return scenario_error(line, line->word[2], "on or off", error);
    }
    client->has_frames[index] = is_on;
    return STATUS_OK;
}

static status_t take_truth(const live_t* const live, client_t* const client,
                           const scenario_line_t* const line, char error[SCENARIO_ERROR_MAX])
{
    static char columns[LIVE_ROW_OCTETS];
    double rate     = 0.0;
    status_t status = scenario_arguments(line, 1U, "truth <Hz> (0: none)", error);
    status = (status == STATUS_OK) ? scenario_number(line, 1U, "rate [Hz]", 0.0, TRUTH_HZ_MAX, &rate, error)
                                   : status;
    if (status != STATUS_OK) {
        return status;
    }
    client->truth_ns      = (rate > 0.0) ? (uint64_t)(NS_PER_S / rate) : 0U;
    client->next_truth_ns = live->now_ns;
    if (client->truth_ns > 0U) {
        put_report(client, columns, live_rows_columns(live->config.world, columns));
    }
    return STATUS_OK;
}

static status_t take_words(live_t* const live, client_t* const client, scenario_line_t* const line,
                           char error[SCENARIO_ERROR_MAX])
{
    static const char* const paces[] = {"pause", "resume", "step", "speed"};
    const char* const verb           = line->word[0];
    if ((strcmp(verb, "hand") == 0) || (strcmp(verb, "fault") == 0)) {
        return take_world_line(live, line, client->name, error);
    }
    for (size_t i = 0U; i < (sizeof paces / sizeof paces[0]); i++) {
        if (strcmp(verb, paces[i]) == 0) {
            const status_t status = take_pace(live, line, error);
            if (status == STATUS_OK) {
                mark(live, line, client->name);
            }
            return status;
        }
    }
    if (strcmp(verb, "frames") == 0) {
        return take_frames(live, client, line, error);
    }
    if (strcmp(verb, "truth") == 0) {
        return take_truth(live, client, line, error);
    }
    if (strcmp(verb, "time") == 0) {
        return scenario_arguments(line, 0U, "time", error);
    }
    return (strcmp(verb, "name") == 0)
               ? take_name(client, line, error)
               : scenario_error(line, verb,
                                "hand, fault, pause, resume, step, speed, frames, truth, time or name",
                                error);
}

static void take_line(live_t* const live, client_t* const client, const char* const text)
{
    char error[SCENARIO_ERROR_MAX] = "";
    char reply[ANSWER_OCTETS];
    scenario_line_t line = {.path = "live", .line = ++client->line};
    (void)snprintf(line.text, sizeof line.text, "%s", text);
    scenario_words(&line);
    if (line.word_count == 0U) {
        return;
    }
    const status_t status = (line.word_count <= SCENARIO_WORDS_MAX)
                                ? take_words(live, client, &line, error)
                                : scenario_error(&line, "too many words", "at most 12", error);
    if (status == STATUS_OK) {
        const bool is_aimed = live->is_aimed && !live->is_silent;
        (void)snprintf(reply, sizeof reply, "ok %" PRIu64 ".%09" PRIu64 "%s speed %g%s%s\n",
                       live->now_ns / 1000000000U, live->now_ns % 1000000000U,
                       live_is_held(live, live->now_ns) ? " paused" : "", live->speed,
                       is_aimed ? " hand " : "", is_aimed ? live->aiming_client : "");
    } else {
        (void)snprintf(reply, sizeof reply, "refused %s\n", error);
    }
    answer(client, reply);
}

// ---- Clients ----

static void accept_client(live_t* const live)
{
    char refusal[96];
    osal_socket_t socket = OSAL_SOCKET_CLOSED;
    osal_address_t peer;
    if (osal_tcp_accept(&live->listener, &socket, &peer) != STATUS_OK) {
        return;
    }
    for (size_t i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        client_t* const client = &live->client[i];
        if (!osal_socket_is_open(&client->socket)) {
            memset(client, 0, sizeof *client);
            client->socket = socket;
            (void)snprintf(client->name, sizeof client->name, "live");
            return;
        }
    }
    size_t sent = 0U;
    (void)snprintf(refusal, sizeof refusal, "refused live:0: found one more client, expected at most %u\n",
                   LIVE_CLIENTS_MAX);
    const status_t status = osal_stream_send(&socket, (const uint8_t*)refusal, strlen(refusal), &sent);
    (void)status; // The client is disconnected even if it has not got the refusal.
    osal_socket_close(&socket);
}

static void take_lines(live_t* const live, client_t* const client)
{
    char* end = memchr(client->text, '\n', client->size);
    while (osal_socket_is_open(&client->socket) && (end != NULL)) {
        const size_t octets = (size_t)(end - client->text) + 1U;
        *end                = '\0';
        take_line(live, client, client->text);
        client->size -= octets;
        memmove(client->text, &client->text[octets], client->size);
        end = memchr(client->text, '\n', client->size);
    }
    if (client->size == sizeof client->text) { // The text is full, and has no line end.
        osal_socket_close(&client->socket);
    }
}

static void serve(live_t* const live, client_t* const client)
{
    size_t size           = 0U;
    const status_t status = osal_stream_receive(&client->socket, (uint8_t*)&client->text[client->size],
                                                sizeof client->text - client->size, &size);
    if (status == STATUS_OK) {
        client->size += size;
        take_lines(live, client);
    } else if (status != STATUS_EMPTY) {
        osal_socket_close(&client->socket);
    } else {
        // No octets were received.
    }
}

/// If the client that has sent `aim` sends no more lines, no person controls the stick: the hand must not
/// keep its force on it.
static void watch_hand(live_t* const live)
{
    // A line of the scenario may have given the hand another verb meanwhile. This is visible because the hand
    // has stepped since the last line.
    if (live->is_aimed && (live->now_ns > live->aimed_ns)) {
        const char* const verb = hand_intent(live->config.hand)->verb;
        live->is_aimed = (strcmp(verb, "aim") == 0) || (live->is_silent && (strcmp(verb, "hold") == 0));
    }
    const uint64_t silent_ns = live->now_ns - live->aimed_ns;
    const bool lets_go       = silent_ns >= LIVE_LET_GO_NS;
    char error[SCENARIO_ERROR_MAX];
    if (!live->is_aimed || (!lets_go && (live->is_silent || (silent_ns < LIVE_HOLD_NS)))) {
        return;
    }
    const scenario_line_t line = {
        .path = "live", .time_ns = live->now_ns, .word_count = 1U, .word = {lets_go ? "let_go" : "hold"}};
    if (hand_add(live->config.hand, &line, error) == STATUS_OK) {
        const scenario_line_t whole = {.word_count = 2U, .word = {"hand", line.word[0]}};
        char reason[32];
        (void)snprintf(reason, sizeof reason, "no line for %g s",
                       (double)(lets_go ? LIVE_LET_GO_NS : LIVE_HOLD_NS) / NS_PER_S);
        record(live, "hand", &line, reason);
        mark(live, &whole, reason);
    }
    live->is_silent = true;
    live->is_aimed  = !lets_go;
}

// ---- Functions of sim/app/live.h ----

static bool write_port(const live_t* const live, const char* const directory)
{
    char path[PATH_OCTETS];
    osal_address_t address;
    (void)snprintf(path, sizeof path, "%s/live.port", directory);
    FILE* const file = fopen(path, "w");
    if (file == NULL) {
        return false;
    }
    const bool is_written = (osal_socket_local_address(&live->listener, &address) == STATUS_OK) &&
                            (fprintf(file, "%u\n", (unsigned)address.port) > 0);
    return (fclose(file) == 0) && is_written;
}

status_t live_open(const live_config_t* const config, live_t** const out_live)
{
    char path[PATH_OCTETS];
    live_t* const live = calloc(1U, sizeof *live);
    *out_live          = NULL;
    if (live == NULL) {
        return STATUS_EXHAUSTED;
    }
    live->config   = *config;
    live->speed    = 1.0;
    live->listener = (osal_socket_t)OSAL_SOCKET_CLOSED;
    for (size_t i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        live->client[i].socket = (osal_socket_t)OSAL_SOCKET_CLOSED;
    }
    (void)snprintf(path, sizeof path, "%s/live.scn", config->directory);
    live->record = fopen(path, "w");
    if ((live->record == NULL) ||
        (osal_tcp_listen(&live->listener, (osal_address_t){.ipv4 = OSAL_IPV4_LOOPBACK}) != STATUS_OK) ||
        !write_port(live, config->directory)) {
        (void)live_close(live);
        return STATUS_IO;
    }
    *out_live = live;
    return STATUS_OK;
}

void live_take(live_t* const live, const uint64_t now_ns)
{
    live->now_ns = now_ns;
    if ((live->calls % ACCEPT_EVERY) == 0U) {
        accept_client(live);
    }
    live->calls++;
    for (size_t i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        client_t* const client = &live->client[i];
        if (osal_socket_is_open(&client->socket)) {
            serve(live, client);
        }
        if (osal_socket_is_open(&client->socket) && (client->waiting_size > 0U)) {
            flush(client);
        }
    }
    watch_hand(live);
}

void live_frame(live_t* const live, const char* const name, const osal_can_frame_t* const frame)
{
    char text[sizeof "frame " + FRAME_LOG_LINE_MAX] = "frame ";
    size_t octets                                   = 0U;
    size_t index                                    = CHANNELS_MAX;
    for (size_t i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        client_t* const client = &live->client[i];
        if (!osal_socket_is_open(&client->socket)) {
            continue;
        }
        // Compare names only if there are clients, because this function is called for every frame.
        if (index == CHANNELS_MAX) {
            index = bus_index(live, name);
        }
        if ((index < CHANNELS_MAX) && client->has_frames[index]) {
            if (octets == 0U) {
                octets = strlen("frame ") + frame_log_line(frame, name, &text[strlen("frame ")]);
            }
            put_report(client, text, octets);
        }
    }
}

void live_report(live_t* const live)
{
    static char row[LIVE_ROW_OCTETS];
    const uint64_t time_ns = live->config.truth->time_ns;
    for (size_t i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        client_t* const client = &live->client[i];
        if (osal_socket_is_open(&client->socket) && (client->truth_ns > 0U) &&
            (time_ns >= client->next_truth_ns)) {
            put_report(client, row, live_rows_row(live->config.world, live->config.truth, row));
            client->next_truth_ns = ((time_ns / client->truth_ns) + 1U) * client->truth_ns;
        }
        if (osal_socket_is_open(&client->socket) && (client->waiting_size > 0U)) {
            flush(client);
        }
    }
}

bool live_is_held(const live_t* const live, const uint64_t now_ns)
{
    return live->is_paused && (now_ns >= live->step_until_ns);
}

double live_speed(const live_t* const live)
{
    return live->speed;
}

status_t live_close(live_t* const live)
{
    if (live == NULL) {
        return STATUS_OK;
    }
    bool is_complete = !live->is_record_broken;
    for (size_t i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        osal_socket_close(&live->client[i].socket);
    }
    osal_socket_close(&live->listener);
    is_complete = (live->record == NULL) || ((fclose(live->record) == 0) && is_complete);
    free(live);
    return is_complete ? STATUS_OK : STATUS_IO;
}
