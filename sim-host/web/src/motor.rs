//! A travelling-wave motor for the animated view: its waves and its rotor over time.

use std::f64::consts::TAU;

use report::decimate::keep;
use serde::Serialize;
use sim::study::driven::Run;

/// Approximate number of points over the run.
const MAX_POINTS: usize = 3000;

/// The motor over time.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Motor {
    /// Number of waves around the ring.
    waves: f64,
    /// Number of electrode tabs around the ring.
    tabs: u16,
    /// Number of electrical lanes; tab `j` belongs to lane `j` mod 4.
    lanes: u8,
    time_s: Vec<f64>,
    /// Amplitude of the wave that turns the rotor forwards, µm.
    forward_um: Vec<f32>,
    /// Amplitude of the wave in the other direction, µm.
    backward_um: Vec<f32>,
    /// Speed of the rotor, rad/s.
    rotor_rad_per_s: Vec<f32>,
    /// Angle of the rotor since the beginning, rad.
    rotor_rad: Vec<f32>,
    /// Peak drive voltage, V.
    drive_v: Vec<f32>,
    /// Half the angle over which a crest touches, degrees of the wave.
    contact_deg: Vec<f32>,
}

impl Motor {
    /// Collects the motor of a run, if it has a stator.
    pub(crate) fn from_run(run: &Run) -> Option<Self> {
        let stator = run.scene.stator()?;
        let rows = &run.record.rows;
        let motors: Vec<_> = rows.iter().map(|row| run.record.motors.get(row.number as usize)).collect::<Option<_>>()?;
        let time_s: Vec<f64> = rows.iter().map(|row| row.time_s).collect();
        let speed: Vec<f64> = motors.iter().map(|motor| motor.rotor_rad_per_s).collect();
        let forward: Vec<f64> = motors.iter().map(|motor| motor.forward_m).collect();
        let mut before_s = 0.0;
        let turned: Vec<f64> = time_s
            .iter()
            .zip(&speed)
            .scan(0.0, |angle, (&time_s, speed)| {
                *angle += speed * (time_s - before_s);
                before_s = time_s;
                Some(*angle)
            })
            .collect();
        let places = keep(&[&time_s, &speed, &forward], MAX_POINTS);
        let of = |value: &dyn Fn(usize) -> f64| places.iter().map(|&place| value(place) as f32).collect();
        let pitch_m = stator.tab_width_m + stator.tab_gap_m;
        let around_m = rotor_or_tabs_m(run, f64::from(stator.tabs) * pitch_m);
        Some(Motor {
            waves: (around_m / stator.wave_length_m).round().max(1.0),
            tabs: stator.tabs,
            lanes: run.scene.controller.drive.lanes,
            time_s: places.iter().map(|&place| time_s[place]).collect(),
            forward_um: of(&|place| 1e6 * motors[place].forward_m),
            backward_um: of(&|place| 1e6 * motors[place].backward_m),
            rotor_rad_per_s: of(&|place| speed[place]),
            rotor_rad: of(&|place| turned[place]),
            drive_v: of(&|place| rows[place].drive_v),
            contact_deg: of(&|place| motors[place].contact_deg),
        })
    }
}

/// Returns the circumference of the ring, m: by the rotor's radius, otherwise by the tabs.
fn rotor_or_tabs_m(run: &Run, tabs_m: f64) -> f64 {
    run.scene.rotor().map_or(tabs_m, |rotor| TAU * rotor.radius_m)
}
