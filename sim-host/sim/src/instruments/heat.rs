//! Self-heating of a stack: temperature, losses, thermal runaway, and limits of the ceramic.

use super::curves::{axis, curve, shaded};
use super::{Instrument, Line, View};
use crate::metrics::Metrics;
use firmware::guard::DERATE_K;
use plant::truth::HeatTruth;
use report::statistics::mean;
use report::{Figure, Style};
use scene::Thermal;

/// Instrument of driven scenes with `[stack.thermal]`.
pub(super) struct Heat;

impl Instrument for Heat {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        let Some(thermal) = thermal(run) else { return };
        metrics.put("stack_temperature_k", all(run).last().map(|(_, heat)| heat.temperature_k));
        metrics.put("peak_stack_temperature_k", all(run).map(|(_, heat)| heat.temperature_k).reduce(f64::max));
        metrics.put("stack_heating_w", mean(steady(run).map(|heat| heat.heating_w)));
        metrics.put("thermal_gain", mean(steady(run).map(|heat| heat.gain)));
        metrics
            .put("lasting_stack_temperature_k", mean(steady(run).map(|heat| heat.lasting_k)).filter(|kelvin| !kelvin.is_nan()));
        let hot = all(run).filter(|(_, heat)| thermal.ambient_c + heat.temperature_k >= thermal.hottest_c()).count();
        metrics.put("depoling_time_ms", 1e3 * run.block_s * hot as f64);
    }

    fn headline(&self) -> &'static [Line] {
        &[("stack temperature above ambient", "peak_stack_temperature_k", "K")]
    }

    fn remarks(&self, run: &View) -> Vec<String> {
        let Some(thermal) = thermal(run) else { return Vec::new() };
        let first = |is: &dyn Fn(&HeatTruth) -> bool| all(run).find(|(_, heat)| is(heat)).map(|(time_s, _)| time_s);
        let runaway = first(&|heat| heat.gain >= 1.0).map(|s| {
            let gain = all(run).map(|(_, heat)| heat.gain).fold(0.0, f64::max);
            format!(
                "Thermal runaway from {s:.3} s on: at this motional current, one kelvin adds {gain:.2} times as much loss as it \
                 removes. The stack has no steady temperature while the current is held."
            )
        });
        let hottest = thermal.hottest_c();
        let depoling = first(&|heat| thermal.ambient_c + heat.temperature_k >= hottest).map(|s| {
            let of = if thermal.depoling_c.is_some() { "`stack.thermal.depoling_c`" } else { "half its Curie point" };
            format!(
                "The stack is above {hottest:.1} °C, {of}, from {s:.3} s on. It slowly loses its polarisation there, which is \
                 not simulated: later results are too good."
            )
        });
        let depoled = first(&|heat| heat.depoled).map(|s| {
            format!(
                "The stack reaches its Curie point of {:.1} °C at {s:.3} s and loses its polarisation (as by the fault \
                     `depoled`).",
                thermal.curie_c
            )
        });
        let limit_c = run.scene.controller.limits.temperature_c;
        let excess = all(run).map(|(_, heat)| thermal.ambient_c + heat.temperature_k - limit_c).fold(0.0, f64::max);
        let unnoticed = (excess > 0.0 && run.rows.iter().all(|row| row.fault == 0)).then(|| {
            format!(
                "The stack exceeds `controller.limits.temperature_c` by {excess:.1} K, and the controller has not noticed it. \
                 `[controller.thermometer]` tells it how to infer the temperature."
            )
        });
        [runaway, depoling, depoled, unnoticed].into_iter().flatten().collect()
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        temperature(run).into_iter().collect()
    }
}

/// Returns the thermal model of the scene's stack, if it has one.
fn thermal(run: &View) -> Option<Thermal> {
    match run.scene.transducer {
        scene::Transducer::Stack(stack, _) => stack.thermal,
        scene::Transducer::Stator(..) => None,
    }
}

/// Returns all blocks, with their times, s.
fn all<'a>(run: &View<'a>) -> impl Iterator<Item = (f64, &'a HeatTruth)> {
    run.rows.iter().filter_map(|row| Some((row.time_s, row.truth.heat.as_ref()?)))
}

/// Returns the steady blocks.
fn steady<'a>(run: &'a View) -> impl Iterator<Item = &'a HeatTruth> {
    run.steady().filter_map(|row| row.truth.heat.as_ref())
}

/// Returns the figure of the true temperature over the run, with the limits.
fn temperature(run: &View) -> Option<Figure> {
    let thermal = thermal(run)?;
    let of = |value: fn(&HeatTruth) -> f64| move |row: &crate::record::Row| row.truth.heat.as_ref().map_or(f64::NAN, value);
    let limits = &run.scene.controller.limits;
    let highest = all(run).map(|(_, heat)| heat.temperature_k).fold(0.0, f64::max);
    let lines = [
        (limits.temperature_c - f64::from(DERATE_K), "derating begins"),
        (limits.temperature_c, "controller's limit"),
        (thermal.hottest_c(), "ceramic's limit"),
    ];
    // A limit far above the curve would compress it.
    let shown = lines
        .into_iter()
        .map(|(celsius, name)| (celsius - thermal.ambient_c, name))
        .filter(|(kelvin, _)| *kelvin < 2.0 * highest);
    Some(Figure {
        id: "stack-temperature".into(),
        title: "Temperature of the stack".into(),
        caption: "The stack is modelled as one body heated by its losses.".into(),
        x: axis("time [s]"),
        y: axis("temperature over ambient [K]"),
        series: vec![curve(run.rows, "truth", "stack_temperature_k", Style::Line, of(|heat| heat.temperature_k))],
        hlines: shown.map(|(kelvin, name)| (kelvin, name.to_owned())).collect(),
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    })
}
