//! Test of the bound against maximum-likelihood fits of simulated codes; they share only the
//! current with it.

use super::*;
use plant::converter::Adc;

const SEEDS: u64 = 200;
const STEPS: [f64; 6] = [0.1, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5];

/// Solves a linear system by Gaussian elimination.
fn solved(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let size = rows.len();
    for n in 0..size {
        let pivot = (n..size).max_by(|&a, &b| rows[a][n].abs().total_cmp(&rows[b][n].abs())).unwrap();
        rows.swap(n, pivot);
        for m in (0..size).filter(|&m| m != n) {
            let (factor, row) = (rows[m][n] / rows[n][n], rows[n].clone());
            rows[m].iter_mut().zip(row).for_each(|(x, y)| *x -= factor * y);
        }
    }
    (0..size).map(|n| rows[n][size] / rows[n][n]).collect()
}

/// Returns the expected samples, in standard deviations of their noise.
fn expected(setting: &Setting, by: &[f64; 6], samples: usize) -> Vec<f64> {
    let (circuit, drive) = moved(setting, by);
    let response = Response::new(&circuit, &drive, &setting.start);
    let times = (1..=samples).map(|n| n as f64 / setting.sample_hz);
    times
        .flat_map(|t| [response.current(t).0 / setting.current_noise_a, response.voltage(t).0 / setting.voltage_noise_v])
        .collect()
}

/// Fits by the Gauss-Newton method; returns the deviation from the truth. `prior` is the mean of
/// each parameter's prior.
fn fit(setting: &Setting, measured: &[f64], prior: &[f64; 6]) -> [f64; 6] {
    let knowledge = &setting.prior.of_each()[..6];
    let free: Vec<usize> = (0..6).filter(|&n| knowledge[n] != Knowledge::Known).collect();
    let mut at = [100.0, 0.2, 0.05, 0.002, 0.0, 0.0];
    (0..6).filter(|n| !free.contains(n)).for_each(|n| at[n] = 0.0);
    for _ in 0..7 {
        let model = expected(setting, &at, measured.len() / 2);
        let by: Vec<Vec<f64>> = free
            .iter()
            .map(|&n| {
                let beside = |sign: f64| {
                    let mut other = at;
                    other[n] += sign * STEPS[n];
                    expected(setting, &other, measured.len() / 2)
                };
                beside(1.0).iter().zip(beside(-1.0)).map(|(a, b)| (a - b) / (2.0 * STEPS[n])).collect()
            })
            .collect();
        let rows = free.iter().enumerate().map(|(row, &n)| {
            let mut sums: Vec<f64> = by.iter().map(|other| by[row].iter().zip(other).map(|(a, b)| a * b).sum()).collect();
            let mut right: f64 =
                by[row].iter().zip(measured.iter().zip(&model)).map(|(by, (measured, model))| by * (measured - model)).sum();
            if let Knowledge::Within(deviation) = knowledge[n] {
                sums[row] += deviation.powi(-2);
                right += (prior[n] - at[n]) / deviation.powi(2);
            }
            sums.push(right);
            sums
        });
        solved(rows.collect()).iter().zip(&free).for_each(|(step, &n)| at[n] += step);
    }
    at
}

/// Returns the rms error of the fits, relative to the bound.
fn ratio(setting: &Setting, oversample: u8, samples: u32) -> f64 {
    let sensors = sensors(oversample);
    let pure = simulated(|_| setting.circuit, &setting.drive, first_state(setting), samples);
    let lsb = |full_scale: f64| full_scale / 2048.0;
    let square: f64 = (0..SEEDS)
        .map(|seed| {
            let mut adc = Adc::new(&sensors, 3 * seed + 1);
            let lsb = [lsb(sensors.v_full_scale_v), lsb(sensors.i_full_scale_a)];
            let measured: Vec<f64> = pure
                .iter()
                .flat_map(|&[i, v]| {
                    let mut sum = [0.0; 2];
                    for _ in 0..oversample {
                        sum.iter_mut().zip(adc.convert([v, i])).for_each(|(sum, code)| *sum += f64::from(code) - 2048.0);
                    }
                    let [v, i] = std::array::from_fn(|channel| sum[channel] * lsb[channel] / f64::from(oversample));
                    [i / setting.current_noise_a, v / setting.voltage_noise_v]
                })
                .collect();
            let coarse = Sensors { adc_bits: 16, noise_lsb: 1000.0, v_full_scale_v: 32.768, ..sensors.clone() };
            let mut chance = Adc::new(&coarse, 3 * seed + 3);
            // The mean of a prior deviates by its standard deviation: a Gaussian in steps of 0.001.
            let prior = std::array::from_fn(|n| match setting.prior.of_each()[n] {
                Knowledge::Within(deviation) => deviation * (f64::from(chance.convert([0.0; 2])[0]) - 32768.0) / 1000.0,
                _ => 0.0,
            });
            fit(setting, &measured, &prior)[0].powi(2)
        })
        .sum();
    let error_hz = (square / SEEDS as f64).sqrt();
    let bound_hz = bound_at(setting, f64::from(samples) * 1e-6);
    println!("{samples:>5} us: {error_hz:.4} Hz rms of {SEEDS} fits, bound {bound_hz:.4} Hz rms: {:.3}", error_hz / bound_hz);
    error_hz / bound_hz
}

#[test]
fn fits_reach_the_bound() {
    let cold = |q: f64| {
        let setting = set_a(q, 400.0, PriorKnowledge::NONE);
        Setting {
            prior: PriorKnowledge::cold(setting.drive.hz, 0.02),
            ..super::setting(setting.circuit, 400.0, setting.prior, &sensors(2))
        }
    };
    let measured = PriorKnowledge { voltage: Knowledge::Unknown, ..PriorKnowledge::LM_AND_C0 };
    let cases = [
        ("Q 65, no priors", set_a(65.0, 400.0, PriorKnowledge::NONE), 1, 200),
        ("Q 65, no priors", set_a(65.0, 400.0, PriorKnowledge::NONE), 1, 500),
        ("Q 500, no priors", set_a(500.0, 0.0, PriorKnowledge::NONE), 1, 300),
        ("Q 20, Lm and C0 known, voltage measured", set_a(20.0, 0.0, measured), 1, 200),
        ("Q 65, priors of a cold start", cold(65.0), 2, 100),
        ("Q 200, priors of a cold start", cold(200.0), 2, 300),
        ("load step, Lm and C0 known", load_step(PriorKnowledge::LM_AND_C0, 1), 1, 100),
    ];
    for (name, setting, oversample, samples) in cases {
        print!("{name:36}");
        let ratio = ratio(&setting, oversample, samples);
        // The rms of 200 errors is known to 5 %.
        assert!((ratio - 1.0).abs() < 0.15, "{name}: {ratio}");
    }
}
