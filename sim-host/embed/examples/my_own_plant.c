/* The firmware's controller finds and tracks a resonator in C: replace it by your model.

       cargo build --release -p sonoglide-embed
       cc my_own_plant.c -I ../include ../../../target/release/libsonoglide.a -lpthread -ldl -lm -o my_own_plant
*/
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "sonoglide.h"

#define BLOCK 64
#define LATENCY 2

int main(void) {
    const double pi = 3.14159265358979323846;
    const char *changes[] = {"controller.burst.on_s=[0.0]", "controller.burst.off_s=[9.0]"};
    SonoglideController *controller = sonoglide_controller_new("lock", changes, 2);
    SonoglideShape shape;
    if (controller == NULL || sonoglide_controller_shape(controller, &shape) != 0) {
        fprintf(stderr, "%s\n", sonoglide_failure());
        return 1;
    }
    if (shape.samples > BLOCK || shape.lanes != 1 || shape.latency_blocks != LATENCY) {
        fprintf(stderr, "another block than this example expects\n");
        return 1;
    }
    /* u = Rm i + Lm di/dt + 1/Cm integral i dt, in parallel with C0, by sixteen midpoint steps in a sample */
    const double hz = 39.6e3, q = 100, rm = 3.08, c0 = 300e-9, w = 2 * pi * hz, lm = q * rm / w, cm = 1 / (w * w * lm);
    const double sample_s = 1 / shape.sample_hz, h = sample_s / 16;
    double i = 0, uc = 0, last = 0;
    uint16_t queue[LATENCY][BLOCK], v[BLOCK], a[BLOCK];
    for (int slot = 0; slot < LATENCY; slot++)
        for (size_t n = 0; n < shape.samples; n++) queue[slot][n] = shape.drive_mid_code;
    SonoglideReport report;
    memset(&report, 0, sizeof report);
    for (int block = 0; block < 6000; block++) {
        uint16_t *codes = queue[block % LATENCY];
        for (size_t n = 0; n < shape.samples; n++) {
            double u = (codes[n] - (double)shape.drive_mid_code) * shape.drive_volt_per_code;
            for (int k = 0; k < 16; k++) {
                double im = i + 0.5 * h * (u - rm * i - uc) / lm, um = uc + 0.5 * h * i / cm;
                i += h * (u - rm * im - um) / lm;
                uc += h * im / cm;
            }
            double current = i + c0 * (u - last) / sample_s;
            last = u;
            v[n] = (uint16_t)fmin(fmax(rint(u / shape.volt_per_code) + shape.sense_mid_code, 0), shape.sense_max_code);
            a[n] = (uint16_t)fmin(fmax(rint(current / shape.ampere_per_code) + shape.sense_mid_code, 0), shape.sense_max_code);
        }
        if (sonoglide_controller_process(controller, v, a, NULL, codes, &report) != 0) {
            fprintf(stderr, "%s\n", sonoglide_failure());
            return 1;
        }
    }
    printf("fault %d, locked %d: %.1f Hz, resonance of the model %.1f Hz\n", report.fault, report.locked, report.frequency_hz, hz);
    sonoglide_controller_free(controller);
    return report.locked && fabs(report.frequency_hz - hz) < 0.25 * hz / q ? 0 : 1;
}
