/* The start, the vector table, SysTick, and semihosting. */
#include "board.h"

#include <stddef.h>

#define REGISTER(address) (*(volatile uint32_t *)(uintptr_t)(address))
#define SYSTICK_CONTROL REGISTER(0xE000E010)
#define SYSTICK_RELOAD REGISTER(0xE000E014)
#define SYSTICK_VALUE REGISTER(0xE000E018)
#define COPROCESSORS REGISTER(0xE000ED88)
#define CLOCK_HZ 25000000

/* Operations of semihosting. */
enum { SYS_WRITE0 = 0x04, SYS_GET_CMDLINE = 0x15, SYS_EXIT_EXTENDED = 0x20 };
/* Why a program stops: it came to its end. */
#define APPLICATION_EXIT 0x20026

/* Written in the stack before it is used. */
#define PAINT 0xA5A5A5A5

/* Of the linker script: only their addresses count. */
extern uint32_t stack_start[], stack_end[], data_start[], data_end[], bss_start[], bss_end[];
extern const uint32_t data_load[];

int main(void);

static volatile uint32_t tick_count;

/* What a compiler calls by itself, and a C library would bring. */
void *memset(void *to, int value, size_t bytes);
void *memcpy(void *restrict to, const void *restrict from, size_t bytes);

void *memset(void *to, int value, size_t bytes) {
    unsigned char *byte = to;
    for (size_t i = 0; i < bytes; i++) byte[i] = (unsigned char)value;
    return to;
}

void *memcpy(void *restrict to, const void *restrict from, size_t bytes) {
    unsigned char *byte = to;
    const unsigned char *source = from;
    for (size_t i = 0; i < bytes; i++) byte[i] = source[i];
    return to;
}

static uint32_t semihost(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

_Noreturn void reset(void) {
    /* Floating point, which a compiler may use to move memory. */
    COPROCESSORS |= 0xFu << 20;
    __asm__ volatile("dsb\n isb" ::: "memory");
    for (volatile uint32_t *word = stack_start; word < (uint32_t *)__builtin_frame_address(0) - 16; word++) *word = PAINT;
    for (size_t i = 0; data_start + i < data_end; i++) data_start[i] = data_load[i];
    for (size_t i = 0; bss_start + i < bss_end; i++) bss_start[i] = 0;
    leave((uint32_t)main());
}

static void fault(void) {
    print("a fault of the processor\n");
    leave(101);
}

static void tick(void) {
    tick_count++;
}

typedef void (*handler)(void);
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    handler handlers[15];
} vectors = {stack_end, {reset, fault, fault, fault, fault, fault, 0, 0, 0, 0, fault, fault, 0, fault, tick}};

void start_ticks(void) {
    SYSTICK_RELOAD = CLOCK_HZ / TICKS_PER_SECOND - 1;
    SYSTICK_VALUE = 0;
    /* Runs by the processor's clock, and interrupts. */
    SYSTICK_CONTROL = 7;
}

uint32_t ticks(void) {
    return tick_count;
}

void sleep_until_interrupt(void) {
    __asm__ volatile("wfi" ::: "memory");
}

uint32_t stack_used(void) {
    const uint32_t *word = stack_start;
    while (word < stack_end && *word == PAINT) word++;
    return (uint32_t)((uintptr_t)stack_end - (uintptr_t)word);
}

uint32_t stack_size(void) {
    return (uint32_t)((uintptr_t)stack_end - (uintptr_t)stack_start);
}

void print(const char *text) {
    semihost(SYS_WRITE0, text);
}

void print_number(uint32_t number, int places) {
    char digits[12];
    int at = 11;
    digits[at] = 0;
    do {
        digits[--at] = (char)('0' + number % 10);
        number /= 10;
    } while (number > 0 && at > 0);
    while (11 - at < places && at > 0) digits[--at] = ' ';
    print(digits + at);
}

bool was_told(const char *word) {
    static char line[256];
    const struct {
        char *text;
        uint32_t room;
    } request = {line, sizeof line};
    if (semihost(SYS_GET_CMDLINE, &request) != 0) return false;
    for (const char *from = line; *from != 0; from++) {
        size_t i = 0;
        while (word[i] != 0 && from[i] == word[i]) i++;
        if (word[i] == 0) return true;
    }
    return false;
}

_Noreturn void leave(uint32_t status) {
    const uint32_t reason[] = {APPLICATION_EXIT, status};
    semihost(SYS_EXIT_EXTENDED, reason);
    for (;;) {}
}
