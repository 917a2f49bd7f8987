// SPDX-License-Identifier: Apache-2.0
#include "sim/app/fault_kill.h"

#include "osal/include/osal/console.h"

#include <ctype.h>
#include <dirent.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define OPERATOR "operator"
// The operator is the command `<interpreter> gse/gse script ...`, so its program has another name.
#define OPERATOR_VERB "script"
#define VERB_AT 2U ///< Number of words before the verb.
#define TEXT_OCTETS 512U

/// Read the beginning of a /proc file of a process, followed by NUL. Returns the number of octets; 0: the
/// process has ended.
static size_t read_of(const char* const id, const char* const file, char out_text[TEXT_OCTETS])
{
    char path[64];
    (void)snprintf(path, sizeof path, "/proc/%.20s/%.20s", id, file);
    FILE* stream = fopen(path, "re");
    if (stream == NULL) {
        return 0U;
    }
    const size_t octets = fread(out_text, 1U, TEXT_OCTETS - 1U, stream);
    out_text[octets]    = '\0';
    (void)fclose(stream);
    return octets;
}

/// True if the process has the same parent as this process. Its /proc file is "id (program) state parent
/// ...", and the name of a program may contain any character.
static bool is_sibling(const char* const id)
{
    char text[TEXT_OCTETS];
    const size_t octets = read_of(id, "stat", text);
    const char* after   = (octets > 0U) ? strrchr(text, ')') : NULL;
    const bool is_whole = (after != NULL) && (strlen(after) > 4U);
    return is_whole && (strtol(&after[4], NULL, 10) == (long)getppid());
}

static bool has_name(const char* const id, const char* const process)
{
    char text[TEXT_OCTETS];
    const size_t octets = read_of(id, "cmdline", text);
    if ((octets > 0U) && (strcmp(process, OPERATOR) == 0)) {
        const char* word = text;
        for (unsigned i = 0U; (i < VERB_AT) && (word < &text[octets]); i++) {
            word += strlen(word) + 1U;
        }
        return (word < &text[octets]) && (strcmp(word, OPERATOR_VERB) == 0);
    }
    const char* slash = strrchr(text, '/');
    return (octets > 0U) && (strcmp((slash != NULL) ? &slash[1] : text, process) == 0);
}

static void signal_process(const char* const process, const char* const verb, const int signal_number)
{
    if (strcmp(process, "launcher") == 0) {
        (void)kill(getppid(), signal_number);
        return;
    }
    DIR* directory        = opendir("/proc");
    bool is_found         = false;
    struct dirent* number = (directory != NULL) ? readdir(directory) : NULL;
    while ((number != NULL) && !is_found) {
        const char* id = number->d_name;
        is_found       = (isdigit((unsigned char)id[0]) != 0) && is_sibling(id) && has_name(id, process) &&
                   (kill((pid_t)strtol(id, NULL, 10), signal_number) == 0);
        number = readdir(directory);
    }
    if (directory != NULL) {
        (void)closedir(directory);
    }
    if (!is_found) {
        char line[TEXT_OCTETS];
        (void)snprintf(
            line, sizeof line,
            "simulator: fault %.8s %.64s: no such process is running; run.json lists the processes", verb,
            process);
        osal_console_print_error(line);
    }
}

void fault_kill(const char* const process)
{
    signal_process(process, "kill", SIGKILL);
}

void fault_suspend(const char* const process)
{
    signal_process(process, "hang", SIGSTOP);
}

void fault_resume(const char* const process)
{
    signal_process(process, "resume", SIGCONT);
}
