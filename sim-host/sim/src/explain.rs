//! Explanation of a word: a metric, a machine figure, a fault, a limit, a key of a scene, a choice
//! of a key, a term of the glossary, a file or a column of it.

mod glossary;
mod notes;

use firmware::seam::fault::{Fault, Limit};

use crate::data::{FIGURES, FigureData, files};
use scene::all_keys::{Key, Repeats, keys};
use scene::metrics::{MACHINE, METRICS, Metric, RENAMED, machine_figure, metric, of_one_run, renamed};
use scene::nearest::nearest;
use scene::schema::{Kind, Schema};

use glossary::TERMS;
pub use glossary::page as glossary_page;
pub(crate) use notes::note;

/// Maximum number of suggestions for an unknown word.
const MAX_SUGGESTIONS: usize = 3;
/// File name extensions of a figure.
const FIGURE_FILES: [&str; 3] = [".csv", ".svg", ".png"];

/// Explains a word, with one text for each thing of this name.
///
/// # Errors
/// If nothing has this name; the error contains the nearest names.
///
/// ```
/// use sonoglide_sim::explain::explain;
///
/// let texts = explain("friction_ratio").expect("a metric");
/// assert!(texts[0].starts_with("friction_ratio: metric"));
/// assert!(explain("fault 21").expect("a fault")[0].contains("over-current"));
/// assert_eq!(explain("frictoin_ratio").unwrap_err()[0], "friction_ratio");
/// ```
pub fn explain(word: &str) -> Result<Vec<String>, Vec<String>> {
    let word = word.trim().trim_matches(['`', '[', ']']);
    let keys = keys();
    let mut texts: Vec<String> = Vec::new();
    texts.extend(metric(word).or_else(|| of_one_run(word)).map(|metric| of_metric(word, metric)));
    if let Some(present) = renamed(word).and_then(metric) {
        texts.push(format!(
            "{word}: former name of {}\n  if a run has no metric `{word}`, it is read as `{}`",
            present.name, present.name
        ));
    }
    let machine = machine_figure(word);
    texts.extend(machine.map(|figure| {
        paragraph(&format!("{word}: machine figure"), figure.meaning, &[("unit", figure.unit), ("file", "machine.json")])
    }));
    texts.extend(
        Fault::ALL
            .iter()
            .filter(|fault| is_called(word, "fault", fault.code(), fault.called(), &format!("{fault:?}")))
            .map(|fault| numbered(("fault", fault.code(), fault.called()), fault.meaning(), fault.remedy(), fault.place())),
    );
    texts.extend(
        Limit::ALL
            .iter()
            .filter(|limit| is_called(word, "limit", limit.code(), limit.called(), &format!("{limit:?}")))
            .map(|limit| numbered(("limit", limit.code(), limit.called()), limit.meaning(), limit.remedy(), limit.place())),
    );
    // The key of a list of tables may have an index: `fault.0.kind`.
    let names = word.split('.').filter(|name| name.parse::<u16>().is_err()).collect::<Vec<_>>().join(".");
    let ends_so = |path: &str| path == names || path.strip_suffix(&names).is_some_and(|tables| tables.ends_with('.'));
    texts.extend(keys.iter().filter(|key| ends_so(&key.path)).map(of_key));
    texts.extend(of_choices(word));
    texts.extend(
        TERMS
            .iter()
            .filter(|(names, ..)| glossary::is_named(names, word))
            .map(|(names, meaning, more)| paragraph(&format!("{names}: term"), meaning, &[("see", &format!("docs/{more}.md"))])),
    );
    texts.extend(of_files(word));
    if texts.is_empty() { Err(suggestions(word, &keys)) } else { Ok(texts) }
}

