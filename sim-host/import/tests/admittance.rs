//! Imports of synthetic and hand-made files: the results agree with the truth, and unusable files
//! are refused with the reason.

use sonoglide_import::admittance::coordinate::Coordinate;
use sonoglide_import::admittance::measured::Measured;
use sonoglide_import::admittance::options::Options;
use sonoglide_import::admittance::{Admittance, Value, fit};
use sonoglide_import::error::ImportError;
use sonoglide_import::synthetic::{Example, mutated};
use sonoglide_import::units::Units;

fn parse(name: &str, text: &str, options: &Options) -> Result<Measured, ImportError> {
    Measured::parse(name, text.as_bytes(), options)
}

fn refused(name: &str, text: &str) -> String {
    match parse(name, text, &Options::default()).and_then(|sweep| fit("refused", sweep, None)) {
        Ok(found) => panic!("{:?}", found.circuit),
        Err(error) => error.to_string(),
    }
}

/// Returns the admittance of C0 = 1 nF and a branch of 40 kHz, Q 100 and the conductance `g`, S.
fn admittance(hz: f64, g: f64) -> num_complex::Complex64 {
    let own = num_complex::Complex64::new(1.0, 100.0 * (hz / 40e3 - 40e3 / hz));
    num_complex::Complex64::new(0.0, std::f64::consts::TAU * hz * 1e-9) + g * own.inv()
}

/// Returns a table of G and B over frequencies.
fn table(g: f64, hz: impl Iterator<Item = f64>) -> String {
    let line = |(at, hz): (usize, f64)| {
        let y = admittance(hz, g);
        // Reproducible noise of about 0.1 %.
        let noise = |k: f64| 1e-3 * ((at as f64 * k).sin() + (at as f64 * k * 1.7).cos());
        format!("{hz},{:e},{:e}\n", y.re + y.norm() * noise(12.9), y.im + y.norm() * noise(78.2))
    };
    format!("f [Hz],G [S],B [S]\n{}", hz.enumerate().map(line).collect::<String>())
}

#[test]
fn stated_deviations_cover_the_truth_in_many_formats() {
    let within = |value: Value, truth: f64| (value.value - truth).abs() <= 2.0 * value.sd;
    let (mut covered, mut all) = (0, 0);
    let few = (1000..).map(|number| (number, Example::draw(number))).filter(|(_, example)| example.hz.len() <= 401);
    for (number, example) in few.take(40) {
        let found = example.import().unwrap_or_else(|error| panic!("{number} {:?}: {error}", example.kind));
        let (c, truth) = (&found.circuit, example.true_values());
        let values = [c.series_resonance_hz, c.parallel_resonance_hz, c.q, c.rm_ohm, c.lm_h, c.cm_f, c.c0_f, c.coupling];
        covered += values.iter().zip(truth).filter(|(value, truth)| within(**value, *truth)).count();
        all += values.len();
    }
    // The values of a file are correlated: 320 of them correspond to about 130 independent ones.
    let part = covered as f64 / all as f64;
    assert!((0.89..=0.995).contains(&part), "{covered} of {all}");
}

/// The draws have the deviations of the fit, and Lm and Cm keep the resonance.
#[test]
fn draws_are_as_uncertain_as_the_fit() {
    let text = table(0.04, (0..400).map(|n| 39e3 + 5.0 * f64::from(n)));
    let found = fit("drawn", parse("a.csv", &text, &Options::default()).unwrap(), None).unwrap();
    let samples = found.samples().unwrap();
    let rows: Vec<Vec<f64>> =
        samples.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!((samples.lines().next(), rows.len()), (Some("c0_f,cm_f,lm_h,rm_ohm"), 256));
    let is_as_stated = |stated: Value, of: &dyn Fn(&[f64]) -> f64| {
        let mean = rows.iter().map(|row| of(row)).sum::<f64>() / 256.0;
        let sd = (rows.iter().map(|row| (of(row) - mean).powi(2)).sum::<f64>() / 255.0).sqrt();
        assert!((sd / stated.sd - 1.0).abs() < 0.2 && (mean - stated.value).abs() < 0.3 * stated.sd, "{stated:?} {mean} {sd}");
    };
    is_as_stated(found.circuit.c0_f, &|row| row[0]);
    is_as_stated(found.circuit.cm_f, &|row| row[1]);
    is_as_stated(found.circuit.rm_ohm, &|row| row[3]);
    let hz = |row: &[f64]| 1.0 / (std::f64::consts::TAU * (row[1] * row[2]).sqrt());
    is_as_stated(found.circuit.series_resonance_hz, &hz);
}

