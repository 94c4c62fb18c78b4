//! Tests of the simulation from outside the crate.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test says what went wrong by panicking; expected values are found independently"
)]

mod bow;
mod bow_kept;
mod cycles;
mod five_axis;
mod gantry;
mod gap_bound;
mod gap_theorem;
mod import;
mod import_checks;
mod import_conditions;
mod import_controls;
mod import_damage;
mod import_gantry;
mod import_kinematics;
mod import_replay;
mod import_servos;
mod import_units;
mod import_values;
mod interventions;
mod machine_axes;
mod machine_file;
mod machine_presets;
mod measure;
mod memory;
mod random_five_axis;
mod recorded;
mod recorded_tool;
mod rewrite;
mod robot_joint;
mod sample_parts;
mod settings;
mod splines;
mod split;
mod stops;
mod stops_end;
mod testpart;
mod threads;
mod time;
mod travel;
mod tube;
mod worm;
