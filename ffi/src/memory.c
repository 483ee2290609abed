/* What a compiler calls to copy, fill and compare memory. The shared library of the core has its own, so that it needs no
 * other library; in a static one they are the program's. Compiled so that no loop here becomes a call of itself. */
#include <stddef.h>
#include <stdint.h>

#define OWN __attribute__((visibility("hidden")))

OWN void *memcpy(void *restrict to, const void *restrict from, size_t bytes) {
    unsigned char *t = to;
    const unsigned char *f = from;
    for (; bytes >= 16; bytes -= 16, t += 16, f += 16) {
        uint64_t low, high;
        __builtin_memcpy(&low, f, 8);
        __builtin_memcpy(&high, f + 8, 8);
        __builtin_memcpy(t, &low, 8);
        __builtin_memcpy(t + 8, &high, 8);
    }
    while (bytes-- > 0) *t++ = *f++;
    return to;
}

OWN void *memmove(void *to, const void *from, size_t bytes) {
    unsigned char *t = to;
    const unsigned char *f = from;
    if (t <= f || t >= f + bytes) return memcpy(to, from, bytes);
    while (bytes-- > 0) t[bytes] = f[bytes];
    return to;
}

OWN void *memset(void *to, int value, size_t bytes) {
    unsigned char *t = to;
    const uint64_t word = 0x0101010101010101u * (unsigned char)value;
    for (; bytes >= 16; bytes -= 16, t += 16) {
        __builtin_memcpy(t, &word, 8);
        __builtin_memcpy(t + 8, &word, 8);
    }
    while (bytes-- > 0) *t++ = (unsigned char)value;
    return to;
}

OWN int memcmp(const void *a, const void *b, size_t bytes) {
    const unsigned char *x = a, *y = b;
    for (; bytes > 0; bytes--, x++, y++)
        if (*x != *y) return *x - *y;
    return 0;
}
