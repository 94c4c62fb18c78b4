//! What a run is refused for, as findings.

use super::{Finding, Origin};
use lostmotion_base::BlockRef;
use lostmotion_gcode::{Provenance, Severity};
use lostmotion_sim::SimError;
use serde_json::Map;

impl Finding {
    /// What a run of the program of this name was refused for: all that is wrong with it, moves
    /// beyond the travel, an axis that there is not, an arc that cannot be. Nothing of an error that
    /// is about no block.
    ///
    /// ```
    /// use lostmotion_report::findings::Finding;
    /// use lostmotion_sim::{Machine, Program, Simulation};
    ///
    /// let program = Program::from_str("part", "G21 G90\nG0 X9000\nM2\n");
    /// let machine = Machine::preset("vmc3")?;
    /// let error = Simulation::new(&program, &machine).run().unwrap_err();
    /// let found = Finding::from_error(&error, program.name());
    /// assert_eq!((found[0].code.as_str(), found[0].span.line), ("outside-travel", 2));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_error(error: &SimError, program: &str) -> Vec<Finding> {
        let of = |code: &str, block: &BlockRef, provenance: &Provenance, message, hint| {
            let origin = Origin {
                program,
                provenance,
            };
            vec![Finding {
                code: code.to_owned(),
                severity: Severity::Error,
                message,
                file: origin.file(block.span.file),
                span: block.span,
                values: Map::new(),
                excerpt: String::new(),
                hint,
                calls: origin.calls(block.call_stack),
            }]
        };
        match error {
            SimError::Program { diagnostics, .. } => {
                let origin = Origin {
                    program,
                    provenance: diagnostics.provenance(),
                };
                let kept = diagnostics.kept().iter();
                kept.map(|diagnostic| Finding::from_diagnostic(diagnostic, &origin))
                    .collect()
            }
            SimError::NoAxis {
                block,
                axis,
                machine,
                provenance,
            } => {
                let message = format!("machine \"{machine}\" has no axis {axis}");
                let hint = "take a machine with that axis, see `lostmotion machine list`";
                of("no-axis", block, provenance, message, Some(hint.to_owned()))
            }
            SimError::Path {
                block,
                source,
                provenance,
            } => of("path", block, provenance, source.to_string(), None),
            // One finding for all of them: a wrong work offset takes hundreds of blocks out of the
            // travel. The farthest excess comes first.
            SimError::Travel {
                machine,
                moves,
                excesses,
                hint,
                provenance,
                ..
            } => excesses.first().map_or_else(Vec::new, |worst| {
                let all: Vec<String> = excesses.iter().map(ToString::to_string).collect();
                let moves = if *moves == 1 {
                    "1 move goes".to_owned()
                } else {
                    format!("{moves} moves go")
                };
                let message = format!(
                    "{moves} beyond the travel of machine \"{machine}\": {}; the farthest is here",
                    all.join(", ")
                );
                let (code, hint) = ("outside-travel", Some(hint.clone()));
                of(code, &worst.block, provenance, message, hint)
            }),
            _ => Vec::new(),
        }
    }
}
