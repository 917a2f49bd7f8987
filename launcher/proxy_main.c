// SPDX-License-Identifier: Apache-2.0
// The proxy of a remote-endian program (remote_endian_wire.h): it starts the program, represents its
// component in the scheduler and on the buses, and exchanges the data with the program. The proxy ends with
// its program.
#include "fsw/programs/remote_endian_wire.h"
#include "launcher/eeprom_image.h"
#include "launcher/target_link.h"
#include "base/number.h"
#include "base/text.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/process.h"

#include <string.h>

#define LINE_MAX 512U
#define SLICE_MS 50U         ///< Interval of checks whether the run has ended.
#define END_TIMEOUT_MS 5000U ///< Wall-clock time in which the program must end by itself.

typedef struct { // All storage of the proxy.
    osal_shm_t run_shm;
    osal_shm_t scheduler_shm;
    run_state_t* run;
    osal_lockstep_t* scheduler;
    unsigned component;
    uint32_t life;
    const char* program;
    const char* board; ///< Emulated board; null: the program is a process of another byte order.
    osal_process_t process;
    target_link_t target;
    eeprom_image_t eeprom; ///< EEPROM of the board; the emulator uses the image, too.
    remote_endian_wire_t wire;
    remote_endian_buses_t buses;
    bool has_reported_refused;
    uint32_t reported_lost; ///< Number of lost datagrams at the last print.
} proxy_t;

static proxy_t storage;

static int report_error(const char* const first, const char* const second)
{
    char line[LINE_MAX];
    (void)text_join(line, sizeof line, (const char* const[]){"proxy: ", first, second, NULL});
    osal_console_print_error(line);
    return 1;
}

/// Attach to the shared memory of the run, and find the component. Returns null, or the error text.
static const char* open_run(proxy_t* const self, const char* const name)
{
    char scheduler_name[RUN_NAME_MAX];
    if (run_state_attach(&self->run_shm, name, &self->run) != STATUS_OK) {
        return "there is no such run; `hirosco run --remote-endian SUBSYSTEM` starts it";
    }
    if (self->component >= self->run->component_count) {
        return "the run has no such component; `hirosco run` starts it";
    }
    self->life = __atomic_load_n(&self->run->components[self->component].life, __ATOMIC_ACQUIRE);
    if (!run_name(self->run, "scheduler", 0U, scheduler_name, sizeof scheduler_name) ||
        (osal_shm_open(&self->scheduler_shm, scheduler_name) != STATUS_OK)) {
        return "the run's scheduler is gone; start the mission again";
    }
    self->scheduler = osal_lockstep_attach(osal_shm_address(&self->scheduler_shm));
    return (self->scheduler != NULL)
               ? NULL
               : "the run's scheduler is of another version; build all programs with `make`";
}

/// Start the runner, arguments[0]. It inherits the descriptors `ends` and, unless it emulates a board, the
/// sockets of the run.
static bool start_runner(proxy_t* const self, const char* const* const arguments, const int* const ends,
                         const size_t end_count)
{
    int descriptors[3U + RUN_LINKS_MAX];
    size_t count = 0U;
    while (count < end_count) {
        descriptors[count] = ends[count];
        count++;
    }
    if (self->board == NULL) { // A program on a board sends and receives through the proxy.
        descriptors[count++] = self->run->components[self->component].message_descriptor;
        for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
            if (self->run->link_descriptors[i] >= 0) {
                descriptors[count++] = self->run->link_descriptors[i];
            }
        }
    }
    // The launcher ends the run. An emulator handles SIGINT itself, and would end before the run.
    const osal_process_start_t start = {.arguments        = arguments,
                                        .descriptors      = descriptors,
                                        .descriptor_count = count,
                                        .processor        = -1,
                                        .has_own_group    = true};
    return osal_process_start(&self->process, &start) == STATUS_OK;
}

/// Start the program with `runner`. The program inherits the sockets of the run and its end of the stream.
/// The name of the run is one of its arguments, so that process lists show the run.
static bool start_program(proxy_t* const self, const char* const name, const char* const runner)
{
    osal_socket_t peer = OSAL_SOCKET_CLOSED;
    char digits[16];
    if (osal_local_pair(&self->wire.socket, &peer) != STATUS_OK) {
        return false;
    }
    text_t text = text_in(digits, sizeof digits);
    text_add_unsigned(&text, (uint64_t)osal_socket_descriptor(&peer));
    const int end                 = osal_socket_descriptor(&peer);
    const char* const arguments[] = {runner, self->program, "--run", name, "--proxy", digits, NULL};
    const bool is_started         = start_runner(self, arguments, &end, 1U);
    osal_socket_close(&peer);
    return is_started;
}

