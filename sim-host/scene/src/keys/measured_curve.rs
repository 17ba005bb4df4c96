//! `[[overlay]]`: a measured curve that is drawn over a figure of a run and compared with the
//! simulated one.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A measured curve over a figure, from a table of numbers (`file`) or as points (`x` and
/// `values`). The figure shows it as dots; `overlay_rms_…` and `overlay_max_…` are the differences
/// of the simulated curve from it. When a scene is loaded, its file is replaced by the points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Overlay {
    /// Curve of the figure that was measured, by the name of its column in the figure's CSV, for
    /// example `load_cell_n`.
    pub quantity: String,
    /// Figure that it is drawn over, by the name of its files. Default: the first with this curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figure: Option<String>,
    /// Name in the legend. Default: the file and the heading of the column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Table of numbers, as CSV; the path is relative to the scene's file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Heading of the column, or its number from 1. Default: the only column other than `x_column`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Unit of the column. Default: from its heading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Heading of the column for the horizontal axis, or its number. Default: `t` or `time`;
    /// without headings the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x_column: Option<String>,
    /// Unit of the horizontal axis; for loaded points, that of `x`. Default: from its heading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x_unit: Option<String>,
    /// Horizontal position in the file, in the unit of `x_unit`, that corresponds to zero in the
    /// figure.
    #[serde(default)]
    pub x_zero: f64,
    /// File and columns that the points were read from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Horizontal position of each point.
    #[serde(default)]
    pub x: Arc<[f64]>,
    /// Measured value of each point, in the unit of `quantity`.
    #[serde(default)]
    pub values: Arc<[f64]>,
}

impl Overlay {
    /// Returns `true` if it is drawn over the figure with this name, which has curves with these
    /// names.
    pub fn lies_over<'a>(&self, id: &str, mut curves: impl Iterator<Item = &'a str>) -> bool {
        self.figure.as_ref().is_none_or(|figure| figure == id) && curves.any(|curve| curve == self.quantity)
    }

    /// Returns its name in the legend.
    pub fn legend(&self) -> String {
        let source = self.source.split(" over ").next().filter(|source| !source.is_empty());
        self.name.clone().unwrap_or_else(|| format!("measured: {}", source.unwrap_or(&self.quantity)))
    }

    /// Returns the horizontal positions in this unit, or `None` if the unit is not convertible.
    pub fn along(&self, axis_unit: Option<&str>) -> Option<Vec<f64>> {
        let factor = columns::heading::factor(self.x_unit.as_deref(), axis_unit)?;
        Some(self.x.iter().map(|x| factor * (x - self.x_zero)).collect())
    }
}
