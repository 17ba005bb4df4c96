/* The port of CoreMark: seeds of a performance run, time, and the number of cycles for the host. */

#include <stdio.h>

#include "coremark.h"

#define CYCLES_PER_SECOND 1000000

uint32_t cycles(void);

/* Zero, zero and 0x66 are those of a performance run; ITERATIONS is set by the command line; all algorithms. */
volatile ee_s32 seed1_volatile = 0;
volatile ee_s32 seed2_volatile = 0;
volatile ee_s32 seed3_volatile = 0x66;
volatile ee_s32 seed4_volatile = ITERATIONS;
volatile ee_s32 seed5_volatile = 0;

ee_u32 default_num_contexts = 1;

static uint32_t began, ended;

void start_time(void)
{
    began = cycles();
}

void stop_time(void)
{
    ended = cycles();
}

CORE_TICKS get_time(void)
{
    return ended - began;
}

secs_ret time_in_secs(CORE_TICKS ticks)
{
    return ticks / CYCLES_PER_SECOND;
}

void portable_init(core_portable *port, int *argc, char *argv[])
{
    (void)argc;
    (void)argv;
    port->portable_id = 1;
}

void portable_fini(core_portable *port)
{
    port->portable_id = 0;
}

int report(int status)
{
    printf("MEASURED %lu cycles of %d iterations\n", (unsigned long)get_time(), ITERATIONS);
    return status;
}
