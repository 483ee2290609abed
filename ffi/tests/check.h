/* The check of these tests: says what failed and where, counts it, and goes on. */
#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>

static int check_failures;

#define CHECK(condition) ((condition) ? (void)0 : check_failed(__FILE__, __LINE__, #condition))

static inline void check_failed(const char *file, int line, const char *what) {
    check_failures++;
    fprintf(stderr, "%s:%d: %s\n", file, line, what);
}

/* What main returns. */
static inline int check_end(const char *name) {
    printf("%s: %s\n", name, check_failures == 0 ? "all as it should be" : "WRONG");
    return check_failures == 0 ? 0 : 1;
}

#endif