/// Lists all names that can be explained.
pub fn list() -> String {
    let names = |title: &str, names: Vec<String>| format!("{title}\n  {}\n\n", names.join("\n  "));
    let mut text = names("metrics", METRICS.iter().map(|metric| metric.name.to_owned()).collect());
    text += &names("machine figures", MACHINE.iter().map(|figure| figure.name.to_owned()).collect());
    text += &names("faults", Fault::ALL.iter().map(|fault| format!("{} {}", fault.code(), fault.called())).collect());
    text += &names("limits", Limit::ALL.iter().map(|limit| format!("{} {}", limit.code(), limit.called())).collect());
    let mut named: Vec<String> = files().iter().map(|file| file.name.to_owned()).collect();
    named.dedup();
    named.extend(FIGURES.iter().map(|figure| format!("{}.csv", figure.id)));
    text += &names("files", named);
    text += &names("terms", TERMS.iter().map(|(names, ..)| names.split(", ").next().unwrap_or(names).to_owned()).collect());
    text + &names("keys of a scene", keys().into_iter().filter(|key| key.table.is_none()).map(|key| key.path).collect())
}

fn of_metric(word: &str, metric: &Metric) -> String {
    let several = match word {
        word if word.ends_with("_low95") => "for several runs, the lower end of the interval that contains 95 % of them",
        word if word.ends_with("_high95") => "for several runs, the upper end of the interval that contains 95 % of them",
        word if word.ends_with("_p95") && word != metric.name => "for several runs, the value that 95 % of them do not exceed",
        word if word.ends_with("_max") && word != metric.name => "for several runs, the largest value",
        _ => metric.sign.meaning(),
    };
    let former = RENAMED.iter().filter(|(_, present)| *present == metric.name).map(|(former, _)| *former);
    let former = former.collect::<Vec<_>>().join(", ");
    let over = format!("{}: {}", metric.window.name(), metric.window.meaning());
    let mut lines = vec![("unit", metric.unit), ("values", several), ("measured", &over)];
    if !former.is_empty() {
        lines.push(("formerly", &former));
    }
    paragraph(&format!("{word}: metric"), metric.meaning, &lines)
}

fn numbered((kind, code, called): (&str, u8, &str), meaning: &str, remedy: &str, place: &str) -> String {
    let [cause, check, command] = note(code);
    let example = if command.is_empty() { String::new() } else { format!("sim-host {command}") };
    let lines = [("cause", cause), ("check", check), ("remedy", remedy), ("example", &example), ("see", place)];
    paragraph(&format!("{kind} {code}: {called}"), meaning, &lines)
}

/// Explains a value of keys with choices, such as the kind of a fault.
fn of_choices(word: &str) -> Vec<String> {
    let mut texts = Vec::new();
    for (path, table) in Schema::tables() {
        for (name, schema) in table.properties().filter(|(_, schema)| schema.kind() == Kind::Choice) {
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            let meanings = schema.described_choices().into_iter().filter(|(choice, _)| *choice == word);
            texts.extend(
                meanings.map(|(_, meaning)| paragraph(&format!("{word}: value of `{path}`"), &meaning.replace('\n', " "), &[])),
            );
        }
    }
    texts
}

/// Returns `true` if a word is the number or the name of a fault or limit, optionally after its
/// kind.
fn is_called(word: &str, kind: &str, code: u8, called: &str, variant: &str) -> bool {
    let word = word.strip_prefix(kind).map_or(word, |rest| rest.trim_start_matches([' ', '-', '_']));
    let plain = |name: &str| name.to_lowercase().replace(['-', '_', ' '], "");
    word.parse() == Ok(code) || [called, variant].iter().any(|name| plain(name) == plain(word))
}

fn of_key(key: &Key) -> String {
    let title = match key.table {
        Some(Repeats::Once) => format!("[{}]: table of a scene", key.path),
        Some(Repeats::Several) => format!("[[{}]]: tables of a scene, may repeat", key.path),
        None => format!("{}: key of a scene", key.path),
    };
    let unit = key.unit.as_deref().unwrap_or_default();
    paragraph(&title, &key.meaning, &[("unit", unit), ("values", &key.range), ("default", &key.default)])
}

