//! Embench: cycles of its programs on an STM32F407 at 16 MHz, without wait states, from its own
//! table.

use std::path::{Path, PathBuf};

use cortex_m4::Timing;

use crate::compile::{self, Program};
use crate::{Error, FLASHES, cycles_of_iteration, hosted};

/// Compiler flags of the baseline.
const FLAGS: &str = "-O2 -ffunction-sections -fdata-sections";

/// Prints a row for each program, and the means.
pub fn measure(folder: &Path) -> Result<(), Error> {
    println!("| Embench, `{FLAGS}` | published cycles | ratio, usual | longest |");
    println!("|---|---|---|---|");
    let mut ratios = Vec::new();
    for (name, milliseconds) in baseline(folder)? {
        // Milliseconds at 16 MHz with a scale of 16 are thousands of cycles with a scale of 1.
        let published = milliseconds * 1e3;
        let elf = compile::build(&program(folder, &name)?, FLAGS)?;
        let ratio =
            |timing| -> Result<f64, Error> { Ok(cycles_of_iteration(&hosted::run(&elf, FLASHES[0], timing)?.text)? / published) };
        let (usual, longest) = (ratio(Timing::Usual)?, ratio(Timing::Longest)?);
        println!("| {name} | {published:.0} | {usual:.3} | {longest:.3} |");
        ratios.push([usual, longest]);
    }
    let statistics = [0, 1].map(|column| mean(ratios.iter().map(|row| row[column].ln()).collect()));
    println!("| geometric mean | | {:.3} | {:.3} |", statistics[0].0.exp(), statistics[1].0.exp());
    println!("| geometric standard deviation | | {:.3} | {:.3} |", statistics[0].1.exp(), statistics[1].1.exp());
    Ok(())
}

/// Returns mean and standard deviation.
fn mean(values: Vec<f64>) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// Reads `baseline-data/speed.json`: pairs of a name and milliseconds.
fn baseline(folder: &Path) -> Result<Vec<(String, f64)>, Error> {
    let text = std::fs::read_to_string(folder.join("baseline-data/speed.json"))?;
    let pairs = text.trim().trim_matches(['{', '}']).split(',');
    pairs
        .map(|pair| {
            let (name, value) = pair.split_once(':').ok_or_else(|| format!("speed.json: {pair}"))?;
            Ok((name.trim().trim_matches('"').to_owned(), value.trim().parse()?))
        })
        .collect()
}

fn program(folder: &Path, name: &str) -> Result<Program, Error> {
    let entries = std::fs::read_dir(folder.join("src").join(name))?.collect::<Result<Vec<_>, _>>()?;
    let mut sources: Vec<PathBuf> = entries.iter().map(std::fs::DirEntry::path).collect();
    sources.retain(|path| path.extension().is_some_and(|end| end == "c"));
    sources.sort();
    let support = folder.join("support");
    sources.extend(["main.c", "beebsc.c"].map(|name| support.join(name)));
    // Version 1 is scaled by the first define, version 2 by the second.
    let defines = &["-DCPU_MHZ=1", "-DGLOBAL_SCALE_FACTOR=1", "-DWARMUP_HEAT=1"];
    Ok(Program { name: name.to_owned(), sources, headers: support, port: "embench.c", defines })
}