// The emulator has two devices for the EEPROM of a board, each with one half of the image. The octets that
// they write are on the disk before the board continues.
#define EEPROM_HALF(name, offset)                                                                            \
    "if=none,id=" name ",cache=writethrough,driver=raw,offset=" offset                                       \
    ",size=65536,file.driver=file,file.filename=/dev/fdset/1"
#define EEPROM_DEVICE(name, address) "at24c-eeprom,drive=" name ",address=" address ",rom-size=65536"

/// Start the emulator `runner`, which inherits the two pipes and the image of the EEPROM. Time on the board
/// advances by 32 ns with each instruction, so it does not advance while the program waits for a grant. A
/// reset of the board ends the emulator, and with it this life of the component.
static bool start_emulator(proxy_t* const self, const char* const runner, const char* const semihosting)
{
    char descriptors[2][24];
    const int ends[] = {osal_file_descriptor(&self->eeprom.reader), osal_file_descriptor(&self->eeprom.file),
                        target_link_peer_in(&self->target), target_link_peer_out(&self->target)};
    for (unsigned i = 0U; i < 2U; i++) {
        text_t text = text_in(descriptors[i], sizeof descriptors[i]);
        text_add(&text, "set=1,fd=");
        text_add_unsigned(&text, (uint64_t)ends[i]);
    }
    const char* const arguments[] = {runner,
                                     "-M",
                                     self->board,
                                     "-display",
                                     "none",
                                     "-monitor",
                                     "none",
                                     "-icount",
                                     "shift=5,sleep=off",
                                     "-no-reboot",
                                     "-serial",
                                     "none",
                                     "-parallel",
                                     "none",
                                     "-nic",
                                     "none",
                                     "-add-fd",
                                     descriptors[0],
                                     "-add-fd",
                                     descriptors[1],
                                     "-drive",
                                     EEPROM_HALF("low", "0"),
                                     "-drive",
                                     EEPROM_HALF("high", "65536"),
                                     "-device",
                                     EEPROM_DEVICE("low", "0x50"),
                                     "-device",
                                     EEPROM_DEVICE("high", "0x51"),
                                     "-semihosting-config",
                                     semihosting,
                                     "-kernel",
                                     self->program,
                                     NULL};
    return start_runner(self, arguments, ends, sizeof ends / sizeof ends[0]);
}

/// Open the image of the EEPROM of the board. If the proxy of the earlier life was killed, the emulator of
/// that life uses the image until the emulator has ended. Returns false after it has printed the reason.
static bool open_eeprom(proxy_t* const self)
{
    const char* const name  = self->run->components[self->component].name;
    const uint64_t until_ns = osal_clock_monotonic_ns() + (END_TIMEOUT_MS * 1000000ULL);
    status_t status         = eeprom_image_open(&self->eeprom, self->run->storage, name);
    while ((status == STATUS_BUSY) && (osal_clock_monotonic_ns() < until_ns) &&
           (osal_process_stop_count() == 0U)) {
        (void)osal_process_wait_any(NULL, 0U, SLICE_MS);
        status = eeprom_image_open(&self->eeprom, self->run->storage, name);
    }
    if (status != STATUS_OK) {
        (void)report_error("the image of the EEPROM cannot be used: ",
                           (status == STATUS_BUSY)
                               ? "another flight uses this storage; choose another directory with --storage"
                               : status_text(status));
    }
    return status == STATUS_OK;
}

/// Start the program on a board. It accesses the console and the two pipes to the proxy by semihosting, and
/// keeps its records on the EEPROM.
static bool start_board(proxy_t* const self, const char* const name, const char* const runner)
{
    target_link_t* const target = &self->target;
    char semihosting[LINE_MAX];
    if (!open_eeprom(self) || (target_link_open(target, self->run, self->component) != STATUS_OK)) {
        return false;
    }
    self->wire.carrier = target_link_carrier(target);
    const int ends[]   = {target_link_peer_in(target), target_link_peer_out(target)};
    text_t text        = text_in(semihosting, sizeof semihosting);
    text_add(&text, "enable=on,target=native,arg=program,arg=wire=");
    text_add_unsigned(&text, (uint64_t)ends[0]);
    text_add(&text, ":");
    text_add_unsigned(&text, (uint64_t)ends[1]);
    text_add(&text, ",arg=--run,arg=");
    text_add(&text, name);
    text_add(&text, ",arg=--proxy,arg=0");
    const bool is_started = !text.cut && start_emulator(self, runner, semihosting);
    target_link_release_peer(target);
    return is_started;
}