fn of_files(word: &str) -> Vec<String> {
    let mut texts = Vec::new();
    for file in files() {
        if file.name == word {
            let mut text = paragraph(&format!("{word}: file of {}", file.of), file.meaning, &[]);
            for column in &file.columns {
                let unit = if column.unit.is_empty() { String::new() } else { format!(" [{}]", column.unit) };
                text += &format!("\n  {}{unit}: {}", column.name, column.meaning);
            }
            texts.push(text);
        }
        // Metrics and machine figures are already explained above.
        let known = metric(word).is_some() || machine_figure(word).is_some();
        texts.extend(file.columns.iter().filter(|column| column.name == word && !known).map(|column| {
            paragraph(&format!("{word}: field of {} of {}", file.name, file.of), &column.meaning, &[("unit", &column.unit)])
        }));
    }
    let id = FIGURE_FILES.iter().find_map(|end| word.strip_suffix(end)).unwrap_or(word);
    texts.extend(FigureData::of(id).filter(|_| id != word || texts.is_empty()).map(|figure| {
        let columns = figure.columns.join(", ");
        paragraph(&format!("{id}.csv, {id}.svg, {id}.png: a figure"), figure.meaning, &[("x", figure.x), ("columns", &columns)])
    }));
    texts
}

/// Formats a title, a sentence and labelled lines; empty lines are omitted.
fn paragraph(title: &str, meaning: &str, lines: &[(&str, &str)]) -> String {
    let mut text = format!("{title}\n  {meaning}");
    for (label, line) in lines.iter().filter(|(_, line)| !line.is_empty()) {
        text += &format!("\n  {label:10}{line}");
    }
    text
}

fn suggestions(word: &str, keys: &[Key]) -> Vec<String> {
    let metrics = METRICS.iter().map(|metric| metric.name).chain(MACHINE.iter().map(|figure| figure.name));
    let ends = keys.iter().map(|key| key.path.rsplit('.').next().unwrap_or(&key.path));
    let files = files();
    let numbered = Fault::ALL.iter().map(|fault| fault.called()).chain(Limit::ALL.iter().map(|limit| limit.called()));
    let files = files.iter().map(|file| file.name);
    // A term that is also a metric is named once, as the metric.
    let terms = TERMS.iter().flat_map(|(names, ..)| names.split(", ")).filter(|term| metric(&term.replace(' ', "_")).is_none());
    let mut near: Vec<&str> = nearest(word, metrics.chain(ends).chain(files).chain(numbered).chain(terms));
    near.dedup();
    near.into_iter().take(MAX_SUGGESTIONS).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(word: &str) -> String {
        explain(word).unwrap_or_else(|near| panic!("{word}: {near:?}")).remove(0)
    }

    #[test]
    fn each_kind_of_word_is_explained() {
        for (word, says) in [
            ("drive_power_w", "formerly  input_power_w"),
            ("lock_time_20hz_ms_p95", "95 %"),
            ("ns_per_period", "machine.json"),
            ("21", "fault 21: over-current"),
            ("LossOfLock", "fault 32"),
            ("loss_of_lock", "fault 32"),
            ("limit 101", "limit 101"),
            ("rig.slider.speed_m_per_s", "unit      m/s"),
            ("[[expect]]", "[[expect]]"),
            ("machine.json", "wall_s [s]"),
            ("trace.csv", "time_s [s]"),
            ("hysteresis.csv", "columns   friction_n"),
            ("fault.0.kind", "fault.kind: key of a scene"),
            ("encoder_lies", "value of `fault.kind`"),
            ("22", "see       docs/faults.md#fault-22"),
            ("SIL", "term"),
        ] {
            assert!(first(word).contains(says), "{word}: {}", first(word));
        }
        assert!(explain("speed_m_per_s").is_ok_and(|texts| texts.len() >= 2), "a key of slider and belt");
    }

    #[test]
    fn every_listed_name_is_explained() {
        for name in list().lines().filter_map(|line| line.strip_prefix("  ")) {
            assert!(explain(name).is_ok() || name.split_once(' ').is_some_and(|(code, _)| explain(code).is_ok()), "{name}");
        }
    }

    #[test]
    fn misspelt_words_get_the_nearest_names() {
        assert_eq!(explain("overshot_percent").unwrap_err(), ["overshoot_percent"]);
        assert!(explain("xyzzy plugh").unwrap_err().is_empty());
    }
}
