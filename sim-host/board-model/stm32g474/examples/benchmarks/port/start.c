/* Startup, output and clock of a benchmark: no operating system, output by semihosting, time by DWT's cycle counter. */

#include <stddef.h>
#include <stdint.h>

#define DEMCR (*(volatile uint32_t *)0xE000EDFC)
#define DWT_CTRL (*(volatile uint32_t *)0xE0001000)
#define DWT_CYCCNT (*(volatile uint32_t *)0xE0001004)

extern uint32_t data_from[], data_begin[], data_end[], bss_begin[], bss_end[], heap_begin[], stack_top[];

int main(void);
/* Prints the cycles; the exit status, of that of `main`. */
int report(int status);

static int semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

uint32_t cycles(void)
{
    return DWT_CYCCNT;
}

/* What newlib's printf, malloc and exit stand on. */

__attribute__((used)) int _write(int file, const char *bytes, int length)
{
    (void)file;
    for (int at = 0; at < length; at++) {
        semihosting(0x03 /* SYS_WRITEC */, &bytes[at]);
    }
    return length;
}

__attribute__((used)) void *_sbrk(ptrdiff_t bytes)
{
    static char *end = (char *)heap_begin;
    char *from = end;
    end += bytes;
    return from;
}

__attribute__((used)) void _exit(int status)
{
    /* SYS_EXIT: ADP_Stopped_ApplicationExit, or a run-time error. */
    semihosting(0x18, (const void *)(uintptr_t)(status == 0 ? 0x20026 : 0x20023));
    for (;;) {
    }
}

static void unexpected(void)
{
    _exit(1);
}

void start(void)
{
    uint32_t *from = data_from;
    for (uint32_t *to = data_begin; to < data_end; to++) {
        *to = *from++;
    }
    for (uint32_t *to = bss_begin; to < bss_end; to++) {
        *to = 0;
    }
    DEMCR |= 1u << 24; /* TRCENA */
    DWT_CTRL |= 1;     /* CYCCNTENA */
    _exit(report(main()));
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top,  start,      unexpected, unexpected, unexpected, unexpected, unexpected, unexpected,
    unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected,
};