/// Open the ends of buses that the program has opened in this turn. Earlier frames are dropped, because a
/// controller does not receive frames from before it is switched on.
static void open_buses(proxy_t* const self, const uint32_t opened)
{
    for (unsigned bus = 0U; bus < MISSION_BUSES_MAX; bus++) {
        const uint32_t bit = 1U << bus;
        if (((opened & bit) == 0U) || ((self->buses.open & bit) != 0U)) {
            continue;
        }
        const char* const address = self->run->buses[bus].flight;
        if (osal_can_open(&self->buses.ends[bus], address, OSAL_CAN_NODE) == STATUS_OK) {
            self->buses.open |= bit;
        } else {
            (void)report_error("cannot open a bus; start the mission again: ", address);
        }
    }
}

static void deliver(const proxy_t* const self, const osal_deliveries_t* const deliveries)
{
    for (unsigned receiver = 0U; receiver < OSAL_LOCKSTEP_PARTICIPANTS_MAX; receiver++) {
        if ((deliveries->messages[receiver] > 0U) || (deliveries->octets[receiver] > 0U)) {
            osal_lockstep_deliver(self->scheduler, run_participant(self->component), receiver,
                                  deliveries->lives[receiver], deliveries->messages[receiver],
                                  deliveries->octets[receiver]);
        }
    }
}

/// Wait for a record of the program. STATUS_OK, STATUS_TIMEOUT (the run has ended); any other status: the
/// program is lost.
static status_t receive_done(proxy_t* const self, octet_reader_t* const out_reader)
{
    status_t status = STATUS_TIMEOUT;
    bool is_over    = false;
    while ((status == STATUS_TIMEOUT) && !is_over) {
        status  = remote_endian_receive(&self->wire, REMOTE_ENDIAN_DONE, SLICE_MS, out_reader);
        is_over = osal_lockstep_is_closed(self->scheduler);
    }
    return status;
}

/// Wait for the program's answer. Statuses of receive_done.
static status_t take_done(proxy_t* const self, remote_endian_done_t* const out_done)
{
    octet_reader_t reader;
    status_t status = receive_done(self, &reader);
    if (status != STATUS_OK) {
        return status;
    }
    if (!remote_endian_read_done(&reader, out_done)) {
        return STATUS_INVALID;
    }
    open_buses(self, out_done->opened);
    bool has_more = true;
    while (has_more && (status == STATUS_OK)) {
        if (!remote_endian_read_frames(&reader, &self->buses, &has_more)) {
            return STATUS_INVALID;
        }
        status = has_more ? receive_done(self, &reader) : STATUS_OK;
    }
    if ((self->buses.refused > 0U) && !self->has_reported_refused) {
        self->has_reported_refused = true;
        (void)report_error("a bus was full, and frames are lost; lower its load: ", self->program);
    }
    return status;
}

static void print_lost(proxy_t* const self)
{
    char line[LINE_MAX];
    text_t text = text_in(line, sizeof line);
    text_add(&text, self->run->components[self->component].name);
    text_add(&text, ": ");
    text_add_unsigned(&text, target_link_lost(&self->target));
    text_add(&text, " datagrams lost, because they could not be sent or were too long");
    self->reported_lost = target_link_lost(&self->target);
    (void)report_error(line, "");
}

/// Print the count when datagrams between the board and the sockets are lost for the first time, and mark the
/// run as one that cannot be repeated.
static void note_lost(proxy_t* const self)
{
    if ((self->board != NULL) && (target_link_lost(&self->target) > 0U) && (self->reported_lost == 0U)) {
        __atomic_store_n(&self->run->is_lossy, 1U, __ATOMIC_RELAXED);
        print_lost(self);
    }
}

