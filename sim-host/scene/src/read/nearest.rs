//! Search for similar names, and short forms of names and numbers for messages.

/// Returns the names similar enough to be misspelled, the most similar first.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let plain = |name: &str| name.to_lowercase().replace(['-', ' '], "_");
    let name = plain(name);
    let similar = |candidate: &'a str| {
        let likeness = strsim::normalized_damerau_levenshtein(&name, &plain(candidate));
        let begins_so = name.len() >= 3 && candidate.starts_with(&name);
        let enough = if name.len() <= 3 { 0.5 } else { 0.6 };
        (likeness >= enough || begins_so).then_some((candidate, likeness))
    };
    let mut found: Vec<_> = candidates.into_iter().filter_map(similar).collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(b.0)));
    found.into_iter().map(|(candidate, _)| candidate).collect()
}

/// Returns the names in backquotes, separated by commas and, before the last, the word `last`.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>, last: &str) -> String {
    let quoted: Vec<_> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [] => String::new(),
        [single] => single.clone(),
        [most @ .., end] => format!("{} {last} {end}", most.join(", ")),
    }
}

/// Shortens a key or string of the user for a message.
pub fn short(text: &str) -> String {
    const MAX_CHARS: usize = 60;
    match text.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// Formats a number in the usual way, with at most ten digits.
pub fn shown(number: f64) -> String {
    let rounded: f64 = format!("{number:.9e}").parse().unwrap_or(number);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_names_are_found_and_others_not() {
        assert_eq!(nearest("dutty", ["duty", "period_s"]), ["duty"]);
        assert_eq!(nearest("Duration-S", ["duration_s"]), ["duration_s"]);
        assert!(nearest("colour", ["duty", "period_s"]).is_empty());
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(shown(0.1 + 0.2), "0.3");
        assert_eq!(shown(450e3), "450000");
        assert_eq!(shown(1e-12), "1e-12");
        assert_eq!(shown(-0.5), "-0.5");
        assert_eq!(shown(0.0), "0");
    }
}