/// Contradictory columns and impossible cells are refused with their place.
#[test]
fn ambiguous_columns_and_impossible_cells_are_refused() {
    let rows = |row: &dyn Fn(f64) -> String| (0..200).map(|n| row(39e3 + 10.0 * f64::from(n)) + "\n").collect::<String>();
    let polar = |hz: f64| admittance(hz, 0.04).inv().to_polar();
    for (head, row, why) in [
        ("f [Hz],R [ohm],Rs [ohm],X [ohm]", &(|hz| format!("{hz},1,2,3")) as &dyn Fn(f64) -> String, "have the same quantity"),
        ("f [Hz],|Z| [ohm],theta [rad]", &|hz| format!("{hz},{:e},{}", polar(hz).0, polar(hz).1.to_degrees()), "not in radians"),
        (
            "f [Hz],|Z| [ohm],theta [deg]",
            &|hz| format!("{hz},{},-80", if hz == 40e3 { -5 } else { 5 }),
            "line 102: the magnitude",
        ),
        ("f [Hz],|Z| [ohm],theta [deg]", &|hz| format!("{hz},{},-80", if hz == 40e3 { 0 } else { 5 }), "line 102: the impedance"),
        ("# Reference impedance: 75 Ohm\nf [Hz],S11 re,S11 im", &|hz| format!("{hz},0.5,-0.5"), "reference of 75 ohm"),
    ] {
        let said = refused("a.csv", &format!("{head}\n{}", rows(row)));
        assert!(said.contains(why), "{head}: {said}");
    }
    assert!(refused("a.s4p", "# Hz S RI R 50\n1 2 3\n").contains("Touchstone with 4 ports"));
    // A phase belongs to the magnitude before it.
    let s11 = |hz: f64| {
        let z = admittance(hz, 0.04).inv();
        let (size, angle) = ((z - 50.0) / (z + 50.0)).to_polar();
        format!("{hz},{},{},{}", 20.0 * size.log10(), angle.to_degrees(), z.norm())
    };
    let text = format!("f [Hz],S11 (dB),Phase(deg),|Z|(Ohm)\n{}", rows(&s11));
    let sweep = parse("a.csv", &text, &Options::default()).unwrap();
    assert!((sweep.admittance[50] / admittance(39_500.0, 0.04) - 1.0).norm() < 1e-6, "{:?}", sweep.admittance[50]);
    // With several magnitudes before it, it is that of the impedance.
    let both = |hz: f64| format!("{hz},{:e},{:e},{}", polar(hz).0, 1.0 / polar(hz).0, polar(hz).1.to_degrees());
    let text = format!("f [Hz],|Z| [ohm],|Y| [S],Phase [deg]\n{}", rows(&both));
    let sweep = parse("a.csv", &text, &Options::default()).unwrap();
    assert!((sweep.admittance[50] / admittance(39_500.0, 0.04) - 1.0).norm() < 1e-6, "{:?}", sweep.admittance[50]);
    // Repeated frequencies are averaged.
    let twice: String = table(0.04, (0..200).flat_map(|n| [39e3 + 10.0 * f64::from(n); 2]));
    let sweep = parse("a.csv", &twice, &Options::default()).unwrap();
    assert!(
        sweep.hz.len() == 200 && sweep.remarks.iter().any(|remark| remark.contains("measured 2 times")),
        "{:?}",
        sweep.remarks
    );
}

