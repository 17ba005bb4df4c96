//! Prints the drive hashes of the built-in scenes on this machine, as JSON. The page compares its
//! own hashes with them.
//!
//! By scene name: the hash of the scene as the page opens it, and that of the unchanged scene.

use rayon::prelude::*;
use serde_json::{Map, Value, json};
use sonoglide_web::{Request, Session, scenes};

fn main() -> Result<(), String> {
    let scenes = scenes();
    let driven: Vec<_> = scenes.iter().filter(|entry| entry.driven).collect();
    let pairs: Vec<(String, Value)> = driven
        .par_iter()
        .map(|entry| {
            let whole = hash(entry.name, Vec::new())?;
            let opened = if entry.sets.is_empty() { whole.clone() } else { hash(entry.name, entry.sets.clone())? };
            Ok((entry.name.to_owned(), json!({ "opened": opened, "whole": whole })))
        })
        .collect::<Result<_, String>>()?;
    println!("{}", Value::from(pairs.into_iter().collect::<Map<_, _>>()));
    Ok(())
}

fn hash(name: &str, sets: Vec<String>) -> Result<String, String> {
    let request = Request { name: name.to_owned(), sets, ..Request::default() };
    let result = Session::default().run(&request, None).map_err(|error| format!("{name}: {error}"))?;
    let hash = result["drive_hash"].as_str().ok_or_else(|| format!("{name} has no drive hash"))?;
    Ok(hash.to_owned())
}
