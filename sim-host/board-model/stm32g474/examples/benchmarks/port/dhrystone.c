/* The clock that Dhrystone reads before and after its loop, and the number of cycles for the host. */

#include <stdint.h>
#include <stdio.h>

uint32_t cycles(void);

static uint32_t last, before;

long time(long *unused)
{
    (void)unused;
    before = last;
    last = cycles();
    return (long)last;
}

/* Its `main` returns nothing. */
int report(int status)
{
    (void)status;
    printf("MEASURED %lu cycles of %d iterations\n", (unsigned long)(last - before), DHRY_ITERS);
    return 0;
}
