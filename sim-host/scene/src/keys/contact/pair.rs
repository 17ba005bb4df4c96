//! Published coefficients of kinetic friction of pairs of materials, dry.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Defines the pairs: name, range of the coefficient, and the text of the schema, which contains
/// each number with its source.
macro_rules! pairs {
    ($($name:ident $low:literal $high:literal $text:literal),* $(,)?) => {
        /// Pair of materials, dry, whose published kinetic friction is the `mu` of the model. If
        /// the sources differ, `mu` is uniform over their range.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "kebab-case")]
        pub enum Pair {
            $(#[doc = $text] $name,)*
        }

        impl Pair {
            /// Returns the name in a scene.
            pub fn name(self) -> String {
                let words = format!("{self:?}");
                let second = words.rfind(char::is_uppercase).unwrap_or(0);
                format!("{}-{}", &words[..second], &words[second..]).to_lowercase()
            }

            /// Returns the smallest and the largest published coefficient.
            pub fn mu(self) -> [f64; 2] {
                match self {
                    $(Pair::$name => [$low, $high],)*
                }
            }
        }
    };
}

// The tables were read directly, the two articles only in a summary by others.
pairs! {
    AluminiumAluminium 0.34 0.34
        "mu 0.34 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1). Clean surfaces seize: 1.05 to 1.35, \
         static (Physics Fundamentals, eCampusOntario, Table A.1).",
    AluminiumSteel 0.25 0.47
        "mu 0.25 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1), 0.47 (Physics Fundamentals, \
         eCampusOntario, Table A.1).",
    CopperSteel 0.25 0.36
        "mu 0.25 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1), 0.36 (Physics Fundamentals, \
         eCampusOntario, Table A.1).",
    BrassSteel 0.44 0.44
        "mu 0.44 (Physics Fundamentals, eCampusOntario, Table A.1).",
    SteelSteel 0.23 0.74
        "mu 0.23 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1), 0.40 to 0.70 (pickedshares, \
         static and sliding friction values), 0.66 to 0.74 (35NCD16, flat on flat, 10 to 175 MPa, 0.5 to 10 Hz; S. \
         Baydoun and others, Wear 426-427 (2019) 676, doi 10.1016/j.wear.2018.12.022, read in a summary).",
    TitaniumTitanium 0.6 0.65
        "mu 0.60 to 0.65 (Ti-6Al-4V, cylinder on plane, 131 to 525 MPa, 0.05 to 5 Hz; S. Fouvry and others, Tribol. Int. \
         113 (2017) 460, doi 10.1016/j.triboint.2016.12.049, read in a summary).",
    SteelPtfe 0.16 0.16
        "mu 0.16 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1).",
    SteelPvc 0.38 0.38
        "mu 0.38 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1).",
    SteelAbs 0.35 0.35
        "mu 0.35 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1).",
    SteelGlass 0.12 0.12
        "mu 0.12 (G. Wypych, Handbook of Surface Improvement and Modification, Table 11.1).",
}