#[test]
fn damaged_files_do_not_panic() {
    let small: Vec<Example> = (0..).map(Example::draw).filter(|example| example.hz.len() == 101).take(12).collect();
    for number in 0..150 {
        let example = &small[number as usize % small.len()];
        let bytes = mutated(&example.bytes, number);
        let _ = Measured::parse(&example.name, &bytes, &example.options).and_then(|sweep| fit("damaged", sweep, None));
    }
}

/// Computed curves have rounding errors only, and a loss or a wide band leaves other ones.
#[test]
fn the_circuit_is_exact_without_noise() {
    let lossy = |hz: f64, tan: f64| admittance(hz, 2e-3) + std::f64::consts::TAU * hz * 1e-9 * tan;
    for (tan, from_hz, step_hz, points) in [(0.0, 39e3, 20.0, 101), (4e-3, 38e3, 10.0, 401), (4e-3, 20e3, 30.0, 2001)] {
        for (heading, is_impedance) in [("R_ohm X_ohm", true), ("G_s B_s", false)] {
            let line = |hz: f64| {
                let y = lossy(hz, tan);
                let shown = if is_impedance { y.inv() } else { y };
                format!("{hz} {:e} {:e}\n", shown.re, shown.im)
            };
            let text: String = (0..points).map(|n| line(from_hz + step_hz * f64::from(n))).collect();
            let sweep = parse("exact.txt", &format!("f_hz {heading}\n{text}"), &Options::default()).unwrap();
            let found = fit("exact", sweep, None).unwrap_or_else(|error| panic!("{heading} {tan}: {error}"));
            assert!(
                found.modes.len() == 1 && !found.is_doubtful() && found.warnings.is_empty(),
                "{:?} {:?}",
                found.modes,
                found.warnings
            );
            let c = found.circuit;
            for (value, truth) in [(c.series_resonance_hz, 40e3), (c.q, 100.0), (c.rm_ohm, 500.0), (c.c0_f, 1e-9)] {
                assert!((value.value / truth - 1.0).abs() < 1e-9, "{c:?}");
                assert!(value.sd > 0.0 && value.sd < 1e-8 * truth, "{c:?}");
            }
        }
    }
}

#[test]
fn written_scenes_are_valid() {
    let few = (2000..).map(|number| (number, Example::draw(number))).filter(|(_, example)| example.hz.len() <= 201);
    for (number, example) in few.take(12) {
        let found: Admittance = example.import().unwrap();
        let text = found.scene("a \"file\".s1p").unwrap();
        let loaded = scene::load::load_text("imported", &text, &[]);
        assert!(loaded.is_ok(), "{number}:\n{text}\n{}", loaded.err().map(|error| error.to_string()).unwrap_or_default());
    }
}

#[test]
fn rounded_frequencies_are_refused_with_the_step() {
    let hz = (0..40).map(|n| (39e3 + 300.0 * f64::from(n)) / 1e3).map(|khz| khz.round() * 1e3);
    let error = refused("rounded.csv", &table(1e-3, hz));
    assert!(error.starts_with("neighbouring frequencies are equal: lines 2 and 3 both have 39000 Hz"), "{error}");
    assert!(error.contains("has rounded the frequencies to 1 kHz"), "{error}");
}

#[test]
fn a_capacitor_has_no_resonance() {
    let error = refused("capacitor.csv", &table(0.0, (0..201).map(|n| 39e3 + 10.0 * f64::from(n))));
    assert!(error.starts_with("no resonance in the range from 39000 to 41000 Hz: "), "{error}");
}

#[test]
fn too_few_points_are_refused_with_their_number() {
    let error = refused("few.csv", &table(1e-3, (0..8).map(|n| 39.6e3 + 100.0 * f64::from(n))));
    assert!(error.starts_with("too few points: 8; a circuit with 1 resonance(s) has 5 parameters and needs 9"), "{error}");
}

