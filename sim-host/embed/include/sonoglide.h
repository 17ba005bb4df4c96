// Sonoglide in C and C++: the controller of the firmware, and the simulated plant, block by block.
// Each object may be used by one thread at a time. Numbers of faults and limits: docs/faults.md.
// Generated from sim-host/embed/src; UPDATE_DOCS=1 cargo test -p sonoglide-embed writes it anew.

#ifndef SONOGLIDE_H
#define SONOGLIDE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

// Controller of a scene: the code of the firmware, bit for bit.
typedef struct SonoglideController SonoglideController;

// Simulated amplifier, transducer, contact and converters of a scene.
typedef struct SonoglidePlant SonoglidePlant;

// Sizes of a block, and the conversion between codes and physical units.
typedef struct SonoglideShape {
  // Number of lanes of the drive.
  size_t lanes;
  // Samples in a block.
  size_t samples;
  // Samples per second.
  double sample_hz;
  // Number of blocks after which the answer to a block plays.
  size_t latency_blocks;
  // Sample of the playing block from which it must be silent if an answer drops the queue.
  size_t dropped_from;
  // Code of zero volts and amperes.
  uint16_t sense_mid_code;
  // Largest code of the sense channels.
  uint16_t sense_max_code;
  // Volts per code of the voltage channel.
  float volt_per_code;
  // Amperes per code of the current channel.
  float ampere_per_code;
  // Code of zero drive.
  uint16_t drive_mid_code;
  // Volts of the drive per code.
  float drive_volt_per_code;
} SonoglideShape;

// Slow readings of a board. NaN without such a sensor.
typedef struct SonoglideSlow {
  // `true` if there is a belt encoder.
  bool has_counts;
  // Counts of the belt encoder.
  int32_t counts;
  // `true` if a line to the belt encoder is broken.
  bool broken;
  // Friction force, N.
  float force_n;
  // Temperature at the driver, degrees Celsius.
  float temperature_c;
} SonoglideSlow;

// Report of one block.
typedef struct SonoglideReport {
  // Number of the block, from zero.
  uint32_t block;
  // Number of the fault for which the drive is muted, or zero.
  uint8_t fault;
  // Number of the limit that acts, or zero.
  uint8_t limit;
  // `true` if the tracker is locked.
  bool locked;
  // `true` if codes that were returned before must not play any longer.
  bool drops_queue;
  // Lane that the sense channels are connected to while the returned codes play.
  uint8_t listen;
  // Frequency of the returned codes, Hz.
  float frequency_hz;
  // Smoothed estimate of the resonance, Hz.
  float resonance_hz;
  // Peak voltage of the returned codes before the envelope, V.
  float drive_v;
  // Peak motional current of the measured block, A, in phase with the voltage and at 90 degrees.
  float motional_current_a[2];
  // Estimate of the friction ratio; NaN if friction is not switched.
  float friction_ratio;
} SonoglideReport;

// True state of a plant at the end of the last block, which a controller never receives.
typedef struct SonoglideTruth {
  // Mean friction, N.
  double friction_n;
  // Peak tip velocity, m/s.
  double tip_velocity_m_per_s;
  // Series resonance, Hz.
  double series_resonance_hz;
  // Mean power of the drive, W.
  double power_w;
  // Hash of all codes played, as in the summary of a run.
  uint64_t drive_hash;
} SonoglideTruth;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Text of the last failure in this thread. It is valid until the next call.
const char *sonoglide_failure(void);

// Creates the controller of a scene: a built-in name or a TOML file, with `count` changes such as
// "controller.drive.amplitude_v=5". Returns null on failure; `sonoglide_failure` tells why. The
// scene gives the orders until the first order of the caller.
//
// # Safety
// `source` and the `count` texts `changes` end with a zero byte.
struct SonoglideController *sonoglide_controller_new(const char *source,
                                                     const char *const *changes,
                                                     size_t count);

// Frees a controller.
//
// # Safety
// `controller` is null or comes from `sonoglide_controller_new`, and is not used any more.
void sonoglide_controller_free(struct SonoglideController *controller);

// Writes the sizes of a block. Returns 0, or -1 on failure.
//
// # Safety
// `controller` comes from `sonoglide_controller_new`, `shape` has room for one.
int sonoglide_controller_shape(struct SonoglideController *controller,
                               struct SonoglideShape *shape);

// Processes one block: `samples` codes of voltage and current, and slow readings, or null if the
// scene has no such sensor. Writes the codes to play `latency_blocks` later, `lanes` times
// `samples`, lane after lane, and the report, if it is not null. Returns 0, or -1 on failure.
//
// # Safety
// `controller` comes from `sonoglide_controller_new`; the arrays have the sizes stated.
int sonoglide_controller_process(struct SonoglideController *controller,
                                 const uint16_t *v,
                                 const uint16_t *i,
                                 const struct SonoglideSlow *slow,
                                 uint16_t *codes,
                                 struct SonoglideReport *report);

// Orders a run with the drive always ON at a peak voltage, V. Like every order, it ends the
// friction steps of the scene. Returns 0, or -1 on failure.
//
// # Safety
// `controller` comes from `sonoglide_controller_new`.
int sonoglide_controller_drive(struct SonoglideController *controller, float volts);

// Orders the drive ON or OFF in a run, instead of the bursts and the friction switch of the scene;
// OFF holds the frequency. Returns 0, or -1 on failure.
//
// # Safety
// `controller` comes from `sonoglide_controller_new`.
int sonoglide_controller_gate(struct SonoglideController *controller, bool on);

// Orders a friction ratio, 0 to 1, for scenes with [controller.friction]. Returns 0, or -1 on
// failure.
//
// # Safety
// `controller` comes from `sonoglide_controller_new`.
int sonoglide_controller_friction(struct SonoglideController *controller, float ratio);

// Orders silence, and clears a fault if wanted; then `sonoglide_controller_drive` begins a new
// attempt. Returns 0, or -1 on failure.
//
// # Safety
// `controller` comes from `sonoglide_controller_new`.
int sonoglide_controller_stop(struct SonoglideController *controller, bool clear_fault);

// Creates the plant of a scene, with the arguments of `sonoglide_controller_new`. Returns null on
// failure; `sonoglide_failure` tells why.
//
// # Safety
// `source` and the `count` texts `changes` end with a zero byte.
struct SonoglidePlant *sonoglide_plant_new(const char *source,
                                           const char *const *changes,
                                           size_t count);

// Frees a plant.
//
// # Safety
// `plant` is null or comes from `sonoglide_plant_new`, and is not used any more.
void sonoglide_plant_free(struct SonoglidePlant *plant);

// Plays one block of codes, `lanes` times `samples`, with the sense channels at the lane `listen`.
// Writes `samples` codes of voltage and of current, and the slow readings, if `slow` is not null.
// Returns 0, or -1 on failure.
//
// # Safety
// `plant` comes from `sonoglide_plant_new`; the arrays have the sizes stated.
int sonoglide_plant_step(struct SonoglidePlant *plant,
                         const uint16_t *codes,
                         uint8_t listen,
                         uint16_t *v,
                         uint16_t *i,
                         struct SonoglideSlow *slow);

// Writes the true state of a plant. Returns 0, or -1 on failure.
//
// # Safety
// `plant` comes from `sonoglide_plant_new`, `truth` has room for one.
int sonoglide_plant_truth(struct SonoglidePlant *plant, struct SonoglideTruth *truth);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SONOGLIDE_H */
