/* The script and the log. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "stand_in.h"

#define LINES 256

struct line {
    char key[NAME_LENGTH], name[NAME_LENGTH];
    uint64_t first, second;
    int fields;
    /* How often it was asked for. */
    uint64_t times;
};

static struct line lines[LINES];
static int count;
static int log_file = -1;
static pthread_mutex_t reading = PTHREAD_MUTEX_INITIALIZER;

__attribute__((constructor)) static void open_files(void)
{
    const char *script = getenv("RED_STAND_IN"), *log = getenv("RED_STAND_IN_LOG");
    char text[256];
    FILE *file = script == NULL ? NULL : fopen(script, "r");
    while (file != NULL && count < LINES && fgets(text, sizeof text, file) != NULL) {
        struct line *l = &lines[count];
        l->fields = sscanf(text, "%63s %63s %lu %lu", l->key, l->name, &l->first, &l->second);
        count += l->fields >= 2;
    }
    if (file != NULL) {
        fclose(file);
    }
    if (log != NULL) {
        log_file = open(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    }
}

uint64_t script_number(const char *key, uint64_t otherwise)
{
    for (int i = 0; i < count; i++) {
        if (strcmp(lines[i].key, key) == 0) {
            return strtoull(lines[i].name, NULL, 10);
        }
    }
    return otherwise;
}

uint64_t script_of(const char *key, const char *name, uint64_t otherwise)
{
    for (int i = 0; i < count; i++) {
        bool is_meant = strcmp(lines[i].name, name) == 0 || strcmp(lines[i].name, "*") == 0;
        if (is_meant && strcmp(lines[i].key, key) == 0) {
            return lines[i].first;
        }
    }
    return otherwise;
}

uint64_t script_from(const char *key, const char *name, uint64_t otherwise)
{
    pthread_mutex_lock(&reading);
    for (int i = 0; i < count; i++) {
        struct line *l = &lines[i];
        if (strcmp(l->key, key) == 0 && strcmp(l->name, name) == 0 && ++l->times >= l->first) {
            otherwise = l->second;
        }
    }
    pthread_mutex_unlock(&reading);
    return otherwise;
}

bool script_at(const char *key, const char *name, uint64_t *value)
{
    bool is_now = false;
    pthread_mutex_lock(&reading);
    for (int i = 0; i < count; i++) {
        struct line *l = &lines[i];
        if (strcmp(l->key, key) == 0 && strcmp(l->name, name) == 0 && ++l->times == l->first) {
            *value = l->second;
            is_now = true;
        }
    }
    pthread_mutex_unlock(&reading);
    return is_now;
}

void say(const char *format, ...)
{
    char text[256];
    va_list arguments;
    if (log_file < 0) {
        return;
    }
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text - 1, format, arguments);
    va_end(arguments);
    length = length < (int)sizeof text - 1 ? length : (int)sizeof text - 2;
    text[length] = '\n';
    /* One write: lines of several threads do not mix, and none is lost where the process dies. */
    if (write(log_file, text, (size_t)length + 1) < 0) {
        log_file = -1;
    }
}

uint64_t clock_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

void sleep_us(uint64_t microseconds)
{
    struct timespec time = {(time_t)(microseconds / 1000000), (long)(microseconds % 1000000) * 1000};
    while (microseconds > 0 && nanosleep(&time, &time) != 0) {
    }
}
