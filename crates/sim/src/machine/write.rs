//! A machine as a TOML file.

use super::{Gantry, General, LimitsTable, Machine};
use lostmotion_drive::config::Cycles;
use lostmotion_methods::AxisConfig;
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize)]
struct AxisTable<'a> {
    limits: &'a LimitsTable,
    #[serde(flatten)]
    config: AxisConfig,
}

#[derive(Serialize)]
struct File<'a, G: Serialize> {
    #[serde(flatten)]
    general: &'a General,
    #[serde(skip_serializing_if = "Option::is_none")]
    gantry: Option<G>,
    axis: BTreeMap<String, AxisTable<'a>>,
}

impl Machine {
    /// The machine as a file that [`Machine::from_toml`] reads back to an equal machine. Comments
    /// of the file it came from are gone.
    ///
    /// # Errors
    /// None for a machine made by this crate; the type is that of the writer underneath.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        let mut axis = BTreeMap::new();
        for part in &self.axes {
            // the machine's own table has the cycles
            axis.insert(
                part.id.letter().to_ascii_lowercase().to_string(),
                AxisTable {
                    limits: &part.table,
                    config: AxisConfig {
                        cycles: Cycles::default(),
                        ..part.config.clone()
                    },
                },
            );
        }
        toml::to_string_pretty(&File {
            general: &self.general,
            gantry: self.gantry.as_ref().map(Gantry::table),
            axis,
        })
    }
}