#[test]
fn the_content_of_an_unknown_format_is_reported() {
    let error = refused("letter.csv", "Dear colleague,\nthe transducer is broken.\n");
    assert!(error.contains("it begins with `Dear colleague,`"), "{error}");
    let error = refused("plain.csv", "40000 1 2\n40001 1 2\n");
    assert!(error.contains("3 columns without a heading"), "{error}");
    let error = refused("time.csv", "t [s],u [V]\n0,1\n1,2\n");
    assert!(error.contains("the columns are `t [s]`, `u [V]`: no column is the frequency"), "{error}");
}

#[test]
fn doubtful_and_missing_units_are_refused() {
    let text = "f [Hz],|Z|,phase\n40000,100,-0.3\n40001,101,-0.2\n";
    let error = refused("z.csv", text);
    assert!(error.starts_with("unit missing: the column `|Z|` has no unit"), "{error}");
    let with = |units: &[&str]| {
        let options = Options { units: Units::parse(units.iter().copied()).unwrap(), ..Options::default() };
        parse("z.csv", text, &options).map_err(|error| error.to_string())
    };
    assert!(with(&["ohm"]).is_err_and(|error| error.starts_with("degrees or radians?")));
    assert!(with(&["ohm", "deg"]).is_ok());
}

#[test]
fn an_ambiguous_two_port_file_is_refused() {
    let line = |n: u32| format!("{} 0.1 0.2 0.3 -0.4 0.3 -0.4 0.1 0.2\n", 40_000 + n);
    let error = refused("x.s2p", &format!("# Hz S RI R 50\n{}", (0..40).map(line).collect::<String>()));
    assert!(error.starts_with("series-through or shunt-through?"), "{error}");
}

/// Returns a sweep of the conductance `g`, S, with relative noise and its correlation.
fn sweep(rows: u32, g: f64, noise: f64, rho: f64) -> Measured {
    let mut state = 0x9e37_79b9_7f4a_7c15 ^ u64::from(rows);
    let mut part = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as f64 / u64::MAX as f64 - 0.5
    };
    let mut normal = || (0..12).map(|_| part()).sum::<f64>();
    let mut last = num_complex::Complex64::ZERO;
    let hz: Vec<f64> = (0..rows).map(|n| 39e3 + 2e3 * f64::from(n) / f64::from(rows)).collect();
    let reading = |hz: &f64| {
        last = rho * last + (1.0 - rho * rho).sqrt() * num_complex::Complex64::new(normal(), normal());
        admittance(*hz, g) * (1.0 + noise * last)
    };
    let seen: Vec<_> = hz.iter().map(reading).collect();
    Measured { hz, admittance: seen.clone(), seen, fixture: Vec::new(), coordinate: Coordinate::Immittance, remarks: Vec::new() }
}

#[test]
fn many_rows_have_the_circuit_of_few_with_the_uncertainty_of_many() {
    for (noise, rho) in [(1e-3, 0.0), (1e-5, 0.0), (1e-3, 0.9)] {
        let [few, many] = [3_000, 300_000].map(|rows| fit("rows", sweep(rows, 2e-3, noise, rho), None).unwrap());
        let values = |found: &Admittance| {
            let c = &found.circuit;
            [c.series_resonance_hz, c.q, c.rm_ohm, c.c0_f]
        };
        for ((few, many), truth) in values(&few).into_iter().zip(values(&many)).zip([40e3, 100.0, 500.0, 1e-9]) {
            let far = |value: Value, truth: f64| (value.value - truth).abs() > 4.0 * value.sd;
            assert!(!far(many, truth) && !far(few, many.value), "{noise} {rho}: {many:?} {few:?}");
            assert!((7.0..13.0).contains(&(few.sd / many.sd)), "{noise} {rho}: {many:?} {few:?}");
        }
        assert_eq!((many.residuals.len(), many.modes.len()), (300_000, 1));
        assert!((many.noise[0] / noise - 1.0).abs() < 0.05, "{:?}", many.noise);
    }
    assert!(fit("noise", sweep(20_001, 0.0, 30.0, 0.0), None).is_err());
}
