//! Figures of a belt under a horn: pull over time, and reduction over ON time and over load.

use crate::instruments::View;
use crate::instruments::curves::{axis, binned, curve, mean, shaded};
use crate::record::Row;
use contact::empirical::reached;
use report::{Figure, Marker, Series, Style};

/// Loads in addition to the scene's own, N.
const LOADS_N: [f64; 3] = [270.0, 450.0, 670.0];
/// Number of points of a closed-form curve.
const POINTS: u32 = 120;
/// Minimum ON time that is drawn, s.
const LONGEST_S: f64 = 3.0;

/// Returns all figures; none without a belt.
pub(super) fn all(run: &View) -> Vec<Figure> {
    [pull(run), over_on_time(run), over_load(run)].into_iter().flatten().collect()
}

fn pull(run: &View) -> Option<Figure> {
    let (contact, belt) = run.scene.belt()?;
    let rows = run.rows;
    let would = |row: &Row| contact.mu * belt.load_n * (1.0 - row.truth.horn.map_or(0.0, |horn| horn.lasting_reduction));
    let cell_hz = run.scene.sensors.load_cell_hz;
    Some(Figure {
        id: "friction".into(),
        title: "Pull of the belt, switched by ultrasound".into(),
        caption: "The horn reaches its amplitude within milliseconds; the pull follows with the lag of the rig. Dashed: pull by \
                  the law if the present amplitude lasted. Before the first ON window, calibration and lock also vibrate the \
                  belt. The reduction is FITTED to the thesis; mu is assumed."
            .into(),
        x: axis("time [s]"),
        y: axis("pull of the belt [N]"),
        series: vec![
            curve(rows, "if the amplitude lasted", "friction_lasting_n", Style::Dashed, would),
            curve(rows, "true pull", "friction_true_n", Style::Line, |row| row.truth.friction_mean_n.abs()),
            curve(rows, &format!("load cell ({cell_hz} Hz)"), "load_cell_n", Style::Dashed, |row| row.truth.load_cell_n.abs()),
        ],
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    })
}

fn over_on_time(run: &View) -> Option<Figure> {
    let (contact, belt) = run.scene.belt()?;
    let (from_s, to_s) = run.belt_window()?;
    let rest_n = contact.mu * belt.load_n;
    let rows = run.after(from_s);
    let rows = &rows[..rows.partition_point(|row| row.time_s <= to_s)];
    if rows.len() < 2 {
        return None;
    }
    let percent = |row: &Row| 100.0 * (1.0 - row.truth.friction_mean_n.abs() / rest_n);
    let (x, y) = binned(rows).map(|bin| (mean(bin, |row| row.time_s) - from_s, mean(bin, percent))).unzip();
    let as_run = format!("this run: {} N, {} %", belt.load_n, 100.0 * belt.amplitude_fraction);
    let mut series = vec![Series { name: as_run, csv_column: "reduction_percent".into(), x, y, style: Style::Line }];
    let time: Vec<f64> = (0..=POINTS).map(|n| f64::from(n) / f64::from(POINTS) * LONGEST_S.max(to_s - from_s)).collect();
    for load in LOADS_N {
        let lasting = contact.law().lasting(load, belt.speed_m_per_s, belt.amplitude_fraction);
        let y = time.iter().map(|&on_s| 100.0 * reached(lasting, on_s, belt.lag_s)).collect();
        let (name, csv_column) = (format!("law, {load} N"), format!("law_{load}_n_percent"));
        series.push(Series { name, csv_column, x: time.clone(), y, style: Style::Dashed });
    }
    Some(Figure {
        id: "reduction-on-time".into(),
        title: "Reduction over the ON time".into(),
        caption: format!(
            "A shorter window has the same curve up to its end. Of the lasting reduction, {:.0} % is reached after 0.5 s, {:.0} \
             % after 1 s and {:.0} % after 2 s. FITTED lag of {} s.",
            100.0 * reached(1.0, 0.5, belt.lag_s),
            100.0 * reached(1.0, 1.0, belt.lag_s),
            100.0 * reached(1.0, 2.0, belt.lag_s),
            belt.lag_s
        ),
        x: axis("time since the horn is ON [s]"),
        y: axis("reduction [%]"),
        series,
        interactive: true,
        ..Figure::default()
    })
}

fn over_load(run: &View) -> Option<Figure> {
    let (contact, belt) = run.scene.belt()?;
    let (from_s, to_s) = run.belt_window()?;
    let last = run.after(from_s).iter().take_while(|row| row.time_s <= to_s).last()?;
    let got = 100.0 * (1.0 - last.truth.friction_mean_n.abs() / (contact.mu * belt.load_n));
    let load: Vec<f64> = (0..=POINTS).map(|n| 200.0 + 600.0 * f64::from(n) / f64::from(POINTS)).collect();
    let mut amplitudes = vec![0.5, 0.7, 1.0];
    if !amplitudes.contains(&belt.amplitude_fraction) {
        amplitudes.push(belt.amplitude_fraction);
    }
    let of = |amplitude: f64| {
        let at =
            |&load: &f64| 100.0 * reached(contact.law().lasting(load, belt.speed_m_per_s, amplitude), to_s - from_s, belt.lag_s);
        let percent = 100.0 * amplitude;
        let style = if (0.5..=0.7).contains(&amplitude) { Style::Line } else { Style::Dashed };
        let (name, csv_column) = (format!("law, {percent} %"), format!("law_{percent}_percent"));
        Series { name, csv_column, x: load.clone(), y: load.iter().map(at).collect(), style }
    };
    Some(Figure {
        id: "reduction-load".into(),
        title: format!("Reduction over the load, ON for {:.3} s", to_s - from_s),
        caption: "The fitted law with its lag, and this run. Tests were made at 270, 450 and 670 N with 50 and 70 %. Elsewhere \
                  (dashed: other amplitudes) the law is only a fitted curve, and its hump at 50 % has no meaning."
            .into(),
        x: axis("load [N]"),
        y: axis("reduction [%]"),
        series: amplitudes.into_iter().map(of).collect(),
        markers: vec![Marker { x: belt.load_n, y: got, label: "this run".into() }],
        interactive: true,
        ..Figure::default()
    })
}
