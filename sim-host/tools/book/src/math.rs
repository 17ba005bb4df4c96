//! Equations as MathML, which browsers typeset without a script: fenced blocks of the language
//! `math`, and spans between ``$` `` and `` `$ ``, as on GitHub.

use anyhow::{Context, bail};
use pulldown_latex::config::DisplayMode;
use pulldown_latex::{Parser, RenderConfig, Storage, push_mathml};

const FENCE: &str = "```";
const OPENS: &str = "$`";
const CLOSES: &str = "`$";

/// Returns a page with its equations typeset.
///
/// # Errors
/// An equation is not valid LaTeX, or has no end.
pub fn typeset(page: &str) -> anyhow::Result<String> {
    let mut out = String::with_capacity(page.len());
    let mut lines = page.lines();
    let mut in_code = false;
    while let Some(line) = lines.next() {
        if !in_code && line.trim_end() == "```math" {
            let equation: Vec<&str> = lines.by_ref().take_while(|line| line.trim_end() != FENCE).collect();
            // A div is one block of HTML as long as it has no empty line.
            out += &format!("<div class=\"equation\">{}</div>\n", mathml(&equation.join("\n"), DisplayMode::Block)?);
            continue;
        }
        if line.trim_start().starts_with(FENCE) {
            in_code = !in_code;
        }
        out += &if in_code { line.to_owned() } else { spans(line)? };
        out.push('\n');
    }
    Ok(out)
}

/// Returns a line with its equations typeset.
fn spans(line: &str) -> anyhow::Result<String> {
    let mut out = String::new();
    let mut rest = line;
    while let Some((before, after)) = rest.split_once(OPENS) {
        let (equation, next) = after.split_once(CLOSES).with_context(|| format!("an equation has no end: {after}"))?;
        out += before;
        out += &mathml(equation, DisplayMode::Inline)?;
        rest = next;
    }
    Ok(out + rest)
}

fn mathml(latex: &str, display_mode: DisplayMode) -> anyhow::Result<String> {
    let storage = Storage::new();
    let events: Vec<_> = Parser::new(latex, &storage).collect();
    if let Some(Err(error)) = events.iter().find(|event| event.is_err()) {
        bail!("{latex}: {error}");
    }
    let mut out = String::new();
    let config = RenderConfig { display_mode, annotation: Some(latex), ..RenderConfig::default() };
    push_mathml(&mut out, events.into_iter(), config)?;
    Ok(out.replace('\n', " "))
}