/// Exchange grants and answers. Returns true when the run has ended, false if the program is lost.
static bool serve(proxy_t* const self)
{
    octet_writer_t writer = remote_endian_begin(&self->wire, REMOTE_ENDIAN_RUN);
    remote_endian_write_run(&writer, self->run, self->component,
                            (self->board != NULL) ? TARGET_EEPROM_DIRECTORY : self->run->storage);
    status_t status = remote_endian_send(&self->wire, &writer);
    while (status == STATUS_OK) {
        remote_endian_done_t done;
        osal_grant_t grant = {0U, 0U, 0U};
        status             = take_done(self, &done);
        if (status == STATUS_TIMEOUT) {
            return true;
        }
        if (status != STATUS_OK) {
            break;
        }
        if (done.is_lossy) {
            __atomic_store_n(&self->run->is_lossy, 1U, __ATOMIC_RELAXED);
        }
        note_lost(self);
        // Announce the deliveries before the wait: it ends this turn, and only a running participant may
        // announce them.
        deliver(self, &done.deliveries);
        run_state_beat(self->run, self->component, osal_lockstep_now_ns(self->scheduler), done.wake_ns);
        if ((osal_lockstep_wait(self->scheduler, run_participant(self->component), self->life, done.wake_ns,
                                &grant) != STATUS_OK) ||
            (osal_process_stop_count() > 0U)) {
            return true;
        }
        writer = remote_endian_begin(&self->wire, REMOTE_ENDIAN_GRANT);
        remote_endian_write_grant(&writer, &grant, self->run);
        status = remote_endian_send_frames(&self->wire, &writer, &self->buses);
    }
    if ((status == STATUS_INVALID) || (status == STATUS_TOO_LARGE)) {
        (void)report_error(
            "the protocol between the proxy and its program was violated; build both again (make "
            "remote-endian, make rtos): ",
            status_text(status));
    }
    return false;
}

/// Wait for the end of the program after the stream was closed; kill it if it does not end by itself.
static osal_process_result_t await_end(proxy_t* const self)
{
    osal_process_result_t result  = {.has_ended = false};
    osal_process_t* const process = &self->process;
    const uint64_t until_ns       = osal_clock_monotonic_ns() + (END_TIMEOUT_MS * 1000000ULL);
    while ((osal_process_poll(process, &result) == STATUS_OK) && !result.has_ended) {
        if (osal_clock_monotonic_ns() >= until_ns) {
            (void)osal_process_stop(process, true);
        }
        (void)osal_process_wait_any(&process, 1U, SLICE_MS);
    }
    return result;
}

static void print_loss(const proxy_t* const self, const osal_process_result_t* const result)
{
    char line[LINE_MAX];
    text_t text = text_in(line, sizeof line);
    text_add(&text, self->program);
    text_add(&text, result->was_signalled ? " was ended by signal " : " ended with exit code ");
    text_add_unsigned(&text, (uint64_t)result->code);
    (void)report_error(self->run->components[self->component].name, ": its program is lost:");
    (void)report_error(line, "");
}

/// Take component, program and board from the command line. False if they do not have the form in
/// which the launcher writes them.
static bool take_arguments(proxy_t* const self, const int count, char* const arguments[])
{
    const bool has_board = (count == 11) && (strcmp(arguments[9], "--board") == 0);
    if (((count != 9) && !has_board) || (strcmp(arguments[1], "--run") != 0) ||
        (strcmp(arguments[3], "--component") != 0) || (strcmp(arguments[5], "--program") != 0) ||
        (strcmp(arguments[7], "--runner") != 0)) {
        return false;
    }
    const char* text   = arguments[4];
    uint64_t component = 0U;
    const bool is_component =
        (number_read_unsigned(&text, &component) == STATUS_OK) && (component < MISSION_SUBSYSTEMS_MAX);
    // No run has a component with this index, so open_run refuses an index that is not a number.
    self->component = is_component ? (unsigned)component : MISSION_SUBSYSTEMS_MAX;
    self->program   = arguments[6];
    self->board     = has_board ? arguments[10] : NULL;
    return true;
}

int main(int argument_count, char* arguments[])
{
    static const char usage[] = "usage: --run NAME --component INDEX --program PATH --runner PATH "
                                "[--board NAME] (the launcher `hirosco run --remote-endian SUBSYSTEM` "
                                "or `--rtos SUBSYSTEM` starts it)";
    proxy_t* const self       = &storage;
    if (osal_console_introduce(argument_count, arguments, "proxy", usage)) {
        return 0;
    }
    if (!take_arguments(self, argument_count, arguments)) {
        (void)report_error(usage, "");
        return 2;
    }
    osal_process_catch_stop();
    osal_process_ignore_interrupt();
    const char* const error = open_run(self, arguments[2]);
    if (error != NULL) {
        return report_error(error, "");
    }
    const bool is_started = (self->board != NULL) ? start_board(self, arguments[2], arguments[8])
                                                  : start_program(self, arguments[2], arguments[8]);
    if (!is_started) {
        return report_error("cannot start a program; install its emulator with `make setup`: ", arguments[8]);
    }
    const bool is_good = serve(self);
    if (self->board != NULL) {
        if (target_link_lost(&self->target) > self->reported_lost) { // More were lost after the first print.
            print_lost(self);
        }
        target_link_close(&self->target);
    } else {
        osal_socket_close(&self->wire.socket);
    }
    const osal_process_result_t result = await_end(self);
    if (!is_good) {
        print_loss(self, &result);
    }
    return is_good ? 0 : 1;
}
