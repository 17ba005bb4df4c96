//! `[[overlay]]`: a measured curve that lies over a figure of a run, and is held against the simulated one.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A measured curve over a figure, from a table of numbers (`file`) or as points (`x` and `values`). The figure shows it as dots, and
/// `overlay_rms_…` and `overlay_max_…` say how far the simulated curve is from it. A scene that has been read has the points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Overlay {
    /// Curve of a figure that was measured, by the name of its column in the figure's CSV: `load_cell_n`.
    pub quantity: String,
    /// Figure that it lies over, by the name of its files. Default: the first that has the curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figure: Option<String>,
    /// Name in the legend. Default: the file and the heading of the column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Table of numbers, as CSV; beside the file of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Heading of the column, or its number from 1. Default: the only one beside that of `x_column`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Unit of the column. Default: as its heading says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Heading of the column along the horizontal axis, or its number. Default: `t` or `time`; without headings the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x_column: Option<String>,
    /// Unit along the horizontal axis; of points that were read, that of `x`. Default: as its heading says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x_unit: Option<String>,
    /// Place along the horizontal axis of the file, in the unit of `x_unit`, that lies at zero of the figure.
    #[serde(default)]
    pub x_zero: f64,
    /// File and columns that the points were read from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Place of each point along the horizontal axis.
    #[serde(default)]
    pub x: Arc<[f64]>,
    /// Measured value of each point, in the unit of `quantity`.
    #[serde(default)]
    pub values: Arc<[f64]>,
}

impl Overlay {
    /// Whether it lies over the figure of this name, which has curves of these names.
    pub fn lies_over<'a>(&self, id: &str, mut curves: impl Iterator<Item = &'a str>) -> bool {
        self.figure.as_ref().is_none_or(|figure| figure == id) && curves.any(|curve| curve == self.quantity)
    }

    /// Name in the legend.
    pub fn legend(&self) -> String {
        let source = self.source.split(" over ").next().filter(|source| !source.is_empty());
        self.name.clone().unwrap_or_else(|| format!("measured: {}", source.unwrap_or(&self.quantity)))
    }

    /// The points along an axis of this unit; none if it is none of theirs.
    pub fn along(&self, axis_unit: Option<&str>) -> Option<Vec<f64>> {
        let factor = crate::profile::heading::factor(self.x_unit.as_deref(), axis_unit)?;
        Some(self.x.iter().map(|x| factor * (x - self.x_zero)).collect())
    }
}
