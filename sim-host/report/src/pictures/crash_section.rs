//! The crash view, as a section of the page.
//!
//! `assets/crash.js` draws it. Nothing moves on its own, and there is no animation if the reader's
//! system requests reduced motion. Buttons move to the next or previous important moment, and a
//! slider to any moment.

use crate::crash_view::{CrashView, Instant};

const STYLE: &str = include_str!("../../assets/crash.css");
const SCRIPT: &str = include_str!("../../assets/crash.js");

/// Introduction for the reader, before the view.
const LEAD: &str = "The car stops, but the person in it keeps moving. The shoulder belt catches them. It runs from the \
     shoulder over a steel ring on the pillar, the D-ring, down to a reel. The reel yields at a set force, so that the belt \
     does not cut in. Friction at the ring more than doubles that force on its way to the shoulder. For a light person this is \
     more than needed. Ultrasound in the ring can make it slippery, so that less force reaches the shoulder. The price: the \
     person moves further forward. The picture is not to scale.";

/// Returns the view as a section of the page, with style, data and script.
pub(super) fn section(view: &CrashView) -> Result<String, String> {
    let rounded = CrashView { instants: view.instants.iter().map(Instant::rounded).collect(), ..view.clone() };
    let data = serde_json::to_string(&rounded).map_err(|error| error.to_string())?.replace('<', "\\u003c");
    Ok(format!(
        "<section id=\"crash-view\" class=\"crash\">\n<style>\n{STYLE}</style>\n<h2>The crash, step by step</h2>\n\
         <p class=\"prose\">{LEAD}</p>\n<noscript>This view needs JavaScript; the curves below show the same data.</noscript>\n\
         <div class=\"card\" id=\"crash-stage\" hidden>\n\
         <div class=\"crash-pair\"><svg viewBox=\"0 0 460 330\" role=\"img\" \
         aria-label=\"passive belt, as in today's cars\"></svg>\
         <svg viewBox=\"0 0 460 330\" role=\"img\" aria-label=\"belt with switched friction\"></svg></div>\n\
         <p class=\"crash-story\" aria-live=\"polite\"></p>\n\
         <div class=\"crash-controls\"><button type=\"button\" data-go=\"-1\">◀ previous moment</button>\
         <button type=\"button\" data-play>Play, 80 times slower</button>\
         <button type=\"button\" data-go=\"1\">next moment ▶</button>\
         <label>time <input type=\"range\" min=\"0\" step=\"1\" value=\"0\"></label><output></output></div>\n\
         <svg class=\"crash-bars\" viewBox=\"0 0 940 250\" role=\"img\" aria-label=\"force at the shoulder over time, as bars\"></svg>\n\
         </div>\n<script id=\"crash-data\" type=\"application/json\">{data}</script>\n<script>\n{SCRIPT}</script>\n</section>\n"
    ))
}

impl Instant {
    /// Returns the instant rounded to a tenth of a millimetre and to a newton.
    fn rounded(&self) -> Instant {
        let to = |value: f64, parts: f64| (value * parts).round() / parts;
        Instant {
            ms: to(self.ms, 100.0),
            low: to(self.low, 100.0),
            pulse_g: to(self.pulse_g, 100.0),
            mm: self.mm.map(|mm| to(mm, 10.0)),
            newton: self.newton.map(|newton| to(newton, 1.0)),
            payout_mm: self.payout_mm.map(|mm| to(mm, 10.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_text_is_escaped() {
        let view = CrashView { occupant: "</script><b>".into(), instants: vec![Instant::default()], ..CrashView::default() };
        let html = section(&view).unwrap();
        assert_eq!(html.matches("</script>").count(), 2);
        assert!(!html.contains("<b>") && !html.contains("http"));
    }
}
