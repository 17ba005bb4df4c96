//! The circuit of a design as tables of a driven scene.

use std::fmt::Write;

use super::Drawn;

/// Returns the text of `stack.toml`; empty for a design without rings.
pub fn text(drawn: &Drawn, name: &str) -> String {
    let (solved, mut text) = (&drawn.solved, String::new());
    let (Some(branch), Some(circuit)) = (solved.working().branch, &solved.circuit) else { return text };
    let values = [
        ("c0_f", circuit.c0_f),
        ("cm_f", branch.cm_f),
        ("lm_h", branch.lm_h),
        ("rm_ohm", branch.rm_ohm),
        ("force_factor_n_per_v", branch.force_factor_n_per_v),
        ("loss_tangent", circuit.loss_tangent),
    ];
    // Writing to a string cannot fail.
    let _ = writeln!(text, "# Computed from the design `{name}`. Add it to a scene with [controller].\n\n[stack.bvd]");
    for (key, value) in values {
        let _ = writeln!(text, "{key} = {value:e}");
    }
    for mode in circuit.further.iter().map(|&index| &solved.modes[index]) {
        let Some(branch) = mode.branch else { continue };
        let hz = 1.0 / (std::f64::consts::TAU * (branch.lm_h * branch.cm_f).sqrt());
        let _ = writeln!(text, "\n[[stack.mode]]\nseries_resonance_hz = {hz}\nq = {}\nlm_h = {:e}", mode.q, branch.lm_h);
    }
    text
}
